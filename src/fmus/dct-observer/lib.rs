//! The FMU library `DctObserver`.
