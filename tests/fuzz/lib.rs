//! An importer that follows a script of bytes: what libFuzzer's targets share.

pub mod importer;
pub mod script;
