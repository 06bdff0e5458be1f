//! Compiles the logger: stable Rust cannot define a function of variable arguments.

fn main() {
    println!("cargo::rerun-if-changed=logger.c");
    cc::Build::new().file("logger.c").compile("cosim_logger");
}
