//! Atomic writes: a reader sees the old file or the new one, never a half.
//!
//! The bytes go to a temporary file beside the target, which is then renamed over it. A failure or a killed process
//! leaves the target as it was. [`check_writable`] tells before long work whether that will be possible. A link is followed, and a device (`/dev/null`)
//! is written to, never replaced. Temporary files bear the number of their process; those of processes that were killed are removed when
//! another file is written beside them.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::NamedTempFile;

use crate::FormatError;

/// Writes `bytes` to `path`, all or nothing.
///
/// # Errors
/// [`FormatError::Unwritable`] if the folder, the temporary file or the renaming is refused; the old file then stands.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), FormatError> {
    write(path, bytes).map_err(|source| FormatError::Unwritable { file: path.display().to_string(), source })
}

/// Checks that a file can be written: makes a temporary file beside it, and removes that.
///
/// # Errors
/// [`FormatError::Unwritable`] as [`write_atomically`].
pub fn check_writable(path: &Path) -> Result<(), FormatError> {
    let checked = if is_device(path) { Ok(()) } else { temporary_beside(&real(path)).map(drop) };
    checked.map_err(|source| FormatError::Unwritable { file: path.display().to_string(), source })
}

fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if is_device(path) {
        return fs::write(path, bytes);
    }
    let path = real(path);
    let mut file = temporary_beside(&path)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// How temporary files are called: what comes before the number of the process, and at the end.
const PREFIX: &str = ".umbrage-";
const SUFFIX: &str = ".part";

/// Where the system does not tell which processes run, a temporary file is left over once it is so old.
const STALE_AFTER: Duration = Duration::from_secs(24 * 3600);

/// Removes temporary files that processes have left which are no more. What cannot be looked at or removed stays.
fn remove_stale(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.filter_map(Result::ok) {
        let name = entry.file_name();
        let part = name.to_str().and_then(|name| name.strip_prefix(PREFIX)?.strip_suffix(SUFFIX));
        let is_plain = || entry.file_type().is_ok_and(|kind| kind.is_file());
        if part.is_some_and(|part| is_stale(part, &entry)) && is_plain() {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Whether nobody writes a temporary file any more; `part` is the middle of its name.
fn is_stale(part: &str, entry: &fs::DirEntry) -> bool {
    let processes = Path::new("/proc");
    match part.split_once('-').and_then(|(process, _)| process.parse::<u32>().ok()) {
        Some(process) if process == std::process::id() => false,
        Some(process) if processes.join("self").exists() => !processes.join(process.to_string()).exists(),
        _ => {
            let modified = entry.metadata().and_then(|metadata| metadata.modified());
            modified.is_ok_and(|modified| modified.elapsed().is_ok_and(|age| age > STALE_AFTER))
        }
    }
}

fn is_device(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|old| !old.is_file() && !old.is_dir())
}

/// Where a path leads, over links.
fn real(path: &Path) -> PathBuf {
    if let Ok(real) = fs::canonicalize(path) {
        return real;
    }
    // A link to a file that is not there yet.
    match fs::read_link(path) {
        Ok(target) => path.parent().unwrap_or(Path::new("")).join(target),
        Err(_) => path.to_path_buf(),
    }
}

/// An empty temporary file that can be renamed to `path`, as readable as the file that is there.
fn temporary_beside(path: &Path) -> io::Result<NamedTempFile> {
    let old = fs::metadata(path).ok();
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    remove_stale(folder);
    let prefix = format!("{PREFIX}{}-", std::process::id());
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(SUFFIX);
    // A temporary file is private by default; the result should be as readable as the file it replaces, or as any
    // other new one.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder)?;
    if let Some(old) = old {
        if old.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "there is a folder of this name"));
        }
        file.as_file().set_permissions(old.permissions())?;
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_write_replaces_the_old_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.glb");
        write_atomically(&path, b"one").unwrap();
        write_atomically(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(names(folder.path()), ["out.glb"]);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none").join("out.glb");
        let message = write_atomically(&path, b"one").unwrap_err().to_string();
        assert!(message.contains("out.glb") && message.contains("folder exists"), "{message}");
        let message = check_writable(&path).unwrap_err().to_string();
        assert!(message.contains("out.glb") && message.contains("folder exists"), "{message}");
    }

    #[test]
    fn a_check_leaves_all_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.glb");
        check_writable(&path).unwrap();
        assert!(names(folder.path()).is_empty());
        write_atomically(&path, b"old").unwrap();
        check_writable(&path).unwrap();
        assert_eq!((fs::read(&path).unwrap(), names(folder.path()).len()), (b"old".to_vec(), 1));
        assert!(check_writable(folder.path()).is_err(), "a folder is no file");
    }

    #[test]
    fn a_folder_of_that_name_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.glb");
        fs::create_dir(&path).unwrap();
        assert!(matches!(write_atomically(&path, b"one"), Err(FormatError::Unwritable { .. })));
        assert_eq!(names(folder.path()), ["out.glb"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_dead_processes_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        // Numbers of processes end below 2^22.
        let own = format!(".umbrage-{}-abc.part", std::process::id());
        for name in [".umbrage-4294967295-abc.part", own.as_str(), ".umbrage-new.part", "umbrage-4294967295-a.part"] {
            fs::write(folder.path().join(name), "x").unwrap();
        }
        write_atomically(&folder.path().join("out.glb"), b"one").unwrap();
        let mut kept = vec![own.as_str(), ".umbrage-new.part", "out.glb", "umbrage-4294967295-a.part"];
        kept.sort_unstable();
        assert_eq!(names(folder.path()), kept);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("out.glb"), folder.path().join("link.glb"));
        write_atomically(&path, b"one").unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write_atomically(&link, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        fs::remove_file(&path).unwrap();
        write_atomically(&link, b"three").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"three", "also to a file that is not there");
    }

    #[cfg(unix)]
    #[test]
    fn a_failing_write_leaves_the_old_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.glb");
        write_atomically(&path, b"old").unwrap();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).unwrap();
        let refused = write_atomically(&path, b"new");
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
        // The superuser may write anywhere: then there is no failure to test.
        let expected: &[u8] = if refused.is_ok() { b"new" } else { b"old" };
        assert_eq!(fs::read(&path).unwrap(), expected);
        assert_eq!(names(folder.path()), ["out.glb"]);
    }
}
