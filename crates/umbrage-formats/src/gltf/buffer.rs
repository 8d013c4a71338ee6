//! Buffers: the binary chunk of a GLB, data URIs, and files beside the glTF.
//!
//! A buffer is loaded when something first needs it, and once however many buffers name the same file. A file must lie
//! in the glTF's folder or below: a scene from a stranger shall not read the rest of the disk.

use std::cell::{Cell, OnceCell};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::alphabet;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use super::item::Item;
use crate::FormatError;
use crate::beside::{self, Folder};

/// Base64 as it is found: with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Where a buffer's bytes are.
#[derive(Debug)]
enum Source {
    /// In the binary chunk.
    Chunk,
    /// In the place that the URI of this number names.
    Uri(usize),
    /// Made while reading, with this number.
    Made(usize),
    /// Nowhere.
    None,
}

/// All buffers of a file.
#[derive(Debug)]
pub(super) struct Buffers {
    folder: Folder,
    /// The file itself, if it is a GLB.
    glb: Vec<u8>,
    /// The binary chunk in it.
    chunk: Option<Range<usize>>,
    sources: Vec<Source>,
    /// What the distinct URIs name, once loaded.
    loaded: Vec<OnceCell<Vec<u8>>>,
    /// Bytes of all of them so far.
    loaded_bytes: Cell<u64>,
    /// What was made while reading.
    made: Vec<Vec<u8>>,
}

impl Buffers {
    /// Lists the buffers of the document whose root is `root`, without loading any.
    pub(super) fn list(
        root: &Item<'_>,
        folder: Folder,
        glb: Vec<u8>,
        chunk: Option<Range<usize>>,
    ) -> Result<Self, FormatError> {
        let mut numbers = BTreeMap::new();
        let mut sources = Vec::new();
        for (number, buffer) in root.children("buffers", "buffer")?.enumerate() {
            sources.push(match buffer?.text("uri")? {
                Some(uri) => {
                    let next = numbers.len();
                    Source::Uri(*numbers.entry(uri).or_insert(next))
                }
                None if number == 0 && chunk.is_some() => Source::Chunk,
                None => Source::None,
            });
        }
        let loaded = numbers.iter().map(|_| OnceCell::new()).collect();
        Ok(Self { folder, glb, chunk, sources, loaded, loaded_bytes: Cell::new(0), made: Vec::new() })
    }

    /// Adds a buffer of bytes that were made while reading; its number.
    pub(super) fn add(&mut self, bytes: Vec<u8>) -> usize {
        self.sources.push(Source::Made(self.made.len()));
        self.made.push(bytes);
        self.sources.len() - 1
    }

    /// Bytes of all URIs that have been loaded.
    pub(super) fn loaded_bytes(&self) -> u64 {
        self.loaded_bytes.get()
    }

    /// Whether the buffer has bytes at all; a fallback buffer of a compression extension has none.
    pub(super) fn has_bytes(&self, number: usize) -> bool {
        !matches!(self.sources.get(number), Some(Source::None))
    }

    /// The bytes of a buffer, as many as it declares.
    pub(super) fn bytes(&self, number: usize, buffer: &Item<'_>) -> Result<&[u8], FormatError> {
        let length = buffer.required_whole("byteLength")?;
        let all = match self.sources.get(number) {
            Some(Source::Chunk) => self.chunk.clone().map_or(&[][..], |range| &self.glb[range]),
            Some(&Source::Uri(uri)) => self.uri_bytes(uri, buffer)?,
            Some(&Source::Made(number)) => &self.made[number],
            _ => {
                return Err(bad(
                    buffer,
                    "has neither a uri nor a binary chunk",
                    "export as .glb, or with its .bin file",
                ));
            }
        };
        all.get(..length).ok_or_else(|| FormatError::BeyondEnd {
            file: buffer.file.to_owned(),
            place: buffer.place.clone(),
            end: length as u64,
            length: all.len() as u64,
        })
    }

    fn uri_bytes(&self, number: usize, buffer: &Item<'_>) -> Result<&[u8], FormatError> {
        let cell = &self.loaded[number];
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let bytes = self.load(buffer.text("uri")?.unwrap_or_default(), buffer)?;
        self.loaded_bytes.set(self.loaded_bytes.get() + bytes.len() as u64);
        Ok(cell.get_or_init(|| bytes))
    }

    /// The bytes that a URI names, for `holder`: a buffer, or an image.
    pub(super) fn load(&self, uri: &str, holder: &Item<'_>) -> Result<Vec<u8>, FormatError> {
        match strip_scheme(uri, "data:") {
            Some(data) => data_uri(data).map_err(|what| bad(holder, what, "export as .glb")),
            None => self.read_file(uri, holder),
        }
    }

    fn read_file(&self, uri: &str, buffer: &Item<'_>) -> Result<Vec<u8>, FormatError> {
        let relative = relative_path(uri).map_err(|what| {
            bad(buffer, format!("{what}: {}", shortened(uri)), "put the file beside the glTF, or export as .glb")
        })?;
        self.folder.read(&relative).map_err(|what| {
            let path = self.folder.join(&relative).display().to_string();
            bad(buffer, format!("{} {what}", shortened(&path)), "put the file beside the glTF, or export as .glb")
        })
    }
}

/// The path that a relative URI names, if it stays in the folder.
fn relative_path(uri: &str) -> Result<PathBuf, &'static str> {
    let first = uri.split('/').next().unwrap_or_default();
    if first.contains(':') {
        return Err("its uri is not a relative path, and nothing is fetched from elsewhere");
    }
    let decoded = percent_decode_str(uri).decode_utf8().map_err(|_| "its uri is not UTF-8")?;
    if decoded.is_empty() || decoded.contains('\0') {
        return Err("its uri is not a path");
    }
    beside::relative_path(Path::new(""), &decoded).map_err(|_| "its uri is not a relative path")
}

/// The bytes of a data URI, without its scheme.
fn data_uri(uri: &str) -> Result<Vec<u8>, String> {
    let (kind, data) = uri.split_once(',').ok_or("its data URI has no comma")?;
    let decoded = percent_decode_str(data);
    if kind.ends_with(";base64") {
        // Line breaks and blanks are no part of Base64, and are found in it all the same.
        let text: Vec<u8> = decoded.filter(|byte| !byte.is_ascii_whitespace()).collect();
        BASE64.decode(&text).map_err(|e| format!("its data URI is not Base64: {e}"))
    } else {
        Ok(decoded.collect())
    }
}

fn strip_scheme<'a>(uri: &'a str, scheme: &str) -> Option<&'a str> {
    let head = uri.get(..scheme.len())?;
    head.eq_ignore_ascii_case(scheme).then(|| &uri[scheme.len()..])
}

fn shortened(uri: &str) -> String {
    if uri.len() <= 200 { uri.to_owned() } else { format!("{}...", uri.chars().take(200).collect::<String>()) }
}

fn bad(buffer: &Item<'_>, what: impl Into<String>, cure: &'static str) -> FormatError {
    FormatError::BadBuffer { file: buffer.file.to_owned(), place: buffer.place.clone(), what: what.into(), cure }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative() {
        assert_eq!(relative_path("a%20b/c.bin"), Ok(PathBuf::from("a b/c.bin")));
        for uri in ["./c.bin", "./sub/../c.bin", "sub\\..\\c.bin", "sub%5c..%5Cc.bin"] {
            assert_eq!(relative_path(uri), Ok(PathBuf::from("c.bin")), "{uri}");
        }
        for uri in ["/etc/passwd", "%2fetc", "https://x/y.bin", "file:///x", "", "%00"] {
            assert!(relative_path(uri).is_err(), "{uri}");
        }
    }

    #[test]
    fn data_uris_are_decoded() {
        assert_eq!(data_uri("application/octet-stream;base64,AAEC").unwrap(), [0, 1, 2]);
        assert_eq!(data_uri(";base64,AAE").unwrap(), [0, 1]);
        assert_eq!(data_uri(",a%20b").unwrap(), b"a b");
        assert_eq!(data_uri("x;base64,AA\r\n EC%0A").unwrap(), [0, 1, 2]);
        assert!(data_uri(";base64,%%%").is_err() && data_uri("nothing").is_err());
        assert_eq!(strip_scheme("DATA:x", "data:"), Some("x"));
        assert_eq!(strip_scheme("é", "data:"), None);
    }
}
