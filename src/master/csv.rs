//! The heading of a CSV table, as Python's `csv` writes and reads it: FMI's names of matrices, `a[1,2]`, hold commas.

/// A heading of names; those with a comma or a quote stand in quotes.
pub fn heading<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let cell = |name: &str| match name.contains([',', '"']) {
        true => format!("\"{}\"", name.replace('"', "\"\"")),
        false => name.to_owned(),
    };
    let cells: Vec<_> = names.into_iter().map(cell).collect();
    cells.join(",")
}

/// The names of a heading, without space around them.
pub fn names(heading: &str) -> Vec<String> {
    let mut names = vec![];
    let (mut name, mut quoted) = (String::new(), false);
    let mut letters = heading.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if quoted && letters.next_if_eq(&'"').is_some() => name.push('"'),
            '"' if quoted || name.is_empty() => quoted = !quoted,
            ',' if !quoted => names.push(std::mem::take(&mut name)),
            letter => name.push(letter),
        }
    }
    names.push(name);
    names.iter().map(|name| name.trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_were_written() {
        let all = ["time", "plant.a[1,2]", "plant.'say \"so\", do'", "b"];
        let line = heading(all);
        assert_eq!(
            line,
            "time,\"plant.a[1,2]\",\"plant.'say \"\"so\"\", do'\",b"
        );
        assert_eq!(names(&line), all);
        assert_eq!(names("time , b\"c"), ["time", "b\"c"]);
        assert_eq!(names(""), [""]);
    }
}
