//! Whole drives on the exact plant: every observer method, its errors, what it learns and what it tells.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "helpers of tests"
)]

mod begun;
mod bench;
mod calibrating;
mod consistency;
mod encoders;
mod glitches;
mod laws;
mod methods;
mod observability;
mod twins;
mod vouched;
mod worn;
