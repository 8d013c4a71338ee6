//! The files of an MGF scene: each read once, included any number of times, never within itself.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::FormatError;
use crate::beside::{self, Folder};
use crate::text::Place;

/// Includes deeper than this are refused: nobody makes them.
const MAX_DEPTH: usize = 64;

/// A file's bytes.
#[derive(Debug)]
pub(super) struct Source {
    /// As messages name it.
    pub(super) file: String,
    /// Relative to the scene's folder.
    path: PathBuf,
    pub(super) bytes: Vec<u8>,
}

/// All files that have been read.
#[derive(Debug)]
pub(super) struct Sources {
    folder: Folder,
    read: BTreeMap<PathBuf, Rc<Source>>,
}

impl Sources {
    /// The scene's own file, and no others yet.
    pub(super) fn new(path: &Path, bytes: &[u8], folder: &Folder) -> (Self, Rc<Source>) {
        let own = PathBuf::from(path.file_name().unwrap_or_default());
        let main = Source { file: path.display().to_string(), path: own.clone(), bytes: bytes.to_vec() };
        let main = Rc::new(main);
        let read = BTreeMap::from([(own, Rc::clone(&main))]);
        (Self { folder: folder.clone(), read }, main)
    }

    /// The file that `name` means in the last of the open files; and the bytes that were read for it.
    pub(super) fn include(
        &mut self,
        place: Place<'_>,
        name: &str,
        open: &[&Rc<Source>],
    ) -> Result<(Rc<Source>, usize), FormatError> {
        let cure = "put the file beside the scene, or remove the line";
        let from = open.last().and_then(|source| source.path.parent()).unwrap_or(Path::new(""));
        let bad = |what: &str| place.bad(format!("the include {:?} {what}", crate::text::shortened(name)), cure);
        let path = beside::relative_path(from, name).map_err(bad)?;
        if open.iter().any(|source| source.path == path) {
            return Err(bad("includes itself"));
        }
        if open.len() >= MAX_DEPTH {
            return Err(bad("is too deep"));
        }
        if let Some(source) = self.read.get(&path) {
            return Ok((Rc::clone(source), 0));
        }
        let bytes = self.folder.read(&path).map_err(|what| bad(&what))?;
        let length = bytes.len();
        let source = Rc::new(Source { file: self.folder.join(&path).display().to_string(), path: path.clone(), bytes });
        self.read.insert(path, Rc::clone(&source));
        Ok((source, length))
    }
}
