//! The FMU library `DctObserver`.

fmi2_cosim::export!(dct_models::Observer);
