//! Lamps without extent: points, spots and distant lights, as `KHR_lights_punctual` has them.
//!
//! What a lamp of intensity `I` brings to a surface that faces it is `I / d^2`. A spot's intensity falls from its inner
//! to its outer cone, and a lamp with a range fades towards it, both by the formulas that the extension recommends.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

use glam::DVec3;

use super::Rgb;
use super::bounds::{MAX_BRIGHTNESS, MAX_COORDINATE_M};

/// The least difference of the cosines of a spot's cones, so that nothing is divided by zero where they are one and the light has a
/// sharp border. The extension recommends 0.001, which dims all cones of less than 2.6 degrees.
const LEAST_CONE: f64 = 1e-12;

/// A lamp.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lamp {
    /// Name, as in the file.
    pub name: String,
    /// What kind of lamp it is, and how bright.
    pub kind: LampKind,
}

/// A kind of lamp. Directions are unit vectors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LampKind {
    /// Shines the same in all directions.
    Point {
        /// Where it is, in metres.
        position_m: DVec3,
        /// Radiant intensity, in W/sr.
        intensity: Rgb,
        /// Where its light ends, in metres; a real lamp's does not.
        range_m: Option<f64>,
    },
    /// Shines into a cone.
    Spot {
        /// Where it is, in metres.
        position_m: DVec3,
        /// The axis of the cone, away from the lamp.
        direction: DVec3,
        /// Radiant intensity inside the inner cone, in W/sr.
        intensity: Rgb,
        /// Where its light ends, in metres.
        range_m: Option<f64>,
        /// Angle between the axis and the inner cone, in radians; that of the outer cone where the light has a sharp border.
        inner_rad: f64,
        /// Angle between the axis and the outer cone, beyond which it is dark, in radians; at most a right angle.
        outer_rad: f64,
    },
    /// Shines from far away, everywhere the same.
    Directional {
        /// The way the light goes.
        direction: DVec3,
        /// Irradiance of a surface that faces it, in W/m2.
        irradiance: Rgb,
    },
}

/// What arrives at a point from a lamp, if nothing stands between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arriving {
    /// Unit vector to the lamp.
    pub towards: DVec3,
    /// Distance of the lamp, in metres; infinite for a distant one.
    pub distance_m: f64,
    /// Irradiance of a surface that faces the lamp, in W/m2.
    pub irradiance: Rgb,
}

impl Lamp {
    /// What arrives at a point; `None` where the lamp does not shine.
    pub fn arriving(&self, at_m: DVec3) -> Option<Arriving> {
        let from = |position_m: DVec3, intensity: Rgb, range_m: Option<f64>| {
            let between = position_m - at_m;
            let distance_m = between.length();
            let fading = range_m.map_or(1.0, |range_m| (1.0 - (distance_m / range_m).powi(4)).clamp(0.0, 1.0));
            let irradiance = fading * intensity / (distance_m * distance_m);
            Arriving { towards: between / distance_m, distance_m, irradiance }
        };
        let arriving = match self.kind {
            LampKind::Point { position_m, intensity, range_m } => from(position_m, intensity, range_m),
            LampKind::Spot { position_m, direction, intensity, range_m, inner_rad, outer_rad } => {
                let arriving = from(position_m, intensity, range_m);
                let share = cone_share(-direction.dot(arriving.towards), inner_rad, outer_rad);
                Arriving { irradiance: share * arriving.irradiance, ..arriving }
            }
            LampKind::Directional { direction, irradiance } => {
                Arriving { towards: -direction, distance_m: f64::INFINITY, irradiance }
            }
        };
        // In the lamp itself there is no direction.
        (arriving.irradiance.is_finite() && arriving.irradiance.max_element() > 0.0).then_some(arriving)
    }

    /// Radiant intensity that it sends in a direction before a range takes any, in W/sr; irradiance of a surface that faces it, in
    /// W/m2, for a distant one.
    pub fn intensity_towards(&self, direction: DVec3) -> Rgb {
        match self.kind {
            LampKind::Point { intensity, .. } => intensity,
            LampKind::Spot { direction: axis, intensity, inner_rad, outer_rad, .. } => {
                cone_share(axis.dot(direction), inner_rad, outer_rad) * intensity
            }
            LampKind::Directional { irradiance, .. } => irradiance,
        }
    }

    /// Where it is, in metres; `None` for a distant one.
    pub fn position_m(&self) -> Option<DVec3> {
        match self.kind {
            LampKind::Point { position_m, .. } | LampKind::Spot { position_m, .. } => Some(position_m),
            LampKind::Directional { .. } => None,
        }
    }

    /// The same lamp in other coordinates: points and directions are moved by the two functions, and ranges are lengths
    /// that are scaled.
    pub fn moved(mut self, point: impl Fn(DVec3) -> DVec3, turned: impl Fn(DVec3) -> DVec3, scale: f64) -> Self {
        match &mut self.kind {
            LampKind::Point { position_m, range_m, .. } => {
                *position_m = point(*position_m);
                *range_m = range_m.map(|range_m| scale * range_m);
            }
            LampKind::Spot { position_m, direction, range_m, .. } => {
                *position_m = point(*position_m);
                *direction = turned(*direction);
                *range_m = range_m.map(|range_m| scale * range_m);
            }
            LampKind::Directional { direction, .. } => *direction = turned(*direction),
        }
        self
    }

    /// Flux that it gives, in W; `None` for a distant one, which has none of its own. A range takes nothing from it.
    pub fn flux_w(&self) -> Option<Rgb> {
        match self.kind {
            LampKind::Point { intensity, .. } => Some(4.0 * PI * intensity),
            LampKind::Spot { intensity, inner_rad, outer_rad, .. } => {
                // The mean over the soft part of a share that is a square is a third.
                let (inner, outer) = (inner_rad.cos(), outer_rad.cos());
                let soft = (inner - outer).max(LEAST_CONE);
                Some(2.0 * PI * (1.0 - outer - soft * 2.0 / 3.0) * intensity)
            }
            LampKind::Directional { .. } => None,
        }
    }

    /// Whether another lamp is the same but for its brightness: it has the same shadows.
    pub fn shines_where(&self, other: &Self) -> bool {
        self.of_brightness(Rgb::ONE).kind == other.of_brightness(Rgb::ONE).kind
    }

    /// Its intensity, in W/sr, or the irradiance of a distant one, in W/m2.
    pub fn brightness(&self) -> Rgb {
        match self.kind {
            LampKind::Point { intensity, .. } | LampKind::Spot { intensity, .. } => intensity,
            LampKind::Directional { irradiance, .. } => irradiance,
        }
    }

    /// The same lamp with another brightness.
    fn of_brightness(&self, brightness: Rgb) -> Self {
        let mut lamp = self.clone();
        match &mut lamp.kind {
            LampKind::Point { intensity, .. } | LampKind::Spot { intensity, .. } => *intensity = brightness,
            LampKind::Directional { irradiance, .. } => *irradiance = brightness,
        }
        lamp
    }

    /// Whether it gives light, at the brightness that it has.
    pub fn emits(&self) -> bool {
        self.brightness().max_element() > 0.0
    }

    /// What is wrong with it: a property, and what it must be.
    pub(super) fn defect(&self) -> Option<&'static str> {
        let unit = |direction: DVec3| (direction.length() - 1.0).abs() < 1e-6;
        let bright =
            |light: Rgb| light.is_finite() && light.min_element() >= 0.0 && light.max_element() <= MAX_BRIGHTNESS;
        let (position_m, direction, light, range_m) = match self.kind {
            LampKind::Point { position_m, intensity, range_m } => (position_m, DVec3::X, intensity, range_m),
            LampKind::Spot { position_m, direction, intensity, range_m, .. } => {
                (position_m, direction, intensity, range_m)
            }
            LampKind::Directional { direction, irradiance } => (DVec3::ZERO, direction, irradiance, None),
        };
        let cones = match self.kind {
            LampKind::Spot { inner_rad, outer_rad, .. } => {
                inner_rad >= 0.0 && inner_rad <= outer_rad && outer_rad > 0.0 && outer_rad <= 0.5 * PI + 1e-6
            }
            LampKind::Point { .. } | LampKind::Directional { .. } => true,
        };
        if !(position_m.is_finite() && position_m.abs().max_element() <= MAX_COORDINATE_M) {
            Some("its position must be finite, and within 4e11 m: mend it in the file, or say its unit with --unit")
        } else if !unit(direction) {
            Some("its direction must be a unit vector")
        } else if !bright(light) {
            Some("its brightness must be finite, not negative and at most 1e15: mend it in the file")
        } else if range_m.is_some_and(|range_m| !(range_m.is_finite() && range_m > 0.0)) {
            Some("its range must be above 0")
        } else if !cones {
            Some(
                "its inner cone must be at least 0 and no wider than the outer, which is above 0 and at most a right angle",
            )
        } else {
            None
        }
    }
}

/// The share of a spot's intensity at an angle from the axis of this cosine.
fn cone_share(cosine: f64, inner_rad: f64, outer_rad: f64) -> f64 {
    let soft = (inner_rad.cos() - outer_rad.cos()).max(LEAST_CONE);
    ((cosine - outer_rad.cos()) / soft).clamp(0.0, 1.0).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(inner_rad: f64, outer_rad: f64) -> Lamp {
        let kind = LampKind::Spot {
            position_m: DVec3::Z * 2.0,
            direction: DVec3::NEG_Z,
            intensity: Rgb::new(1.0, 2.0, 4.0),
            range_m: None,
            inner_rad,
            outer_rad,
        };
        Lamp { name: "spot".into(), kind }
    }

    #[test]
    fn a_point_lamp_falls_with_the_square_of_the_distance_and_ends_at_its_range() {
        let at = |range_m| {
            let kind = LampKind::Point { position_m: DVec3::ZERO, intensity: Rgb::splat(8.0), range_m };
            move |x: f64| Lamp { name: String::new(), kind }.arriving(DVec3::X * x)
        };
        let arriving = at(None)(2.0).unwrap();
        assert_eq!((arriving.towards, arriving.distance_m), (DVec3::NEG_X, 2.0));
        assert_eq!(arriving.irradiance, Rgb::splat(2.0));
        assert_eq!(at(Some(4.0))(2.0).unwrap().irradiance, Rgb::splat(2.0 * (1.0 - 1.0 / 16.0)));
        assert_eq!(at(Some(4.0))(4.0), None);
        assert_eq!(at(None)(0.0), None, "in the lamp there is no direction");
    }

    #[test]
    fn a_spot_is_bright_within_its_inner_cone_and_dark_beyond_the_outer() {
        let (inner, outer) = (0.3_f64, 0.6_f64);
        let at = |angle: f64| spot(inner, outer).arriving(DVec3::new(2.0 * angle.tan(), 0.0, 0.0));
        assert_eq!(at(0.0).unwrap().irradiance, Rgb::new(0.25, 0.5, 1.0));
        let share = |angle: f64| at(angle).map_or(0.0, |a| a.irradiance.x * a.distance_m * a.distance_m);
        // Where both cones are one, light ends at once.
        let sharp = |angle: f64| spot(outer, outer).arriving(DVec3::new(2.0 * angle.tan(), 0.0, 0.0));
        assert!(sharp(outer + 1e-9).is_none() && spot(outer, outer).defect().is_none());
        assert!((sharp(outer - 1e-9).unwrap().irradiance.x - 0.25 * outer.cos().powi(2)).abs() < 1e-8);
        assert!(spot(outer + 1e-9, outer).defect().is_some() && spot(0.0, 0.0).defect().is_some());
        assert!((share(0.29) - 1.0).abs() < 1e-12 && share(0.61) == 0.0);
        // Half way in the cosine, a quarter.
        let middle = (0.5 * (inner.cos() + outer.cos())).acos();
        assert!((share(middle) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn fluxes_are_the_integrals_of_what_arrives() {
        // Over rings of a sphere of radius 1 around the lamp.
        let rings = 200_000;
        for (inner, outer) in [(0.3, 0.6), (0.0, 1.2), (0.599, 0.6), (0.6, 0.6), (0.0, 0.02)] {
            let lamp = spot(inner, outer);
            let ring = |i: i32| {
                let cosine = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(rings);
                let p = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, 2.0 - cosine);
                lamp.arriving(p).map_or(0.0, |arriving| arriving.irradiance.x) * 4.0 * PI / f64::from(rings)
            };
            let sum: f64 = (0..rings).map(ring).sum();
            let flux = lamp.flux_w().unwrap().x;
            assert!((sum / flux - 1.0).abs() < 0.04, "{sum} {flux} for {inner} {outer}");
        }
        let point = LampKind::Point { position_m: DVec3::ZERO, intensity: Rgb::ONE, range_m: None };
        assert_eq!(Lamp { name: String::new(), kind: point }.flux_w(), Some(Rgb::splat(4.0 * PI)));
    }

    #[test]
    fn a_distant_lamp_is_the_same_everywhere() {
        let kind = LampKind::Directional { direction: DVec3::NEG_Y, irradiance: Rgb::splat(3.0) };
        let sun = Lamp { name: "sun".into(), kind };
        let arriving = sun.arriving(DVec3::splat(1e3)).unwrap();
        assert_eq!((arriving.towards, arriving.irradiance), (DVec3::Y, Rgb::splat(3.0)));
        assert!(arriving.distance_m.is_infinite() && sun.flux_w().is_none() && sun.position_m().is_none());
    }
}
