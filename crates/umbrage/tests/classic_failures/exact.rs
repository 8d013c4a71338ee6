//! Irradiance past one convex occluder, exactly, without any of the program's geometry.
//!
//! Of a source a point sees what is not in the cone from the point over the occluder, which is bounded by the planes
//! through the point and the edges of the occluder's outline. Both the source and the part of it in the cone are plane
//! and convex, and Lambert's formula gives what comes from each.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::common::{Lit, irradiance_at};

/// Planes through a point and an edge in line with it have no normal; less than this, in m2, is none.
const IN_LINE_M2: f64 = 1e-15;

/// A triangle further from a place is not its own.
const ON_PLANE_M: f64 = 1e-5;

/// A place on a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
}

/// The half of a convex polygon on the side of a plane through `point` that `inward` shows.
fn clipped(polygon: &[DVec3], point: DVec3, inward: DVec3) -> Vec<DVec3> {
    let height = |p: DVec3| (p - point).dot(inward);
    let mut kept = Vec::new();
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        if height(p) >= 0.0 {
            kept.push(p);
        }
        if (height(p) > 0.0) != (height(q) > 0.0) && height(p) != 0.0 && height(q) != 0.0 {
            kept.push(p.lerp(q, height(p) / (height(p) - height(q))));
        }
    }
    kept
}

/// The share of its light that a place gets from a polygon of exitance 1, above its horizon (Lambert's formula).
fn form_factor(place: Place, polygon: &[DVec3]) -> f64 {
    let above = clipped(polygon, place.point, place.normal);
    let rays: Vec<DVec3> = above.iter().map(|p| p - place.point).collect();
    let sides = rays.iter().zip(rays.iter().cycle().skip(1)).map(|(p, q)| {
        let across = p.cross(*q);
        across.length().atan2(p.dot(*q)) * place.normal.dot(across.normalize_or_zero())
    });
    sides.sum::<f64>().abs() / TAU
}

/// The part of a polygon that lies in the cone from a point over a closed convex occluder, which may be nothing.
fn covered(point: DVec3, polygon: &[DVec3], occluder: &[Vec<DVec3>]) -> Vec<DVec3> {
    let corners = || occluder.iter().flatten();
    if occluder.is_empty() {
        return Vec::new();
    }
    let middle = corners().sum::<DVec3>() / corners().count() as f64;
    let faces_point = |face: &[DVec3]| (face[1] - face[0]).cross(face[2] - face[0]).dot(point - face[0]) > 0.0;
    let edges = |face: &[DVec3]| (0..face.len()).map(|i| [face[i], face[(i + 1) % face.len()]]).collect::<Vec<_>>();
    let away: Vec<[DVec3; 2]> =
        occluder.iter().filter(|face| !faces_point(face)).flat_map(|face| edges(face)).collect();
    let mut part = polygon.to_vec();
    for [p, q] in occluder.iter().filter(|face| faces_point(face)).flat_map(|face| edges(face)) {
        let plane = (p - point).cross(q - point);
        if away.contains(&[q, p]) && plane.length() > IN_LINE_M2 {
            part = clipped(&part, point, plane * plane.dot(middle - point).signum());
        }
    }
    part
}

/// Root mean square difference between what triangles show at places and what is true, over the colours.
pub(crate) fn rms(triangles: &[Lit], places: &[Place], truth: impl Fn(Place) -> f64) -> f64 {
    let squared = |&place: &Place| (shown(triangles, place).unwrap() - truth(place)).length_squared() / 3.0;
    (places.iter().map(squared).sum::<f64>() / places.len() as f64).sqrt()
}

/// What triangles show at a place; `None` where there are none.
pub(crate) fn shown(triangles: &[Lit], place: Place) -> Option<DVec3> {
    irradiance_at(triangles, place.point, place.normal, ON_PLANE_M)
}

/// Irradiance at a place by a one-sided source of even exitance past an occluder, which stands between the two or
/// beside.
pub(crate) fn irradiance(place: Place, source: &[DVec3], exitance: f64, occluder: &[Vec<DVec3>]) -> f64 {
    let front = (source[1] - source[0]).cross(source[2] - source[0]);
    if front.dot(place.point - source[0]) <= 0.0 {
        return 0.0;
    }
    let visible = form_factor(place, source) - form_factor(place, &covered(place.point, source, occluder));
    exitance * visible.max(0.0)
}

#[test]
fn a_square_above_a_point_and_what_a_box_leaves_of_it_are_closed_forms() {
    use crate::common::build::{box_faces, quad};
    // Under the middle of a unit square at distance 1, and under its corner; known numbers.
    let place = Place { point: DVec3::ZERO, normal: DVec3::Z };
    let source = |x: f64, y: f64| quad(DVec3::new(x, y, 1.0), 0.5 * DVec3::X, -0.5 * DVec3::Y);
    assert!((irradiance(place, &source(0.0, 0.0), 1.0, &[]) - 0.239_456_470_5).abs() < 1e-9);
    assert!((irradiance(place, &source(0.5, 0.5), 1.0, &[]) - 0.138_531_606_0).abs() < 1e-9);
    // A box beside the axis hides the half of it: what is left of the square is two quarters, each above its corner.
    let half = box_faces(DVec3::new(0.0, -9.0, 0.5), DVec3::new(9.0, 9.0, 0.6));
    assert!((irradiance(place, &source(0.0, 0.0), 1.0, &half) - 0.5 * 0.239_456_470_5).abs() < 1e-9);
    // One that hides all, and the back of the source.
    let all = box_faces(DVec3::new(-9.0, -9.0, 0.5), DVec3::new(9.0, 9.0, 0.6));
    assert!(irradiance(place, &source(0.0, 0.0), 1.0, &all) < 1e-12);
    let above = Place { point: DVec3::new(0.0, 0.0, 2.0), normal: -DVec3::Z };
    assert_eq!(irradiance(above, &source(0.0, 0.0), 1.0, &[]), 0.0);
}
