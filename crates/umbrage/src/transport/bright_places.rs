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
use super::ray_lattice::cosine_direction;
use crate::geometry::polygon;
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
                FirstMet::Back(_) => fate.on_backs_w += ray_w,
                FirstMet::Front(face, point_m) => {
                    let normal = prepared.normal(face);
                    let irradiance = unoccluded(lamp, point_m, normal);
                    let squared_m2 =
                        if lamp.position_m().is_some() { point_m.distance_squared(ray.from_m) } else { 1.0 };
                    // Grazing rays cover no end of a plane, and bring it nothing.
                    let area_m2 = ray.share * squared_m2 / -normal.dot(ray.direction);
                    let arriving_w = if area_m2.is_finite() { (area_m2 * irradiance).min(ray_w) } else { Rgb::ZERO };
                    fate.on_fronts_w += arriving_w;
                    fate.fading_w += ray_w - arriving_w;
                    if arriving_w.max_element() > 0.0 {
                        // What is shown there may be spread.
                        let receiver = ReceiverPoint::on_face(prepared, face, point_m);
                        let irradiance = lamps.unoccluded(id, &receiver);
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
        let (low_m, high_m) =
            (corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max));
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
        polygon::signed_area_2d_m2(&polygon.corners_m) * exitance.element_sum()
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
                let from_m = polygon::point_of(&outline.corners_m, s, t);
                let direction = cosine_direction(
                    outline.oriented_plane.normal,
                    (i as f64 + 0.5) / count as f64,
                    (GOLDEN * i as f64).fract(),
                );
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Scene};
    use crate::transport::DirectLight;
    use crate::visibility::fixture::{self, square};

    /// What is sent over a floor of 4 x 4 m that looks up, with a plate of 1 x 1 m at 1 m over its middle that looks up.
    fn sent(kinds: &[LampKind]) -> LightSent {
        let prepared = fixture::prepared(&[square(DVec3::ZERO, 2.0, true), square(DVec3::Z, 0.5, true)]);
        let visibility = Visibility::new(&prepared);
        let mut scene = Scene::default();
        for &kind in kinds {
            scene.lamps.push(Lamp { name: String::new(), kind });
        }
        scene.materials.push(Material::diffuse("grey", Rgb::ONE));
        DirectLight::new(&scene, &prepared, &visibility).light_sent()
    }

    #[test]
    fn rays_carry_the_flux_of_a_lamp_to_where_it_falls() {
        let intensity = Rgb::new(1.0, 2.0, 4.0);
        let point = |z: f64| LampKind::Point { position_m: z * DVec3::Z, intensity, range_m: None };
        let fates = sent(&[point(2.0), point(0.5)]).lamps;
        // The floor is a side of a cube of 4 m; what the plate takes of it would fall there, too.
        for (id, fate) in fates.iter_enumerated() {
            assert!((fate.sent_w / (4.0 * PI * intensity) - 1.0).abs().max_element() < 1e-9);
            let sum = fate.on_fronts_w + fate.on_backs_w + fate.leaving_w + fate.fading_w;
            assert!((sum / fate.sent_w - 1.0).abs().max_element() < 1e-9, "{id:?} {fate:?}");
        }
        assert!((fates[LampId::from(0)].on_fronts_w.x / (4.0 * PI / 6.0) - 1.0).abs() < 0.01);
        // From below, the back of the plate is seen as one side of a cube.
        assert!((fates[LampId::from(1)].on_backs_w.x / (4.0 * PI / 6.0) - 1.0).abs() < 0.01);
    }

    #[test]
    fn places_stand_for_the_lit_area() {
        let direction = DVec3::new(0.1, 0.0, -1.0).normalize();
        let (position_m, intensity, range_m) = (DVec3::new(-1.0, 1.0, 2.0), Rgb::ONE, None);
        let outer_rad = 0.1;
        let kind = LampKind::Spot { position_m, direction, intensity, range_m, inner_rad: 0.0, outer_rad };
        let sun = LampKind::Directional { direction, irradiance: Rgb::ONE };
        let places = sent(&[kind, sun]).places;
        let area_m2 = |lamp: usize| {
            let of = places.iter().filter(|place| place.lamp == Some(LampId::from(lamp)) && place.irradiance.x > 0.0);
            of.map(|place| place.area_m2).sum::<f64>()
        };
        // The section of a cone with a plane 2 m below its apex, to whose normal its axis is tilted.
        let (sine, cosine) = (outer_rad.sin(), outer_rad.cos());
        let ellipse = PI * 4.0 * sine * sine * cosine / (direction.z * direction.z - sine * sine).powf(1.5);
        assert!((area_m2(0) / ellipse - 1.0).abs() < 0.02, "{} {ellipse}", area_m2(0));
        // The sun lights floor and plate, less the shadow of the plate.
        assert!((area_m2(1) / 16.0 - 1.0).abs() < 0.02, "{}", area_m2(1));
    }

    #[test]
    fn a_range_takes_what_fades() {
        let kind = LampKind::Point { position_m: 2.0 * DVec3::Z, intensity: Rgb::ONE, range_m: Some(1.0) };
        let sent = sent(&[kind]);
        let fate = sent.lamps[LampId::from(0)];
        // The plate is at the end of the range, the floor beyond.
        assert!(fate.on_fronts_w.x < 1e-9 && sent.places.iter().all(|place| place.irradiance.x < 1e-9));
        assert!((fate.fading_w.x + fate.leaving_w.x) / fate.sent_w.x > 1.0 - 1e-9);
    }
}
