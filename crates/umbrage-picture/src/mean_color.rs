//! The mean colour of an image, or of the part of it that a triangle shows: what a textured surface reflects on the
//! whole.
//!
//! Idea: the image is reduced once to a coarse grid of cells, each with the mean light of its texels and, where alpha
//! counts, the mean of alpha, by which the light is weighted: what is not seen reflects nothing. A triangle then takes
//! the mean of cells at points that are spread evenly over it.

use crate::color::linear_from_srgb;
use crate::decode::{TextureError, decode};
use crate::texture::{Wrap, wrapped};

/// Cells along the longer side of an image.
const MOST_CELLS: usize = 64;
/// A triangle is sampled at the square of so many points at most.
const MOST_POINTS: f64 = 8.0;
/// Images of more texels are refused: 8192 x 8192.
pub(crate) const MOST_TEXELS: usize = 1 << 26;

/// Light times alpha, linear RGB, and alpha, summed or averaged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Linear RGB times alpha, 0 to 1 each for one texel.
    pub light: [f64; 3],
    /// Alpha, 0 to 1 for one texel.
    pub alpha: f64,
}

impl Seen {
    /// The sum of this and `weight` times another.
    pub fn plus(self, weight: f64, other: Self) -> Self {
        let light = std::array::from_fn(|i| self.light[i] + weight * other.light[i]);
        Self { light, alpha: self.alpha + weight * other.alpha }
    }

    /// The mean colour of what is seen, linear RGB; black where nothing is.
    pub fn color(self) -> [f64; 3] {
        self.light.map(|light| if self.alpha > 0.0 { light / self.alpha } else { 0.0 })
    }
}

/// A coarse grid of an image's mean colours.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanColor {
    size: [usize; 2],
    cells: Vec<Seen>,
    whole: Seen,
    has_alpha: bool,
}

impl MeanColor {
    /// Decodes an image and reduces it. `alpha` says whether its alpha counts.
    ///
    /// # Errors
    /// [`TextureError`] where it is of an unknown format, broken or too large.
    pub fn decode(file: &[u8], alpha: bool) -> Result<Self, TextureError> {
        let ([width, height], codes) = decode(file, MOST_TEXELS)?;
        let linear: Vec<f64> = (0..=255u8).map(|code| linear_from_srgb(f64::from(code) / 255.0)).collect();
        let longest = width.max(height).max(1);
        let size = [width, height].map(|side| (side * MOST_CELLS.min(longest) / longest).max(1));
        let mut cells = vec![(Seen::default(), 0.0); size[0] * size[1]];
        for (y, row) in codes.chunks_exact(width).enumerate() {
            for (x, &[r, g, b, a]) in row.iter().enumerate() {
                let a = if alpha { f64::from(a) / 255.0 } else { 1.0 };
                let texel = Seen { light: [r, g, b].map(|c| a * linear[usize::from(c)]), alpha: a };
                let cell = &mut cells[(y * size[1] / height) * size[0] + x * size[0] / width];
                *cell = (cell.0.plus(1.0, texel), cell.1 + 1.0);
            }
        }
        let whole = cells.iter().fold(Seen::default(), |sum, cell| sum.plus(1.0 / (width * height) as f64, cell.0));
        let cells =
            cells.into_iter().map(|(sum, count)| Seen::default().plus(1.0 / f64::max(count, 1.0), sum)).collect();
        let has_alpha = alpha && codes.iter().any(|texel| texel[3] < u8::MAX);
        Ok(Self { size, cells, whole, has_alpha })
    }

    /// Whether its alpha counts, and is less than 1 somewhere.
    pub fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    /// The mean of the whole image.
    pub fn whole(&self) -> Seen {
        self.whole
    }

    /// The mean over a triangle whose corners lie at these texture coordinates.
    pub fn over(&self, [a, b, c]: [[f64; 2]; 3], wrap: [Wrap; 2]) -> Seen {
        let extent = |axis: usize| {
            let [a, b, c] = [a[axis], b[axis], c[axis]];
            (a.max(b).max(c) - a.min(b).min(c)) * self.size[axis] as f64
        };
        let wide = extent(0).max(extent(1));
        if !wide.is_finite() {
            return self.whole;
        }
        let n = wide.ceil().clamp(1.0, MOST_POINTS) as usize;
        let mut sum = Seen::default();
        // The triangle is cut into n x n like ones; their centroids are the points.
        for i in 0..n {
            for j in 0..n - i {
                for third in [1.0, 2.0] {
                    if third == 2.0 && i + j + 1 == n {
                        continue;
                    }
                    let (s, t) = ((i as f64 + third / 3.0) / n as f64, (j as f64 + third / 3.0) / n as f64);
                    let uv = [0, 1].map(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
                    sum = sum.plus(1.0 / (n * n) as f64, self.at(uv, wrap));
                }
            }
        }
        sum
    }

    /// The cell at a place.
    fn at(&self, uv: [f64; 2], wrap: [Wrap; 2]) -> Seen {
        // A cast from float to integer saturates.
        let [x, y] = [0, 1].map(|k| wrapped((uv[k] * self.size[k] as f64).floor() as i64, self.size[k], wrap[k]));
        self.cells[y * self.size[0] + x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::tests::png_of;

    const REPEAT: [Wrap; 2] = [Wrap::Repeat; 2];

    /// Left half white, right half black and, where alpha counts, a quarter as much seen.
    fn halves(alpha: bool) -> MeanColor {
        let row: Vec<u8> = (0..128).flat_map(|x| if x < 64 { [255, 255, 255, 255] } else { [0, 0, 0, 51] }).collect();
        MeanColor::decode(&png_of(128, 4, png::ColorType::Rgba, &row.repeat(4)), alpha).unwrap()
    }

    #[test]
    fn the_mean_weighs_light_by_alpha() {
        assert_eq!(halves(false).whole().color(), [0.5; 3]);
        assert!(halves(true).has_alpha() && !halves(false).has_alpha());
        let seen = halves(true).whole();
        assert!((seen.alpha - 0.6).abs() < 1e-12 && (seen.color()[0] - 0.5 / 0.6).abs() < 1e-12, "{seen:?}");
        // The mean is of light, not of codes.
        let grey = MeanColor::decode(&png_of(2, 1, png::ColorType::Grayscale, &[0, 188]), false).unwrap();
        assert!((grey.whole().color()[0] - 0.25).abs() < 0.004);
    }

    #[test]
    fn what_is_too_large_is_refused_by_its_head() {
        // The head of a PNG alone, of 16384 x 8192 texels.
        let mut file = png_of(1, 1, png::ColorType::Grayscale, &[0]);
        file[16..24].copy_from_slice(&[0, 0, 64, 0, 0, 0, 32, 0]);
        let sum = crc32(&file[12..29]);
        file[29..33].copy_from_slice(&sum.to_be_bytes());
        let refused = MeanColor::decode(&file, false);
        assert!(matches!(refused, Err(TextureError::BadSize { width: 16384, height: 8192 })), "{refused:?}");
    }

    /// The checksum of a PNG's chunk (PNG specification, annex D), bit by bit.
    fn crc32(bytes: &[u8]) -> u32 {
        let step = |crc: u32| if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
        let byte = |crc: u32, &byte: &u8| (0..8).fold(crc ^ u32::from(byte), |crc, _| step(crc));
        !bytes.iter().fold(u32::MAX, byte)
    }

    #[test]
    fn a_triangle_has_the_mean_of_its_part() {
        let image = halves(false);
        let over = |corners| image.over(corners, REPEAT).color()[0];
        assert_eq!(over([[0.0, 0.0], [0.5, 0.0], [0.0, 1.0]]), 1.0);
        assert_eq!(over([[0.5, 0.0], [1.0, 0.0], [0.75, 1.0]]), 0.0);
        assert_eq!(over([[1.0, 0.0], [1.5, 0.0], [1.0, 1.0]]), 1.0, "the next tile");
        // Of the triangle below the diagonal three quarters lie in the left half.
        let lower = over([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        assert!((lower - 0.75).abs() < 0.05, "{lower}");
        assert_eq!(image.over([[0.0, 0.0], [f64::INFINITY, 0.0], [0.0, 1.0]], REPEAT), image.whole());
        assert!(image.over([[0.0; 2], [1e300, 0.0], [0.0, -1e300]], REPEAT).color()[0].is_finite());
    }
}
