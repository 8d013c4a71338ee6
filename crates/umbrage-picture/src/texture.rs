//! Base colour textures: mip levels, and the colour at a point.
//!
//! Idea: texels become linear light once, when the file is decoded; each level of the pyramid is the mean of four
//! texels of the level below, so that it has the same mean light; a sample reads two levels, four texels each
//! (trilinear), and chooses the levels by how far apart neighbouring samples are in the texture. The picture has many
//! samples per pixel, so it stays sharp where a surface is seen at a grazing angle.
//!
//! Holds: colours lie within 0..1; a texture of one colour has that colour everywhere; memory is 4/3 of the texels'.
//! Alpha is averaged like a colour, as graphics processors do it; what it means is the caller's to say.

use crate::color::linear_from_srgb;
use crate::decode::{MAX_SIZE_TEXELS, TextureError, decode};

/// What a texture does beyond its border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Begins anew.
    #[default]
    Repeat,
    /// Begins anew, every other time turned over.
    Mirror,
    /// Goes on with its last texel.
    Clamp,
}

/// An image on a surface, with all its mip levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// From the finest to a single texel.
    levels: Vec<Level>,
    /// Along u and along v.
    wrap: [Wrap; 2],
}

#[derive(Clone, Debug, PartialEq)]
struct Level {
    size: [usize; 2],
    texels: Vec<Texel>,
}

/// Linear RGB and alpha.
pub type Texel = [f32; 4];

impl Texture {
    /// Decodes a PNG, a JPEG, a WebP or a TGA.
    ///
    /// # Errors
    /// [`TextureError`] where it is of an unknown format, broken or too large.
    pub fn decode(file: &[u8], wrap: [Wrap; 2]) -> Result<Self, TextureError> {
        let (size, codes) = decode(file, MAX_SIZE_TEXELS * MAX_SIZE_TEXELS)?;
        let linear: Vec<f32> = (0..=255u8).map(|code| linear_from_srgb(f64::from(code) / 255.0) as f32).collect();
        let texel = |&[r, g, b, a]: &[u8; 4]| {
            let [r, g, b] = [r, g, b].map(|c| linear[usize::from(c)]);
            [r, g, b, f32::from(a) / 255.0]
        };
        let texels = codes.iter().map(texel).collect();
        Ok(Self { levels: pyramid(Level { size, texels }), wrap })
    }

    /// Its levels, from the finest to a single texel: columns and rows, and the texels row by row from the top.
    pub fn levels(&self) -> impl ExactSizeIterator<Item = ([usize; 2], &[Texel])> {
        self.levels.iter().map(|level| (level.size, level.texels.as_slice()))
    }

    /// What it does beyond its border, along u and along v.
    pub fn wrap(&self) -> [Wrap; 2] {
        self.wrap
    }

    /// Colour and alpha at `uv`, where the next samples to the right and below are `steps` away, as shares of the
    /// texture.
    pub(crate) fn sample(&self, uv: [f64; 2], steps: [[f64; 2]; 2]) -> Texel {
        let [width, height] = self.levels[0].size.map(|side| side as f64);
        let texels = steps.map(|[u, v]| (u * width).hypot(v * height)).into_iter().fold(0.0, f64::max);
        let last = self.levels.len() - 1;
        // A NaN or negative logarithm means the finest level, an infinite one the coarsest.
        let level = texels.log2().max(0.0).min(last as f64);
        let (fine, share) = (level as usize, level.fract() as f32);
        let near = self.levels[fine].sample(uv, self.wrap);
        if share == 0.0 {
            return near;
        }
        let far = self.levels[fine + 1].sample(uv, self.wrap);
        std::array::from_fn(|i| near[i] + share * (far[i] - near[i]))
    }
}

impl Level {
    /// Colour and alpha at `uv`, between the four texels around it.
    fn sample(&self, uv: [f64; 2], wrap: [Wrap; 2]) -> Texel {
        let [(x0, x1, sx), (y0, y1, sy)] = [0, 1].map(|axis| between(uv[axis], self.size[axis], wrap[axis]));
        let texel = |x: usize, y: usize| self.texels[y * self.size[0] + x];
        let (a, b, c, d) = (texel(x0, y0), texel(x1, y0), texel(x0, y1), texel(x1, y1));
        std::array::from_fn(|i| {
            let (top, bottom) = (a[i] + sx * (b[i] - a[i]), c[i] + sx * (d[i] - c[i]));
            top + sy * (bottom - top)
        })
    }
}

/// The two texels of a row of `size` around `at`, and how far the point is on its way to the second.
fn between(at: f64, size: usize, wrap: Wrap) -> (usize, usize, f32) {
    let place = at * size as f64 - 0.5;
    let first = place.floor();
    // A cast from float to integer saturates.
    let index = first as i64;
    (wrapped(index, size, wrap), wrapped(index.saturating_add(1), size, wrap), (place - first) as f32)
}

/// The texel that stands for texel `index` of a row of `size`.
pub(crate) fn wrapped(index: i64, size: usize, wrap: Wrap) -> usize {
    let size = size as i64;
    let texel = match wrap {
        Wrap::Repeat => index.rem_euclid(size),
        Wrap::Clamp => index.clamp(0, size - 1),
        Wrap::Mirror => {
            let there_and_back = index.rem_euclid(2 * size);
            there_and_back.min(2 * size - 1 - there_and_back)
        }
    };
    texel as usize
}

/// All levels, from `finest` to a single texel.
fn pyramid(finest: Level) -> Vec<Level> {
    let mut levels = vec![finest];
    while let Some(below) = levels.last().filter(|level| level.size != [1, 1]) {
        let size = below.size.map(|side| (side / 2).max(1));
        let mut texels = Vec::with_capacity(size[0] * size[1]);
        for y in 0..size[1] {
            for x in 0..size[0] {
                texels.push(mean(below, size, [x, y]));
            }
        }
        levels.push(Level { size, texels });
    }
    levels
}

/// The mean of the texels of `below` that texel `at` of a level of `size` covers.
fn mean(below: &Level, size: [usize; 2], at: [usize; 2]) -> Texel {
    let [columns, rows] =
        [0, 1].map(|axis| at[axis] * below.size[axis] / size[axis]..(at[axis] + 1) * below.size[axis] / size[axis]);
    let count = (columns.len() * rows.len()) as f32;
    let mut sum = [0.0f32; 4];
    for y in rows {
        for x in columns.clone() {
            let texel = below.texels[y * below.size[0] + x];
            sum = std::array::from_fn(|i| sum[i] + texel[i]);
        }
    }
    sum.map(|s| s / count)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::color::linear_from_srgb8;

    /// Samples that are as good as in one place.
    const NEAR: [[f64; 2]; 2] = [[0.0; 2]; 2];

    pub(crate) fn png_of(width: u32, height: u32, color: png::ColorType, bytes: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(color);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(bytes).unwrap();
        writer.finish().unwrap();
        file
    }

    /// Black and white, one row.
    fn two(wrap: Wrap) -> Texture {
        Texture::decode(&png_of(2, 1, png::ColorType::Grayscale, &[0, 255]), [wrap; 2]).unwrap()
    }

    #[test]
    fn a_point_between_texels_has_their_mean_light() {
        let seen = |u| two(Wrap::Clamp).sample([u, 0.5], NEAR)[0];
        assert_eq!([-1.0, 0.25, 0.5, 0.625, 0.75, 2.0].map(seen), [0.0, 0.0, 0.5, 0.75, 1.0, 1.0]);
    }

    #[test]
    fn borders_wrap_as_asked() {
        let seen = |wrap, u| two(wrap).sample([u, 0.5], NEAR)[0];
        assert_eq!([0.0, 1.0, 1.25, -0.25].map(|u| seen(Wrap::Repeat, u)), [0.5, 0.5, 0.0, 1.0]);
        assert_eq!([0.0, 1.0, 1.25, -0.25].map(|u| seen(Wrap::Mirror, u)), [0.0, 1.0, 1.0, 0.0]);
        assert!(seen(Wrap::Repeat, 1e300).is_finite() && seen(Wrap::Mirror, -1e300).is_finite());
    }

    #[test]
    fn far_away_a_texture_has_its_mean_light() {
        // An odd size: rows and columns of unequal share.
        let bytes: Vec<u8> = (0..35 * 3).map(|i| (i * 7 % 256) as u8).collect();
        let texture = Texture::decode(&png_of(7, 5, png::ColorType::Rgb, &bytes), [Wrap::Repeat; 2]).unwrap();
        assert_eq!(texture.levels.iter().map(|level| level.size).collect::<Vec<_>>(), [[7, 5], [3, 2], [1, 1]]);
        let one = Texture::decode(&png_of(8, 2, png::ColorType::Rgb, &[200, 100, 50].repeat(16)), [Wrap::Repeat; 2]);
        let one = one.unwrap();
        for footprint in [0.0, 0.1, 0.4, f64::INFINITY, f64::NAN] {
            for (seen, expected) in
                one.sample([0.3, 0.9], [[footprint, 0.0], [0.0; 2]]).iter().zip(linear_from_srgb8([200, 100, 50]))
            {
                assert!((seen - expected).abs() < 1e-6, "{footprint}: {seen} {expected}");
            }
        }
        assert_eq!(two(Wrap::Repeat).sample([0.1, 0.1], [[1.0, 0.0], [0.0; 2]]), [0.5, 0.5, 0.5, 1.0]);
    }
}
