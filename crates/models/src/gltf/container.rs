//! Documents from bytes: GLB or plain JSON.

use serde_json::Value;

use super::document::Document;
use super::fault::{Warnings, at};
use super::{json_path, nulls};
use crate::error::{Fault, Place};
use crate::text::escaped;

const MAGIC: &[u8; 4] = b"glTF";
const JSON_CHUNK: &[u8; 4] = b"JSON";
const BINARY_CHUNK: &[u8; 4] = b"BIN\0";
const HEADER_BYTES: usize = 12;
/// Most bytes of a document that is read once more to see what is wrong with it, which takes many times as much memory.
const MOST_BYTES_OF_SECOND_LOOK: usize = 64 << 20;

/// A file taken apart.
pub(super) struct Container<'a> {
    pub document: Document,
    /// Bytes of GLB's own buffer.
    pub binary: Option<&'a [u8]>,
}

/// Takes a .glb or .gltf apart; the first bytes tell which of them it is.
pub(super) fn open<'a>(bytes: &'a [u8], warnings: &Warnings) -> Result<Container<'a>, Fault> {
    if !bytes.starts_with(MAGIC) {
        return Ok(Container { document: parse(bytes, true, warnings)?, binary: None });
    }
    let chunks = chunks(bytes)?;
    let (kind, json) = chunks.first().ok_or_else(|| Fault::new(Place::Byte(HEADER_BYTES), "there is no JSON chunk"))?;
    if *kind != JSON_CHUNK {
        return Err(Fault::new(Place::Byte(HEADER_BYTES), "the first chunk should be of type JSON"));
    }
    // Chunks of other types are to be ignored.
    let binary = chunks.get(1).filter(|(kind, _)| *kind == BINARY_CHUNK).map(|(_, data)| *data);
    Ok(Container { document: parse(json, false, warnings)?, binary })
}

type Chunk<'a> = (&'a [u8; 4], &'a [u8]);

fn chunks(bytes: &[u8]) -> Result<Vec<Chunk<'_>>, Fault> {
    let header =
        |at: usize| bytes.get(at..).and_then(<[u8]>::first_chunk).map(|word| u32::from_le_bytes(*word) as usize);
    let ends = || Fault::new(Place::Byte(bytes.len()), "the file ends inside the 12 bytes of its header");
    let version = header(4).ok_or_else(ends)?;
    let length = header(8).ok_or_else(ends)?;
    if version != 2 {
        return Err(Fault::new(
            Place::Byte(4),
            format!("is GLB of version {version}: version 2, of glTF 2.0, is read"),
        ));
    }
    let file = bytes.get(..length).filter(|file| file.len() >= HEADER_BYTES).ok_or_else(|| {
        let message = format!("the file should have {length} bytes as its header says: it has {}", bytes.len());
        Fault::new(Place::Byte(8), message)
    })?;
    let mut chunks = Vec::new();
    let mut position = HEADER_BYTES;
    // Only the first two can matter.
    while position < file.len() && chunks.len() < 2 {
        let (chunk, next) = chunk(file, position)?;
        chunks.push(chunk);
        position = next;
    }
    Ok(chunks)
}

/// The chunk at `position`, and the position of the next one.
fn chunk(file: &[u8], position: usize) -> Result<(Chunk<'_>, usize), Fault> {
    let fault = |message: String| Fault::new(Place::Byte(position), message);
    let rest = &file[position..];
    let (length, rest) = rest.split_first_chunk::<4>().ok_or_else(|| fault("a chunk should have 8 bytes".into()))?;
    let (kind, rest) = rest.split_first_chunk::<4>().ok_or_else(|| fault("a chunk should have 8 bytes".into()))?;
    let length = u32::from_le_bytes(*length) as usize;
    let data = rest.get(..length).ok_or_else(|| {
        fault(format!("the chunk says that it has {length} bytes: there are only {} left in the file", rest.len()))
    })?;
    Ok(((kind, data), position + 8 + length))
}

/// Document of a JSON text; with `has_lines`, line numbers mean something to people.
fn parse(json: &[u8], has_lines: bool, warnings: &Warnings) -> Result<Document, Fault> {
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    if is_utf16(json) {
        return Err(Fault::whole("is written in UTF-16: glTF is UTF-8, save it as that"));
    }
    // Some programs fill chunks up with zeros, where spaces should be.
    let end = json.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    if end < json.len() {
        warnings.push("zeros follow the JSON of the document, where only spaces should: they are not read");
    }
    let document = deserialize(&json[..end], has_lines).or_else(|fault| second_look(&json[..end], fault, warnings))?;
    check_version(&document)?;
    Ok(document)
}

/// Whether a text begins with a byte order mark of UTF-16, or with an ASCII character in it.
fn is_utf16(json: &[u8]) -> bool {
    matches!(json, [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [0, 1..=0x7f, ..] | [1..=0x7f, 0, ..])
}

fn deserialize(json: &[u8], has_lines: bool) -> Result<Document, Fault> {
    serde_json::from_slice(json).map_err(|error| fault(error, json, has_lines))
}

fn fault(error: serde_json::Error, json: &[u8], has_lines: bool) -> Fault {
    let line = error.line();
    let mut message = error.to_string();
    if let Some(end) = message.rfind(" at line ") {
        message.truncate(end);
    }
    let path = json_path::of(json, line, error.column());
    let message = if path.is_empty() { message } else { format!("{path}: {message}") };
    let message = shortened(&escaped(&message));
    if has_lines && line > 0 { Fault::line(line, message) } else { Fault::whole(message) }
}

/// Document of a text that is not one of glTF 2.0 as it stands, if that can be helped; `first` says what was found.
fn second_look(json: &[u8], first: Fault, warnings: &Warnings) -> Result<Document, Fault> {
    if json.len() > MOST_BYTES_OF_SECOND_LOOK {
        return Err(first);
    }
    let Ok(mut value) = serde_json::from_slice::<Value>(json) else { return Err(first) };
    if let Some(version) = value.pointer("/asset/version").and_then(old_version) {
        return Err(Fault::whole(format!("is glTF {version}: 2.0 is read")));
    }
    let removed = nulls::remove(&mut value);
    if removed.is_empty() {
        return Err(first);
    }
    // The text is made anew, so that the compiler need not make a second reader, from values.
    let document = deserialize(value.to_string().as_bytes(), false)?;
    removed.iter().for_each(|path| warnings.push(format!("{path} is null: its default is used")));
    Ok(document)
}

/// A version below 2, which some of those programs write as a number.
fn old_version(version: &Value) -> Option<String> {
    let number = version.as_f64().or_else(|| version.as_str()?.parse().ok())?;
    (0.0..2.0).contains(&number).then(|| format!("{number:.1}"))
}

/// The message cut short: it quotes the file, which may be long.
fn shortened(message: &str) -> String {
    const MOST_CHARS: usize = 300;
    match message.char_indices().nth(MOST_CHARS) {
        Some((end, _)) => format!("{}…", &message[..end]),
        None => message.to_string(),
    }
}

fn check_version(document: &Document) -> Result<(), Fault> {
    let asset = document.asset.as_ref().ok_or_else(|| at("asset", "is missing: a glTF file says its version there"))?;
    let needed = asset.min_version.as_ref().unwrap_or(&asset.version);
    let version = needed.split_once('.').and_then(|(major, minor)| Some((major.parse().ok()?, minor.parse().ok()?)));
    let version: Option<(u32, u32)> = version;
    let is_read = match version {
        Some((2, 0)) => true,
        // A later 2.x is read as far as it can be, unless it says that this is not enough.
        Some((2, _)) => asset.min_version.is_none(),
        _ => false,
    };
    match version {
        _ if is_read => Ok(()),
        Some((major, minor)) => Err(Fault::whole(format!("is glTF {major}.{minor}: 2.0 is read"))),
        None => Err(at("asset.version", format!("is {}: it should be `2.0`", crate::text::quoted(needed.as_bytes())))),
    }
}
