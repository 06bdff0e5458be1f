//! Describes, builds and checks FMUs.
fn main() {}
