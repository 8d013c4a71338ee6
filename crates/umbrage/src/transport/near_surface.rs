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
//!
//! Of the disc only the part counts that is there and that the lamp sees: in the edge of a room, or beside a box that stands there, half
//! of it, in a corner a quarter. The flux into that part is a closed form ([`super::lamp_flux`]); the integrals of `1` and `t^2` are
//! moments of it, sector by sector. It is found once for each lamp and plane.
//!
//! Holds: the visible part of the disc shows the flux that the lamp sends into it, whatever edges, walls and objects cut off.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use std::ops::ControlFlow;

use super::lamp_flux;
use crate::geometry::convex::Moments;
use crate::geometry::{PlaneFrame, clip};
use crate::id::{FaceId, PlaneId};
use crate::prepare::Prepared;
use crate::scene::{Lamp, Rgb};
use crate::visibility::{FlatSource, ReceiverPoint, Seen, Visibility};

/// The radius within which the light of a lamp nearer to a surface than that is spread, as a share of the scene's extent: two
/// millimetres in a room of five metres. The least edges of refinement are a sixteenth of it: at half of it, where they are an eighth,
/// triangles showed 8 % too much of the flux of a bulb in a corner, now 2 %.
pub(super) const SPREAD_OF_EXTENT: f64 = 4e-4;
/// The disc is a polygon of so many sectors, in each of which light at the border is taken to be even: its area is short by 0.04 %, and
/// a spot whose cone ends within it is told to a hundredth.
const SECTORS: usize = 128;

/// Irradiance of an unoccluded point, in W/m2.
pub(super) fn unoccluded(lamp: &Lamp, at_m: DVec3, normal: DVec3) -> Rgb {
    lamp.arriving(at_m).map_or(Rgb::ZERO, |arriving| normal.dot(arriving.towards).max(0.0) * arriving.irradiance)
}

/// The disc of a plane over which the light of a lamp is spread.
#[derive(Clone, Debug)]
pub(super) struct SpreadDisc {
    plane: PlaneId,
    normal: DVec3,
    foot_m: DVec3,
    radius_m: f64,
    /// Irradiance at the foot, in W/m2.
    peak: Rgb,
}

impl SpreadDisc {
    /// Irradiance of an unoccluded point that lies in the disc, in W/m2; `None` beyond it.
    pub(super) fn irradiance(&self, lamp: &Lamp, receiver: &ReceiverPoint) -> Option<Rgb> {
        if receiver.plane != self.plane || receiver.normal.dot(self.normal) <= 0.0 {
            return None;
        }
        let away_m = receiver.position_m - self.foot_m;
        let t2 = away_m.length_squared() / (self.radius_m * self.radius_m);
        if t2 >= 1.0 {
            return None;
        }
        let direction = away_m.try_normalize().unwrap_or_else(|| self.normal.any_orthonormal_vector());
        let border = unoccluded(lamp, self.foot_m + self.radius_m * direction, receiver.normal);
        Some(t2 * border + (1.0 - t2) * self.peak)
    }

    /// The disc around the foot of a lamp. `seen` is what the lamp sees of the plane there, in a frame with its origin at the foot.
    fn new(lamp: &Lamp, plane: PlaneId, frame: &PlaneFrame, lamp_m: DVec3, radius_m: f64, seen: &[Seen]) -> Self {
        let normal = frame.plane.normal;
        let corner_m = |i: usize| radius_m * DVec2::from_angle(TAU * (i % SECTORS) as f64 / SECTORS as f64);
        // The flux, and of shapes the integrals: of `t^2 E(R)`, and of `1 - t^2`, in square metres.
        let (mut flux_w, mut border_w, mut peak_m2) = (Rgb::ZERO, Rgb::ZERO, 0.0);
        for sector in 0..SECTORS {
            let [from_m, to_m] = [corner_m(sector), corner_m(sector + 1)];
            let wedge_m = [DVec2::ZERO, from_m, to_m];
            let border = unoccluded(lamp, frame.to_3d(radius_m * (from_m + to_m).normalize()), normal);
            for seen in seen {
                let within = |corners_m: &[DVec2]| clip::intersection(corners_m, &wedge_m);
                let moments = seen.measure(|corners_m| Moments::of(&within(corners_m)));
                let t2_m2 = (moments.second_m4.x_axis.x + moments.second_m4.y_axis.y) / (radius_m * radius_m);
                border_w += t2_m2 * border;
                peak_m2 += moments.area_m2 - t2_m2;
                flux_w += seen.measure(|corners_m| lamp_flux::into_polygon(lamp, lamp_m, frame, &within(corners_m)));
            }
        }
        let peak = if peak_m2 > 0.0 { ((flux_w - border_w) / peak_m2).max(Rgb::ZERO) } else { Rgb::ZERO };
        Self { plane, normal, foot_m: frame.origin, radius_m, peak }
    }
}

/// The discs over which the light of a lamp is spread: one on each plane that it is nearer to than `radius_m`.
pub(super) fn discs(
    lamp: &Lamp,
    prepared: &Prepared,
    visibility: &Visibility,
    no_plane: PlaneId,
    radius_m: f64,
) -> Vec<SpreadDisc> {
    let Some(lamp_m) = lamp.position_m().filter(|_| lamp.emits()) else { return Vec::new() };
    // The disc lies in a ball around the lamp.
    let reach_m = std::f64::consts::SQRT_2 * radius_m;
    let mut near: Vec<FaceId> = Vec::new();
    let is_near = |min_m: DVec3, max_m: DVec3| lamp_m.distance_squared(lamp_m.clamp(min_m, max_m)) < reach_m * reach_m;
    visibility.walk(is_near, |face| {
        let height_m = prepared.oriented_plane(face).signed_distance_m(lamp_m);
        if height_m > 0.0 && height_m < radius_m {
            near.push(face);
        }
        ControlFlow::Continue(())
    });
    near.sort_unstable_by_key(|&face| (prepared.faces[face].plane, face));
    let of_plane = |faces: &[FaceId]| {
        let face = *faces.first()?;
        let frame = PlaneFrame::new(prepared.oriented_plane(face), lamp_m);
        let receiver = lamp_flux::looking_at(no_plane, lamp, &frame.plane)?;
        let seen: Vec<Seen> = faces
            .iter()
            .filter_map(|&face| {
                // What lies around the disc would make slacks, which are shares of what is looked at, larger than the disc.
                let around_m =
                    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| radius_m * DVec2::new(x, y));
                let corners_m: Vec<DVec2> = prepared.polygon_m(face).iter().map(|&p| frame.to_2d(p)).collect();
                let corners_m = clip::intersection(&corners_m, &around_m).into_iter().collect();
                let polygon = FlatSource { frame, corners_m, plane: prepared.faces[face].plane };
                let seen = visibility.seen(&receiver, visibility.view(&receiver, &polygon)?, &polygon, None);
                (!seen.is_nothing()).then_some(seen)
            })
            .collect();
        let plane = prepared.faces[face].plane;
        (!seen.is_empty()).then(|| SpreadDisc::new(lamp, plane, &frame, lamp_m, radius_m, &seen))
    };
    let is_same_side = |&one: &FaceId, &other: &FaceId| prepared.faces[one].plane == prepared.faces[other].plane;
    near.chunk_by(is_same_side).filter_map(of_plane).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::LampKind;
    use crate::visibility::fixture;

    /// A bulb of 1 W/sr.
    fn bulb(position_m: DVec3) -> Lamp {
        Lamp { name: String::new(), kind: LampKind::Point { position_m, intensity: Rgb::ONE, range_m: None } }
    }

    /// The discs, within 0.1 m, of a lamp in a scene.
    fn discs_of(lamp: &Lamp, prepared: &Prepared) -> Vec<SpreadDisc> {
        let no_plane = PlaneId::from(prepared.planes.len());
        discs(lamp, prepared, &Visibility::new(prepared), no_plane, 0.1)
    }

    /// Flux into the part of a plane within a metre of a lamp's foot that `is_there`, by rings.
    fn flux_by_rings(lamp: &Lamp, prepared: &Prepared, face: usize, is_there: impl Fn(DVec3) -> bool) -> f64 {
        let (rings, around) = (2000, 256);
        let discs = discs_of(lamp, prepared);
        let plane = prepared.oriented_plane(FaceId::from(face));
        let frame = PlaneFrame::new(plane, lamp.position_m().unwrap());
        let radius_m = |k: usize| (k as f64 / rings as f64).powi(2);
        let ring = |k: usize| {
            let (inner_m, outer_m) = (radius_m(k), radius_m(k + 1));
            let mean = (0..around).map(|i| {
                let direction = DVec2::from_angle(TAU * (i as f64 + 0.5) / around as f64);
                let position_m = frame.to_3d(0.5 * (inner_m + outer_m) * direction);
                if !is_there(position_m) {
                    return 0.0;
                }
                let receiver = ReceiverPoint::on_face(prepared, FaceId::from(face), position_m);
                let spread = discs.iter().find_map(|disc| disc.irradiance(lamp, &receiver));
                spread.unwrap_or_else(|| unoccluded(lamp, position_m, receiver.normal)).x
            });
            0.5 * TAU * (outer_m * outer_m - inner_m * inner_m) * mean.sum::<f64>() / around as f64
        };
        (0..rings).map(ring).sum()
    }

    #[test]
    fn spread_light_is_as_much_as_there_is() {
        let floor = fixture::prepared(&[fixture::square(DVec3::ZERO, 2.0, true)]);
        for height_m in [1e-5_f64, 1e-3, 0.05, 0.099, 0.101] {
            let found = flux_by_rings(&bulb(height_m * DVec3::Z), &floor, 0, |_| true);
            let truth = TAU * (1.0 - height_m / height_m.hypot(1.0));
            assert!((found / truth - 1.0).abs() < 1e-3, "{found} {truth} at {height_m}");
        }
        for direction in [DVec3::NEG_Z, DVec3::new(0.6, 0.0, -0.8)] {
            let (position_m, intensity, range_m) = (0.01 * DVec3::Z, Rgb::ONE, None);
            let kind = LampKind::Spot { position_m, direction, intensity, range_m, inner_rad: 0.2, outer_rad: 0.5 };
            let lamp = Lamp { name: String::new(), kind };
            let (found, truth) = (flux_by_rings(&lamp, &floor, 0, |_| true), lamp.flux_w().unwrap().x);
            assert!((found / truth - 1.0).abs() < 0.02, "{found} {truth}");
        }
    }

    #[test]
    fn in_edges_and_corners_it_is_what_falls_on_the_part_that_is_there() {
        let room = fixture::prepared(&fixture::inward_box(DVec3::ZERO, DVec3::splat(4.0)));
        for d in [1e-4_f64, 1e-3, 0.03] {
            // Half a metre square of each wall, in the corner: the lamp sees three of them, or two of a metre in an edge.
            for (lamp_m, near) in [(DVec3::new(d, 2.0, d), 2), (DVec3::splat(d), 3)] {
                let lamp = bulb(lamp_m);
                assert_eq!(discs_of(&lamp, &room).len(), near);
                for face in
                    (0..6).filter(|&face| room.oriented_plane(FaceId::from(face)).signed_distance_m(lamp_m) < 0.1)
                {
                    let is_in = |p: DVec3| p.min_element() > -1e-9 && p.distance(lamp_m) < 0.9;
                    let found = flux_by_rings(&lamp, &room, face, is_in);
                    // By thin rings of the true light, whose first is far finer than `d`.
                    let plane = room.oriented_plane(FaceId::from(face));
                    let frame = PlaneFrame::new(plane, lamp_m);
                    let radius_m = |k: usize| d * 1e-3 * (0.95_f64 / (d * 1e-3)).powf(k as f64 / 2000.0);
                    let ring = |k: usize| {
                        let r = radius_m(k).midpoint(radius_m(k + 1));
                        let point = |i: usize| frame.to_3d(r * DVec2::from_angle(TAU * (i as f64 + 0.5) / 512.0));
                        let lit = (0..512).map(point).filter(|&p| is_in(p));
                        let width_m = radius_m(k + 1) - radius_m(k);
                        TAU * r * width_m / 512.0 * lit.map(|p| unoccluded(&lamp, p, plane.normal).x).sum::<f64>()
                    };
                    let truth: f64 = (0..2000).map(ring).sum();
                    assert!((found / truth - 1.0).abs() < 0.01, "{found} {truth} at {d} on {face} of {near}");
                }
            }
        }
    }
}
