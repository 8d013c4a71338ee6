//! Which files a command may replace: those that it could have made itself.
//!
//! `umbrage page room.glb -o room.glb` is a slip of the hand, and would cost a bake of an hour. So before any work a file that is
//! there already is looked at: what this program did not make stays, unless `--force` says otherwise.
//!
//! Holds: nothing is written here; a device and an empty file may always be written to.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use umbrage_formats::check_writable;

/// What is looked at of a file; of a GLB all of its JSON, which names the generator somewhere, but not more than this.
const HEAD_BYTES: u64 = 1 << 16;
const MAX_JSON_BYTES: u64 = 1 << 28;

/// A kind of file that commands make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Made {
    /// A baked file.
    Glb,
    /// A picture.
    Picture,
    /// A web page.
    Page,
    /// A report of a bake.
    Report,
    /// What `inspect` tells or draws.
    Inspection,
}

impl Made {
    /// What a message calls it.
    fn noun(self) -> &'static str {
        match self {
            Self::Glb => "a baked file of umbrage",
            Self::Picture => "a picture (PNG or OpenEXR)",
            Self::Page => "a page of umbrage",
            Self::Report => "a report of umbrage",
            Self::Inspection => "what umbrage inspect writes",
        }
    }

    /// Whether a file that begins so is of this kind.
    fn is(self, head: &[u8]) -> bool {
        let has = |words: &[u8]| head.windows(words.len()).any(|window| window == words);
        match self {
            Self::Glb => head.starts_with(b"glTF") && has(b"\"generator\":\"Umbrage "),
            Self::Picture => head.starts_with(b"\x89PNG") || head.starts_with(&[0x76, 0x2f, 0x31, 0x01]),
            Self::Page => has(b"<meta name=\"generator\" content=\"Umbrage\">"),
            Self::Report => has(b"\"umbrage-report\""),
            Self::Inspection => head.starts_with(b"<svg") || has(b"\"umbrage-inspect\""),
        }
    }
}

/// Fails where a file cannot be written, or is one that a command could not have made and may not replace: better now than after
/// long work.
///
/// # Errors
/// In words, with the name of the file.
pub(crate) fn check(path: &Path, made: Made, force: bool) -> anyhow::Result<()> {
    if !force && fs::metadata(path).is_ok_and(|old| old.is_file() && old.len() > 0) {
        anyhow::ensure!(
            head(path).is_ok_and(|head| made.is(&head)),
            "{}: is there already, and is not {}: give another name, or --force to replace it",
            path.display(),
            made.noun()
        );
    }
    Ok(check_writable(path)?)
}

/// How a file begins; a GLB up to the end of its JSON.
fn head(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let mut head = Vec::new();
    file.by_ref().take(HEAD_BYTES).read_to_end(&mut head)?;
    if let (true, Some(length)) = (head.starts_with(b"glTF"), head.get(12..16).and_then(|four| four.first_chunk::<4>()))
    {
        let rest = (u64::from(u32::from_le_bytes(*length)) + 20).min(MAX_JSON_BYTES).saturating_sub(head.len() as u64);
        file.take(rest).read_to_end(&mut head)?;
    }
    Ok(head)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_told_by_how_they_begin() {
        let glb = b"glTF\x02\0\0\0....JSON{\"asset\":{\"extras\":{},\"generator\":\"Umbrage 0.1.0\"";
        assert!(Made::Glb.is(glb) && !Made::Page.is(glb) && !Made::Picture.is(glb));
        assert!(!Made::Glb.is(b"glTF\x02\0\0\0....JSON{\"asset\":{\"generator\":\"Khronos"));
        assert!(Made::Picture.is(b"\x89PNG\r\n") && !Made::Picture.is(b"GIF89a"));
        assert!(!Made::Report.is(b"{\"name\": \"npm\"}") && !Made::Inspection.is(b"{}"));
    }
}
