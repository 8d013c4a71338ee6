//! Tells when files have changed, by asking.
//!
//! Idea: whoever saves a scene may write several files, each in several steps, and rename others over them; so a change
//! counts when all have stayed the same from one question to the next, and the scene itself is there. What a scene is
//! made of is known once it has been read; what was watched before keeps the state that it had before the reading, so
//! that nothing that changes meanwhile is lost.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What tells one state of a file from another; nothing where it is not there.
type Stamp = Option<(SystemTime, u64)>;

/// Files, and the state that each was in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Stamps(BTreeMap<PathBuf, Stamp>);

impl Stamps {
    /// As they are now.
    pub(crate) fn now(files: impl IntoIterator<Item = PathBuf>) -> Self {
        Self(files.into_iter().map(|file| (file.clone(), stamp(&file))).collect())
    }

    /// As the same files are now.
    fn again(&self) -> Self {
        Self::now(self.0.keys().cloned())
    }

    fn has(&self, file: &Path) -> bool {
        self.0.get(file).is_some_and(Option::is_some)
    }
}

/// A scene and what it is made of. The scene must be there, the others may be.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    scene: PathBuf,
    known: Stamps,
    seen: Option<Stamps>,
}

impl Watch {
    /// Watches a scene and other files from their present state on.
    pub(crate) fn new(scene: PathBuf, others: impl IntoIterator<Item = PathBuf>) -> Self {
        let known = Stamps::now(std::iter::once(scene.clone()).chain(others));
        Self { scene, known, seen: None }
    }

    /// Watches these files instead, the scene among them; those that are new from the state that is given.
    pub(crate) fn follow(&mut self, mut files: Stamps) {
        for (file, stamp) in &mut files.0 {
            *stamp = self.known.0.get(file).copied().unwrap_or(*stamp);
        }
        self.known = files;
        self.seen = None;
    }

    /// Whether something has changed since it last said so, and has come to rest.
    pub(crate) fn has_changed(&mut self) -> bool {
        let now = self.known.again();
        if now == self.known || !now.has(&self.scene) {
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
        let mut watch = Watch::new(file.clone(), []);
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
        let mut watch = Watch::new(file.clone(), []);
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
        let mut watch = Watch::new(scene, [materials.clone()]);
        fs::write(&materials, "").unwrap();
        assert!(!watch.has_changed());
        assert!(watch.has_changed());
    }

    #[test]
    fn what_changes_while_the_scene_is_read_is_not_lost() {
        let folder = tempfile::tempdir().unwrap();
        let [scene, paint, wood] = ["room.obj", "room.mtl", "wood.png"].map(|name| folder.path().join(name));
        fs::write(&scene, "1").unwrap();
        fs::write(&paint, "1").unwrap();
        let mut watch = Watch::new(scene.clone(), [paint.clone()]);
        fs::write(&paint, "12").unwrap();
        watch.follow(Stamps::now([scene.clone(), paint.clone(), wood.clone()]));
        assert!(!watch.has_changed());
        assert!(watch.has_changed(), "the library changed before it was followed, and after it was known");
        fs::write(&wood, "1").unwrap();
        assert!(!watch.has_changed());
        assert!(watch.has_changed(), "the image is there now");
        watch.follow(Stamps::now([scene, wood]));
        fs::write(&paint, "123").unwrap();
        assert!(!watch.has_changed() && !watch.has_changed(), "the scene does not refer to it any more");
    }
}
