//! The FMU library `DctPlant`.
