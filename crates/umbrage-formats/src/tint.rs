//! Colours of vertices as reflectance, for formats whose polygons may have any: OBJ and PLY.
//!
//! A polygon reflects the mean colour of its corners. Each colour makes a material of its own, of the same name; the first
//! [`EXACT`] as they are, further ones in [`SHADES`] steps for each channel, so that a scanned mesh has not as many
//! materials as polygons. Colours are codes of sRGB, as most programs write them, though neither format says so.

use std::collections::BTreeMap;

use umbrage::id::MaterialId;
use umbrage::scene::Rgb;
use umbrage_picture::color::linear_from_srgb;

use crate::builder::SceneBuilder;

/// So many different colours are taken as they are, to 8 bits.
const EXACT: usize = 256;
/// Steps of a channel for further colours: 0.07 in a code of sRGB, about what neighbours on a noisy scan differ by.
const SHADES: f64 = 15.0;

/// The materials that colours have made so far.
#[derive(Debug, Default)]
pub(crate) struct Tints {
    known: BTreeMap<(MaterialId, [u8; 3]), MaterialId>,
}

impl Tints {
    /// The material of a polygon whose corners have these codes, each channel 0 to 1; white leaves it as it is.
    pub(crate) fn tinted(
        &mut self,
        material: MaterialId,
        codes: impl ExactSizeIterator<Item = Rgb>,
        builder: &mut SceneBuilder,
    ) -> MaterialId {
        let count = codes.len().max(1) as f64;
        let mean = (codes.sum::<Rgb>() / count).clamp(Rgb::ZERO, Rgb::ONE);
        if mean == Rgb::ONE || mean.is_nan() {
            return material;
        }
        let steps = |steps: f64| mean.to_array().map(|code| ((code * steps).round() / steps * 255.0).round() as u8);
        let exact = (material, steps(255.0));
        if let Some(&known) = self.known.get(&exact) {
            return known;
        }
        let key = if self.known.len() < EXACT { exact } else { (material, steps(SHADES)) };
        *self.known.entry(key).or_insert_with(|| {
            let tint = Rgb::from(key.1.map(|code| linear_from_srgb(f64::from(code) / 255.0)));
            builder.tinted(material, tint)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ReadOptions;

    #[test]
    fn few_colours_are_exact_and_many_are_few_materials() {
        let mut builder = SceneBuilder::new("scan".into(), 0, &ReadOptions::default());
        let grey = builder.grey("default");
        let mut tints = Tints::default();
        let of = |tints: &mut Tints, builder: &mut SceneBuilder, codes: [f64; 3]| {
            tints.tinted(grey, [Rgb::from(codes); 3].into_iter(), builder)
        };
        assert_eq!(of(&mut tints, &mut builder, [1.0; 3]), grey);
        let red = of(&mut tints, &mut builder, [1.0, 0.0, 188.0 / 255.0]);
        assert_eq!(of(&mut tints, &mut builder, [1.0, 0.0, 188.0 / 255.0]), red);
        for i in 0..20_000_u32 {
            let codes = [0, 5, 10].map(|shift| f64::from((i.wrapping_mul(2_654_435_761) >> shift) & 255) / 255.0);
            of(&mut tints, &mut builder, codes);
        }
        let (scene, _) = builder.finish();
        let reflected = scene.materials[red].reflectance / scene.materials[grey].reflectance;
        assert!((reflected - Rgb::new(1.0, 0.0, 0.5)).abs().max_element() < 0.004, "{reflected}");
        assert!(scene.materials.len() <= EXACT + 4096 + 1 && scene.materials[red].name == "default");
    }
}
