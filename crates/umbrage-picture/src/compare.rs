//! Pictures beside each other, and how two pictures of a quantity differ.
//!
//! Idea: both pictures are [`crate::Look::Raw`], taken with the same camera, so that a pixel's difference is a quantity
//! with a unit; a pixel that shows no surface is NaN in both and stays out of all figures.

use crate::color::{BACKGROUND, DIVERGING, LinearRgb, luminance, on_scale};
use crate::picture::Picture;

/// Columns between two pictures, in pixels.
const GAP_PX: usize = 4;
/// Share of the pixels that the scale of a difference holds: single pixels along edges shall not decide it.
const SHARE_IN_SCALE: f64 = 0.995;

/// Pictures from left to right, upper edges aligned.
pub fn beside(pictures: &[Picture]) -> Picture {
    let height = pictures.iter().map(|picture| picture.height).max().unwrap_or(0);
    let gaps = GAP_PX * pictures.len().saturating_sub(1);
    let width = pictures.iter().map(|picture| picture.width).sum::<usize>() + gaps;
    let mut joined = Picture { width, height, pixels: vec![[0.0; 3]; width * height] };
    let mut left = 0;
    for picture in pictures {
        for row in 0..picture.height {
            let own = &picture.pixels[row * picture.width..(row + 1) * picture.width];
            joined.pixels[row * width + left..][..picture.width].copy_from_slice(own);
        }
        left += picture.width + GAP_PX;
    }
    joined
}

/// How the luminance of one picture differs from that of another.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    width: usize,
    height: usize,
    /// Second minus first; NaN where nothing is seen.
    values: Vec<f32>,
    /// Mean of the first.
    mean_of_first: f64,
}

/// `second` minus `first`, or nothing where their sizes differ.
pub fn difference(first: &Picture, second: &Picture) -> Option<Difference> {
    if (first.width, first.height) != (second.width, second.height) {
        return None;
    }
    let pairs = first.pixels.iter().zip(&second.pixels);
    let values = pairs.map(|(&a, &b)| luminance(b) - luminance(a)).collect();
    let seen = first.pixels.iter().map(|&a| f64::from(luminance(a))).filter(|a| !a.is_nan());
    let (sum, count) = seen.fold((0.0, 0usize), |(sum, count), a| (sum + a, count + 1));
    let mean_of_first = sum / count.max(1) as f64;
    Some(Difference { width: first.width, height: first.height, values, mean_of_first })
}

impl Difference {
    fn seen(&self) -> impl Iterator<Item = f64> + '_ {
        self.values.iter().map(|&value| f64::from(value)).filter(|value| !value.is_nan())
    }

    /// Root of the mean square over the pixels that show a surface; 0 if none does.
    pub fn rms(&self) -> f64 {
        let (sum, count) = self.seen().fold((0.0, 0usize), |(sum, count), value| (sum + value * value, count + 1));
        (sum / count.max(1) as f64).sqrt()
    }

    /// Mean of the first picture over the pixels that show a surface; 0 if none does.
    pub fn mean_of_first(&self) -> f64 {
        self.mean_of_first
    }

    /// What nearly all differences do not exceed; 0 if there is none.
    pub fn largest(&self) -> f64 {
        let mut sizes: Vec<f64> = self.seen().map(f64::abs).collect();
        sizes.sort_by(f64::total_cmp);
        let last = sizes.len().saturating_sub(1);
        sizes.get((SHARE_IN_SCALE * last as f64).round() as usize).copied().unwrap_or(0.0)
    }

    /// The difference on a scale from `-end` to `end`, which is above 0.
    pub fn picture(&self, end: f64) -> Picture {
        let color = |&value: &f32| -> LinearRgb {
            if value.is_nan() { BACKGROUND } else { on_scale(&DIVERGING, 0.5 + 0.5 * (f64::from(value) / end) as f32) }
        };
        Picture { width: self.width, height: self.height, pixels: self.values.iter().map(color).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::linear_from_srgb8;

    fn picture(width: usize, values: &[f32]) -> Picture {
        let pixels: Vec<_> = values.iter().map(|&value| [value; 3]).collect();
        Picture { width, height: values.len() / width, pixels }
    }

    #[test]
    fn pictures_stand_side_by_side() {
        let joined = beside(&[picture(2, &[1.0, 2.0, 3.0, 4.0]), picture(1, &[5.0])]);
        assert_eq!((joined.width(), joined.height()), (3 + GAP_PX, 2));
        let row = |row| [0, 1, 2, 2 + GAP_PX].map(|column| joined.pixel(column, row)[0]);
        assert_eq!([row(0), row(1)], [[1.0, 2.0, 0.0, 5.0], [3.0, 4.0, 0.0, 0.0]]);
    }

    #[test]
    fn figures_leave_out_what_shows_no_surface() {
        let (first, second) = (picture(2, &[1.0, f32::NAN, 3.0, 2.0]), picture(2, &[4.0, f32::NAN, 3.0, -2.0]));
        let difference = difference(&first, &second).unwrap();
        // Differences 3, 0, -4: the mean square is 25/3.
        assert!((difference.rms() - (25.0f64 / 3.0).sqrt()).abs() < 1e-6);
        assert!((difference.mean_of_first() - 2.0).abs() < 1e-6);
        assert!((difference.largest() - 4.0).abs() < 1e-6);
        let shown = difference.picture(4.0);
        assert_eq!(shown.pixel(1, 0), BACKGROUND);
        let near = |seen: LinearRgb, code: [u8; 3]| {
            linear_from_srgb8(code).iter().zip(seen).all(|(expected, seen)| (expected - seen).abs() < 1e-5)
        };
        assert!(near(shown.pixel(0, 1), DIVERGING[2]) && near(shown.pixel(1, 1), DIVERGING[0]));
    }

    #[test]
    fn pictures_of_unequal_size_have_no_difference() {
        assert_eq!(difference(&picture(2, &[0.0; 2]), &picture(1, &[0.0; 2])), None);
        let nothing = difference(&picture(1, &[f32::NAN]), &picture(1, &[f32::NAN])).unwrap();
        assert_eq!((nothing.rms(), nothing.largest(), nothing.mean_of_first()), (0.0, 0.0, 0.0));
    }
}
