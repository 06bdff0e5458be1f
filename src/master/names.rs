//! What a component may be called: what `dct-harness` takes, too.

use serde::Deserialize;

/// The component that a mapping is for.
pub const PLANT: &str = "plant";

/// The name of a component.
#[derive(Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(try_from = "String")]
pub struct Name(pub String);

impl TryFrom<String> for Name {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let mut letters = text.chars();
        let first = letters.next().unwrap_or_default();
        let plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
        let starts = plain(first) && !first.is_ascii_digit();
        let taken = matches!(text.as_str(), "scenario" | "noise");
        if starts && letters.all(plain) && !taken {
            return Ok(Self(text));
        }
        Err(format!(
            "'{text}' is no name of a component: a letter or _, then letters, digits or _, and neither \
             'scenario' nor 'noise'"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_words_that_nothing_else_has() {
        let taken = |name: &str| Name::try_from(name.to_owned()).is_ok();
        for name in ["plant", "_1", "Plant2"] {
            assert!(taken(name), "{name}");
        }
        for name in [
            "", "pl.ant", "2nd", "a b", "scenario", "noise", "\u{e4}", "a\0",
        ] {
            assert!(!taken(name), "{name}");
        }
    }
}
