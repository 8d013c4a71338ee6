//! Files beside a scene that it refers to: material libraries, includes.
//!
//! A scene from a stranger shall not read the rest of the disk: names are taken relative to a folder, and what they mean
//! has to lie in the scene's folder or below. A pipe or a device would never end, so only plain files are read.

use std::fs;
use std::path::{Component, Path, PathBuf};

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

/// The bytes of a plain file.
///
/// # Errors
/// In words, if there is none or it cannot be read.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    match fs::metadata(path) {
        Err(error) => Err(format!("cannot be read ({error})")),
        Ok(metadata) if !metadata.is_file() => Err("is not a file".into()),
        Ok(_) => fs::read(path).map_err(|error| format!("cannot be read ({error})")),
    }
}

/// The folder that the names in a file are relative to.
pub(crate) fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
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
        assert!(read_file(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap_err().contains("not a file"));
        assert!(read_file(Path::new("nowhere/at/all")).is_err());
    }
}
