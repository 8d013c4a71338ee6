//! The frame of a GLB: a header, a JSON chunk, and perhaps a binary chunk.
//!
//! Source: glTF 2.0, section 4.4. Unknown chunks and bytes after the declared end are skipped, as it says.

use crate::FormatError;

/// The first four bytes of a GLB.
pub(crate) const MAGIC: [u8; 4] = *b"glTF";
pub(super) const JSON: [u8; 4] = *b"JSON";
pub(super) const BINARY: [u8; 4] = *b"BIN\0";

/// The two chunks of a GLB.
#[derive(Debug, PartialEq)]
pub(super) struct Chunks<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
}

/// Finds the chunks of a GLB.
pub(super) fn chunks<'a>(file: &str, bytes: &'a [u8]) -> Result<Chunks<'a>, FormatError> {
    let broken = |what: &str| FormatError::BadContainer { file: file.to_owned(), what: what.to_owned() };
    let cut = |what: &str, end: usize| FormatError::BeyondEnd {
        file: file.to_owned(),
        place: what.to_owned(),
        end: end as u64,
        length: bytes.len() as u64,
    };
    if bytes.get(..4) != Some(MAGIC.as_slice()) {
        return Err(broken("it does not begin with the letters glTF"));
    }
    let version = word(bytes, 4).ok_or_else(|| cut("the header", 12))?;
    if version != 2 {
        return Err(FormatError::BadVersion { file: file.to_owned(), version: version.to_string() });
    }
    let length = word(bytes, 8).ok_or_else(|| cut("the header", 12))? as usize;
    let body = bytes.get(..length).ok_or_else(|| cut("the length that the header states", length))?;

    let mut found = None;
    let mut binary = None;
    let mut at = 12;
    while at < body.len() {
        let size = word(body, at).ok_or_else(|| cut("a chunk's header", at + 8))? as usize;
        let kind = body.get(at + 4..at + 8).ok_or_else(|| cut("a chunk's header", at + 8))?;
        let end = (at + 8).checked_add(size).ok_or_else(|| broken("a chunk's length overflows"))?;
        let chunk = body.get(at + 8..end).ok_or_else(|| cut("a chunk", end))?;
        if found.is_none() {
            if kind != JSON {
                return Err(broken("its first chunk is not JSON"));
            }
            found = Some(chunk);
        } else if kind == BINARY && binary.is_none() {
            binary = Some(chunk);
        }
        at = end;
    }
    let json = found.ok_or_else(|| broken("it has no JSON chunk"))?;
    Ok(Chunks { json, binary })
}

/// Frames a JSON text and a binary buffer as a GLB; if it would pass 4 GiB, the error is its length.
pub(super) fn glb(mut json: Vec<u8>, mut binary: Vec<u8>) -> Result<Vec<u8>, u64> {
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let length = 12 + 8 + json.len() as u64 + 8 + binary.len() as u64;
    let length_word = u32::try_from(length).map_err(|_| length)?;
    let mut out = Vec::with_capacity(length_word as usize);
    out.extend_from_slice(&MAGIC);
    out.extend_from_slice(&2_u32.to_le_bytes());
    out.extend_from_slice(&length_word.to_le_bytes());
    for (kind, chunk) in [(JSON, &json), (BINARY, &binary)] {
        out.extend_from_slice(&(chunk.len() as u32).to_le_bytes());
        out.extend_from_slice(&kind);
        out.extend_from_slice(chunk);
    }
    Ok(out)
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(four.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_come_back_padded() {
        let bytes = glb(b"{ }".to_vec(), vec![1, 2, 3, 4, 5]).unwrap();
        assert_eq!(bytes.len() % 4, 0);
        let chunks = chunks("a.glb", &bytes).unwrap();
        assert_eq!((chunks.json, chunks.binary), (b"{ } ".as_slice(), Some([1, 2, 3, 4, 5, 0, 0, 0].as_slice())));
    }

    #[test]
    fn every_prefix_is_an_error() {
        let bytes = glb(b"{}".to_vec(), vec![7; 9]).unwrap();
        for end in 0..bytes.len() {
            let message = chunks("a.glb", &bytes[..end]).unwrap_err().to_string();
            assert!(message.starts_with("a.glb: "), "{message}");
        }
    }

    #[test]
    fn unknown_chunks_and_bytes_behind_the_end_are_skipped() {
        let mut bytes = glb(b"{}".to_vec(), vec![7; 4]).unwrap();
        bytes.extend_from_slice(&[4, 0, 0, 0, b'E', b'X', b'T', b'R', 9, 9, 9, 9]);
        let length = (bytes.len() as u32).to_le_bytes();
        bytes[8..12].copy_from_slice(&length);
        bytes.extend_from_slice(b"more");
        assert_eq!(chunks("a.glb", &bytes).unwrap().binary, Some([7; 4].as_slice()));
    }

    #[test]
    fn another_version_is_named() {
        let mut bytes = glb(b"{}".to_vec(), vec![]).unwrap();
        bytes[4] = 1;
        assert!(matches!(chunks("a.glb", &bytes), Err(FormatError::BadVersion { .. })));
    }
}
