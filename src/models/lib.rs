//! The models behind the FMUs.
