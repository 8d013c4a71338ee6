//! Names of files that are saved from the window: beside what is open, and never over another file.

use std::path::{Path, PathBuf};

/// The first name of `room-view-1.png`, `room-view-2.png`, ... (for `path` = `room.glb`) that is free, in the same
/// folder.
pub(crate) fn free_name(path: &Path, what: &str, ending: &str) -> PathBuf {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let mut number = 1u32;
    loop {
        let name = path.with_file_name(format!("{stem}-{what}-{number}.{ending}"));
        if number == u32::MAX || !name.exists() {
            return name;
        }
        number += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_file_is_named_twice() {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("room.v2.glb");
        let first = free_name(&scene, "view", "png");
        assert_eq!(first, folder.path().join("room.v2-view-1.png"));
        std::fs::write(first, "").unwrap();
        assert_eq!(free_name(&scene, "view", "png"), folder.path().join("room.v2-view-2.png"));
        assert_eq!(free_name(&scene, "baked", "glb"), folder.path().join("room.v2-baked-1.glb"));
    }
}
