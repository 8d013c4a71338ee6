//! A texture of a material: its image, what lies beyond its border, and where vertices lie in it.
//!
//! Sources: glTF 2.0, sections 3.8 and 3.9.2; `KHR_texture_transform`, which is applied to the coordinates here, so that
//! nothing later has to know of it. Images stay the files that they are: formats do not decode pictures.

use glam::DVec2;

use super::document::{Document, List};
use super::item::Item;
use umbrage::scene::Wrap;

use crate::{BakedTexture, FormatError};

/// Extensions that hold an image in a format that is not read, for a texture that has no other source, and what to do.
const OTHER_FORMATS: [(&str, &str); 3] = [
    ("KHR_texture_basisu", "unpack its images (`gltf-transform ktxdecompress` does)"),
    ("EXT_texture_avif", "convert its images to PNG, JPEG or WebP"),
    ("MSFT_texture_dds", "convert its images to PNG, JPEG or WebP"),
];

/// A texture, and how its coordinates are found.
#[derive(Debug)]
pub(super) struct BaseTexture {
    pub(super) texture: BakedTexture,
    /// The set of coordinates: `TEXCOORD_n`.
    pub(super) set: usize,
    /// Magnification and minification, in OpenGL's numbers.
    pub(super) filters: [Option<u32>; 2],
    /// What turns them into places in the image: offset, rotation in radians, scale.
    transform: ([f64; 2], f64, [f64; 2]),
}

impl BaseTexture {
    /// The base colour texture of a material, if it has one.
    pub(super) fn of(document: &Document, material: &Item<'_>) -> Result<Option<Self>, FormatError> {
        match material.child("pbrMetallicRoughness")? {
            Some(metallic) => Self::in_slot(document, &metallic, "baseColorTexture"),
            None => Ok(None),
        }
    }

    /// The texture in a slot of a material, if there is one.
    pub(super) fn in_slot(document: &Document, holder: &Item<'_>, slot: &str) -> Result<Option<Self>, FormatError> {
        let Some(info) = holder.child(slot)? else { return Ok(None) };
        let texture = document.item(List::Textures, info.required_whole("index")?, &info.place)?;
        let webp = texture.extension("EXT_texture_webp")?;
        let webp = webp.map(|webp| webp.whole("source")).transpose()?.flatten();
        let Some(image) = texture.whole("source")?.or(webp) else { return without_source(&texture) };
        document.item(List::Images, image, &texture.place)?;
        let (wrap, filters) = match texture.whole("sampler")? {
            Some(sampler) => {
                let sampler = document.item(List::Samplers, sampler, &texture.place)?;
                let filter = |key| Ok(sampler.whole(key)?.and_then(|code| u32::try_from(code).ok()));
                ([wrap(&sampler, "wrapS")?, wrap(&sampler, "wrapT")?], [filter("magFilter")?, filter("minFilter")?])
            }
            None => ([Wrap::Repeat; 2], [None; 2]),
        };
        let mut set = info.whole("texCoord")?.unwrap_or(0);
        let mut transform = ([0.0; 2], 0.0, [1.0; 2]);
        if let Some(extension) = info.extension("KHR_texture_transform")? {
            set = extension.whole("texCoord")?.unwrap_or(set);
            transform = (
                extension.numbers::<2>("offset")?.unwrap_or(transform.0),
                extension.number("rotation")?.unwrap_or(transform.1),
                extension.numbers::<2>("scale")?.unwrap_or(transform.2),
            );
        }
        Ok(Some(Self { texture: BakedTexture { image, wrap }, set, filters, transform }))
    }

    /// The place in the image that a coordinate means, (0, 0) being its upper left corner.
    pub(super) fn place(&self, coordinate: [f64; 2]) -> DVec2 {
        let (offset, rotation, scale) = self.transform;
        let scaled = DVec2::from(coordinate) * DVec2::from(scale);
        let (sin, cos) = rotation.sin_cos();
        let turned = DVec2::new(cos * scaled.x + sin * scaled.y, cos * scaled.y - sin * scaled.x);
        turned + DVec2::from(offset)
    }
}

fn without_source(texture: &Item<'_>) -> Result<Option<BaseTexture>, FormatError> {
    for (name, cure) in OTHER_FORMATS {
        if texture.extension(name)?.is_some() {
            return Err(FormatError::UnsupportedExtension {
                file: texture.file.to_owned(),
                place: texture.place.clone(),
                extension: name.to_owned(),
                cure,
            });
        }
    }
    Ok(None)
}

fn wrap(sampler: &Item<'_>, key: &str) -> Result<Wrap, FormatError> {
    match sampler.whole(key)?.unwrap_or(10_497) {
        10_497 => Ok(Wrap::Repeat),
        33_648 => Ok(Wrap::Mirror),
        33_071 => Ok(Wrap::Clamp),
        other => Err(sampler.bad(key, format!("{other} is not a way to wrap"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_scaled_then_turned_then_moved() {
        let transform = ([0.5, -1.0], std::f64::consts::FRAC_PI_2, [2.0, 4.0]);
        let texture = BakedTexture { image: 0, wrap: [Wrap::Repeat; 2] };
        let placed = BaseTexture { texture, set: 0, filters: [None; 2], transform }.place([1.0, 0.25]);
        // (2, 1) turned by a quarter is (1, -2), in the extension's sense of rotation.
        assert!((placed[0] - 1.5).abs() < 1e-6 && (placed[1] + 3.0).abs() < 1e-6, "{placed:?}");
    }
}
