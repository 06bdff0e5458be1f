//! Files that come with a model in its FMU: where they lie, and how a model reads them.

use std::borrow::Cow;
use std::ffi::CStr;
use std::fmt;
use std::path::{Component, Path, PathBuf};

/// Why a model could not take what it needs from its files: any error, or a sentence (`"…".into()`).
pub type LoadError = Box<dyn std::error::Error + Send + Sync>;

/// The folder `resources` of an unpacked FMU. It is there, but may be empty.
///
/// ```
/// let folder = std::env::temp_dir();
/// let resources = fmi2_cosim::Resources::at(&folder)?;
/// let missing = resources.text("no/such.csv").unwrap_err().to_string();
/// assert!(missing.starts_with("resources/no/such.csv: "));
/// # Ok::<(), fmi2_cosim::LoadError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Resources {
    folder: PathBuf,
}

impl Resources {
    /// Those in a folder: for a model that runs without an importer.
    ///
    /// # Errors
    /// When there is no such folder.
    pub fn at(folder: impl Into<PathBuf>) -> Result<Self, LoadError> {
        let folder = folder.into();
        if folder.is_dir() {
            Ok(Self { folder })
        } else {
            Err(format!("{} is no folder", folder.display()).into())
        }
    }

    /// Those that `fmuResourceLocation` of `fmi2Instantiate` names; `None` where it names none.
    ///
    /// # Errors
    /// For what is no `file:` URI of a folder on this machine.
    pub(crate) fn named(location: Option<&CStr>) -> Result<Option<Self>, LoadError> {
        let location = location.unwrap_or_default().to_bytes();
        if location.is_empty() {
            return Ok(None);
        }
        let shown = String::from_utf8_lossy(location);
        let told = |fault: &dyn fmt::Display| format!("fmuResourceLocation = {shown}: {fault}");
        let path = decoded(location, cfg!(windows)).map_err(|fault| told(&fault))?;
        let path = system(path).map_err(|fault| told(&fault))?;
        Self::at(path)
            .map(Some)
            .map_err(|fault| told(&fault).into())
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Path of a file in the folder, e.g. `maps/loss.csv`, whether it is there or not.
    ///
    /// # Errors
    /// For a name that leads out of the folder: it may be one that an importer set.
    pub fn path(&self, name: &str) -> Result<PathBuf, LoadError> {
        let mut parts = Path::new(name).components();
        let inside = parts.all(|part| matches!(part, Component::Normal(_)));
        if inside && !name.is_empty() && !name.contains('\0') {
            Ok(self.folder.join(name))
        } else {
            Err(format!("{name:?} is no file of the folder resources").into())
        }
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// When it cannot be read; the error names it.
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>, LoadError> {
        let read = std::fs::read(self.path(name)?);
        read.map_err(|fault| format!("resources/{name}: {fault}").into())
    }

    /// The text of a file.
    ///
    /// # Errors
    /// When it cannot be read or is not UTF-8; the error names it.
    pub fn text(&self, name: &str) -> Result<String, LoadError> {
        let text = String::from_utf8(self.bytes(name)?);
        text.map_err(|fault| format!("resources/{name} is no text in UTF-8: {fault}").into())
    }
}

/// The path of a `file:` URI (RFC 8089), as bytes. An absolute path, which some importers hand over instead, is taken as
/// it is.
fn decoded(location: &[u8], windows: bool) -> Result<Cow<'_, [u8]>, &'static str> {
    let Some(rest) = without_scheme(location) else {
        return if is_absolute(location, windows) {
            Ok(Cow::Borrowed(location))
        } else {
            Err("neither a file: URI nor an absolute path")
        };
    };
    let (host, path) = match rest.strip_prefix(b"//") {
        Some(rest) => {
            let end = rest.iter().position(|byte| *byte == b'/');
            rest.split_at(end.unwrap_or(rest.len()))
        }
        None => (&b""[..], rest),
    };
    let mut path = if host.is_empty() || host.eq_ignore_ascii_case(b"localhost") {
        percent_decoded(path)?
    } else if windows && is_drive(host) {
        percent_decoded(rest.get(2..).unwrap_or_default())? // file://C:/x, as some write it
    } else if windows {
        percent_decoded(rest)? // //server/share/x
    } else {
        return Err("on another machine");
    };
    if windows && path.first() == Some(&b'/') && is_drive(path.get(1..3).unwrap_or_default()) {
        path.remove(0);
    }
    if path.contains(&0) {
        return Err("it holds a NUL");
    }
    if is_absolute(&path, windows) {
        Ok(Cow::Owned(path))
    } else {
        Err("no absolute path")
    }
}

fn without_scheme(location: &[u8]) -> Option<&[u8]> {
    let (scheme, rest) = location.split_at_checked(b"file:".len())?;
    scheme.eq_ignore_ascii_case(b"file:").then_some(rest)
}

/// `/x`; on Windows `C:/x` and `//server/share`, with slashes of either kind.
fn is_absolute(path: &[u8], windows: bool) -> bool {
    let slash = |at| matches!(path.get(at), Some(b'/' | b'\\'));
    if windows {
        (slash(0) && slash(1)) || (is_drive(path.get(..2).unwrap_or_default()) && slash(2))
    } else {
        path.first() == Some(&b'/')
    }
}

/// `C:`.
fn is_drive(text: &[u8]) -> bool {
    matches!(text, [letter, b':'] if letter.is_ascii_alphabetic())
}

/// Every `%41` as the byte it stands for.
fn percent_decoded(text: &[u8]) -> Result<Vec<u8>, &'static str> {
    const FAULT: &str = "a percent sign in it is not followed by two hexadecimal digits";
    let digit = |byte: Option<&u8>| byte.and_then(|byte| char::from(*byte).to_digit(16));
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.iter();
    while let Some(&byte) = rest.next() {
        bytes.push(if byte == b'%' {
            let pair = digit(rest.next()).zip(digit(rest.next()));
            let value = pair.map(|(high, low)| 16 * high + low);
            value
                .and_then(|value| u8::try_from(value).ok())
                .ok_or(FAULT)?
        } else {
            byte
        });
    }
    Ok(bytes)
}

#[cfg(unix)]
fn system(path: Cow<'_, [u8]>) -> Result<PathBuf, &'static str> {
    use std::os::unix::ffi::OsStringExt as _;
    Ok(std::ffi::OsString::from_vec(path.into_owned()).into())
}

#[cfg(not(unix))]
fn system(path: Cow<'_, [u8]>) -> Result<PathBuf, &'static str> {
    let text = String::from_utf8(path.into_owned());
    text.map(PathBuf::from).map_err(|_| "not UTF-8")
}

#[cfg(test)]
mod tests;
