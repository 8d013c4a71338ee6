//! The header: which elements follow, how many of each, and which properties they have.

use crate::FormatError;
use crate::text::{Cursor, EXPORT_AGAIN, Place, shortened};

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    /// What white is in a colour of this type.
    pub(super) fn white(self) -> f64 {
        match self {
            Self::I8 | Self::U8 => 255.0,
            Self::I16 | Self::U16 => 65_535.0,
            Self::I32 | Self::U32 => f64::from(u32::MAX),
            Self::F32 | Self::F64 => 1.0,
        }
    }

    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }
}

/// A property of an element.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Property {
    pub(super) name: String,
    /// Of the length, if it is a list.
    pub(super) length: Option<Kind>,
    pub(super) kind: Kind,
}

/// A kind of element.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// All that stands before the data.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Where the data begin.
    pub(super) length: usize,
}

/// Reads the header.
pub(super) fn read(file: &str, bytes: &[u8]) -> Result<Header, FormatError> {
    let (mut encoding, mut elements) = (None, Vec::<Element>::new());
    let mut cursor = Cursor::default();
    while let Some(line) = cursor.next_line(bytes, false) {
        let place = Place { file, line: line.number };
        let words: Vec<&str> = line.text.split_ascii_whitespace().collect();
        match words.as_slice() {
            ["ply"] | ["comment" | "obj_info", ..] => {}
            ["format", name, ..] => {
                encoding = Some(match *name {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(bad(place, "is not a format of PLY", name)),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| bad(place, "is not a number of elements", count))?;
                elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
            }
            ["property", words @ ..] => {
                let property = property(place, words)?;
                let element = elements.last_mut();
                element
                    .ok_or_else(|| bad(place, "is a property of no element", &property.name))?
                    .properties
                    .push(property);
            }
            ["end_header"] => {
                let encoding = encoding.ok_or_else(|| bad(place, "comes before the format", "end_header"))?;
                return Ok(Header { encoding, elements, length: cursor.offset() });
            }
            _ => return Err(bad(place, "is not a line of a header", &line.text)),
        }
    }
    let (file, place, length) = (file.to_owned(), "the header".to_owned(), bytes.len() as u64);
    Err(FormatError::BeyondEnd { file, place, end: length + 1, length })
}

fn property(place: Place<'_>, words: &[&str]) -> Result<Property, FormatError> {
    let kind = |word: &str| Kind::parse(word).ok_or_else(|| bad(place, "is not a type", word));
    match words {
        ["list", length, of, name] => {
            Ok(Property { name: (*name).to_owned(), length: Some(kind(length)?), kind: kind(of)? })
        }
        [of, name] => Ok(Property { name: (*name).to_owned(), length: None, kind: kind(of)? }),
        _ => Err(bad(place, "is not a property", &words.join(" "))),
    }
}

fn bad(place: Place<'_>, what: &str, word: &str) -> FormatError {
    place.bad(format!("{:?} {what}", shortened(word)), EXPORT_AGAIN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_is_read() {
        let text =
            b"ply\r\nformat ascii 1.0\r\ncomment x\r\nelement vertex 8\r\nproperty float x\r\nelement face 6\r\n\
            property list uchar int32 vertex_indices\r\nend_header\r\n1 2";
        let header = read("a.ply", text).unwrap();
        assert_eq!((header.encoding, header.length, header.elements.len()), (Encoding::Text, text.len() - 3, 2));
        assert_eq!(header.elements[0].properties[0], Property { name: "x".into(), length: None, kind: Kind::F32 });
        assert_eq!(header.elements[1].properties[0].length, Some(Kind::U8));
    }

    #[test]
    fn bad_headers_are_named() {
        for (text, words) in [
            ("ply\nformat text 1.0\n", "line 2: \"text\" is not a format"),
            ("ply\nelement vertex -1\n", "\"-1\" is not a number of elements"),
            ("ply\nproperty float x\n", "property of no element"),
            ("ply\nelement v 1\nproperty complex x\n", "\"complex\" is not a type"),
            ("ply\nend_header\n", "before the format"),
            ("ply\nfoo\n", "\"foo\" is not a line"),
            ("ply\nformat ascii 1.0\n", "the header"),
        ] {
            let message = read("a.ply", text.as_bytes()).unwrap_err().to_string();
            assert!(message.starts_with("a.ply: ") && message.contains(words), "{message}");
        }
    }
}
