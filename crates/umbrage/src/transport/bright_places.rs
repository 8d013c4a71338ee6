//! Where light falls first, known from the side of its sources.
//!
//! A spot's circle, the pool around a bulb next to a wall, the patch of light behind a hole: on a large face all of them fall between
//! the points at which light is sampled. From its source they cannot be missed. Rays are sent in directions that are even over all
//! that a source shines into; each carries an equal share of it to the first face that it meets, and stands there for the area that
//! its share of the solid angle covers. So a sum over rays is an integral over the lit area, with as many samples where it is bright
//! and small as where it is wide. Meshes are refined where they show less light than a ray brings.
//!
//! The same rays tell how much of a lamp's light falls on fronts, on backs, beyond the scene, or fades before.
//!
//! Directions are those of a spherical Fibonacci lattice (Gonzalez, *Measurement of areas on a sphere using Fibonacci and
//! latitude-longitude lattices*, 2010), the same every time.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rayon::prelude::*;

use super::form_factor::factor_of_seen;
use super::lamps::Lamps;
use super::near_surface::unoccluded;
use crate::id::{FaceId, LampId, Table};
use crate::prepare::Prepared;
use crate::scene::{Lamp, LampKind, Rgb};
use crate::visibility::{FirstMet, FlatSource, ReceiverPoint, SourcePolygon, Visibility};

/// Rays of one lamp at most and at least, and of all lamps together, unless they are very many.
const MOST_OF_LAMP: usize = 4096;
const LEAST_OF_LAMP: usize = 256;
const OF_ALL_LAMPS: usize = 1 << 15;
/// Rays of all emitting faces together; where there are more faces than that, none is small and bright by itself.
const OF_ALL_EMITTERS: usize = 1024;
const LEAST_OF_EMITTER: usize = 8;
/// The golden angle, in radians, and the conjugate of the golden ratio.
const GOLDEN_RAD: f64 = 2.399_963_229_728_653;
const GOLDEN: f64 = 0.618_033_988_749_895;
/// The square of that of the plastic ratio and its own, for points of a polygon.
const PLASTIC: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];

/// A place that a source lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrightPlace {
    /// The face whose front it lies on.
    pub face: FaceId,
    /// Where it is, in metres.
    pub point_m: DVec3,
    /// The area that it stands for, in square metres.
    pub area_m2: f64,
    /// What the source alone brings there, in W/m2.
    pub irradiance: Rgb,
    /// The lamp; `None` for an emitting face.
    pub lamp: Option<LampId>,
}

/// What becomes of the light of a lamp before it is reflected, in W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LampFate {
    /// What it sends; a distant lamp, what would fall on the scene.
    pub sent_w: Rgb,
    /// What falls on the fronts of surfaces.
    pub on_fronts_w: Rgb,
    /// What falls on their backs.
    pub on_backs_w: Rgb,
    /// What leaves the scene.
    pub leaving_w: Rgb,
    /// What ends before it falls on anything: a lamp with a range fades.
    pub fading_w: Rgb,
}

/// The light of all sources, followed to where it falls first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightSent {
    /// The places where rays end.
    pub places: Vec<BrightPlace>,
    /// What becomes of the light of each lamp.
    pub lamps: Table<LampId, LampFate>,
}

/// A ray, and the light that it carries.
struct Ray {
    from_m: DVec3,
    direction: DVec3,
    /// Its share of the solid angle, in sr; of a distant lamp's beam, in square metres.
    share: f64,
    /// Radiant intensity in W/sr before it fades, or irradiance of a surface that faces a distant lamp, in W/m2.
    intensity: Rgb,
}

/// Follows the light of lamps.
pub(super) fn of_lamps(lamps: &Lamps, prepared: &Prepared, visibility: &Visibility) -> LightSent {
    let shining = lamps.iter().filter(|(_, lamp)| lamp.emits()).count().max(1);
    let count = (OF_ALL_LAMPS / shining).clamp(LEAST_OF_LAMP, MOST_OF_LAMP);
    let mut sent = LightSent::default();
    for (id, lamp) in lamps.iter() {
        let mut fate = LampFate::default();
        let rays = if lamp.emits() { rays(lamp, prepared, lamps.outside_m(), count) } else { Vec::new() };
        let met: Vec<FirstMet> = rays
            .par_iter()
            .map(|ray| visibility.first_met(ray.from_m, ray.from_m + 2.0 * lamps.outside_m() * ray.direction, None))
            .collect();
        for (ray, met) in rays.iter().zip(met) {
            let ray_w = ray.share * ray.intensity;
            fate.sent_w += ray_w;
            match met {
                FirstMet::Nothing if lamp.position_m().is_none() => fate.sent_w -= ray_w,
                FirstMet::Nothing => fate.leaving_w += ray_w,
                FirstMet::Back => fate.on_backs_w += ray_w,
                FirstMet::Front(face, point_m) => {
                    let normal = prepared.normal(face);
                    let irradiance = unoccluded(lamp, point_m, normal);
                    let squared_m2 = if lamp.position_m().is_some() { point_m.distance_squared(ray.from_m) } else { 1.0 };
                    // Grazing rays cover no end of a plane, and bring it nothing.
                    let area_m2 = ray.share * squared_m2 / -normal.dot(ray.direction);
                    let arriving_w = if area_m2.is_finite() { (area_m2 * irradiance).min(ray_w) } else { Rgb::ZERO };
                    fate.on_fronts_w += arriving_w;
                    fate.fading_w += ray_w - arriving_w;
                    if arriving_w.max_element() > 0.0 {
                        sent.places.push(BrightPlace { face, point_m, area_m2, irradiance, lamp: Some(id) });
                    }
                }
            }
        }
        sent.lamps.push(fate);
    }
    sent
}

/// Rays that are even over all that a lamp shines into.
fn rays(lamp: &Lamp, prepared: &Prepared, outside_m: f64, count: usize) -> Vec<Ray> {
    let (axis, outer_rad) = match lamp.kind {
        LampKind::Point { .. } => (DVec3::Z, PI),
        LampKind::Spot { direction, outer_rad, .. } => (direction, outer_rad),
        LampKind::Directional { direction, .. } => (direction, 0.0),
    };
    let (u, v) = axis.any_orthonormal_pair();
    let around = |i: usize| {
        let (sin, cos) = (GOLDEN_RAD * i as f64).sin_cos();
        cos * u + sin * v
    };
    let even = |i: usize| (i as f64 + 0.5) / count as f64;
    let Some(from_m) = lamp.position_m() else {
        let corners = || prepared.vertices_m.iter().copied();
        let (low_m, high_m) = (corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max));
        let radius_m = 0.5 * (high_m - low_m).length();
        let ray = |i: usize| Ray {
            from_m: low_m.midpoint(high_m) - outside_m * axis + radius_m * even(i).sqrt() * around(i),
            direction: axis,
            share: PI * radius_m * radius_m / count as f64,
            intensity: lamp.brightness(),
        };
        return (0..count).map(ray).collect();
    };
    // The cosine of an outer cone of a tenth of a degree has few digits left: its difference from 1 is twice a squared sine.
    let height = 2.0 * (0.5 * outer_rad).sin().powi(2);
    let ray = |i: usize| {
        let below = height * even(i);
        let direction = (1.0 - below) * axis + (below * (2.0 - below)).max(0.0).sqrt() * around(i);
        Ray { from_m, direction, share: TAU * height / count as f64, intensity: lamp.intensity_towards(direction) }
    };
    (0..count).map(ray).collect()
}

/// Follows the light of emitting faces: their outlines, as sources, with their exitance.
pub(super) fn of_emitters(
    emitters: &[(&SourcePolygon, &FlatSource, Rgb)],
    prepared: &Prepared,
    visibility: &Visibility,
) -> Vec<BrightPlace> {
    if emitters.len() > OF_ALL_EMITTERS / LEAST_OF_EMITTER {
        return Vec::new();
    }
    let power_w = |&(_, polygon, exitance): &(&SourcePolygon, &FlatSource, Rgb)| {
        crate::geometry::polygon::signed_area_2d_m2(&polygon.corners_m) * exitance.element_sum()
    };
    let all_w: f64 = emitters.iter().map(power_w).sum();
    let of_one = |emitter: &(&SourcePolygon, &FlatSource, Rgb)| {
        let (outline, polygon, exitance) = *emitter;
        let share = if all_w > 0.0 { power_w(emitter) / all_w } else { 0.0 };
        let count = ((OF_ALL_EMITTERS as f64 * share) as usize).max(LEAST_OF_EMITTER);
        let ray_w = power_w(emitter) / count as f64;
        let outside_m = 2.0 * prepared.tolerance.extent_m;
        (0..count)
            .filter_map(move |i| {
                let [s, t] = PLASTIC.map(|step| (step * (i as f64 + 0.5)).fract());
                let from_m = point_of(&outline.corners_m, s, t);
                let direction = cosine_direction(outline.oriented_plane.normal, (i as f64 + 0.5) / count as f64, GOLDEN * i as f64);
                let met = visibility.first_met(from_m, from_m + outside_m * direction, Some(outline.plane));
                let FirstMet::Front(face, point_m) = met else { return None };
                let receiver = ReceiverPoint::on_face(prepared, face, point_m);
                let irradiance = factor_of_seen(visibility, &receiver, polygon, None) * exitance;
                let area_m2 = ray_w / irradiance.element_sum();
                area_m2.is_finite().then_some(BrightPlace { face, point_m, area_m2, irradiance, lamp: None })
            })
            .collect::<Vec<_>>()
    };
    emitters.par_iter().map(of_one).collect::<Vec<_>>().concat()
}

/// A point of a convex polygon, evenly by area for `s` and `t` that are even.
fn point_of(corners_m: &[DVec3], s: f64, t: f64) -> DVec3 {
    let spokes: Vec<DVec3> = corners_m[1..].iter().map(|corner| corner - corners_m[0]).collect();
    let areas: Vec<f64> = spokes.windows(2).map(|pair| pair[0].cross(pair[1]).length()).collect();
    let mut left = s * areas.iter().sum::<f64>();
    let mut triangle = 0;
    while triangle + 1 < areas.len() && left > areas[triangle] {
        left -= areas[triangle];
        triangle += 1;
    }
    let share = if areas[triangle] > 0.0 { (left / areas[triangle]).min(1.0) } else { 0.5 };
    corners_m[0] + share.sqrt() * spokes[triangle].lerp(spokes[triangle + 1], t)
}

/// A direction of the hemisphere over a plane, in proportion to its cosine; `turns` around the normal.
fn cosine_direction(normal: DVec3, u: f64, turns: f64) -> DVec3 {
    let (across, along) = normal.any_orthonormal_pair();
    let (sine, cosine) = (TAU * turns).sin_cos();
    (u.sqrt() * (cosine * across + sine * along) + (1.0 - u).sqrt() * normal).normalize()
}
