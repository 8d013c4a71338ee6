//! From light to what a screen shows: exposure, tone curve, clipping, sRGB, and the scales of false colour.
//!
//! Idea: colours are linear up to the last step, and this file is the only one that leaves linear light, so that every
//! way of showing a bake (picture, window, page) has one meaning of colour. What a shader needs is written as numbers
//! and tables ([`shader_constants`]), from which the source text of any shading language can be made.
//!
//! Holds: encoding and decoding are inverse on all 256 codes; NaN is black; both tone curves keep black black and never
//! fall; the sequential scale rises in luminance, so that it reads the same in grey and to the colour-blind.
//!
//! Sources: IEC 61966-2-1 (sRGB); K. Narkowicz, ACES Filmic Tone Mapping Curve, 2016; viridis by S. van der Walt and
//! N. Smith (CC0), here at nine equidistant points.

/// A linear colour: red, green, blue; 1 is the screen's white.
pub type LinearRgb = [f32; 3];

/// What is behind the scene: a dark grey. Unlike black it shows where a dark scene ends, unlike white it does not
/// blind.
pub const BACKGROUND: LinearRgb = [0.03; 3];

/// Weights of linear red, green and blue in luminance (Rec. 709).
pub const LUMINANCE_WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Luminance above which a thin black line is easier to see than a thin white one.
pub const CONTRAST_LUMINANCE: f32 = 0.6;

/// Luminous efficacy that turns W into lm where light is given in W alone: that of glTF and of the candela.
pub const LUMENS_PER_WATT: f64 = 683.0;

/// Share of a scene's area whose irradiance lies within the scale of false colours, where nobody says where it ends:
/// spots beside a lamp are many times brighter than all else, and would leave the rest one colour.
pub const SHARE_WITHIN_SCALE: f64 = 0.98;

/// Brighter light than this counts as this: the greatest half-precision number, so that a shader can hold it.
const LARGEST: f32 = 65504.0;

/// sRGB: linear value up to which the curve is straight, its slope there, then scale, offset and exponent.
const SRGB: [f64; 5] = [0.003_130_8, 12.92, 1.055, 0.055, 2.4];

/// `(x (a x + b)) / (x (c x + d) + e)`: the fit of the ACES curve.
const FILMIC: [f32; 5] = [2.51, 0.03, 2.43, 0.59, 0.14];

/// From nothing to the end of the scale, as sRGB codes.
pub const SEQUENTIAL: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 45, 123],
    [59, 82, 139],
    [44, 114, 142],
    [33, 145, 140],
    [40, 174, 128],
    [94, 201, 98],
    [173, 220, 48],
    [253, 231, 37],
];

/// From far below through equal to far above, as sRGB codes.
pub const DIVERGING: [[u8; 3]; 5] = [[20, 70, 150], [120, 170, 216], [245, 245, 245], [235, 150, 110], [160, 25, 40]];

/// Colours of d-segments of degree 0, 1 and 2, as sRGB codes.
pub const DEGREES: [[u8; 3]; 3] = [[226, 30, 30], [255, 140, 0], [40, 110, 255]];

/// How light becomes a displayable colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// As it is, cut off at white: what every ordinary viewer does with an unlit material.
    #[default]
    Off,
    /// A film's curve: more contrast in the dark, and a shoulder that keeps what is brighter than white apart.
    Filmic,
}

impl Tone {
    /// A component of light, 0 or more, as a linear component of the screen, 0 to 1.
    fn apply(self, light: f32) -> f32 {
        let [a, b, c, d, e] = FILMIC;
        match self {
            Self::Off => light.min(1.0),
            Self::Filmic => (light * (a * light + b) / (light * (c * light + d) + e)).min(1.0),
        }
    }
}

/// A colour as it is displayed: times `exposure`, through the tone curve, within what a screen can show.
pub fn displayed(color: LinearRgb, exposure: f32, tone: Tone) -> LinearRgb {
    color.map(|c| {
        let light = c * exposure;
        // NaN is not above 0.
        tone.apply(if light > 0.0 { light.min(LARGEST) } else { 0.0 })
    })
}

/// Light of a linear component, 0 to 1, encoded for an sRGB screen, 0 to 1.
pub fn srgb_from_linear(linear: f64) -> f64 {
    let [cut, slope, scale, offset, exponent] = SRGB;
    if linear <= cut { slope * linear } else { scale * linear.powf(1.0 / exponent) - offset }
}

/// An sRGB component, 0 to 1, as light.
pub fn linear_from_srgb(srgb: f64) -> f64 {
    let [_, slope, scale, offset, exponent] = SRGB;
    if srgb <= 0.040_45 { srgb / slope } else { ((srgb + offset) / scale).powf(exponent) }
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

/// The colour `at` of a scale, 0 to 1, clipped: straight between its stops in sRGB codes, as a style sheet's gradient
/// is.
pub fn on_scale(stops: &[[u8; 3]], at: f32) -> LinearRgb {
    let last = stops.len() - 1;
    // NaN is not above 0.
    let place = if at > 0.0 { f64::from(at.min(1.0)) * last as f64 } else { 0.0 };
    let from = (place as usize).min(last.saturating_sub(1));
    let share = place - from as f64;
    std::array::from_fn(|channel| {
        let [low, high] = [from, (from + 1).min(last)].map(|stop| f64::from(stops[stop][channel]));
        linear_from_srgb((low + share * (high - low)) / 255.0) as f32
    })
}

/// Relative luminance of a linear colour.
pub fn luminance(color: LinearRgb) -> f32 {
    LUMINANCE_WEIGHTS.iter().zip(color).map(|(weight, c)| weight * c).sum()
}

/// What a shader needs of this file.
#[derive(Clone, Debug, PartialEq)]
pub enum ShaderValue {
    /// A number.
    Number(f32),
    /// Three numbers.
    Vector([f32; 3]),
    /// Colours in sRGB codes, 0 to 1.
    Scale(Vec<[f32; 3]>),
}

/// Everything in this file that a shader needs, by name, in capitals: one source for all shading languages.
pub fn shader_constants() -> Vec<(&'static str, ShaderValue)> {
    let numbers = |names: [&'static str; 5], values: [f32; 5]| {
        names.into_iter().zip(values.map(ShaderValue::Number)).collect::<Vec<_>>()
    };
    let mut all = numbers(
        ["SRGB_CUT", "SRGB_SLOPE", "SRGB_SCALE", "SRGB_OFFSET", "SRGB_EXPONENT"],
        SRGB.map(|number| number as f32),
    );
    all.extend(numbers(["FILMIC_A", "FILMIC_B", "FILMIC_C", "FILMIC_D", "FILMIC_E"], FILMIC));
    all.push(("LARGEST", ShaderValue::Number(LARGEST)));
    all.push(("CONTRAST_LUMINANCE", ShaderValue::Number(CONTRAST_LUMINANCE)));
    all.push(("LUMINANCE_WEIGHTS", ShaderValue::Vector(LUMINANCE_WEIGHTS)));
    let scale = SEQUENTIAL.iter().map(|code| code.map(|c| f32::from(c) / 255.0)).collect();
    all.push(("SEQUENTIAL", ShaderValue::Scale(scale)));
    all
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
        assert_eq!(displayed([0.2, 0.8, f32::NAN], 2.0, Tone::Off), [0.4, 1.0, 0.0]);
        assert_eq!(displayed([-1.0, f32::INFINITY, 0.0], 1.0, Tone::Off), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn the_film_keeps_black_rises_and_keeps_what_is_above_white_apart() {
        let filmic = |light| displayed([light; 3], 1.0, Tone::Filmic)[0];
        assert_eq!((filmic(0.0), filmic(f32::NAN)), (0.0, 0.0));
        // By hand: 0.5 (1.255 + 0.03) / (0.5 (1.215 + 0.59) + 0.14) = 0.6425 / 1.0425.
        assert!((filmic(0.5) - 0.616_307).abs() < 1e-6);
        let values: Vec<f32> = (0..400).map(|i| filmic(0.01 * i as f32)).collect();
        assert!(values.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(filmic(1.0) < 0.81 && filmic(2.0) < 0.95 && filmic(f32::INFINITY) == 1.0);
    }

    #[test]
    fn scales_have_their_stops_and_are_straight_between() {
        for (i, &stop) in SEQUENTIAL.iter().enumerate() {
            assert_eq!(on_scale(&SEQUENTIAL, i as f32 / 8.0).map(srgb8_from_linear), stop);
        }
        let half_way = on_scale(&DIVERGING, 0.125).map(srgb8_from_linear);
        assert_eq!(half_way, [70, 120, 183]);
        assert_eq!(on_scale(&DIVERGING, 9.0).map(srgb8_from_linear), DIVERGING[4]);
        assert_eq!(on_scale(&DIVERGING, f32::NAN).map(srgb8_from_linear), DIVERGING[0]);
    }

    #[test]
    fn the_sequential_scale_rises_in_luminance() {
        let values: Vec<f32> = (0..=100).map(|i| luminance(on_scale(&SEQUENTIAL, 0.01 * i as f32))).collect();
        assert!(values.windows(2).all(|pair| pair[0] < pair[1]), "{values:?}");
    }

    #[test]
    fn shader_constants_have_names_of_their_own() {
        let mut names: Vec<_> = shader_constants().into_iter().map(|(name, _)| name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), shader_constants().len());
    }
}
