//! Textures as the scene needs them: what a primitive shows of an image on average, and the images that are passed on.

use std::collections::BTreeMap;

use glam::DVec2;
use umbrage::id::{ImageId, Table};
use umbrage::scene::{Image, Rgb, Texture, Wrap};
use umbrage_picture::{MeanColor, for_viewers};

use super::base_texture::BaseTexture;
use super::document::{Document, List};
use super::item::Item;
use super::primitive::{self, Polygons};
use super::tally::Tally;
use crate::{FormatError, texture_mean};

/// The images of a document, each loaded when something first shows it.
#[derive(Debug, Default)]
pub(super) struct Images {
    /// Those of the scene.
    pub(super) all: Table<ImageId, Image>,
    /// By number in the file, and whether alpha counts; nothing if it cannot be read, which was counted.
    known: BTreeMap<(usize, bool), Option<(ImageId, MeanColor)>>,
    ids: BTreeMap<usize, ImageId>,
}

/// What a primitive shows of a texture.
#[derive(Debug)]
pub(super) struct ShownTexture {
    /// What the scene knows of it.
    pub(super) texture: Texture,
    /// Where each of the primitive's corners lies in its image.
    pub(super) uvs: Vec<DVec2>,
    /// The mean colour over the primitive.
    pub(super) mean: Rgb,
    /// The mean alpha over the primitive, 1 where it does not count.
    pub(super) opacity: f64,
    /// Whether the image's alpha counts, and is less than 1 somewhere.
    pub(super) has_alpha: bool,
}

impl Images {
    /// What a primitive shows of a texture; nothing where its image or coordinates cannot be had.
    pub(super) fn shown(
        &mut self,
        document: &Document,
        (texture, factor, alpha): (&BaseTexture, Rgb, bool),
        (primitive, place): (&Item<'_>, &str),
        polygons: &Polygons,
        tally: &mut Tally,
    ) -> Result<Option<ShownTexture>, FormatError> {
        let uvs = primitive::places_in_texture(document, primitive, place, texture, &polygons.used, tally)?;
        let Some(uvs) = uvs else {
            tally.texture_ignored(format!("{place} has no texture coordinates"));
            return Ok(None);
        };
        let Some((image, mean)) = self.image(document, texture.texture.image, alpha, tally)? else { return Ok(None) };
        let BaseTexture { filters, .. } = *texture;
        let wrap = texture.texture.wrap;
        let has_alpha = mean.has_alpha();
        let (mean, opacity) = mean_over(mean, &uvs, polygons, wrap);
        let texture = Texture { image, wrap, filters, factor };
        Ok(Some(ShownTexture { texture, uvs, mean, opacity, has_alpha }))
    }

    fn image(
        &mut self,
        document: &Document,
        number: usize,
        alpha: bool,
        tally: &mut Tally,
    ) -> Result<Option<(ImageId, &MeanColor)>, FormatError> {
        if !self.known.contains_key(&(number, alpha)) {
            let item = document.item(List::Images, number, "a texture")?;
            let bytes = document.image(number, "a texture").map_err(|error| error.to_string());
            let decoded = bytes.and_then(|bytes| {
                let named = |error| format!("{}: {error}", item.place);
                let bytes = for_viewers(bytes).map_err(named)?;
                let mean = MeanColor::decode(&bytes, alpha).map_err(named)?;
                Ok((bytes, mean))
            });
            let known = match decoded {
                Ok((bytes, mean)) => {
                    let all = &mut self.all;
                    let name = item.name().map(str::to_owned);
                    let id = *self
                        .ids
                        .entry(number)
                        .or_insert_with(|| all.push_and_get_key(Image { name, bytes: bytes.into() }));
                    Some((id, mean))
                }
                Err(why) => {
                    tally.texture_ignored(why);
                    None
                }
            };
            self.known.insert((number, alpha), known);
        }
        Ok(self.known[&(number, alpha)].as_ref().map(|(id, mean)| (*id, mean)))
    }
}

/// The mean colour over a primitive, by area in the world, and the mean alpha.
fn mean_over(image: &MeanColor, uvs: &[DVec2], polygons: &Polygons, wrap: [Wrap; 2]) -> (Rgb, f64) {
    let triangles = || polygons.triangles.iter().map(|triangle| triangle.map(|i| i as usize));
    let sum = texture_mean::over(image, wrap, triangles(), &polygons.positions_m, uvs);
    let area_m2: f64 = triangles()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|i| polygons.positions_m[i]);
            0.5 * (b - a).cross(c - a).length()
        })
        .filter(|area_m2| area_m2.is_finite())
        .sum();
    let seen = if sum.alpha > 0.0 { sum } else { image.whole() };
    let opacity = if area_m2 > 0.0 { (sum.alpha / area_m2).clamp(0.0, 1.0) } else { image.whole().alpha };
    (Rgb::from(seen.color()), opacity)
}
