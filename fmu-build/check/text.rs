//! The text of modelDescription.xml: what some importer's XML parser does not take.

use super::Report;

/// Some importers' XML parsers stop at it.
const BYTE_ORDER_MARK: &str = "\u{feff}";

/// The description's text without a byte order mark; `None` where it is none.
pub(super) fn read(bytes: &[u8], report: &mut Report) -> Option<String> {
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            let line = lines(bytes.get(..error.valid_up_to()).unwrap_or_default());
            let text = format!("modelDescription.xml is not in UTF-8, line {line}");
            report.error("2.2", text);
            return None;
        }
    };
    let plain = text.strip_prefix(BYTE_ORDER_MARK);
    if plain.is_some() {
        report.error("2.2", "modelDescription.xml begins with a byte order mark");
    }
    if let Some((at, character)) = text.char_indices().find(|(_, c)| is_forbidden(*c)) {
        let line = lines(text.as_bytes().get(..at).unwrap_or_default());
        let code = u32::from(character);
        let text = format!(
            "modelDescription.xml has the character U+{code:04X}, line {line}, which XML forbids"
        );
        report.error("2.2", text);
    }
    if text.contains("<!DOCTYPE") {
        let text =
            "modelDescription.xml declares a document type: importers that fear entities refuse it";
        report.warn("2.2", text);
    }
    Some(plain.unwrap_or(text).to_owned())
}

/// XML 1.0, production 2: all others are characters.
const fn is_forbidden(character: char) -> bool {
    match character {
        '\t' | '\n' | '\r' => false,
        '\u{fffe}' | '\u{ffff}' => true,
        other => other < ' ',
    }
}

/// The line that comes after these bytes.
fn lines(before: &[u8]) -> usize {
    1 + before.iter().filter(|byte| **byte == b'\n').count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_xml_is_and_what_frightens_is_named_with_its_line() {
        let cases: [(&[u8], &str); 6] = [
            (b"<?xml?>\n<a>\xc3\xa4\t</a>\r\n", ""),
            (b"\xef\xbb\xbf<a/>", "byte order mark"),
            (b"<a>\n\n\xff</a>", "not in UTF-8, line 3"),
            (b"\xff\xfe<\0a\0", "not in UTF-8, line 1"),
            (b"<a>\n\0</a>", "U+0000, line 2, which XML forbids"),
            (b"<!DOCTYPE a><a/>", "document type"),
        ];
        for (bytes, expected) in cases {
            let mut report = Report::default();
            read(bytes, &mut report);
            let found: String = report.findings.iter().map(ToString::to_string).collect();
            assert!(found.contains(expected), "{expected}: {found}");
            assert_eq!(found.is_empty(), expected.is_empty(), "{found}");
        }
    }
}
