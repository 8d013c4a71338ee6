//! Colours: CIE chromaticities and spectra, and what of red, green and blue they are.
//!
//! A colour of MGF says nothing of brightness, so it is a chromaticity (x, y); a spectrum becomes one by the colour
//! matching functions. Spectra and mixtures are linear, so mixing chromaticities by brightness in XYZ is mixing spectra.
//!
//! Red, green and blue are the primaries of sRGB (ITU-R BT.709), and white is the spectrum that is the same at all
//! wavelengths, E = (1/3, 1/3): the colours of MGF are absolute, a reflectance that is equal at all wavelengths is grey,
//! and so it has to be equal in red, green and blue. Brightness (Y) is kept exactly.
//!
//! Source: colour matching functions by C. Wyman, P.-P. Sloan, P. Shirley, *Simple Analytic Approximations to the CIE XYZ
//! Color Matching Functions*, JCGT 2(2), 2013: multi-lobe fit to the 1931 observer, off by 1 % of the peak.

use glam::{DMat3, DVec3};
use umbrage::scene::Rgb;

/// Chromaticities of red, green and blue.
const PRIMARIES: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];

/// The visible range, in nanometres.
const VISIBLE_NM: [f64; 2] = [380.0, 780.0];

/// The step in which spectra are summed up, in nanometres: narrower than any lobe of the matching functions.
const STEP_NM: f64 = 2.0;

/// The least `y` of a chromaticity that is mended: about that of the bluest light.
const LEAST_Y: f64 = 0.005;

/// A chromaticity, CIE 1931; `y` is above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Colour {
    pub(super) x: f64,
    pub(super) y: f64,
}

impl Default for Colour {
    /// Neutral: the same at all wavelengths.
    fn default() -> Self {
        Self { x: 1.0 / 3.0, y: 1.0 / 3.0 }
    }
}

impl Colour {
    /// A chromaticity, if it is one.
    pub(super) fn new(x: f64, y: f64) -> Option<Self> {
        (x >= 0.0 && y > 0.0 && x + y <= 1.0 + 1e-9).then_some(Self { x, y })
    }

    /// The chromaticity that is nearest to two finite numbers which may be none.
    pub(super) fn nearest(x: f64, y: f64) -> Self {
        let (x, y) = (x.clamp(0.0, 1.0), y.clamp(LEAST_Y, 1.0));
        let sum = (x + y).max(1.0);
        Self { x: x / sum, y: y / sum }
    }

    /// The colour of XYZ, if it has a brightness. Measured spectra have negative values, which can leave a little too little of X or Z.
    fn of_xyz(xyz: DVec3) -> Option<Self> {
        let xyz = DVec3::new(xyz.x.max(0.0), xyz.y, xyz.z.max(0.0));
        let sum = xyz.element_sum();
        Self::new(xyz.x / sum, xyz.y / sum)
    }

    /// XYZ at brightness `y`.
    fn xyz(self, y: f64) -> DVec3 {
        y / self.y * DVec3::new(self.x, self.y, 1.0 - self.x - self.y)
    }

    /// A relative spectrum: `values` at even steps from `from_nm` to `to_nm`, straight between them, 0 outside.
    pub(super) fn of_spectrum(from_nm: f64, to_nm: f64, values: &[f64]) -> Option<Self> {
        let at = |nm: f64| {
            let t = (nm - from_nm) / (to_nm - from_nm) * (values.len() - 1) as f64;
            // The cast saturates; only indices within are taken.
            let i = t.floor() as usize;
            match (t >= 0.0, values.get(i), values.get(i + 1)) {
                (true, Some(low), Some(high)) => low + (high - low) * t.fract(),
                (true, Some(last), None) if t.fract() == 0.0 => *last,
                _ => 0.0,
            }
        };
        if values.len() < 2 || from_nm >= to_nm { None } else { Self::of_xyz(xyz_of_spectrum(at)) }
    }

    /// The spectrum of a black body, by Planck's law.
    pub(super) fn of_black_body(kelvin: f64) -> Option<Self> {
        /// Second radiation constant, in nm K.
        const C2: f64 = 1.438_776_877e7;
        // Relative to its value at 555 nm, so that cold bodies do not vanish.
        let power = |nm: f64| (nm / 555.0).powi(-5) * ((C2 / 555.0 / kelvin).exp_m1() / (C2 / nm / kelvin).exp_m1());
        if kelvin > 0.0 { Self::of_xyz(xyz_of_spectrum(power)) } else { None }
    }

    /// The mixture of colours, each with its brightness.
    pub(super) fn mixture(parts: &[(f64, Colour)]) -> Option<Self> {
        Self::of_xyz(parts.iter().map(|&(weight, colour)| colour.xyz(weight)).sum())
    }

    /// Red, green and blue at brightness 1, and whether the colour is among those that they mix; else the nearest on the
    /// way to equal brightness that is.
    pub(super) fn rgb(self) -> (Rgb, bool) {
        let rgb = rgb_from_xyz() * self.xyz(1.0);
        let least = rgb.min_element();
        // A deviation below 0.1 % comes from chromaticities with three digits.
        if least >= -1e-3 {
            let cut = rgb.max(Rgb::ZERO);
            return (cut / brightness(cut), true);
        }
        // Towards grey of the same brightness, until nothing is negative.
        let t = 1.0 / (1.0 - least);
        ((Rgb::ONE + t * (rgb - Rgb::ONE)).max(Rgb::ZERO), false)
    }
}

/// Brightness Y of a linear colour; that of white is 1.
pub(super) fn brightness(rgb: Rgb) -> f64 {
    rgb_from_xyz().inverse().transpose().y_axis.dot(rgb)
}

/// From XYZ to red, green and blue, white E = (1, 1, 1) in both.
fn rgb_from_xyz() -> DMat3 {
    let [red, green, blue] = PRIMARIES.map(|[x, y]| Colour { x, y }.xyz(y));
    let chromaticities = DMat3::from_cols(red, green, blue);
    let amounts = chromaticities.inverse() * DVec3::ONE;
    (chromaticities * DMat3::from_diagonal(amounts)).inverse()
}

/// XYZ of a spectrum, by the matching functions, each scaled so that the spectrum E is white exactly.
fn xyz_of_spectrum(power: impl Fn(f64) -> f64) -> DVec3 {
    let steps = ((VISIBLE_NM[1] - VISIBLE_NM[0]) / STEP_NM) as usize;
    let wavelengths = (0..steps).map(|i| VISIBLE_NM[0] + (i as f64 + 0.5) * STEP_NM);
    let (mut xyz, mut white) = (DVec3::ZERO, DVec3::ZERO);
    for nm in wavelengths {
        let response = matching(nm);
        xyz += power(nm) * response;
        white += response;
    }
    xyz / white
}

/// The colour matching functions at a wavelength in nanometres.
fn matching(nm: f64) -> DVec3 {
    let lobe = |peak: f64, centre: f64, below: f64, above: f64| {
        let t = (nm - centre) / if nm < centre { below } else { above };
        peak * (-0.5 * t * t).exp()
    };
    DVec3::new(
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neutral_is_grey_however_it_is_said() {
        let flat = Colour::of_spectrum(300.0, 900.0, &[2.0; 7]).unwrap();
        for colour in [Colour::default(), flat, Colour::new(0.3333, 0.3333).unwrap()] {
            let (rgb, inside) = colour.rgb();
            assert!(inside && (rgb - Rgb::ONE).abs().max_element() < 1e-3, "{rgb}");
        }
    }

    #[test]
    fn primaries_are_pure_and_brightness_is_kept() {
        for (i, [x, y]) in PRIMARIES.into_iter().enumerate() {
            let (rgb, inside) = Colour::new(x, y).unwrap().rgb();
            assert!(inside && rgb[i] > 1.0 && (0..3).all(|j| j == i || rgb[j] < 1e-3), "{rgb}");
        }
        for (x, y) in [(0.362, 0.283), (0.1, 0.8), (0.7, 0.29), (0.05, 0.3), (0.2, 0.02)] {
            let (rgb, _) = Colour::new(x, y).unwrap().rgb();
            assert!(rgb.min_element() >= 0.0 && (brightness(rgb) - 1.0).abs() < 1e-9, "{x} {y}: {rgb}");
        }
        assert!(!Colour::new(0.1, 0.8).unwrap().rgb().1);
    }

    #[test]
    fn black_bodies_have_their_known_chromaticities() {
        for (kelvin, x, y) in [(3000.0, 0.4369, 0.4041), (6500.0, 0.3135, 0.3237), (2856.0, 0.4476, 0.4074)] {
            let colour = Colour::of_black_body(kelvin).unwrap();
            assert!((colour.x - x).abs() < 4e-3 && (colour.y - y).abs() < 4e-3, "{kelvin}: {colour:?}");
        }
        assert!(Colour::of_black_body(-1.0).is_none());
    }

    #[test]
    fn mixtures_follow_brightness() {
        let (red, blue) = (Colour::new(0.64, 0.33).unwrap(), Colour::new(0.15, 0.06).unwrap());
        let parts = [(brightness(Rgb::X), red), (brightness(Rgb::Y), Colour::new(0.3, 0.6).unwrap()), {
            (brightness(Rgb::Z), blue)
        }];
        let white = Colour::mixture(&parts).unwrap();
        assert!((white.x - 1.0 / 3.0).abs() < 1e-9 && (white.y - 1.0 / 3.0).abs() < 1e-9);
        let same = Colour::mixture(&[(3.0, red)]).unwrap();
        assert!((same.x - red.x).abs() < 1e-12 && (same.y - red.y).abs() < 1e-12);
        assert!(Colour::mixture(&[]).is_none() && Colour::mixture(&[(0.0, red)]).is_none());
    }

    #[test]
    fn what_is_no_colour_is_refused() {
        assert!(Colour::new(0.3, 0.0).is_none() && Colour::new(0.6, 0.6).is_none());
        assert!(Colour::new(f64::NAN, 0.3).is_none());
        assert!(Colour::of_spectrum(400.0, 700.0, &[0.0; 4]).is_none());
        assert!(Colour::of_spectrum(700.0, 400.0, &[1.0; 4]).is_none());
        assert!(Colour::of_spectrum(400.0, 700.0, &[]).is_none());
        assert!(Colour::of_spectrum(10.0, 20.0, &[1.0; 3]).is_none());
    }

    #[test]
    fn negative_values_and_odd_chromaticities_become_the_nearest() {
        let (rgb, _) = Colour::of_spectrum(400.0, 700.0, &[-0.02, -0.01, 0.1, 0.9]).unwrap().rgb();
        assert!(rgb.min_element() >= 0.0 && rgb.x > rgb.y, "{rgb}");
        for (x, y) in [(0.7, 0.6), (-0.1, 0.3), (0.3, 0.0), (0.3, -1.0), (1e300, 1e300)] {
            let Colour { x, y } = Colour::nearest(x, y);
            assert!(Colour::new(x, y).is_some() && Colour::new(x, y).unwrap().rgb().0.is_finite(), "{x} {y}");
        }
    }

    #[test]
    fn a_reddish_spectrum_is_reddish() {
        let (rgb, inside) = Colour::of_spectrum(400.0, 700.0, &[0.2, 0.2, 0.3, 0.8]).unwrap().rgb();
        assert!(inside && rgb.x > rgb.y && rgb.y > rgb.z, "{rgb}");
    }
}
