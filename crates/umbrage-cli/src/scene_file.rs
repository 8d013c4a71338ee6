//! Reading a scene for a command: with its warnings told.

use std::path::Path;

use umbrage::scene::Scene;
use umbrage_formats::{ReadOptions, read_scene_with};

use crate::output;

/// Reads a scene, and tells what of the file was not taken over.
pub(crate) fn read(path: &Path, options: &ReadOptions) -> anyhow::Result<Scene> {
    let (scene, warnings) = read_scene_with(path, options)?;
    for warning in &warnings {
        output::warning(&format!("{}: {warning}", path.display()));
    }
    Ok(scene)
}
