//! The FMU library `DctClutchControl`.
