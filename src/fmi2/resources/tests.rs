use super::*;
use std::fs;

fn shown(location: &[u8], windows: bool) -> String {
    match decoded(location, windows) {
        Ok(path) => String::from_utf8_lossy(&path).into_owned(),
        Err(fault) => format!("! {fault}"),
    }
}

#[test]
fn every_form_in_which_importers_name_a_folder_is_read() {
    for (location, path) in [
        ("file:///tmp/x/resources", "/tmp/x/resources"),
        ("file:/tmp/x", "/tmp/x"),
        ("FILE://localhost/tmp/x/", "/tmp/x/"),
        ("file:///a%20b/%C3%B6/%25/c+d#e?f", "/a b/ö/%/c+d#e?f"),
        ("/tmp/100%/x", "/tmp/100%/x"),
        ("file:////tmp", "//tmp"),
    ] {
        assert_eq!(shown(location.as_bytes(), false), path);
    }
    for (location, path) in [
        ("file:///C:/Temp/a%20b", "C:/Temp/a b"),
        ("file:/c:/Temp", "c:/Temp"),
        ("file:C:/Temp", "C:/Temp"),
        ("file://C:/Temp", "C:/Temp"),
        ("file://localhost/C:/Temp", "C:/Temp"),
        ("file://server/share/x", "//server/share/x"),
        ("C:\\Temp\\x", "C:\\Temp\\x"),
        ("\\\\server\\share", "\\\\server\\share"),
    ] {
        assert_eq!(shown(location.as_bytes(), true), path);
    }
}

#[test]
fn what_names_no_folder_of_this_machine_is_refused_with_a_reason() {
    let (neither, digits) = (
        "neither a file: URI nor an absolute path",
        "a percent sign in it is not followed by two hexadecimal digits",
    );
    for (location, fault) in [
        ("http://x.org/resources", neither),
        ("resources", neither),
        ("fil", neither),
        ("C:/Temp", neither),
        ("file:", "no absolute path"),
        ("file://", "no absolute path"),
        ("file:///", "/"),
        ("file:resources", "no absolute path"),
        ("file://server/x", "on another machine"),
        ("file:///%", digits),
        ("file:///%4", digits),
        ("file:///%4g", digits),
        ("file:///%+1", digits),
        ("file:///a%00b", "it holds a NUL"),
    ] {
        let expected = if fault == "/" {
            "/".into()
        } else {
            format!("! {fault}")
        };
        assert_eq!(shown(location.as_bytes(), false), expected, "{location}");
    }
    for location in ["file:///tmp", "file:", "/tmp", "C:", "C:x", "file:///C:"] {
        assert!(
            shown(location.as_bytes(), true).starts_with("! "),
            "{location}"
        );
    }
}

/// Every text of up to six of the bytes that mean something, and a long one: an answer, no panic.
#[test]
fn no_location_brings_it_down() {
    const BYTES: &[u8] = b"/\\:%C0\xff";
    let mut texts: Vec<Vec<u8>> = vec![Vec::new()];
    for _ in 0..5 {
        let longer = texts.iter().flat_map(|text| {
            BYTES
                .iter()
                .map(|byte| [text.as_slice(), &[*byte]].concat())
        });
        texts = longer.collect();
        for text in &texts {
            for windows in [false, true] {
                shown(text, windows);
                shown(&[b"file:", text.as_slice()].concat(), windows);
                shown(&[b"file://", text.as_slice()].concat(), windows);
            }
        }
    }
    let long = [b"file://".as_slice(), &b"/..".repeat(1 << 20)].concat();
    assert_eq!(shown(&long, false).len(), 3 << 20);
}

#[test]
fn a_folder_is_looked_for_and_names_do_not_lead_out_of_it() {
    let folder = std::env::temp_dir().join(format!("fmi2 ö% {}", std::process::id()));
    fs::create_dir_all(folder.join("maps")).unwrap();
    fs::write(folder.join("maps/a.csv"), "1,2\n").unwrap();
    fs::write(folder.join("latin1"), b"\xe4").unwrap();
    let uri = format!("file://{}", folder.display())
        .replace('%', "%25")
        .replace(' ', "%20");
    let uri = std::ffi::CString::new(uri).unwrap();
    let found = Resources::named(Some(&uri)).unwrap().unwrap();
    assert_eq!(found.folder(), folder);
    assert_eq!(found.text("maps/a.csv").unwrap(), "1,2\n");
    let told = |name| found.text(name).unwrap_err().to_string();
    assert!(told("b.csv").starts_with("resources/b.csv: "));
    assert!(told("latin1").starts_with("resources/latin1 is no text in UTF-8: "));
    for name in ["", "..", "maps/../../x", "/etc/passwd", "maps/a\0b"] {
        assert_eq!(
            told(name),
            format!("{name:?} is no file of the folder resources")
        );
    }
    fs::remove_dir_all(&folder).unwrap();
    let gone = Resources::named(Some(&uri)).unwrap_err().to_string();
    assert!(gone.starts_with("fmuResourceLocation = file:///"), "{gone}");
    assert!(gone.ends_with(" is no folder"), "{gone}");
    for none in [None, Some(c"")] {
        assert_eq!(Resources::named(none).unwrap(), None);
    }
}
