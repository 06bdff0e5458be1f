//! What people expect of `cargo fmu check` on the command line.

#![allow(clippy::unwrap_used)]

use std::process::Command;

/// Exit code, what was printed, and what was said beside it.
fn told(words: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cargo-fmu"));
    let done = command.args(words).output().unwrap();
    let [printed, said] = [done.stdout, done.stderr].map(|text| String::from_utf8(text).unwrap());
    (done.status.code(), printed, said)
}

#[test]
fn an_fmu_that_is_missing_does_not_keep_the_next_one_from_being_checked() {
    let none = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let (code, printed, said) = told(&["check", "missing.fmu", none]);
    assert_eq!(code, Some(1));
    assert!(said.starts_with("error: missing.fmu: "), "{said}");
    assert!(
        printed.ends_with(&format!("{none}: INVALID, 0 start values compared\n")),
        "{printed}"
    );
    assert_eq!(told(&["check", none]).0, Some(3));
}

#[test]
fn limits_that_are_none_are_refused_with_what_they_are() {
    for (option, value, what) in [
        ("--limit", "0", "must be a number of seconds above 0"),
        ("--limit", "nan", "must be a number of seconds above 0"),
        ("--limit", "1e300", "must be a number of seconds above 0"),
        ("--limit", "10s", "must be a number of seconds above 0"),
        ("--glibc", "2.x", "must be a version like 2.17"),
        ("--glibc", "", "must be a version like 2.17"),
    ] {
        let (code, _, said) = told(&["check", "missing.fmu", option, value]);
        assert_eq!(code, Some(2), "{option} {value}");
        assert!(said.contains(what), "{said}");
    }
}
