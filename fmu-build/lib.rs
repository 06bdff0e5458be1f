//! Describes, builds and checks FMUs.
