//! Tells when files have changed, by asking.
//!
//! Idea: whoever saves a scene may write it in several steps, and rename another file over it; so a change counts when it
//! has stayed the same from one question to the next, and the file is there.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What tells one state of a file from another; nothing where it is not there.
type Stamp = Option<(SystemTime, u64)>;

/// Files that are watched; the first must be there, the others may be.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    files: Vec<PathBuf>,
    known: Vec<Stamp>,
    seen: Option<Vec<Stamp>>,
}

impl Watch {
    /// Watches files from their present state on.
    pub(crate) fn new(files: Vec<PathBuf>) -> Self {
        let known = stamps(&files);
        Self { files, known, seen: None }
    }

    /// Whether something has changed since it last said so, and has come to rest.
    pub(crate) fn has_changed(&mut self) -> bool {
        let now = stamps(&self.files);
        if now == self.known || now.first().is_none_or(Option::is_none) {
            self.seen = None;
            return false;
        }
        if self.seen.as_ref() != Some(&now) {
            self.seen = Some(now);
            return false;
        }
        self.known = now;
        self.seen = None;
        true
    }
}

fn stamps(files: &[PathBuf]) -> Vec<Stamp> {
    files.iter().map(|file| stamp(file)).collect()
}

fn stamp(file: &Path) -> Stamp {
    let metadata = file.metadata().ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_change_counts_once_it_is_at_rest() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("room.glb");
        fs::write(&file, "1").unwrap();
        let mut watch = Watch::new(vec![file.clone()]);
        assert!(!watch.has_changed());
        fs::write(&file, "12").unwrap();
        assert!(!watch.has_changed(), "it may still be being written");
        fs::write(&file, "123").unwrap();
        assert!(!watch.has_changed(), "it was still being written");
        assert!(watch.has_changed());
        assert!(!watch.has_changed(), "a change counts once");
    }

    #[test]
    fn a_file_that_is_gone_is_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("room.glb");
        fs::write(&file, "1").unwrap();
        let mut watch = Watch::new(vec![file.clone()]);
        fs::remove_file(&file).unwrap();
        assert!(!watch.has_changed() && !watch.has_changed());
        fs::write(&file, "12").unwrap();
        assert!(!watch.has_changed());
        assert!(watch.has_changed());
    }

    #[test]
    fn what_appears_beside_counts_too() {
        let folder = tempfile::tempdir().unwrap();
        let [scene, materials] = ["room.glb", "room.umbrage.toml"].map(|name| folder.path().join(name));
        fs::write(&scene, "1").unwrap();
        let mut watch = Watch::new(vec![scene, materials.clone()]);
        fs::write(&materials, "").unwrap();
        assert!(!watch.has_changed());
        assert!(watch.has_changed());
    }
}
