//! Reading a scene, whatever its format: the file's first bytes decide, then its name.

use std::fs;
use std::path::Path;

use umbrage::scene::Scene;

use crate::{BakedFile, FormatError, Warning, gltf};

/// How a scene is read.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// Reflectances above it are capped, per channel and counted, 0 to 1: a white closed room has no solution.
    pub max_reflectance: f64,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self { max_reflectance: 0.9 }
    }
}

/// Formats that people try, and that are not read yet.
const KNOWN_ELSEWHERE: [(&str, &str); 12] = [
    ("obj", "Wavefront OBJ"),
    ("mgf", "MGF"),
    ("ply", "PLY"),
    ("stl", "STL"),
    ("fbx", "FBX"),
    ("blend", "a Blender file"),
    ("dae", "COLLADA"),
    ("3ds", "3DS"),
    ("ifc", "IFC"),
    ("skp", "a SketchUp file"),
    ("usd", "USD"),
    ("usdz", "USDZ"),
];

/// Reads a scene with the default options. Formats: glTF 2.0 as `.gltf` (buffers beside it or embedded) and `.glb`.
///
/// The scene is in metres, +Y up, all in world space; the warnings say what was ignored or altered, each kind once.
/// Nothing is said of whether it can be baked: that is [`Scene::validate`].
///
/// # Errors
/// A [`FormatError`] that names the file, the place in it, and how to mend it.
pub fn read_scene(path: impl AsRef<Path>) -> Result<(Scene, Vec<Warning>), FormatError> {
    read_scene_with(path, &ReadOptions::default())
}

/// Reads a scene: see [`read_scene`].
///
/// # Errors
/// A [`FormatError`] that names the file, the place in it, and how to mend it.
pub fn read_scene_with(path: impl AsRef<Path>, options: &ReadOptions) -> Result<(Scene, Vec<Warning>), FormatError> {
    let path = path.as_ref();
    read_scene_bytes(path, read_file(path)?, options)
}

/// Reads a scene from the bytes of a file. `path` tells the format by its ending, names the file in messages, and is
/// beside what the scene refers to.
///
/// # Errors
/// A [`FormatError`] that names the file, the place in it, and how to mend it.
pub fn read_scene_bytes(
    path: impl AsRef<Path>,
    bytes: Vec<u8>,
    options: &ReadOptions,
) -> Result<(Scene, Vec<Warning>), FormatError> {
    let path = path.as_ref();
    check_format(path, &bytes)?;
    gltf::read(path, bytes, options)
}

/// Reads a GLB that was baked.
///
/// # Errors
/// A [`FormatError`] that names the file, the place in it, and how to mend it; [`FormatError::NotBaked`] if it is a
/// glTF without baked light.
pub fn read_baked(path: impl AsRef<Path>) -> Result<BakedFile, FormatError> {
    let path = path.as_ref();
    read_baked_bytes(path, read_file(path)?)
}

/// Reads a baked GLB from the bytes of a file; `path` as in [`read_scene_bytes`].
///
/// # Errors
/// As [`read_baked`].
pub fn read_baked_bytes(path: impl AsRef<Path>, bytes: Vec<u8>) -> Result<BakedFile, FormatError> {
    let path = path.as_ref();
    check_format(path, &bytes)?;
    gltf::read_baked(path, bytes)
}

fn read_file(path: &Path) -> Result<Vec<u8>, FormatError> {
    fs::read(path).map_err(|source| FormatError::Unreadable { file: path.display().to_string(), source })
}

/// Whether a file is glTF, by its beginning or by its name.
fn check_format(path: &Path, bytes: &[u8]) -> Result<(), FormatError> {
    let file = path.display().to_string();
    if bytes.is_empty() {
        return Err(FormatError::Empty { file });
    }
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let is_json = text.trim_ascii_start().first() == Some(&b'{');
    if bytes.starts_with(&gltf::MAGIC) || is_json || ending == "gltf" {
        return Ok(());
    }
    if ending == "glb" {
        let what = "it does not begin with the letters glTF".to_owned();
        return Err(FormatError::BadContainer { file, what });
    }
    let known = KNOWN_ELSEWHERE.iter().find(|(known, _)| *known == ending).map(|(_, name)| (*name).to_owned());
    let found = known.unwrap_or_else(|| match ending.as_str() {
        "" => "a file without ending that does not begin like glTF".to_owned(),
        _ => format!("a file ending in .{ending}"),
    });
    Err(FormatError::UnknownFormat { file, found })
}
