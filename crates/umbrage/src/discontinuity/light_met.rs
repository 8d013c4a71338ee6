//! About the mean irradiance of a scene, before any light is solved: what its lamps send to surfaces, by a few rays from each.
//!
//! The mean irradiance of a room follows from the flux of its lamps over its area. Of an object under the sky most of that leaves the
//! scene: taken for its mean, it would be several times too high, and lines that matter would be left out as weak. Emitters with extent count with all their flux: most of their lines are
//! of degree 2, and with more of those the Cornell box, which is open, takes 4,173 triangles instead of 3,621.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{Emitter, Features};
use crate::geometry::polygon;
use crate::prepare::Prepared;
use crate::scene::{Lamp, LampKind};
use crate::visibility::{FirstMet, Visibility};

/// Rays of all lamps together. Of one lamp among few, 256 are within some 5 % of its flux.
const RAYS: usize = 8192;
/// Rays of a lamp: no fewer, and no more.
const RAYS_OF_LAMP: [usize; 2] = [4, 256];
/// Rays reach so many extents.
const REACH_OF_EXTENT: f64 = 2.0;
/// Turns of the golden angle: even directions for any number of them.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// About the mean irradiance of the front sides of all faces, in W/m2, of emitters and lamps alone; distant lamps have no flux, and count
/// for nothing. What is reflected is left out, as are shadows within the scene on fronts.
pub(super) fn mean_irradiance(prepared: &Prepared, visibility: &Visibility, features: &Features) -> f64 {
    let area_m2: f64 = prepared.faces.keys().map(|face| polygon::area_m2(&prepared.polygon_m(face))).sum();
    let rays = (RAYS / features.lamps.len().max(1)).clamp(RAYS_OF_LAMP[0], RAYS_OF_LAMP[1]);
    let reach_m = REACH_OF_EXTENT * prepared.tolerance.extent_m;
    let meets = |from_m: DVec3, direction: DVec3| {
        matches!(visibility.first_met(from_m, from_m + reach_m * direction, None), FirstMet::Front(..))
    };
    let of_emitter = |emitter: &Emitter| std::f64::consts::PI * emitter.mean_radiance() * emitter.area_m2;
    let of_lamp = |lamp: &Lamp| {
        let (Some(from_m), Some(flux_w)) = (lamp.position_m(), lamp.flux_w()) else { return 0.0 };
        let (axis, least_cosine) = match lamp.kind {
            LampKind::Spot { direction, outer_rad, .. } => (direction, outer_rad.cos()),
            _ => (DVec3::Z, -1.0),
        };
        let (mut met, mut sent) = (0.0, 0.0);
        for i in 0..rays {
            let direction = in_cone(axis, least_cosine, i, rays);
            let intensity = lamp.intensity_towards(direction).element_sum();
            sent += intensity;
            met += if meets(from_m, direction) { intensity } else { 0.0 };
        }
        if sent > 0.0 { met / sent * flux_w.element_sum() / 3.0 } else { 0.0 }
    };
    let flux_w =
        features.emitters.iter().map(of_emitter).sum::<f64>() + features.lamps.iter().map(of_lamp).sum::<f64>();
    flux_w / area_m2.max(f64::MIN_POSITIVE)
}

/// One of so many even directions in a cone.
fn in_cone(axis: DVec3, least_cosine: f64, i: usize, count: usize) -> DVec3 {
    let share = (i as f64 + 0.5) / count as f64;
    around(axis, 1.0 - share * (1.0 - least_cosine), i)
}

fn around(axis: DVec3, cosine: f64, i: usize) -> DVec3 {
    let (u, v) = axis.any_orthonormal_pair();
    let (sin, cos) = (TAU * GOLDEN * i as f64).sin_cos();
    cosine * axis + (1.0 - cosine * cosine).max(0.0).sqrt() * (cos * u + sin * v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Rgb};
    use crate::visibility::fixture;
    use std::f64::consts::PI;

    /// Mean irradiance under a bulb of 4 pi W where these polygons are.
    fn mean(polygons: &[Vec<DVec3>]) -> f64 {
        let kind = LampKind::Point { position_m: DVec3::Z, intensity: Rgb::ONE, range_m: None };
        let mut scene = fixture::scene(vec![Material::diffuse("grey", Rgb::splat(0.5))]);
        scene.lamps.push(Lamp { name: String::new(), kind });
        let prepared = fixture::prepared(polygons);
        mean_irradiance(&prepared, &Visibility::new(&prepared), &Features::new(&scene, &prepared))
    }

    #[test]
    fn what_leaves_the_scene_is_not_in_the_mean() {
        // A floor of 2 x 2 m, 1 m below, gets a sixth of a bulb's light.
        let floor = mean(&[fixture::square(DVec3::ZERO, 1.0, true)]);
        assert!((floor / (4.0 * PI / 6.0 / 4.0) - 1.0).abs() < 0.05, "{floor}");
        let room = mean(&fixture::inward_box(DVec3::splat(-2.0), DVec3::splat(2.0)));
        assert!((room / (4.0 * PI / 96.0) - 1.0).abs() < 1e-9, "{room}");
    }
}
