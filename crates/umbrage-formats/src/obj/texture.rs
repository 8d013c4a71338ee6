//! The images of an OBJ's materials, and what surfaces show of them.
//!
//! A material may have an image of its colour (`map_Kd`), of its emission (`map_Ke`) and of its opacity (`map_d`). One of them is
//! seen on it: that of the emission if it emits, else that of the colour, with the opacity as its alpha. Each has a scale and an
//! offset of its own, so surfaces keep the coordinates of the file until all means are known.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use umbrage::id::{ImageId, MaterialId};
use umbrage::scene::{Image, Rgb, Surface, Texture, Wrap};
use umbrage_picture::{MeanColor, Seen, for_viewers, with_opacity};

use super::mtl::{MtlMaterial, MtlTexture};
use crate::beside::Folder;
use crate::builder::SceneBuilder;
use crate::{beside, texture_mean};

/// An image on a material.
#[derive(Clone, Debug)]
pub(super) struct Shown {
    /// What its texels are multiplied with: `Kd` or `Ke`, not capped.
    factor: Rgb,
    at: MtlTexture,
    wrap: [Wrap; 2],
    image: ImageId,
    /// Its number among the means.
    mean: usize,
}

impl Shown {
    /// As the scene has it.
    pub(super) fn texture(&self, most: Rgb) -> Texture {
        Texture { image: self.image, wrap: self.wrap, filters: [None; 2], factor: self.factor.min(most) }
    }

    /// The place in the image that coordinates of the file mean; the image's corner where they are beyond all bounds.
    fn place(&self, coordinates: DVec2) -> DVec2 {
        let moved = coordinates * DVec2::from(self.at.scale) + DVec2::from(self.at.offset);
        // In an OBJ, v grows upwards.
        let place = DVec2::new(moved.x, 1.0 - moved.y);
        if place.as_vec2().is_finite() { place } else { DVec2::ZERO }
    }
}

/// The images of a material that could be loaded.
#[derive(Clone, Debug, Default)]
pub(super) struct Images {
    /// `map_Kd`, with `map_d` as its alpha.
    pub(super) colour: Option<Shown>,
    /// `map_Ke`.
    pub(super) emission: Option<Shown>,
    /// Whether the alpha of the first is opacity.
    pub(super) cut_out: bool,
}

impl Images {
    /// The one that is seen.
    pub(super) fn seen(&self) -> Option<&Shown> {
        self.emission.as_ref().or(self.colour.as_ref())
    }
}

/// A file of an image, and that of its opacity.
type Files = (Option<PathBuf>, Option<PathBuf>);

/// The textures of all materials.
#[derive(Debug, Default)]
pub(super) struct Textures {
    used: BTreeMap<MaterialId, Images>,
    means: Vec<MeanColor>,
    known: BTreeMap<Files, (ImageId, usize)>,
    /// How many cannot be used, and why the first one cannot.
    pub(super) ignored: (usize, String),
}

impl Textures {
    /// Loads the images of a material of a library that lies `below` the scene's `folder`; those that cannot be used are counted.
    pub(super) fn load(
        &mut self,
        (folder, below): (&Folder, &Path),
        material: &MtlMaterial,
        builder: &mut SceneBuilder,
    ) -> Images {
        let from = (folder, below);
        let (colour, opacity) = (material.texture.as_ref(), material.opacity_texture.as_ref());
        let both = self.shown(from, (colour, opacity), material.reflectance, builder);
        let cut_out = opacity.is_some() && both.is_some();
        // What one of them cannot give, the other may.
        let colour = both.or_else(|| {
            opacity.and(colour).and_then(|colour| self.shown(from, (Some(colour), None), material.reflectance, builder))
        });
        let emits = material.radiance != Rgb::ZERO;
        let emission = material.emission_texture.as_ref().filter(|_| emits);
        let emission =
            emission.and_then(|emission| self.shown(from, (Some(emission), None), material.radiance, builder));
        Images { colour, emission, cut_out }
    }

    /// Says that a material of the scene shows images.
    pub(super) fn shows(&mut self, material: MaterialId, images: Images) {
        if images.seen().is_some() {
            self.used.insert(material, images);
        }
    }

    fn shown(
        &mut self,
        from: (&Folder, &Path),
        (colour, opacity): (Option<&MtlTexture>, Option<&MtlTexture>),
        factor: Rgb,
        builder: &mut SceneBuilder,
    ) -> Option<Shown> {
        let at = colour.or(opacity)?.clone();
        match self.image(from, (colour, opacity), builder) {
            Ok((image, mean)) => {
                let wrap = [if at.clamp { Wrap::Clamp } else { Wrap::Repeat }; 2];
                Some(Shown { factor, at, wrap, image, mean })
            }
            Err(why) => {
                if self.ignored.0 == 0 {
                    self.ignored.1 = why;
                }
                self.ignored.0 += 1;
                None
            }
        }
    }

    fn image(
        &mut self,
        (folder, below): (&Folder, &Path),
        (colour, opacity): (Option<&MtlTexture>, Option<&MtlTexture>),
        builder: &mut SceneBuilder,
    ) -> Result<(ImageId, usize), String> {
        let named = |file: &str, why: String| format!("{}: {why}", crate::text::shortened(file));
        let path = |texture: Option<&MtlTexture>| {
            let path =
                |t: &MtlTexture| beside::relative_path(below, &t.file).map_err(|why| named(&t.file, why.to_owned()));
            texture.map(path).transpose()
        };
        let files = (path(colour)?, path(opacity)?);
        if let Some(&known) = self.known.get(&files) {
            return Ok(known);
        }
        let bytes = |path: &Option<PathBuf>| {
            let read = |path: &PathBuf| folder.read(path).map_err(|why| named(&path.display().to_string(), why));
            path.as_ref().map(read).transpose()
        };
        let (colour, opacity) = (bytes(&files.0)?, bytes(&files.1)?);
        let of = files.0.as_ref().or(files.1.as_ref());
        let name = of.and_then(|path| path.file_stem()).map(|stem| stem.to_string_lossy().into_owned());
        let cut_out = opacity.is_some();
        let file = match (colour, opacity) {
            (Some(colour), None) => for_viewers(colour),
            (colour, opacity) => with_opacity(colour.as_deref(), &opacity.unwrap_or_default()),
        };
        let decoded = file.and_then(|bytes| MeanColor::decode(&bytes, cut_out).map(|mean| (bytes, mean)));
        let (bytes, mean) =
            decoded.map_err(|why| named(&of.map_or(String::new(), |of| of.display().to_string()), why.to_string()))?;
        let known = (builder.image(Image { name, bytes: bytes.into() }), self.means.len());
        self.means.push(mean);
        self.known.insert(files, known);
        Ok(known)
    }

    /// Whether a material shows an image, so that its surfaces need texture coordinates.
    pub(super) fn is_on(&self, material: MaterialId) -> bool {
        self.used.contains_key(&material)
    }

    /// Gives every material with images the mean reflectance and radiance of what its surfaces show, and takes coordinates of the
    /// file to places in the image that is seen.
    pub(super) fn finish(&self, builder: &mut SceneBuilder) {
        let mut sums: BTreeMap<MaterialId, [Seen; 2]> = BTreeMap::new();
        for (_, surface) in builder.surfaces_mut() {
            let Some(images) = self.used.get(&surface.material) else { continue };
            let sum = sums.entry(surface.material).or_default();
            for (sum, shown) in sum.iter_mut().zip([&images.colour, &images.emission]) {
                if let Some(shown) = shown {
                    *sum = sum.plus(1.0, self.over(surface, shown));
                }
            }
            if let Some(seen) = images.seen() {
                surface.uvs.iter_mut().for_each(|uv| *uv = seen.place(*uv));
            }
        }
        for (&material, images) in &self.used {
            let sum = sums.get(&material).copied().unwrap_or_default();
            let mean = |shown: &Shown, sum: Seen| {
                let seen = if sum.alpha > 0.0 { sum } else { self.means[shown.mean].whole() };
                shown.factor * Rgb::from(seen.color())
            };
            if let Some(colour) = &images.colour {
                builder.set_reflectance(material, mean(colour, sum[0]));
            }
            if let Some(emission) = &images.emission {
                builder.set_radiance(material, mean(emission, sum[1]));
            }
        }
    }

    /// What a surface, whose coordinates are still those of the file, shows of an image.
    fn over(&self, surface: &Surface, shown: &Shown) -> Seen {
        let fans = surface.polygons.iter().flat_map(|polygon| {
            (2..polygon.len()).map(|i| [polygon[0], polygon[i - 1], polygon[i]].map(|corner| corner as usize))
        });
        let places: Vec<DVec2> = surface.uvs.iter().map(|&uv| shown.place(uv)).collect();
        let positions_m: &[DVec3] = &surface.positions_m;
        texture_mean::over(&self.means[shown.mean], shown.wrap, fans, positions_m, &places)
    }
}
