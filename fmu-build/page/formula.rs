//! Equations written in plain ASCII become MathML, which browsers draw without a script.
//!
//! Names as in the code: `omega_c1` is ω with the index c1, `J_ct2_eq` has the index "ct2,eq"; `x'` is a time
//! derivative, `x_hat` an estimate, `x_err` its error, `x^2` a power, `{a}/{b}` a fraction.

use quick_xml::escape::escape;
use std::iter::Peekable;
use std::str::Chars;

const GREEK: [(&str, &str); 18] = [
    ("Delta", "Δ"),
    ("Omega", "Ω"),
    ("alpha", "α"),
    ("beta", "β"),
    ("gamma", "γ"),
    ("delta", "δ"),
    ("eps", "ε"),
    ("epsilon", "ε"),
    ("eta", "η"),
    ("lambda", "λ"),
    ("mu", "μ"),
    ("omega", "ω"),
    ("phi", "φ"),
    ("pi", "π"),
    ("rho", "ρ"),
    ("sigma", "σ"),
    ("tau", "τ"),
    ("theta", "θ"),
];

/// Names that are no variables: upright.
const FUNCTIONS: [&str; 10] = [
    "cos",
    "exp",
    "if",
    "max",
    "min",
    "otherwise",
    "sat",
    "sgn",
    "sin",
    "tanh",
];

/// A formula on a line of its own.
pub(super) fn block(formula: &str) -> String {
    math(formula, " display=\"block\"")
}

/// A formula inside a sentence.
pub(super) fn inline(formula: &str) -> String {
    math(formula, "")
}

fn math(formula: &str, attribute: &str) -> String {
    let mut reader = Reader {
        rest: formula.chars().peekable(),
    };
    let (row, alternative) = (reader.row(None), escape(formula));
    format!("<math{attribute} alttext=\"{alternative}\"><mrow>{row}</mrow></math>")
}

struct Reader<'a> {
    rest: Peekable<Chars<'a>>,
}

impl Reader<'_> {
    /// Everything up to `end`, which is taken; `None`: to the end of the text.
    fn row(&mut self, end: Option<char>) -> String {
        let mut row = String::new();
        while let Some(next) = self.rest.next() {
            match next {
                found if Some(found) == end => break,
                ' ' => {}
                '{' => row.push_str(&self.group()),
                'a'..='z' | 'A'..='Z' => {
                    let name = self.name(next);
                    row.push_str(&self.powered(name));
                }
                '0'..='9' => {
                    let number = self.number(next);
                    row.push_str(&self.powered(number));
                }
                ')' => row.push_str(&self.powered(flat(")"))),
                other => row.push_str(&self.operator(other)),
            }
        }
        row
    }

    /// `{…}`, and `{…}/{…}` as a fraction.
    fn group(&mut self) -> String {
        let top = format!("<mrow>{}</mrow>", self.row(Some('}')));
        let mut ahead = self.rest.clone();
        if (ahead.next(), ahead.next()) != (Some('/'), Some('{')) {
            return self.powered(top);
        }
        self.rest = ahead;
        let bottom = self.row(Some('}'));
        format!("<mfrac>{top}<mrow>{bottom}</mrow></mfrac>")
    }

    fn taken(&mut self, first: char, belongs: impl Fn(char) -> bool) -> String {
        let mut text = String::from(first);
        while let Some(next) = self.rest.next_if(|next| belongs(*next)) {
            text.push(next);
        }
        text
    }

    fn number(&mut self, first: char) -> String {
        let text = self.taken(first, |next| next.is_ascii_digit() || next == '.');
        format!("<mn>{text}</mn>")
    }

    /// A name with its indices, its accent and the dot of a time derivative.
    fn name(&mut self, first: char) -> String {
        let text = self.taken(first, |next| next.is_ascii_alphanumeric() || next == '_');
        let mut parts: Vec<&str> = text.split('_').collect();
        let accent = match parts.last() {
            Some(&"hat") if parts.len() > 1 => Some("^"),
            Some(&"err") if parts.len() > 1 => Some("~"),
            _ => None,
        };
        if accent.is_some() {
            parts.pop();
        }
        let dot = self.rest.next_if_eq(&'\'').map(|_| "˙");
        let mut base = symbol(parts[0]);
        for mark in [accent, dot].into_iter().flatten() {
            base = format!("<mover accent=\"true\">{base}<mo>{mark}</mo></mover>");
        }
        let indices: Vec<_> = parts[1..].iter().map(|part| letter(part)).collect();
        match indices.join(",") {
            index if index.is_empty() => base,
            index => format!("<msub>{base}<mi mathvariant=\"normal\">{index}</mi></msub>"),
        }
    }

    /// With `^…`, if that follows.
    fn powered(&mut self, base: String) -> String {
        if self.rest.next_if_eq(&'^').is_none() {
            return base;
        }
        let power = match self.rest.next() {
            Some('{') => self.row(Some('}')),
            Some(one) => format!("<mn>{one}</mn>"),
            None => String::new(),
        };
        format!("<msup>{base}<mrow>{power}</mrow></msup>")
    }

    fn operator(&mut self, first: char) -> String {
        let pair = |this: &mut Self, wide: &str, narrow: &str| match this.rest.next_if_eq(&'=') {
            Some(_) => wide.to_owned(),
            None => narrow.to_owned(),
        };
        let sign = match first {
            '-' => "−".to_owned(),
            '*' => "·".to_owned(),
            '<' => pair(self, "≤", "&lt;"),
            '>' => pair(self, "≥", "&gt;"),
            '(' | '|' => return flat(&first.to_string()),
            ',' => return "<mo separator=\"true\">,</mo><mspace width=\"0.6em\"></mspace>".into(),
            other => escape(other.to_string()).into_owned(),
        };
        format!("<mo>{sign}</mo>")
    }
}

/// A bracket or bar that is no taller than a letter.
fn flat(sign: &str) -> String {
    format!("<mo stretchy=\"false\" lspace=\"0\" rspace=\"0\">{sign}</mo>")
}

fn symbol(name: &str) -> String {
    const SPACE: &str = "<mspace width=\"0.2em\"></mspace>";
    if FUNCTIONS.contains(&name) {
        return format!("{SPACE}<mi mathvariant=\"normal\">{name}</mi>{SPACE}");
    }
    format!("<mi>{}</mi>", letter(name))
}

/// The Greek letter of a name; another name as it is.
fn letter(name: &str) -> &str {
    let greek = GREEK.iter().find(|(ascii, _)| *ascii == name);
    greek.map_or(name, |(_, letter)| letter)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(formula: &str, expected: &str) {
        let text = inline(formula);
        let inner = text
            .strip_suffix("</mrow></math>")
            .and_then(|text| text.split_once("<mrow>"))
            .map(|(_, inner)| inner);
        assert_eq!(inner, Some(expected), "{formula}");
    }

    #[test]
    fn names_have_indices_accents_and_dots() {
        check("T", "<mi>T</mi>");
        check(
            "J_ct2_eq",
            "<msub><mi>J</mi><mi mathvariant=\"normal\">ct2,eq</mi></msub>",
        );
        check(
            "x_hat'",
            "<mover accent=\"true\"><mover accent=\"true\"><mi>x</mi><mo>^</mo></mover><mo>˙</mo></mover>",
        );
        check(
            "omega_e'",
            "<msub><mover accent=\"true\"><mi>ω</mi><mo>˙</mo></mover><mi mathvariant=\"normal\">e</mi></msub>",
        );
    }

    #[test]
    fn fractions_powers_and_signs() {
        check(
            "{a}/{b}",
            "<mfrac><mrow><mi>a</mi></mrow><mrow><mi>b</mi></mrow></mfrac>",
        );
        check("a^2", "<msup><mi>a</mi><mrow><mn>2</mn></mrow></msup>");
        check("a <= 1.5", "<mi>a</mi><mo>≤</mo><mn>1.5</mn>");
        check("a - b", "<mi>a</mi><mo>−</mo><mi>b</mi>");
    }

    #[test]
    fn whatever_is_written_is_well_formed() {
        for formula in ["a^", "{a", "}", "a & b < c > \"", "{a}/{", "'", "^^2", ""] {
            let text = block(formula);
            let mut reader = quick_xml::Reader::from_str(&text);
            loop {
                match reader.read_event() {
                    Ok(quick_xml::events::Event::Eof) => break,
                    Ok(_) => {}
                    Err(error) => panic!("{formula}: {error} in {text}"),
                }
            }
        }
    }
}
