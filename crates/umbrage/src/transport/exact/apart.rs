//! The form factor between two polygons that are far apart: the double area integral of `cos cos / (pi r^2)`, by Gauss's
//! rules on both.
//!
//! All terms have one sign, so that no digits are lost however small the factor is, while the contour form cancels. With
//! distances of [`FAR`] times both radii and more, the integrand is smooth: each point more a side gains a factor of 200.

use std::f64::consts::PI;

use glam::DVec3;

use super::edge_pair::Part;
use super::quadrature::TriangleRule;
use crate::geometry::{Plane, polygon};

/// Polygons whose middles are this many times the sum of their radii apart are far.
pub(super) const FAR: f64 = 7.0;
/// Points each way in a triangle: one more gains two digits, so that the change bounds the error.
const POINTS: [usize; 2] = [5, 6];

/// Whether two polygons are far apart.
pub(super) fn are_far(receiver: &[DVec3], source: &[DVec3]) -> bool {
    let middle = |corners: &[DVec3]| corners.iter().sum::<DVec3>() / corners.len() as f64;
    let middles = [middle(receiver), middle(source)];
    let radius = |corners: &[DVec3], middle: DVec3| corners.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
    middles[0].distance(middles[1]) > FAR * (radius(receiver, middles[0]) + radius(source, middles[1]))
}

/// The factor from `receiver` times its area, in square metres.
pub(super) fn exchange_area_m2(receiver: &[DVec3], source: &[DVec3]) -> Part {
    let normal = |corners: &[DVec3]| polygon::doubled_area_vector(corners).normalize_or_zero();
    let planes = [receiver, source].map(|corners| Plane::through(corners[0], normal(corners)));
    let [coarse, fine] = POINTS.map(|n| {
        let rule = TriangleRule::new(n);
        let source_points = rule.over(source);
        let from_point = |&(p, area): &(DVec3, f64)| {
            let kernel = |&(q, weight): &(DVec3, f64)| {
                let between = q - p;
                let squared = between.length_squared();
                weight * planes[0].normal.dot(between) * -planes[1].normal.dot(between) / (PI * squared * squared)
            };
            area * source_points.iter().map(kernel).sum::<f64>()
        };
        rule.over(receiver).iter().map(from_point).sum::<f64>()
    });
    Part { value: fine, error: (fine - coarse).abs() + ROUNDING * fine.abs() }
}

/// Rounding of a long sum of terms of one sign, of its value.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
