//! The materials of an OBJ: those of its libraries, and greys for those that are nowhere.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use umbrage::id::MaterialId;
use umbrage::scene::{Alpha, Look, Material, Rgb};

use super::mtl::{self, MtlMaterial};
use super::texture::{Shown, Textures};
use crate::beside::{self, Folder};
use crate::builder::SceneBuilder;
use crate::warning::Unknown;
use crate::{FormatError, Warning};

/// The name of what stands for no material at all.
const NO_MATERIAL: &str = "default";

/// What lets at least half of the light through (`d` of a half and less) blocks nothing, as glass of a glTF.
const GLASS_OPACITY: f64 = 0.5;

/// Missing libraries that have a warning of their own.
const NAMED_LIBRARIES: usize = 4;

/// Opacity below which what has an image of it is not seen: what glTF gives a mask that says nothing.
const CUTOFF: f64 = 0.5;

/// What a polygon's material is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Use {
    /// A material of the scene.
    Opaque(MaterialId),
    /// A material of the scene that light passes through.
    Glass(MaterialId),
    /// Fully transparent: the polygon is left out.
    Transparent,
}

/// All materials by name.
#[derive(Debug, Default)]
pub(super) struct Materials {
    by_name: BTreeMap<String, Use>,
    without: Option<MaterialId>,
    missing: Vec<String>,
    /// The images on them.
    pub(super) textures: Textures,
    half_transparent: usize,
    warnings: Vec<Warning>,
}

/// Collects what `mtllib` statements name, each file once, later materials over earlier ones of the same name.
#[derive(Debug)]
pub(super) struct Libraries<'a> {
    path: &'a Path,
    folder: &'a Folder,
    read: BTreeSet<std::path::PathBuf>,
    /// In the order in which they were first named, each with the folder of its library.
    materials: Vec<(std::path::PathBuf, MtlMaterial)>,
    numbers: BTreeMap<String, usize>,
    warnings: Vec<Warning>,
    /// Libraries that are missing beside those that have a warning.
    more_missing: usize,
}

impl<'a> Libraries<'a> {
    /// None yet, for the OBJ at `path` in `folder`.
    pub(super) fn new(path: &'a Path, folder: &'a Folder) -> Self {
        let (materials, numbers) = (Vec::new(), BTreeMap::new());
        Self { path, folder, read: BTreeSet::new(), materials, numbers, warnings: Vec::new(), more_missing: 0 }
    }

    /// Reads what an `mtllib` statement names: one file, whose name may have spaces, else several.
    ///
    /// Files get renamed together with their libraries and the statement forgotten: if nothing is there, the library
    /// that is named like the OBJ is taken.
    pub(super) fn add(
        &mut self,
        names: &str,
        builder: &mut SceneBuilder,
        unknown: &mut Unknown,
    ) -> Result<(), FormatError> {
        let whole = self.file(names);
        if whole.is_ok() || !names.contains(char::is_whitespace) {
            return self.add_one(names, whole, builder, unknown);
        }
        for name in names.split_ascii_whitespace() {
            let file = self.file(name);
            self.add_one(name, file, builder, unknown)?;
        }
        Ok(())
    }

    /// The bytes of a library, and the path that they are from; nothing if it was read before.
    fn file(&self, name: &str) -> Result<Option<(std::path::PathBuf, Vec<u8>)>, String> {
        let relative = beside::relative_path(Path::new(""), name)?;
        if self.read.contains(&relative) {
            return Ok(None);
        }
        let bytes = self.folder.read(&relative)?;
        Ok(Some((relative, bytes)))
    }

    fn add_one(
        &mut self,
        name: &str,
        file: Result<Option<(std::path::PathBuf, Vec<u8>)>, String>,
        builder: &mut SceneBuilder,
        unknown: &mut Unknown,
    ) -> Result<(), FormatError> {
        let why = match file {
            Ok(None) => return Ok(()),
            Ok(Some(file)) => return self.parse(file, builder, unknown),
            Err(why) => why,
        };
        let own = self.path.with_extension("mtl").file_name().map(|own| own.to_string_lossy().into_owned());
        let instead = own.and_then(|own| self.file(&own).ok().flatten());
        let library = crate::text::shortened(name);
        let replaced_by = instead.as_ref().map(|(path, _)| path.display().to_string());
        let warning = Warning::MaterialLibraryMissing { library, why, replaced_by };
        if self.warnings.len() >= NAMED_LIBRARIES {
            self.more_missing += 1;
        } else if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
        instead.map_or(Ok(()), |file| self.parse(file, builder, unknown))
    }

    fn parse(
        &mut self,
        (relative, bytes): (std::path::PathBuf, Vec<u8>),
        builder: &mut SceneBuilder,
        unknown: &mut Unknown,
    ) -> Result<(), FormatError> {
        builder.budget.grow(bytes.len());
        let file = self.folder.join(&relative).display().to_string();
        let folder = relative.parent().unwrap_or(Path::new("")).to_path_buf();
        for material in mtl::read(&file, &bytes, |word| unknown.add(word))? {
            let next = self.materials.len();
            match *self.numbers.entry(material.name.clone()).or_insert(next) {
                number if number < next => self.materials[number] = (folder.clone(), material),
                _ => self.materials.push((folder.clone(), material)),
            }
        }
        self.read.insert(relative);
        Ok(())
    }
}

impl Materials {
    /// The materials of the libraries, in their order.
    pub(super) fn new(libraries: Libraries<'_>, builder: &mut SceneBuilder) -> Self {
        let mut materials = Self { warnings: libraries.warnings, ..Self::default() };
        if libraries.more_missing > 0 {
            materials.warnings.push(Warning::MoreLibrariesMissing { libraries: libraries.more_missing });
        }
        for (folder, mut material) in libraries.materials {
            if material.opacity <= 0.0 {
                materials.by_name.insert(material.name, Use::Transparent);
                continue;
            }
            if builder.is_dark(&material.name) {
                (material.radiance, material.emission_texture) = (Rgb::ZERO, None);
            }
            let images = materials.textures.load((libraries.folder, &folder), &material, builder);
            let emits = material.radiance != Rgb::ZERO;
            let is_glass = material.opacity <= GLASS_OPACITY && !emits;
            materials.half_transparent += usize::from((material.opacity < 1.0 && !is_glass) || images.cut_out);
            let opacity = material.opacity.min(1.0);
            // What a material reflects and emits is known once its surfaces are, where there is an image on it.
            let known = |colour: Rgb, image: &Option<Shown>| if image.is_some() { Rgb::ZERO } else { colour };
            let MtlMaterial { name, reflectance, radiance, .. } = material;
            let reflectance = known(reflectance, &images.colour);
            let texture = match (&images.emission, &images.colour) {
                (Some(emission), _) => Some(emission.texture(Rgb::INFINITY)),
                (None, colour) => colour.as_ref().map(|colour| colour.texture(Rgb::ONE)),
            };
            let is_cut = images.cut_out && images.emission.is_none();
            let alpha = match (is_glass, is_cut) {
                (true, _) => Alpha::Blend { alpha: opacity },
                (false, true) => Alpha::Mask { alpha: 1.0, cutoff: CUTOFF },
                (false, false) => Alpha::Opaque,
            };
            let look = Look { texture, alpha, ..Look::default() };
            let radiance = known(radiance, &images.emission);
            let id = builder.material(Material { radiance, look, ..Material::diffuse(name.clone(), reflectance) });
            materials.textures.shows(id, images);
            if is_glass {
                builder.see_through(id);
            }
            materials.by_name.insert(name, if is_glass { Use::Glass(id) } else { Use::Opaque(id) });
        }
        materials
    }

    /// What `usemtl` with this name means.
    pub(super) fn named(&mut self, name: &str, builder: &mut SceneBuilder) -> Use {
        if let Some(&found) = self.by_name.get(name) {
            return found;
        }
        let grey = Use::Opaque(builder.grey(name));
        self.by_name.insert(name.to_owned(), grey);
        self.missing.push(name.to_owned());
        grey
    }

    /// What polygons before the first `usemtl` have.
    pub(super) fn none(&mut self, builder: &mut SceneBuilder) -> Use {
        Use::Opaque(*self.without.get_or_insert_with(|| builder.grey(NO_MATERIAL)))
    }

    /// What there is to say of them.
    pub(super) fn warnings(self) -> Vec<Warning> {
        let mut warnings = self.warnings;
        if let Some(first) = self.missing.first() {
            warnings.push(Warning::MaterialsMissing { materials: self.missing.len(), first: first.clone() });
        }
        let (uses, first) = self.textures.ignored;
        if uses > 0 {
            warnings.push(Warning::TexturesIgnored { uses, first });
        }
        if self.half_transparent > 0 {
            warnings.push(Warning::AlphaIgnored { materials: self.half_transparent });
        }
        warnings
    }
}
