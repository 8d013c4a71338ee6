//! Reading a scene, whatever its format: the file's first bytes decide, then its name.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use umbrage::scene::Scene;

use crate::beside::{Folder, read_bounded};
use crate::text::{shortened, utf8};
use crate::{BakedFile, FormatError, Warning, gltf, mgf, obj, ply, stl};

/// How a scene is read.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// Reflectances above it are capped, per channel and counted, 0 to 1: a white closed room has no solution.
    pub max_reflectance: f64,
    /// Length of the file's unit, in metres: 0.001 for a file in millimetres. glTF and MGF say that theirs is the metre,
    /// and many files do not keep to it; the other formats say nothing.
    pub unit_m: f64,
    /// The axis of the file that points up; the scene's is Y.
    pub up: UpAxis,
    /// Chords of a full circle, where a format has curved shapes: 24 are off by 0.9 % of the radius at most.
    pub circle_segments: usize,
    /// What the brightness of lamps is given in, beside that of surfaces.
    pub lamp_units: LampUnits,
    /// Names of materials that give no light, whatever the file says: what is seen on them is then their base colour with its
    /// texture, and not their emission.
    pub dark: Vec<String>,
    /// The folder that all files which the scene refers to have to lie in, links followed; `None` is the scene's own, and for MGF,
    /// whose includes are often in a folder beside, that one's parent.
    pub root: Option<PathBuf>,
}

/// What the brightness of lamps is given in, beside that of surfaces that emit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LampUnits {
    /// The same as that of surfaces: both are photometric (cd and cd/m2, as glTF says), or both are radiometric.
    #[default]
    Same,
    /// Lamps are photometric (candela, lux) and surfaces radiometric (W/(m2 sr)), as Blender writes them: lamps are divided by
    /// 683 lm/W.
    Lumens,
}

/// The axis of a file that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// Y, as in glTF.
    #[default]
    Y,
    /// Z, as is usual in MGF, STL and what comes from CAD: the scene is turned about X, so that it stands upright.
    Z,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            max_reflectance: 0.9,
            unit_m: 1.0,
            up: UpAxis::Y,
            circle_segments: 24,
            lamp_units: LampUnits::Same,
            dark: Vec::new(),
            root: None,
        }
    }
}

/// A scene that was read, and the files that were asked for: see [`read_scene_and_files`].
#[derive(Debug)]
pub struct SceneAndFiles {
    /// The scene and its warnings, or why there is none.
    pub scene: Result<(Scene, Vec<Warning>), FormatError>,
    /// The scene's own file first, each file once.
    pub files: Vec<PathBuf>,
}

/// What to do with a file of no known format.
const EXPORT: &str = "export the scene as glTF 2.0 (.glb or .gltf), OBJ, MGF, PLY or STL";
/// What to do with one that Blender opens.
const BY_BLENDER: &str = "open it in Blender and export it with File > Export > glTF 2.0, Punctual Lights ticked";
const FROM_BLENDER: &str = "in Blender, choose File > Export > glTF 2.0 and tick Data > Lighting > Punctual Lights";
const FROM_ITS_PROGRAM: &str = "export it as glTF 2.0 (.glb) or OBJ from the program that made it";

/// A format that people try, and that is not read.
struct Elsewhere {
    endings: &'static [&'static str],
    /// How its files begin.
    begins: &'static [&'static [u8]],
    name: &'static str,
    cure: &'static str,
}

const ELSEWHERE: [Elsewhere; 8] = [
    Elsewhere { endings: &["blend"], begins: &[b"BLENDER"], name: "a Blender file", cure: FROM_BLENDER },
    Elsewhere { endings: &["fbx"], begins: &[b"Kaydara FBX"], name: "FBX", cure: BY_BLENDER },
    Elsewhere {
        endings: &["usd", "usda", "usdc", "usdz"],
        begins: &[b"#usda", b"PXR-USDC"],
        name: "USD",
        cure: BY_BLENDER,
    },
    Elsewhere { endings: &["dae"], begins: &[], name: "COLLADA", cure: BY_BLENDER },
    Elsewhere { endings: &["3ds"], begins: &[], name: "3DS", cure: FROM_ITS_PROGRAM },
    Elsewhere { endings: &["max"], begins: &[], name: "a 3ds Max file", cure: FROM_ITS_PROGRAM },
    Elsewhere { endings: &["ifc"], begins: &[b"ISO-10303-21"], name: "IFC", cure: BY_BLENDER },
    Elsewhere { endings: &["skp"], begins: &[], name: "a SketchUp file", cure: FROM_ITS_PROGRAM },
];

/// Reads a scene with the default options. Formats: glTF 2.0 as `.gltf` (buffers beside it or embedded) and `.glb`,
/// Wavefront `.obj` with its material libraries, `.mgf`, `.ply` and `.stl`.
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
    read_in(path, bytes, &Folder::of(path, options.root.as_deref()), options)
}

/// Reads a scene, and tells what files it is made of, which have to be looked at to know when it changes: its own, and all
/// that it refers to, whether they are there or not. Where reading fails, those that were asked for until then.
///
/// ```
/// use umbrage_formats::{ReadOptions, read_scene_and_files};
///
/// let read = read_scene_and_files("no/such/room.obj", &ReadOptions::default());
/// assert!(read.scene.is_err() && read.files == [std::path::Path::new("no/such/room.obj")]);
/// ```
pub fn read_scene_and_files(path: impl AsRef<Path>, options: &ReadOptions) -> SceneAndFiles {
    let path = path.as_ref();
    let folder = Folder::of(path, options.root.as_deref());
    let scene = read_file(path).and_then(|bytes| read_in(path, bytes, &folder, options));
    let mut files = folder.asked();
    // A file may refer to itself.
    files.remove(path);
    SceneAndFiles { scene, files: std::iter::once(path.to_path_buf()).chain(files).collect() }
}

/// Reads a scene from the bytes of a file; what it refers to is in `folder`.
fn read_in(
    path: &Path,
    bytes: Vec<u8>,
    folder: &Folder,
    options: &ReadOptions,
) -> Result<(Scene, Vec<Warning>), FormatError> {
    let bytes = utf8(bytes);
    let (mut scene, warnings) = match format_of(path, &bytes)? {
        Format::Gltf => gltf::read(path, bytes, folder, options),
        Format::Mgf => mgf::read(path, &bytes, &folder.within_parent(), options),
        Format::Obj => obj::read(path, &bytes, folder, options),
        Format::Ply => ply::read(path, &bytes, options),
        Format::Stl => stl::read(path, &bytes, options),
    }?;
    to_metres(path, &mut scene, options)?;
    Ok((scene, warnings))
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
    if format_of(path, &bytes)? != Format::Gltf {
        let (file, place) = (path.display().to_string(), "the file".to_owned());
        return Err(FormatError::NotBaked { file, place, what: "glTF document" });
    }
    gltf::read_baked(path, bytes)
}

fn read_file(path: &Path) -> Result<Vec<u8>, FormatError> {
    read_bounded(path).map_err(|source| FormatError::Unreadable { file: path.display().to_string(), source })
}

/// Takes a scene from the file's unit and axes to metres with Y up.
fn to_metres(path: &Path, scene: &mut Scene, options: &ReadOptions) -> Result<(), FormatError> {
    if options.unit_m == 1.0 && options.up == UpAxis::Y {
        return Ok(());
    }
    let upright = |p: DVec3| match options.up {
        UpAxis::Y => p,
        UpAxis::Z => DVec3::new(p.x, p.z, -p.y),
    };
    for lamp in &mut scene.lamps {
        *lamp = lamp.clone().moved(|p| options.unit_m * upright(p), upright, options.unit_m);
    }
    let axes = DMat3::from_cols(upright(DVec3::X), upright(DVec3::Y), upright(DVec3::Z));
    for camera in &mut scene.cameras {
        let DAffine3 { matrix3, translation } = camera.to_world;
        camera.to_world = DAffine3 { matrix3: axes * matrix3, translation: options.unit_m * upright(translation) };
        camera.lens = camera.lens.scaled(options.unit_m);
    }
    for surface in scene.surfaces.iter_mut().chain(&mut scene.see_through) {
        surface.normals.iter_mut().for_each(|normal| *normal = upright(*normal));
        for p in &mut surface.positions_m {
            *p = options.unit_m * upright(*p);
            if !p.is_finite() {
                let (file, place) = (path.display().to_string(), "a corner, in metres".to_owned());
                return Err(FormatError::NotFinite { file, place, value: p.to_string() });
            }
        }
    }
    Ok(())
}

/// The formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Gltf,
    Mgf,
    Obj,
    Ply,
    Stl,
}

/// Formats that their beginning does not tell, by ending.
const BY_ENDING: [(&str, Format); 5] =
    [("gltf", Format::Gltf), ("mgf", Format::Mgf), ("obj", Format::Obj), ("ply", Format::Ply), ("stl", Format::Stl)];

/// The format of a file, by its beginning or by its name.
fn format_of(path: &Path, bytes: &[u8]) -> Result<Format, FormatError> {
    let file = path.display().to_string();
    if bytes.is_empty() {
        return Err(FormatError::Empty { file });
    }
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if bytes.starts_with(&gltf::MAGIC) || text.trim_ascii_start().first() == Some(&b'{') {
        return Ok(Format::Gltf);
    }
    if ply::begins(bytes) {
        return Ok(Format::Ply);
    }
    if ending == "glb" {
        let what = "it does not begin with the letters glTF".to_owned();
        return Err(FormatError::BadContainer { file, what });
    }
    if let Some((_, format)) = BY_ENDING.iter().find(|(known, _)| *known == ending) {
        return Ok(*format);
    }
    let elsewhere = ELSEWHERE.iter().find(|format| {
        format.endings.contains(&ending.as_str()) || format.begins.iter().any(|begin| bytes.starts_with(begin))
    });
    let (found, cure) = match (elsewhere, ending.as_str()) {
        (Some(format), _) => (format.name.to_owned(), format.cure),
        (None, "") => ("a file without ending that does not begin like glTF".to_owned(), EXPORT),
        (None, ending) => (format!("a file ending in .{}", shortened(ending)), EXPORT),
    };
    Err(FormatError::UnknownFormat { file, found, cure })
}
