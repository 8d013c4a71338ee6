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
    let bytes = gltf_bytes(path)?;
    gltf::read(path, bytes, options)
}

/// Reads a GLB that was baked.
///
/// # Errors
/// A [`FormatError`] that names the file, the place in it, and how to mend it; [`FormatError::NotBaked`] if it is a
/// glTF without baked light.
pub fn read_baked(path: impl AsRef<Path>) -> Result<BakedFile, FormatError> {
    let path = path.as_ref();
    let bytes = gltf_bytes(path)?;
    gltf::read_baked(path, bytes)
}

/// The bytes of a file that is glTF by its beginning or by its name.
fn gltf_bytes(path: &Path) -> Result<Vec<u8>, FormatError> {
    let file = path.display().to_string();
    let bytes = fs::read(path).map_err(|source| FormatError::Unreadable { file: file.clone(), source })?;
    if bytes.is_empty() {
        return Err(FormatError::Empty { file });
    }
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes);
    let is_json = text.trim_ascii_start().first() == Some(&b'{');
    if bytes.starts_with(&gltf::MAGIC) || is_json || ending == "gltf" {
        return Ok(bytes);
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
