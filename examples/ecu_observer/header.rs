//! Numbers of `dct_observer.h`, read by the compiler: they stand in one place only.

const TEXT: &[u8] = include_bytes!("dct_observer.h");

/// The number behind `before` in the header; a compile error where there is none.
pub const fn number(before: &str) -> usize {
    let before = before.as_bytes();
    let mut at = 0;
    while !starts_with(at, before) {
        at += 1;
    }
    at += before.len();
    let mut value = 0;
    while TEXT[at].is_ascii_digit() {
        value = 10 * value + (TEXT[at] - b'0') as usize;
        at += 1;
    }
    value
}

const fn starts_with(at: usize, word: &[u8]) -> bool {
    let mut k = 0;
    while k < word.len() && TEXT[at + k] == word[k] {
        k += 1;
    }
    k == word.len()
}
