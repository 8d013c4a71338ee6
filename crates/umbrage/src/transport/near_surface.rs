//! The light of a lamp that nearly touches a surface, spread over a spot that can be shown.
//!
//! A lamp of intensity `I` at the height `h` over a plane lights it by `I h / (h^2 + r^2)^(3/2)`: half of its light falls on a spot of
//! about the size of `h`, however small that is. No triangle shows a spot of some micrometres, and a vertex that happens to lie in
//! it must not show its value for all that lies around. So within a radius `R`, a small share of the scene, the plane shows
//!
//! ```text
//! E(r) = t^2 E(R) + (1 - t^2) c,     t = r / R
//! ```
//!
//! with `E(R)` in the same direction from the foot of the lamp, and `c` such that the flux into the disc is the true one. Beyond `R`
//! nothing changes; and nothing does where the lamp is higher than `R`.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::scene::{Lamp, LampKind, Rgb};
use crate::visibility::ReceiverPoint;

/// The radius within which the light of a lamp nearer to a surface than that is spread, as a share of the scene's extent: a
/// millimetre in a room of five metres.
pub(super) const SPREAD_OF_EXTENT: f64 = 2e-4;
/// Directions in which the light of a spot into the disc is summed, and points of its border.
const DIRECTIONS: usize = 512;
const AROUND: usize = 16;
/// The golden angle, in radians.
const GOLDEN_RAD: f64 = 2.399_963_229_728_653;

/// Irradiance of an unoccluded point, in W/m2.
pub(super) fn unoccluded(lamp: &Lamp, at_m: DVec3, normal: DVec3) -> Rgb {
    lamp.arriving(at_m).map_or(Rgb::ZERO, |arriving| normal.dot(arriving.towards).max(0.0) * arriving.irradiance)
}

/// Irradiance of an unoccluded point whose surface a lamp nearly touches, spread within `radius_m`, in W/m2; `None` where the lamp
/// is not that near.
pub(super) fn spread(lamp: &Lamp, receiver: &ReceiverPoint, radius_m: f64) -> Option<Rgb> {
    let position_m = lamp.position_m()?;
    let normal = receiver.normal;
    let height_m = (position_m - receiver.position_m).dot(normal);
    if height_m <= 0.0 || height_m >= radius_m {
        return None;
    }
    let foot_m = position_m - height_m * normal;
    let away_m = receiver.position_m - foot_m;
    if away_m.length_squared() >= radius_m * radius_m {
        return None;
    }
    let at = |direction: DVec3| unoccluded(lamp, foot_m + radius_m * direction, normal);
    let (u, v) = normal.any_orthonormal_pair();
    let around = |i: usize| u * (TAU * i as f64 / AROUND as f64).cos() + v * (TAU * i as f64 / AROUND as f64).sin();
    let border = (0..AROUND).map(|i| at(around(i))).sum::<Rgb>() / AROUND as f64;
    let peak =
        (2.0 * flux_w(lamp, foot_m, normal, height_m, radius_m) / (PI * radius_m * radius_m) - border).max(Rgb::ZERO);
    let t2 = away_m.length_squared() / (radius_m * radius_m);
    Some(t2 * at(away_m.normalize_or(u)) + (1.0 - t2) * peak)
}

/// Flux of a lamp into a disc around its foot, in W.
fn flux_w(lamp: &Lamp, foot_m: DVec3, normal: DVec3, height_m: f64, radius_m: f64) -> Rgb {
    let least_cosine = height_m / height_m.hypot(radius_m);
    let solid_angle = TAU * (1.0 - least_cosine);
    if let LampKind::Point { intensity, .. } = lamp.kind {
        return solid_angle * intensity;
    }
    let (u, v) = normal.any_orthonormal_pair();
    let intensity = |i: usize| {
        let cosine = 1.0 - (1.0 - least_cosine) * (i as f64 + 0.5) / DIRECTIONS as f64;
        let tangent = (1.0 - cosine * cosine).sqrt() / cosine;
        let (sin, cos) = (GOLDEN_RAD * i as f64).sin_cos();
        let at_m = foot_m + height_m * tangent * (cos * u + sin * v);
        let distance_m = height_m / cosine;
        lamp.arriving(at_m).map_or(Rgb::ZERO, |arriving| distance_m * distance_m * arriving.irradiance)
    };
    solid_angle / DIRECTIONS as f64 * (0..DIRECTIONS).map(intensity).sum::<Rgb>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::PlaneId;

    /// Flux into a disc of one metre by rings, of the light that is spread within 0.1 m.
    fn flux_by_rings(lamp: &Lamp) -> f64 {
        let (rings, around) = (4000, 64);
        let radius_m = |k: usize| (k as f64 / rings as f64).powi(2);
        let ring = |k: usize| {
            let (inner_m, outer_m) = (radius_m(k), radius_m(k + 1));
            let mean = (0..around).map(|i| {
                let (sin, cos) = (TAU * (i as f64 + 0.5) / around as f64).sin_cos();
                let position_m = 0.5 * (inner_m + outer_m) * DVec3::new(cos, sin, 0.0);
                let receiver = ReceiverPoint::on_plane(position_m, DVec3::Z, PlaneId::from(0));
                spread(lamp, &receiver, 0.1).unwrap_or_else(|| unoccluded(lamp, position_m, DVec3::Z)).x
            });
            PI * (outer_m * outer_m - inner_m * inner_m) * mean.sum::<f64>() / around as f64
        };
        (0..rings).map(ring).sum()
    }

    #[test]
    fn spread_light_is_as_much_as_there_is() {
        for height_m in [1e-5_f64, 1e-3, 0.05, 0.099, 0.101] {
            let kind = LampKind::Point { position_m: height_m * DVec3::Z, intensity: Rgb::ONE, range_m: None };
            let found = flux_by_rings(&Lamp { name: String::new(), kind });
            let truth = TAU * (1.0 - height_m / height_m.hypot(1.0));
            assert!((found / truth - 1.0).abs() < 1e-3, "{found} {truth} at {height_m}");
        }
        for direction in [DVec3::NEG_Z, DVec3::new(0.6, 0.0, -0.8)] {
            let (position_m, intensity, range_m) = (0.01 * DVec3::Z, Rgb::ONE, None);
            let kind = LampKind::Spot { position_m, direction, intensity, range_m, inner_rad: 0.2, outer_rad: 0.5 };
            let lamp = Lamp { name: String::new(), kind };
            let (found, truth) = (flux_by_rings(&lamp), lamp.flux_w().unwrap().x);
            assert!((found / truth - 1.0).abs() < 0.02, "{found} {truth}");
        }
    }
}
