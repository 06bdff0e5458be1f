//! The FMU library `DctClutchControl`.

fmi2_cosim::export!(dct_models::ClutchControl);
