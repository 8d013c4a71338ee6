//! The data: one number after the other, whichever way they are written.

use super::header::{Encoding, Kind};
use crate::FormatError;
use crate::text::{EXPORT_AGAIN, shortened};

/// The data behind the header, and how far they are read.
#[derive(Debug)]
pub(super) struct Body<'a> {
    file: &'a str,
    encoding: Encoding,
    rest: &'a [u8],
    /// Bytes of the whole file.
    file_bytes: u64,
}

impl<'a> Body<'a> {
    /// The data from byte `begin` of the file on.
    pub(super) fn new(file: &'a str, encoding: Encoding, bytes: &'a [u8], begin: usize) -> Self {
        let rest = bytes.get(begin..).unwrap_or_default();
        Self { file, encoding, rest, file_bytes: bytes.len() as u64 }
    }

    /// The next number; `place` says of what.
    pub(super) fn number(&mut self, kind: Kind, place: impl Fn() -> String) -> Result<f64, FormatError> {
        match self.encoding {
            Encoding::Text => {
                let word = self.word().ok_or_else(|| self.end(&place))?;
                word.parse().map_err(|_| FormatError::BadStatement {
                    file: self.file.to_owned(),
                    place: place(),
                    what: format!("{:?} is not a number", shortened(word)),
                    cure: EXPORT_AGAIN,
                })
            }
            Encoding::LittleEndian => self.binary(kind, false, &place),
            Encoding::BigEndian => self.binary(kind, true, &place),
        }
    }

    /// A number that has to be whole and not negative: an index, or the length of a list.
    pub(super) fn whole(&mut self, kind: Kind, place: impl Fn() -> String) -> Result<u64, FormatError> {
        let number = self.number(kind, &place)?;
        if number.fract() == 0.0 && (0.0..=9e15).contains(&number) {
            // Whole, and small enough to be exact.
            return Ok(number as u64);
        }
        Err(FormatError::BadStatement {
            file: self.file.to_owned(),
            place: place(),
            what: format!("{number} is not a whole number from 0 up"),
            cure: EXPORT_AGAIN,
        })
    }

    fn word(&mut self) -> Option<&'a str> {
        let rest = self.rest.trim_ascii_start();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(length);
        self.rest = rest;
        if word.is_empty() { None } else { Some(str::from_utf8(word).unwrap_or("?")) }
    }

    fn binary(&mut self, kind: Kind, big: bool, place: &impl Fn() -> String) -> Result<f64, FormatError> {
        Ok(match kind {
            Kind::I8 => f64::from(i8::from_le_bytes(self.take(big, place)?)),
            Kind::U8 => f64::from(u8::from_le_bytes(self.take(big, place)?)),
            Kind::I16 => f64::from(i16::from_le_bytes(self.take(big, place)?)),
            Kind::U16 => f64::from(u16::from_le_bytes(self.take(big, place)?)),
            Kind::I32 => f64::from(i32::from_le_bytes(self.take(big, place)?)),
            Kind::U32 => f64::from(u32::from_le_bytes(self.take(big, place)?)),
            Kind::F32 => f64::from(f32::from_le_bytes(self.take(big, place)?)),
            Kind::F64 => f64::from_le_bytes(self.take(big, place)?),
        })
    }

    /// The next bytes, least significant first.
    fn take<const N: usize>(&mut self, big: bool, place: &impl Fn() -> String) -> Result<[u8; N], FormatError> {
        let (head, rest) = self.rest.split_first_chunk::<N>().ok_or_else(|| self.end(place))?;
        self.rest = rest;
        let mut bytes = *head;
        if big {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn end(&self, place: &impl Fn() -> String) -> FormatError {
        let (file, place, length) = (self.file.to_owned(), place(), self.file_bytes);
        FormatError::BeyondEnd { file, place, end: length + 1, length }
    }
}
