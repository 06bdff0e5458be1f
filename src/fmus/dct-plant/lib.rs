//! The FMU library `DctPlant`.

fmi2_cosim::export!(dct_models::Plant);
