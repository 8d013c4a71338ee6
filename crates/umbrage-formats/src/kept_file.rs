//! A bake kept in a file, for `umbrage bake --reuse`.
//!
//! ```text
//! umbrage kept bake\n      what it is: a file without it is somebody else's, and is never replaced
//! 0.1.0/3\n                who wrote it: version of the program, and of this layout
//! ...                      the bake, in the layout of postcard (https://postcard.jamesmunns.com/wire-format)
//! 4 bytes                  CRC-32 of all before, least byte first
//! ```
//!
//! Only the very version of the program that wrote a file takes it up: another one bakes otherwise. Whatever the bytes, reading ends in a
//! bake or in a [`KeptFileError`]; whether the bake fits a scene, [`umbrage::rebake::rebake`] checks.

use std::fs;
use std::io;
use std::path::Path;

use umbrage::rebake::Kept;

use crate::{FormatError, write_atomically};

const MAGIC: &[u8] = b"umbrage kept bake\n";
const VERSION: &[u8] = concat!(env!("CARGO_PKG_VERSION"), "/3\n").as_bytes();
/// Bytes of the checksum.
const CHECKSUM: usize = 4;

/// Why a bake cannot be read from a file.
#[derive(Debug, thiserror::Error)]
pub enum KeptFileError {
    /// The file cannot be read.
    #[error("{file} cannot be read: {source}")]
    Unreadable {
        /// The file.
        file: String,
        /// Why.
        source: io::Error,
    },
    /// It is no kept bake.
    #[error("{file} is not a kept bake")]
    Foreign {
        /// The file.
        file: String,
    },
    /// Another version of the program wrote it.
    #[error("{file} was written by another version of umbrage")]
    OtherVersion {
        /// The file.
        file: String,
    },
    /// Bytes of it were changed, or are missing.
    #[error("{file} is damaged")]
    Damaged {
        /// The file.
        file: String,
    },
}

/// Writes a kept bake, all or nothing, and says how many bytes it has.
///
/// # Errors
/// [`FormatError::Unwritable`] where the file cannot be written.
pub fn write_kept(path: &Path, kept: &Kept) -> Result<u64, FormatError> {
    let bytes = bytes_of(kept).map_err(|source| FormatError::Unwritable {
        file: path.display().to_string(),
        source: io::Error::other(source),
    })?;
    write_atomically(path, &bytes)?;
    Ok(bytes.len() as u64)
}

/// Reads a kept bake; `None` where there is no file.
///
/// # Errors
/// A [`KeptFileError`].
pub fn read_kept(path: &Path) -> Result<Option<Kept>, KeptFileError> {
    let file = || path.display().to_string();
    match fs::read(path) {
        Ok(bytes) => kept_in(&bytes, file).map(Some),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(source) => Err(KeptFileError::Unreadable { file: file(), source }),
    }
}

/// The bytes of a kept bake, as [`write_kept`] writes them.
///
/// # Errors
/// [`FormatError::Unwritable`] where it cannot be put into bytes.
pub fn kept_bytes(kept: &Kept) -> Result<Vec<u8>, FormatError> {
    bytes_of(kept)
        .map_err(|source| FormatError::Unwritable { file: "the bake".into(), source: io::Error::other(source) })
}

/// A kept bake from bytes that lack the checksum at their end: for tests of what is forged.
///
/// # Errors
/// A [`KeptFileError`].
pub fn kept_from_bytes(mut bytes: Vec<u8>) -> Result<Kept, KeptFileError> {
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    kept_in(&bytes, || "the bytes".into())
}

fn bytes_of(kept: &Kept) -> Result<Vec<u8>, postcard::Error> {
    let mut bytes = postcard::to_extend(kept, [MAGIC, VERSION].concat())?;
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    Ok(bytes)
}

fn kept_in(bytes: &[u8], file: impl Fn() -> String) -> Result<Kept, KeptFileError> {
    let after = bytes.strip_prefix(MAGIC).ok_or_else(|| KeptFileError::Foreign { file: file() })?;
    let after = after.strip_prefix(VERSION).ok_or_else(|| KeptFileError::OtherVersion { file: file() })?;
    let damaged = || KeptFileError::Damaged { file: file() };
    let (payload, _) = after.split_last_chunk::<CHECKSUM>().ok_or_else(damaged)?;
    let (before, checksum) = bytes.split_last_chunk::<CHECKSUM>().ok_or_else(damaged)?;
    if crc32fast::hash(before) != u32::from_le_bytes(*checksum) {
        return Err(damaged());
    }
    match postcard::take_from_bytes(payload) {
        Ok((kept, [])) => Ok(kept),
        _ => Err(damaged()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
    use umbrage::bake::BakeSettings;
    use umbrage::progress::Progress;
    use umbrage::rebake::{bake_to_reuse, rebake};
    use umbrage::scene::cornell::cornell_box;
    use umbrage::shade::ShadeSettings;

    fn settings() -> BakeSettings {
        BakeSettings { shade: ShadeSettings { tolerance: 0.3, ..ShadeSettings::default() }, ..BakeSettings::default() }
    }

    fn read(bytes: &[u8]) -> Result<Kept, KeptFileError> {
        kept_in(bytes, || "kept".into())
    }

    #[test]
    fn a_bake_is_read_as_it_was_written_and_nothing_else_is_read() {
        let (baked, kept) = bake_to_reuse(&cornell_box(), &settings(), Progress::silent()).unwrap();
        let bytes = bytes_of(&kept).unwrap();
        let (again, _) = rebake(&cornell_box(), &settings(), &read(&bytes).unwrap(), Progress::silent()).unwrap();
        assert_eq!(again.mesh, baked.mesh);

        assert!(matches!(read(b"glTF and so on"), Err(KeptFileError::Foreign { .. })));
        let mut other = bytes.clone();
        other[MAGIC.len()] += 1;
        assert!(matches!(read(&other), Err(KeptFileError::OtherVersion { .. })));
        assert!(matches!(read(&bytes[..bytes.len() - 1]), Err(KeptFileError::Damaged { .. })));
        assert!(matches!(read(&bytes[..MAGIC.len() + VERSION.len() + 2]), Err(KeptFileError::Damaged { .. })));
        for place in [MAGIC.len() + VERSION.len(), bytes.len() / 2, bytes.len() - 1] {
            let mut damaged = bytes.clone();
            damaged[place] ^= 0x10;
            assert!(matches!(read(&damaged), Err(KeptFileError::Damaged { .. })), "byte {place}");
        }

        // Someone who knows the checksum may write what they like: it is refused, or bakes to something, but never panics.
        let payload = MAGIC.len() + VERSION.len()..bytes.len() - CHECKSUM;
        let mut runner =
            TestRunner::new_with_rng(ProptestConfig::with_cases(48), TestRng::deterministic_rng(RngAlgorithm::ChaCha));
        let strategy = proptest::collection::vec((payload, any::<u8>()), 1..4);
        runner
            .run(&strategy, |changes| {
                let mut forged = bytes[..bytes.len() - CHECKSUM].to_vec();
                changes.iter().for_each(|&(place, byte)| forged[place] = byte);
                forged.extend(crc32fast::hash(&forged).to_le_bytes());
                if let Ok(kept) = read(&forged) {
                    let _ = rebake(&cornell_box(), &settings(), &kept, Progress::silent());
                }
                Ok(())
            })
            .unwrap();
    }
}
