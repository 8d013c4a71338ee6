//! The legend of a picture in false colours: a bar with the scale, numbers below it, and the unit.
//!
//! Holds: the legend lies in the lower left corner and is as large as the picture's height allows; what does not fit is
//! cut off, never an error. The numbers of a scale that ends at 1, 2 or 5 times a power of ten have few digits.

use crate::color::{LinearRgb, on_scale};
use crate::glyph;
use crate::picture::Picture;

/// Rows of a picture per pixel of a letter.
const ROWS_PER_DOT: usize = 360;
/// Sizes in dots: height of the bar, margin around everything, gap between bar and numbers, room of one number.
const BAR: usize = 8;
const MARGIN: usize = 5;
const GAP: usize = 3;
const NUMBER: usize = 40;
/// What the legend stands on, and its ink.
const PAPER: LinearRgb = [0.01; 3];
const INK: LinearRgb = [0.9; 3];

/// A scale from a quantity to colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// The quantity at its beginning.
    pub begin: f64,
    /// The quantity at its end.
    pub end: f64,
    /// Unit of both, in the letters of a legend: `W/m2`, `lx`.
    pub unit: &'static str,
    /// Its colours, as sRGB codes.
    pub stops: &'static [[u8; 3]],
}

impl Scale {
    /// The numbers below the bar, equidistant from its beginning to its end.
    fn ticks(&self) -> Vec<f64> {
        // A fifth of 1, 5 or 10 is a short number; a quarter of 2 or of -1 to 1 is.
        let mantissa = self.end / 10f64.powf(self.end.abs().log10().floor());
        let parts = if self.begin == 0.0 && (mantissa - 2.0).abs() > 1e-9 { 5 } else { 4 };
        (0..=parts).map(|i| self.begin + (self.end - self.begin) * f64::from(i) / f64::from(parts)).collect()
    }

    /// The numbers below the bar as they are written, and where they stand, as shares of its length.
    pub fn labels(&self) -> Vec<(f64, String)> {
        let ticks = self.ticks();
        let last = (ticks.len() - 1) as f64;
        ticks.into_iter().enumerate().map(|(i, tick)| (i as f64 / last, number(tick))).collect()
    }

    /// Draws the legend over a picture.
    pub fn draw(&self, picture: &mut Picture) {
        let dot = (picture.height / ROWS_PER_DOT).max(1);
        let ticks = self.ticks();
        let bar = NUMBER * (ticks.len() - 1);
        let unit_width = self.unit.chars().count() * glyph::ADVANCE;
        let width = MARGIN + NUMBER / 2 + bar + NUMBER / 2 + unit_width + MARGIN;
        let height = MARGIN + BAR + GAP + glyph::HEIGHT + MARGIN;
        let top = picture.height.saturating_sub(height * dot);
        let mut put = |x: usize, y: usize, color: LinearRgb| {
            for row in top + y * dot..top + (y + 1) * dot {
                for column in x * dot..(x + 1) * dot {
                    if row < picture.height && column < picture.width {
                        picture.pixels[row * picture.width + column] = color;
                    }
                }
            }
        };
        for y in 0..height {
            for x in 0..width {
                put(x, y, PAPER);
            }
        }
        let left = MARGIN + NUMBER / 2;
        for x in 0..=bar {
            let color = on_scale(self.stops, x as f32 / bar as f32);
            let tick = x % NUMBER == 0;
            for y in MARGIN..MARGIN + BAR {
                put(left + x, y, color);
            }
            if tick {
                (MARGIN + BAR..MARGIN + BAR + GAP - 1).for_each(|y| put(left + x, y, INK));
            }
        }
        let mut write = |text: &str, left: usize, top: usize| {
            for (i, letter) in text.chars().enumerate() {
                for y in 0..glyph::HEIGHT {
                    for x in (0..glyph::WIDTH).filter(|&x| glyph::inked(letter, x, y)) {
                        put(left + i * glyph::ADVANCE + x, top + y, INK);
                    }
                }
            }
        };
        for (i, &tick) in ticks.iter().enumerate() {
            let text = number(tick);
            let half = (text.chars().count() * glyph::ADVANCE - 1) / 2;
            write(&text, (left + i * NUMBER).saturating_sub(half), MARGIN + BAR + GAP);
        }
        write(self.unit, left + bar + NUMBER / 2, MARGIN);
    }
}

/// The least of 1, 2 and 5 times a power of ten that is not below `x`; 1 where `x` is 0 or no number.
pub fn nice_ceiling(x: f64) -> f64 {
    if !(x.is_finite() && x > 0.0) {
        return 1.0;
    }
    let power = 10f64.powf(x.log10().floor());
    // 10 times: rounding may leave `x` a hair above 10 times the power, and the power may underflow.
    let nice = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|&nice| nice >= x * (1.0 - 1e-12));
    nice.unwrap_or(x)
}

/// A number in at most six letters of a legend, to three digits.
fn number(x: f64) -> String {
    let size = x.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{x:.0e}");
    }
    let digits_before = if size < 1.0 { 0 } else { size.log10() as usize + 1 };
    let decimals = if size < 0.1 { 4 } else { 3usize.saturating_sub(digits_before) };
    let text = format!("{x:.decimals$}");
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{DIVERGING, SEQUENTIAL, srgb8_from_linear};

    #[test]
    fn nice_numbers_are_not_below() {
        let nice = [0.7, 1.0, 1.2, 2.0, 2.1, 5.0, 5.1, 99.0, 0.0013, 1000.0].map(nice_ceiling);
        for (nice, expected) in nice.iter().zip([1.0, 1.0, 2.0, 2.0, 5.0, 5.0, 10.0, 100.0, 0.002, 1000.0]) {
            assert!((nice / expected - 1.0).abs() < 1e-12, "{nice} {expected}");
        }
        assert_eq!([0.0, -3.0, f64::NAN, f64::INFINITY].map(nice_ceiling), [1.0; 4]);
    }

    #[test]
    fn numbers_are_short() {
        let told = [0.0, 0.25, 12.5, 400.0, 1234.5, 0.002, 2e6, -0.5, 100_000.0, 7e-9].map(number);
        assert_eq!(told, ["0", "0.25", "12.5", "400", "1234", "0.002", "2e6", "-0.5", "1e5", "7e-9"]);
    }

    #[test]
    fn ticks_are_round() {
        let ticks = |begin, end| {
            let scale = Scale { begin, end, unit: "lx", stops: &SEQUENTIAL };
            scale.labels().into_iter().map(|(_, label)| label).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(ticks(0.0, 20.0), "0 5 10 15 20");
        assert_eq!(ticks(0.0, 500.0), "0 100 200 300 400 500");
        assert_eq!(ticks(0.0, 0.1), "0 0.02 0.04 0.06 0.08 0.1");
        assert_eq!(ticks(-1.0, 1.0), "-1 -0.5 0 0.5 1");
    }

    #[test]
    fn the_bar_shows_the_scale_from_end_to_end() {
        let mut picture = Picture { width: 400, height: 300, pixels: vec![[0.5; 3]; 400 * 300] };
        Scale { begin: -2.0, end: 2.0, unit: "W/m2", stops: &DIVERGING }.draw(&mut picture);
        let row = 300 - MARGIN - glyph::HEIGHT - GAP - 2;
        let code = |column: usize| picture.pixel(column, row).map(srgb8_from_linear);
        let left = MARGIN + NUMBER / 2;
        assert_eq!([0, 80, 160].map(|x| code(left + x)), [DIVERGING[0], DIVERGING[2], DIVERGING[4]]);
        assert_eq!(picture.pixel(399, 0), [0.5; 3]);
        let inked = picture.pixels().iter().filter(|pixel| **pixel == INK).count();
        assert!(inked > 100, "{inked} pixels of writing");
    }

    #[test]
    fn a_legend_on_a_tiny_picture_is_cut_off() {
        let mut picture = Picture { width: 9, height: 3, pixels: vec![[0.0; 3]; 27] };
        Scale { begin: 0.0, end: 1.0, unit: "lx", stops: &SEQUENTIAL }.draw(&mut picture);
        assert_eq!(picture.pixels().len(), 27);
    }
}
