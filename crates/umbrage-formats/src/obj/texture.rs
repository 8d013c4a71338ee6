//! The images of an OBJ's materials, and what surfaces show of them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use umbrage::id::{ImageId, MaterialId};
use umbrage::scene::{Image, Rgb, Texture, Wrap};
use umbrage_picture::{MeanColor, Seen};

use super::mtl::MtlTexture;
use crate::beside::Folder;
use crate::builder::SceneBuilder;
use crate::{beside, texture_mean};

/// A texture that is used.
#[derive(Debug)]
struct Used {
    /// `Kd`, not capped.
    factor: Rgb,
    texture: MtlTexture,
    wrap: [Wrap; 2],
    /// Its number among the means.
    mean: usize,
}

/// The textures of all materials.
#[derive(Debug, Default)]
pub(super) struct Textures {
    used: BTreeMap<MaterialId, Used>,
    means: Vec<MeanColor>,
    /// By path.
    known: BTreeMap<PathBuf, (ImageId, usize)>,
    /// How many cannot be used, and why the first one cannot.
    pub(super) ignored: (usize, String),
}

impl Textures {
    /// Loads the image of a texture of a library that lies `below` the scene's `folder`; `None` if it cannot be used, which is
    /// counted.
    pub(super) fn load(
        &mut self,
        (folder, below): (&Folder, &Path),
        texture: &MtlTexture,
        factor: Rgb,
        builder: &mut SceneBuilder,
    ) -> Option<Texture> {
        let wrap = [if texture.clamp { Wrap::Clamp } else { Wrap::Repeat }; 2];
        match self.image((folder, below), &texture.file, builder) {
            Ok((image, _)) => Some(Texture { image, wrap, filters: [None; 2], factor: factor.min(Rgb::ONE) }),
            Err(why) => {
                if self.ignored.0 == 0 {
                    self.ignored.1 = format!("{}: {why}", crate::text::shortened(&texture.file));
                }
                self.ignored.0 += 1;
                None
            }
        }
    }

    /// Says that a material of the scene shows a texture that was loaded.
    pub(super) fn shows(&mut self, material: MaterialId, texture: MtlTexture, shown: Texture, factor: Rgb) {
        let mean = self.known.values().find(|known| known.0 == shown.image).map_or(0, |known| known.1);
        self.used.insert(material, Used { factor, texture, wrap: shown.wrap, mean });
    }

    fn image(
        &mut self,
        (folder, below): (&Folder, &Path),
        name: &str,
        builder: &mut SceneBuilder,
    ) -> Result<(ImageId, usize), String> {
        let relative = beside::relative_path(below, name)?;
        if let Some(&known) = self.known.get(&relative) {
            return Ok(known);
        }
        let bytes = folder.read(&relative)?;
        let mean = MeanColor::decode(&bytes, false).map_err(|error| error.to_string())?;
        let name = relative.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let known = (builder.image(Image { name, bytes: bytes.into() }), self.means.len());
        self.means.push(mean);
        self.known.insert(relative, known);
        Ok(known)
    }

    /// Whether a material shows an image, so that its surfaces need texture coordinates.
    pub(super) fn is_on(&self, material: MaterialId) -> bool {
        self.used.contains_key(&material)
    }

    /// The place in its image that coordinates of a corner mean.
    pub(super) fn place(&self, material: MaterialId, coordinates: DVec2) -> DVec2 {
        let Some(Used { texture, .. }) = self.used.get(&material) else { return coordinates };
        let moved = coordinates * DVec2::from(texture.scale) + DVec2::from(texture.offset);
        // In an OBJ, v grows upwards.
        DVec2::new(moved.x, 1.0 - moved.y)
    }

    /// Gives every material with an image the mean reflectance of what its surfaces show.
    pub(super) fn set_reflectances(&self, builder: &mut SceneBuilder) {
        let mut seen: BTreeMap<MaterialId, Seen> = BTreeMap::new();
        for (_, surface) in builder.surfaces_mut() {
            let Some(used) = self.used.get(&surface.material) else { continue };
            let fans = surface.polygons.iter().flat_map(|polygon| {
                (2..polygon.len()).map(|i| [polygon[0], polygon[i - 1], polygon[i]].map(|corner| corner as usize))
            });
            let positions_m: &[DVec3] = &surface.positions_m;
            let sum = texture_mean::over(&self.means[used.mean], used.wrap, fans, positions_m, &surface.uvs);
            let all = seen.entry(surface.material).or_default();
            *all = all.plus(1.0, sum);
        }
        for (&material, used) in &self.used {
            let seen = seen.get(&material).filter(|seen| seen.alpha > 0.0);
            let mean = seen.copied().unwrap_or_else(|| self.means[used.mean].whole());
            builder.set_reflectance(material, used.factor * Rgb::from(mean.color()));
        }
    }
}
