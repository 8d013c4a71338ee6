//! Files beside a scene that it refers to: buffers, images, material libraries, includes.
//!
//! A scene from a stranger shall not read the rest of the disk: names are taken relative to a folder, and what they mean
//! has to lie in the scene's folder or below. A pipe or a device would never end, so only plain files are read. Whoever
//! wants to know when a scene changes has to look at these files too, so that each one that is asked for is written down.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

/// The folder of a scene. Clones write into one list.
#[derive(Clone, Debug, Default)]
pub(crate) struct Folder {
    path: PathBuf,
    asked: Rc<RefCell<BTreeSet<PathBuf>>>,
}

impl Folder {
    /// That of the scene at `scene`.
    pub(crate) fn of(scene: &Path) -> Self {
        Self { path: scene.parent().unwrap_or(Path::new("")).to_path_buf(), ..Self::default() }
    }

    /// The path of a file in it.
    pub(crate) fn join(&self, relative: &Path) -> PathBuf {
        self.path.join(relative)
    }

    /// The bytes of a plain file in it.
    ///
    /// # Errors
    /// In words, if there is none or it cannot be read.
    pub(crate) fn read(&self, relative: &Path) -> Result<Vec<u8>, String> {
        let path = self.join(relative);
        self.asked.borrow_mut().insert(path.clone());
        match fs::metadata(&path) {
            Err(error) => Err(format!("cannot be read ({error})")),
            Ok(metadata) if !metadata.is_file() => Err("is not a file".into()),
            Ok(_) => fs::read(&path).map_err(|error| format!("cannot be read ({error})")),
        }
    }

    /// All files that were asked for, whether they are there or not.
    pub(crate) fn asked(&self) -> BTreeSet<PathBuf> {
        self.asked.borrow().clone()
    }
}

/// The path that `name` means when it is written in a file of the folder `from`; both are relative to the scene's folder.
///
/// # Errors
/// In words, if the name is no relative path, or leaves the scene's folder.
pub(crate) fn relative_path(from: &Path, name: &str) -> Result<PathBuf, &'static str> {
    // Windows has its own separator, which no other system has in names that people give.
    let name = name.replace('\\', "/");
    if name.is_empty() || name.contains('\0') || name.as_bytes().get(1) == Some(&b':') {
        return Err("is not a relative path");
    }
    let mut path = PathBuf::new();
    for part in from.join(name).components() {
        match part {
            Component::Normal(part) => path.push(part),
            Component::CurDir => {}
            Component::ParentDir if path.pop() => {}
            _ => return Err("leaves the folder of the scene"),
        }
    }
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_in_the_folder() {
        let path = |from: &str, name| relative_path(Path::new(from), name);
        assert_eq!(path("", "a.mtl"), Ok("a.mtl".into()));
        assert_eq!(path("", "./sub\\a b.mtl"), Ok("sub/a b.mtl".into()));
        assert_eq!(path("sub", "../lib/a.mgf"), Ok("lib/a.mgf".into()));
        for name in ["../a", "a/../../b", "/etc/passwd", "C:\\a", "C:a", "", "a\0b", "\\\\host\\a"] {
            assert!(path("", name).is_err(), "{name}");
        }
        assert!(path("sub", "../../a").is_err());
    }

    #[test]
    fn only_plain_files_are_read() {
        let folder = Folder::of(&Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"));
        assert!(folder.read(Path::new("src")).unwrap_err().contains("not a file"));
        assert!(folder.read(Path::new("nowhere/at/all")).is_err());
        assert!(folder.read(Path::new("Cargo.toml")).is_ok());
        let asked = ["Cargo.toml", "nowhere/at/all", "src"].map(|name| folder.join(Path::new(name)));
        assert!(folder.clone().asked().into_iter().eq(asked), "there or not");
    }
}
