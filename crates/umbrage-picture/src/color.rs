//! From light to what a screen shows: exposure, clipping, sRGB.
//!
//! Idea: colours are linear up to the last step, and this file is the only one that leaves linear light, so that every
//! way of showing a bake (picture, window, page) can share one meaning of colour.
//!
//! Holds: encoding and decoding are inverse on all 256 codes; NaN is black.
//!
//! Source: IEC 61966-2-1.

/// A linear colour: red, green, blue; 1 is the screen's white.
pub type LinearRgb = [f32; 3];

/// Light of a linear component, 0 to 1, encoded for an sRGB screen, 0 to 1.
pub fn srgb_from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// An sRGB component, 0 to 1, as light.
pub fn linear_from_srgb(srgb: f64) -> f64 {
    if srgb <= 0.040_45 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).powf(2.4) }
}

/// The 8-bit sRGB code nearest to a linear component, which is clipped to 0..1.
pub fn srgb8_from_linear(linear: f32) -> u8 {
    // A cast from float to integer saturates, and makes NaN 0.
    (255.0 * srgb_from_linear(f64::from(linear).clamp(0.0, 1.0))).round() as u8
}

/// The linear colour of 8-bit sRGB codes, as colours are written on the web.
pub fn linear_from_srgb8(code: [u8; 3]) -> LinearRgb {
    code.map(|c| linear_from_srgb(f64::from(c) / 255.0) as f32)
}

/// A colour as it is displayed: times `exposure`, clipped to what a screen can show.
pub fn exposed(color: LinearRgb, exposure: f32) -> LinearRgb {
    // `max` takes the 0 where the other is NaN.
    color.map(|c| (c * exposure).max(0.0)).map(|c| c.min(1.0))
}

/// Relative luminance of a linear colour (Rec. 709).
pub fn luminance(color: LinearRgb) -> f32 {
    0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_codes_survive_the_round_trip() {
        for code in 0..=255u8 {
            assert_eq!(srgb8_from_linear(linear_from_srgb8([code; 3])[0]), code);
        }
    }

    #[test]
    fn known_codes() {
        assert_eq!([0.0, 0.215_861, 1.0].map(srgb8_from_linear), [0, 128, 255]);
        assert_eq!([-1.0, 7.0, f32::NAN, f32::INFINITY].map(srgb8_from_linear), [0, 255, 0, 255]);
    }

    #[test]
    fn the_two_branches_of_the_curve_meet() {
        assert!((srgb_from_linear(0.003_130_8) - srgb_from_linear(0.003_130_9)).abs() < 2e-6);
        assert!((linear_from_srgb(0.040_45) - linear_from_srgb(0.040_451)).abs() < 2e-7);
    }

    #[test]
    fn exposure_multiplies_and_clips() {
        assert_eq!(exposed([0.2, 0.8, f32::NAN], 2.0), [0.4, 1.0, 0.0]);
    }
}
