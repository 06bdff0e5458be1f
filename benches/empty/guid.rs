//! Prints the GUID that the library in this package asks its importer for.

#![allow(clippy::print_stdout)] // its only purpose

fn main() {
    println!("{}", fmi2_cosim::guid::<bench_empty::Empty>());
}
