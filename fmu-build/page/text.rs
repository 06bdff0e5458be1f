//! Sentences and change logs, written as Markdown is, become HTML.

use super::formula;
use quick_xml::escape::escape;

/// A sentence: `` `code` ``, `$formula$`, `**strong**`, and `[words](link)`, of which the words stay: a page inside an
/// FMU has nothing beside it to link to.
pub(super) fn inline(text: &str) -> String {
    let mut html = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(['`', '$', '*', '[']) {
        let (before, from) = rest.split_at(at);
        html.push_str(&escape(before));
        let (made, after) = marked(from).unwrap_or_else(|| {
            let mut end = from.char_indices().skip(1).map(|(at, _)| at);
            let (sign, after) = from.split_at(end.next().unwrap_or(from.len()));
            (escape(sign).into_owned(), after)
        });
        html.push_str(&made);
        rest = after;
    }
    html.push_str(&escape(rest));
    html
}

/// The marked words at the front of a text, and what follows them.
fn marked(text: &str) -> Option<(String, &str)> {
    let between = |mark: &str| text.strip_prefix(mark)?.split_once(mark);
    if let Some((code, after)) = between("`") {
        return Some((format!("<code>{}</code>", escape(code)), after));
    }
    if let Some((formula, after)) = between("$") {
        return Some((formula::inline(formula), after));
    }
    if let Some((strong, after)) = between("**") {
        return Some((format!("<strong>{}</strong>", inline(strong)), after));
    }
    let (words, after) = text.strip_prefix('[')?.split_once("](")?;
    Some((inline(words), after.split_once(')')?.1))
}

/// The versions of a change log: a heading `## …` each, then its list; the newest one is open.
pub(super) fn changes(log: &str) -> String {
    let mut html = String::new();
    for (index, version) in log.split("\n## ").skip(1).enumerate() {
        let (heading, body) = version.split_once('\n').unwrap_or((version, ""));
        let open = if index == 0 { " open=\"open\"" } else { "" };
        html.push_str(&format!(
            "<details{open}><summary>{}</summary>\n<ul>\n",
            inline(heading)
        ));
        for item in items(body) {
            html.push_str(&format!("<li>{}</li>\n", inline(&item)));
        }
        html.push_str("</ul></details>\n");
    }
    html
}

/// The points of a list, with the lines that go on from them.
fn items(body: &str) -> Vec<String> {
    let mut items: Vec<String> = Vec::new();
    for line in body.lines().map(str::trim_end) {
        let point = line.strip_prefix("- ").or_else(|| line.strip_prefix("* "));
        match (point, items.last_mut()) {
            (Some(point), _) => items.push(point.to_owned()),
            (None, Some(item)) if line.starts_with(' ') => {
                item.push(' ');
                item.push_str(line.trim());
            }
            _ => {}
        }
    }
    items
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_become_elements_and_the_rest_is_escaped() {
        for (text, html) in [
            ("a < b", "a &lt; b"),
            (
                "`x<y` is **on**",
                "<code>x&lt;y</code> is <strong>on</strong>",
            ),
            ("see [the page](page.md).", "see the page."),
            ("2 * 3 [rad] `", "2 * 3 [rad] `"),
            ("µ*ß", "µ*ß"),
        ] {
            assert_eq!(inline(text), html);
        }
        assert!(inline("with $x^2$.").contains("<msup>"));
    }

    #[test]
    fn a_change_log_becomes_lists_by_version() {
        let log = "# Changes\n\n## 2.0.0\n\n- one\n  goes on\n- two\n\n## 1.0.0\n\n- `first`\n";
        let html = changes(log);
        assert_eq!(html.matches("<details").count(), 2);
        assert!(html.starts_with("<details open=\"open\"><summary>2.0.0</summary>"));
        assert!(html.contains("<li>one goes on</li>"));
        assert!(html.contains("<li><code>first</code></li>"));
        assert_eq!(changes("nothing"), "");
    }
}
