//! Bytes that a document refers to: files beside it and data URIs.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use data_encoding::BASE64_MIME_PERMISSIVE;
use percent_encoding::{percent_decode, percent_decode_str};

use crate::file::{path_inside, read};
use crate::text::quoted;

/// Gives the bytes of the files beside a document.
///
/// A closure with the signature of [`Resources::read`] implements this trait, so that tests and fuzzers need no disk.
pub trait Resources {
    /// The bytes of the file that the document calls `name`: a relative reference with its percent signs decoded. Not
    /// safe as a path: see [`path_inside`](crate::path_inside).
    ///
    /// # Errors
    /// When there is none, or when it has more than `most_bytes`; the message goes on after the name of the file.
    fn read(&self, name: &str, most_bytes: u64) -> Result<Vec<u8>, String>;
}

impl<F: Fn(&str, u64) -> Result<Vec<u8>, String>> Resources for F {
    fn read(&self, name: &str, most_bytes: u64) -> Result<Vec<u8>, String> {
        self(name, most_bytes)
    }
}

/// The files of a folder.
pub(super) struct Folder<'a> {
    pub path: &'a Path,
    pub allow_outside: bool,
}

impl Resources for Folder<'_> {
    fn read(&self, name: &str, most_bytes: u64) -> Result<Vec<u8>, String> {
        let path = self.locate(name).ok_or("is outside the folder of the model, where files are not read")?;
        read(&path, most_bytes)
    }
}

impl Folder<'_> {
    fn locate(&self, name: &str) -> Option<PathBuf> {
        path_inside(self.path, name).or_else(|| self.allow_outside.then(|| self.path.join(name)))
    }
}

/// The bytes that `uri` stands for.
pub(super) fn fetch(uri: &str, resources: &dyn Resources, most_bytes: u64) -> Result<Vec<u8>, String> {
    if let Some(data) = strip_scheme(uri, "data") {
        return data_uri(data);
    }
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme);
    if scheme.is_some_and(|scheme| !scheme.contains(['/', '%', '?', '#']) && scheme.len() > 1) {
        return Err(format!("{} is not a file: give a relative path or a data URI", quoted(uri.as_bytes())));
    }
    let name = percent_decode_str(uri).decode_utf8();
    let name = name.map_err(|_| format!("{} should be UTF-8 when decoded", quoted(uri.as_bytes())))?;
    let bytes = resources.read(&name, most_bytes);
    bytes.map_err(|message| format!("{} {message}", quoted(name.as_bytes())))
}

fn strip_scheme<'a>(uri: &'a str, scheme: &str) -> Option<&'a str> {
    let (start, rest) = uri.split_once(':')?;
    start.eq_ignore_ascii_case(scheme).then_some(rest)
}

/// Bytes of a data URI; `data` is the text after `data:`, as RFC 2397 has it.
fn data_uri(data: &str) -> Result<Vec<u8>, String> {
    let (kind, body) = data.split_once(',').ok_or("the data URI should have a comma before its data")?;
    let body: Cow<'_, [u8]> = percent_decode(body.as_bytes()).into();
    if !kind.ends_with(";base64") {
        return Ok(body.into_owned());
    }
    BASE64_MIME_PERMISSIVE.decode(&body).map_err(|error| format!("the data URI should be base64: {error}"))
}
