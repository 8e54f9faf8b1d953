//! Bytes that a document refers to: files beside it and data URIs.

use std::borrow::Cow;
use std::cell::RefCell;
use std::path::Path;

use data_encoding::BASE64_MIME_PERMISSIVE;
use percent_encoding::{percent_decode, percent_decode_str};

use super::fault::Warnings;
use crate::file::read;
use crate::inside::Named;
use crate::text::quoted;

/// Gives the bytes of the files beside a document.
///
/// A closure with the signature of [`Resources::read`] implements this trait, so that tests and fuzzers need no disk.
pub trait Resources {
    /// The bytes of the file that the document calls `name`: a relative reference, or an absolute path where the document
    /// has a `file:` URI. Not safe as a path: see [`path_inside`](crate::path_inside).
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
    /// Files that were asked for.
    pub named: RefCell<Named>,
}

impl Resources for Folder<'_> {
    fn read(&self, name: &str, most_bytes: u64) -> Result<Vec<u8>, String> {
        let relative = self.relative(name);
        let name = relative.as_deref().unwrap_or(name);
        let path = self.named.borrow_mut().locate(self.path, name, self.allow_outside);
        read(&path.map_err(|refusal| refusal.to_string())?, most_bytes)
    }
}

impl Folder<'_> {
    /// The name of a file in this folder that has been given by an absolute path.
    fn relative(&self, name: &str) -> Option<String> {
        let path = Path::new(name);
        let folder = if self.path.as_os_str().is_empty() { Path::new(".") } else { self.path };
        let folders = [folder.canonicalize(), std::path::absolute(folder)];
        let inside = folders.iter().flatten().find_map(|folder| path.strip_prefix(folder).ok())?;
        inside.to_str().map(str::to_string)
    }
}

/// The bytes that `uri` stands for, or the reason why there are none; a way of writing that is odd is a warning.
pub(super) fn fetch(
    uri: &str,
    resources: &dyn Resources,
    most_bytes: u64,
    warnings: &Warnings,
) -> Result<Vec<u8>, String> {
    if let Some(data) = strip_scheme(uri, "data") {
        return data_uri(data);
    }
    let reference = strip_scheme(uri, "file").map(without_host);
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme).filter(|_| reference.is_none());
    if scheme.is_some_and(|scheme| !scheme.contains(['/', '%', '?', '#']) && scheme.len() > 1) {
        return Err(format!("{} is not a file: give a relative path or a data URI", quoted(uri.as_bytes())));
    }
    let reference = reference.unwrap_or(uri);
    let mut first_error = None;
    for named in names(reference)? {
        let name = without_dots(&named.replace('\\', "/"));
        match resources.read(&name, most_bytes) {
            Ok(bytes) => {
                if reference != uri || first_error.is_some() || named.contains('\\') {
                    let (uri, name) = (quoted(uri.as_bytes()), quoted(name.as_bytes()));
                    warnings.push(format!("the URI {uri} should be a relative reference with escapes: {name} is read"));
                }
                return Ok(bytes);
            }
            Err(message) => first_error = first_error.or(Some(format!("{} {message}", quoted(name.as_bytes())))),
        }
    }
    Err(first_error.unwrap_or_else(|| format!("{} is not a file", quoted(uri.as_bytes()))))
}

/// Path of a `file:` URI, without the name of the machine that may stand before it.
fn without_host(path: &str) -> &str {
    let Some(rest) = path.strip_prefix("//") else { return path };
    rest.find('/').map_or(rest, |start| &rest[start..])
}

/// The path without `.`, and without folders that `..` leaves again: they need not exist (RFC 3986).
fn without_dots(path: &str) -> String {
    let mut kept: Vec<&str> = Vec::new();
    for part in path.split('/') {
        let leaves_folder = part == ".." && kept.last().is_some_and(|last| !matches!(*last, "" | ".."));
        if leaves_folder {
            kept.pop();
        } else if part != "." {
            kept.push(part);
        }
    }
    kept.join("/")
}

/// Names of files that a reference may mean, the likeliest first: with its escapes decoded, without a query and a fragment,
/// and as it is written, because some programs escape nothing.
fn names(reference: &str) -> Result<Vec<Cow<'_, str>>, String> {
    let decoded = |text| percent_decode_str(text).decode_utf8();
    let end = reference.find(['?', '#']).unwrap_or(reference.len());
    let whole = decoded(reference);
    let plain = whole.map_err(|_| format!("{} should be UTF-8 when decoded", quoted(reference.as_bytes())))?;
    let mut names = vec![plain];
    for name in [decoded(&reference[..end]).unwrap_or_default(), Cow::Borrowed(reference)] {
        if !name.is_empty() && !names.contains(&name) {
            names.push(name);
        }
    }
    Ok(names)
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
