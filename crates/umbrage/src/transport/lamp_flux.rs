//! The flux that a lamp sends into a polygon: its intensity over the solid angle of the part that it sees.
//!
//! Next to a lamp irradiance grows without bound, and samples of a patch there tell nothing about its mean. But the flux of a lamp
//! that shines evenly is intensity times solid angle, a closed form (van Oosterom and Strackee, *The solid angle of a plane
//! triangle*, 1983), and the visible part of a patch is exact. Where intensity varies, over the soft part of a spot's cone or
//! towards the end of a range, triangles are quartered until it hardly does.

use glam::{DVec2, DVec3};

use crate::geometry::{Plane, PlaneFrame};
use crate::id::PlaneId;
use crate::scene::{Lamp, LampKind, Rgb};
use crate::visibility::{FlatSource, ReceiverPoint, Visibility};

/// A triangle seen under less than this angle from its middle, in radians, is lit evenly enough by a lamp whose light varies; and
/// under less than this share of the angle over which a spot grows dark.
const EVEN_RAD: f64 = 0.1;
const EVEN_OF_SOFT: f64 = 0.25;
/// Triangles are quartered so many times at most.
const MOST_QUARTERINGS: usize = 7;
/// A range takes less than a thousandth from what is nearer than this share of it.
const UNFADED_OF_RANGE: f64 = 0.17;

/// A lamp as a point that looks at a plane, which no face's plane is.
pub(super) fn looking_at(no_plane: PlaneId, lamp: &Lamp, plane: &Plane) -> Option<ReceiverPoint> {
    Some(ReceiverPoint::on_plane(lamp.position_m()?, -plane.normal, no_plane))
}

/// Solid angle of a triangle seen from the origin, in sr: positive where its corners run clockwise seen from there.
pub(super) fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (p, q, r) = (a.length(), b.length(), c.length());
    let triple = -a.dot(b.cross(c));
    2.0 * triple.atan2(p * q * r + a.dot(b) * r + b.dot(c) * p + c.dot(a) * q)
}

/// Flux that a lamp sends into the part of a polygon's front that it sees, in W. `receiver` is the lamp as a point that looks at the
/// polygon's plane (see [`looking_at`]).
pub(super) fn flux_w(visibility: &Visibility, lamp: &Lamp, receiver: &ReceiverPoint, polygon: &FlatSource) -> Rgb {
    let Some(view) = visibility.view(receiver, polygon) else { return Rgb::ZERO };
    let seen = visibility.seen(receiver, view, polygon, None);
    if seen.is_nothing() {
        return Rgb::ZERO;
    }
    let into = |corners_m: &[DVec2]| into_polygon(lamp, receiver.position_m, &polygon.frame, corners_m);
    seen.measure(into).max(Rgb::ZERO)
}

/// Flux that a lamp would send into a polygon of a plane if nothing stood between, in W.
pub(super) fn into_polygon(lamp: &Lamp, lamp_m: DVec3, frame: &PlaneFrame, corners_m: &[DVec2]) -> Rgb {
    let corners_m: Vec<DVec3> = corners_m.iter().map(|&p| frame.to_3d(p) - lamp_m).collect();
    let fan = corners_m.get(1..).unwrap_or_default().windows(2);
    fan.map(|pair| into_triangle(lamp, lamp_m, [corners_m[0], pair[0], pair[1]], 0)).sum()
}

/// Flux into a triangle whose corners are given from the lamp, in W.
fn into_triangle(lamp: &Lamp, position_m: DVec3, corners_m: [DVec3; 3], quarterings: usize) -> Rgb {
    let middle_m = (corners_m[0] + corners_m[1] + corners_m[2]) / 3.0;
    let axis = corners_m.iter().map(|c| c.normalize_or_zero()).sum::<DVec3>().normalize_or(DVec3::Z);
    let radius_rad = corners_m.iter().map(|c| axis.angle_between(*c)).fold(0.0, f64::max);
    let nearest_m = corners_m.iter().map(|c| c.length()).fold(0.0, f64::max);
    let is_faded = |range_m: Option<f64>| range_m.is_some_and(|range_m| nearest_m > UNFADED_OF_RANGE * range_m);
    let is_even = match lamp.kind {
        LampKind::Point { range_m, .. } => !is_faded(range_m) || radius_rad < EVEN_RAD,
        LampKind::Spot { direction, range_m, inner_rad, outer_rad, .. } => {
            let off_rad = direction.angle_between(axis);
            if off_rad - radius_rad > outer_rad {
                return Rgb::ZERO;
            }
            let soft_rad = (outer_rad - inner_rad).max(EVEN_OF_SOFT * outer_rad);
            (off_rad + radius_rad <= inner_rad || radius_rad < EVEN_OF_SOFT * soft_rad)
                && (!is_faded(range_m) || radius_rad < EVEN_RAD)
        }
        LampKind::Directional { .. } => true,
    };
    if is_even || quarterings == MOST_QUARTERINGS {
        // Along the ray to the middle of the corners' directions, as far as the middle is.
        let towards_m = middle_m.length() * axis;
        let intensity = lamp.arriving(position_m + towards_m).map_or(Rgb::ZERO, |arriving| arriving.irradiance);
        return solid_angle(corners_m) * towards_m.length_squared() * intensity;
    }
    let [a, b, c] = corners_m;
    // Halves of the angles, so that what is far is not cut more than what is near.
    let between = |p: DVec3, q: DVec3| p.lerp(q, p.length() / (p.length() + q.length()));
    let [ab, bc, ca] = [between(a, b), between(b, c), between(c, a)];
    let quarters = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
    quarters.into_iter().map(|quarter| into_triangle(lamp, position_m, quarter, quarterings + 1)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::FaceId;
    use crate::visibility::fixture::{self, square};
    use std::f64::consts::PI;

    fn flux(lamp: LampKind, polygons: &[Vec<DVec3>]) -> f64 {
        let prepared = fixture::prepared(polygons);
        let visibility = Visibility::new(&prepared);
        let lamp = Lamp { name: String::new(), kind: lamp };
        let polygon = FlatSource::of_face(&prepared, FaceId::from(0));
        let receiver = looking_at(PlaneId::from(9), &lamp, &Plane::through(DVec3::ZERO, DVec3::Z)).unwrap();
        flux_w(&visibility, &lamp, &receiver, &polygon).x
    }

    #[test]
    fn half_of_a_bulb_goes_into_the_floor_that_it_lies_on() {
        for height_m in [1e-5, 1e-3, 0.1] {
            let position_m = DVec3::new(0.3, -0.2, height_m);
            let kind = LampKind::Point { position_m, intensity: Rgb::ONE, range_m: None };
            let found = flux(kind, &[square(DVec3::ZERO, 1.0, true)]);
            assert!((found / (2.0 * PI) - 1.0).abs() < 1.1 * height_m, "{found} at {height_m}");
        }
    }

    #[test]
    fn a_square_over_a_cube_takes_a_sixth_less_what_a_plate_shades() {
        let kind = LampKind::Point { position_m: DVec3::Z, intensity: Rgb::ONE, range_m: None };
        let whole = flux(kind, &[square(DVec3::ZERO, 1.0, true)]);
        assert!((whole - 4.0 * PI / 6.0).abs() < 1e-12, "{whole}");
        // A plate half way, half as large as the floor is seen there, shades what it is seen as.
        let shaded = flux(kind, &[square(DVec3::ZERO, 1.0, true), square(0.5 * DVec3::Z, 0.25, true)]);
        let plate = 4.0 * (0.25_f64.powi(2) / (0.5 * (0.25_f64 + 2.0 * 0.0625).sqrt())).atan();
        assert!((shaded - (whole - plate)).abs() < 1e-9, "{shaded} {}", whole - plate);
    }

    #[test]
    fn a_spot_sends_all_that_it_gives_into_the_floor_under_it() {
        for (inner_rad, outer_rad) in [(0.0, 0.1), (0.2, 0.4), (0.3, 0.301)] {
            let direction = DVec3::new(0.2, 0.1, -1.0).normalize();
            let (position_m, range_m, intensity) = (DVec3::new(0.1, 0.2, 1.0), None, Rgb::ONE);
            let kind = LampKind::Spot { position_m, direction, intensity, range_m, inner_rad, outer_rad };
            let (found, sent) =
                (flux(kind, &[square(DVec3::ZERO, 2.0, true)]), Lamp { name: String::new(), kind }.flux_w().unwrap().x);
            assert!((found / sent - 1.0).abs() < 0.02, "{found} {sent} for {inner_rad} {outer_rad}");
        }
    }
}
