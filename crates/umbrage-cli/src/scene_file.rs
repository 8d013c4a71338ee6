//! Reading a scene for a command: with its warnings told.

use std::path::Path;

use umbrage::scene::Scene;

use crate::output;

/// Reads a scene, and tells what of the file was not taken over.
pub(crate) fn read(path: &Path) -> anyhow::Result<Scene> {
    let (scene, warnings) = umbrage_formats::read_scene(path)?;
    for warning in &warnings {
        output::warning(&format!("{}: {warning}", path.display()));
    }
    Ok(scene)
}
