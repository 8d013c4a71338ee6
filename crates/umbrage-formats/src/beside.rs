//! Files beside a scene that it refers to: buffers, images, material libraries, includes.
//!
//! A scene from a stranger shall not read the rest of the disk: names are taken relative to a folder, and what they mean, all links
//! followed, has to lie below the root, which is the scene's folder unless the caller names another. A pipe or a device would never end, so only plain files
//! are read, and none larger than [`MAX_FILE_BYTES`]. Files that were made where capitals do not count are found whatever theirs
//! are. Whoever wants to know when a scene changes has to look at these files too, so that each one that is asked for is written down.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

/// Larger files are refused: a GLB cannot be larger.
pub(crate) const MAX_FILE_BYTES: u64 = 1 << 32;
/// What is no plain file (a pipe, a device) may have so many bytes: it does not say how many it has.
pub(crate) const MAX_PIPE_BYTES: u64 = 1 << 28;

/// The folder of a scene. Clones write into one list.
#[derive(Clone, Debug, Default)]
pub(crate) struct Folder {
    path: PathBuf,
    /// What is read has to lie in it; the folder itself where it is `None`.
    root: Option<PathBuf>,
    asked: Rc<RefCell<BTreeSet<PathBuf>>>,
}

impl Folder {
    /// That of the scene at `scene`, which may refer to what lies below `root`.
    pub(crate) fn of(scene: &Path, root: Option<&Path>) -> Self {
        let path = scene.parent().unwrap_or(Path::new("")).to_path_buf();
        Self { path, root: root.map(Path::to_path_buf), ..Self::default() }
    }

    /// The same folder, whose parent is the root unless the caller named another.
    pub(crate) fn within_parent(&self) -> Self {
        let root = self.root.clone().unwrap_or_else(|| self.path.join(".."));
        Self { root: Some(root), ..self.clone() }
    }

    /// The path of a file in it.
    pub(crate) fn join(&self, relative: &Path) -> PathBuf {
        self.path.join(relative)
    }

    /// The bytes of a plain file below the root.
    ///
    /// # Errors
    /// In words, if there is none, it cannot be read, or lies elsewhere.
    pub(crate) fn read(&self, relative: &Path) -> Result<Vec<u8>, String> {
        let path = self.join(relative);
        let root = self.root.as_deref().unwrap_or(&self.path);
        let outside = |what: &str| {
            let whose = if self.root.is_some() { "the root" } else { "the folder of the scene" };
            format!("{what} {whose} ({}): copy it there, or name a folder that holds both with --root", shown(root))
        };
        let climbs = relative.components().any(|part| part == Component::ParentDir);
        if climbs && !lexically_within(&path, root) {
            return Err(outside("leaves"));
        }
        self.asked.borrow_mut().insert(path.clone());
        let found = if fs::symlink_metadata(&path).is_ok() {
            path
        } else {
            whatever_case(&self.path, relative).unwrap_or(path)
        };
        let real = fs::canonicalize(&found).map_err(|error| format!("cannot be read ({error})"))?;
        if !fs::canonicalize(shown_or_dot(root)).is_ok_and(|root| real.starts_with(root)) {
            return Err(outside("is a link that leaves"));
        }
        if !real.is_file() {
            return Err("is not a file".into());
        }
        read_bounded(&real).map_err(|error| format!("cannot be read ({error})"))
    }

    /// All files that were asked for, whether they are there or not.
    pub(crate) fn asked(&self) -> BTreeSet<PathBuf> {
        self.asked.borrow().clone()
    }
}

/// The bytes of a file, of [`MAX_FILE_BYTES`] at most; of a pipe or a device, of [`MAX_PIPE_BYTES`].
///
/// # Errors
/// If it cannot be read, or is larger.
pub(crate) fn read_bounded(path: &Path) -> std::io::Result<Vec<u8>> {
    read_up_to(path, MAX_FILE_BYTES)
}

/// The bytes of a file, `most` at most; of a pipe or a device [`MAX_PIPE_BYTES`] at most.
///
/// # Errors
/// If it cannot be read, or is larger.
pub(crate) fn read_up_to(path: &Path, most: u64) -> std::io::Result<Vec<u8>> {
    let too_large = |most: u64| {
        std::io::Error::new(std::io::ErrorKind::FileTooLarge, format!("it has more than {} MiB", most >> 20))
    };
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    let (most, size) = if metadata.is_file() { (most, metadata.len()) } else { (most.min(MAX_PIPE_BYTES), 0) };
    if size > most {
        return Err(too_large(most));
    }
    let mut bytes = Vec::new();
    // The size is no promise: a file may grow, and one of the system's says 0.
    bytes.try_reserve_exact(usize::try_from(size).unwrap_or(0))?;
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { Err(too_large(most)) } else { Ok(bytes) }
}

/// Whether a path stays below a folder, links left aside.
fn lexically_within(path: &Path, root: &Path) -> bool {
    let plain = |path: &Path| {
        let mut plain = PathBuf::new();
        for part in std::path::absolute(shown_or_dot(path)).ok()?.components() {
            match part {
                Component::ParentDir => drop(plain.pop()),
                Component::CurDir => {}
                part => plain.push(part),
            }
        }
        Some(plain)
    };
    plain(path).zip(plain(root)).is_some_and(|(path, root)| path.starts_with(root))
}

/// An empty path means the current folder.
fn shown_or_dot(path: &Path) -> &Path {
    if path.as_os_str().is_empty() { Path::new(".") } else { path }
}

fn shown(path: &Path) -> std::path::Display<'_> {
    shown_or_dot(path).display()
}

/// The file that a name means where capitals do not count: of several the first by name.
fn whatever_case(folder: &Path, relative: &Path) -> Option<PathBuf> {
    let mut path = folder.to_path_buf();
    for part in relative.components() {
        let next = path.join(part);
        if part == Component::ParentDir || next.exists() {
            path = next;
            continue;
        }
        let wanted = part.as_os_str().to_str()?.to_lowercase();
        let entries = fs::read_dir(shown_or_dot(&path)).ok()?.filter_map(|entry| Some(entry.ok()?.file_name()));
        let alike = entries.filter(|name| name.to_str().is_some_and(|name| name.to_lowercase() == wanted));
        path.push(alike.min()?);
    }
    Some(path)
}

/// The path that `name` means when it is written in a file of the folder `from`; both are relative to the scene's folder. It may
/// begin with `..`: whether it leaves the root, [`Folder::read`] tells.
///
/// # Errors
/// In words, if the name is no relative path.
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
            Component::ParentDir => {
                if path.components().next_back().is_some_and(|last| last != Component::ParentDir) {
                    path.pop();
                } else {
                    path.push("..");
                }
            }
            _ => return Err("is not a relative path"),
        }
    }
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_and_plain() {
        let path = |from: &str, name| relative_path(Path::new(from), name);
        assert_eq!(path("", "a.mtl"), Ok("a.mtl".into()));
        assert_eq!(path("", "./sub\\a b.mtl"), Ok("sub/a b.mtl".into()));
        assert_eq!(path("sub", "../lib/a.mgf"), Ok("lib/a.mgf".into()));
        assert_eq!(path("sub", "../../a"), Ok("../a".into()));
        assert_eq!(path("", "a/../../b"), Ok("../b".into()));
        assert_eq!(path("..", "../b"), Ok("../../b".into()));
        for name in ["/etc/passwd", "C:\\a", "C:a", "", "a\0b", "\\\\host\\a"] {
            assert!(path("", name).is_err(), "{name}");
        }
    }

    #[test]
    fn only_plain_files_are_read() {
        let folder = Folder::of(&Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"), None);
        assert!(folder.read(Path::new("src")).unwrap_err().contains("not a file"));
        assert!(folder.read(Path::new("nowhere/at/all")).is_err());
        assert!(folder.read(Path::new("Cargo.toml")).is_ok());
        let asked = ["Cargo.toml", "nowhere/at/all", "src"].map(|name| folder.join(Path::new(name)));
        assert!(folder.clone().asked().into_iter().eq(asked), "there or not");
    }

    /// A folder with `inner/scene.obj`, `inner/Wood.PNG`, `lib/a.mgf`.
    fn folders() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [("inner/scene.obj", "o"), ("inner/Sub/Wood.PNG", "w"), ("lib/a.mgf", "m")] {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        folder
    }

    #[test]
    fn what_leaves_the_root_is_refused_links_included() {
        let outer = folders();
        let scene = outer.path().join("inner/scene.obj");
        let own = Folder::of(&scene, None);
        let message = own.read(Path::new("../lib/a.mgf")).unwrap_err();
        assert!(message.contains("leaves the folder of the scene") && message.contains("--root"), "{message}");
        assert_eq!(own.within_parent().read(Path::new("../lib/a.mgf")).unwrap(), b"m");
        assert!(own.within_parent().read(Path::new("../../etc/passwd")).unwrap_err().contains("leaves the root"));
        assert_eq!(Folder::of(&scene, Some(outer.path())).read(Path::new("../lib/a.mgf")).unwrap(), b"m");
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("../lib/a.mgf", outer.path().join("inner/link")).unwrap();
            std::os::unix::fs::symlink("../lib", outer.path().join("inner/folder")).unwrap();
            std::os::unix::fs::symlink("scene.obj", outer.path().join("inner/within")).unwrap();
            for link in ["link", "folder/a.mgf"] {
                assert!(own.read(Path::new(link)).unwrap_err().contains("is a link that leaves"), "{link}");
                assert_eq!(own.within_parent().read(Path::new(link)).unwrap(), b"m");
            }
            assert_eq!(own.read(Path::new("within")).unwrap(), b"o");
        }
    }

    #[test]
    fn capitals_do_not_count_where_nothing_has_the_very_name() {
        let outer = folders();
        let folder = Folder::of(&outer.path().join("inner/scene.obj"), None);
        assert_eq!(folder.read(Path::new("sub/wood.png")).unwrap(), b"w");
        assert!(folder.read(Path::new("sub/wool.png")).is_err());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_never_ends_is_refused() {
        let message = read_bounded(Path::new("/dev/zero")).unwrap_err().to_string();
        assert!(message.contains("more than 256 MiB"), "{message}");
    }
}
