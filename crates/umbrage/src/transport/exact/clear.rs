//! The form factor between two polygons in clear sight of one another, to rounding.
//!
//! Each polygon is clipped to the front of the other's plane: points behind it exchange nothing. What is left is taken by
//! Stokes' theorem twice (Sparrow, *A new and simpler formulation for radiative angle factors*, 1963),
//!
//! ```text
//! A1 F12 = 1 / (2 pi) * sum over edge pairs of  (d1 . d2) * double integral of ln r ds dt
//! ```
//!
//! which stays regular where polygons touch; far apart, where its terms cancel, by the double area integral.
//!
//! Source of the reference values: Howell, *A Catalog of Radiation Heat Transfer Configuration Factors*.

use std::f64::consts::PI;

use glam::DVec3;

use super::edge_pair::{Part, edge_pair, edges};
use super::{Exchange, apart};
use crate::geometry::{Plane, clip, polygon};

/// The form factor from `receiver_m` to `source_m`, with nothing between them. Both are convex and plane, and their corners
/// run counter-clockwise seen from the front, in metres; they may touch on an edge or in a corner, and may lie partly
/// behind one another's planes. Polygons without area exchange nothing.
///
/// The error bound is near 1e-13 for polygons of like size; it grows as the receiver gets smaller than the distance to a
/// large source, by rounding.
///
/// ```
/// use glam::DVec3;
/// use umbrage::transport::exact::polygon_to_polygon;
///
/// let floor = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
/// let wall = [DVec3::ZERO, DVec3::Y, DVec3::Y + DVec3::Z, DVec3::Z];
/// let exchange = polygon_to_polygon(&floor, &wall);
/// assert!((exchange.factor - 0.2000437761).abs() < 1e-10 && exchange.error_bound < 1e-12);
/// ```
pub fn polygon_to_polygon(receiver_m: &[DVec3], source_m: &[DVec3]) -> Exchange {
    let area_m2 = polygon::area_m2(receiver_m);
    let Part { value, error } = exchange_area_m2(receiver_m, source_m);
    if area_m2 > 0.0 { Exchange { factor: value / area_m2, error_bound: error / area_m2 } } else { Exchange::default() }
}

/// Rounding of a height over a plane, as a share of the coordinates.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Form factor times area, the same both ways, in square metres.
pub(super) fn exchange_area_m2(receiver_m: &[DVec3], source_m: &[DVec3]) -> Part {
    let (Some(receiver_plane), Some(source_plane)) = (Plane::of_polygon(receiver_m), Plane::of_polygon(source_m))
    else {
        return Part::default();
    };
    // A corner on a common edge is not cut off by rounding.
    let reach = receiver_m.iter().chain(source_m).map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let snap_m = ROUNDING * reach;
    let receiver = clip::in_front_of(receiver_m, &source_plane, snap_m);
    let source = clip::in_front_of(source_m, &receiver_plane, snap_m);
    let rises = |corners: &[DVec3], plane: &Plane| corners.iter().any(|&p| plane.signed_distance_m(p) > 0.0);
    if !rises(&receiver, &source_plane) || !rises(&source, &receiver_plane) {
        return Part::default();
    }
    if apart::are_far(&receiver, &source) {
        return apart::exchange_area_m2(&receiver, &source);
    }
    // Coordinates of the order of 1, about a middle, so that logarithms and their rounding are of that order too.
    let all = || receiver.iter().chain(&source).copied();
    let (low, high) = (all().fold(DVec3::INFINITY, DVec3::min), all().fold(DVec3::NEG_INFINITY, DVec3::max));
    let (middle, size) = (0.5 * (low + high), (high - low).length());
    let [receiver_edges, source_edges] =
        [&receiver, &source].map(|corners| edges(&corners.iter().map(|&p| (p - middle) / size).collect::<Vec<_>>()));
    let mut sum = Part::default();
    for receiver_edge in &receiver_edges {
        for source_edge in &source_edges {
            let part = edge_pair(receiver_edge, source_edge);
            sum.value += part.value;
            sum.error += part.error;
        }
    }
    let scale = size * size / (2.0 * PI);
    Part { value: (scale * sum.value).max(0.0), error: scale * sum.error }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;
    use proptest::prelude::*;

    fn rectangle(origin: DVec3, u: DVec3, v: DVec3) -> Vec<DVec3> {
        vec![origin, origin + u, origin + u + v, origin + v]
    }

    fn unit_square_at(z: f64) -> Vec<DVec3> {
        rectangle(DVec3::Z * z, DVec3::X, DVec3::Y)
    }

    fn reversed(corners: &[DVec3]) -> Vec<DVec3> {
        corners.iter().rev().copied().collect()
    }

    /// Identical, parallel, directly opposed rectangles with sides `x`, `y` at distance 1 (Howell, C-11).
    fn opposed(x: f64, y: f64) -> f64 {
        let (x2, y2) = (1.0 + x * x, 1.0 + y * y);
        let logarithm = (x2 * y2 / (1.0 + x * x + y * y)).ln() / 2.0;
        let arcs = x * y2.sqrt() * (x / y2.sqrt()).atan() + y * x2.sqrt() * (y / x2.sqrt()).atan();
        2.0 / (PI * x * y) * (logarithm + arcs - x * x.atan() - y * y.atan())
    }

    /// Rectangles at a right angle with a common edge of length 1; receiver `w` deep, source `h` high (Howell, C-14).
    fn at_right_angle(h: f64, w: f64) -> f64 {
        let (h2, w2, s) = (h * h, w * w, h * h + w * w);
        let power = |base: f64, exponent: f64| exponent * base.ln();
        let logarithm = power((1.0 + w2) * (1.0 + h2) / (1.0 + s), 1.0)
            + power(w2 * (1.0 + s) / ((1.0 + w2) * s), w2)
            + power(h2 * (1.0 + s) / ((1.0 + h2) * s), h2);
        let arcs = w * (1.0 / w).atan() + h * (1.0 / h).atan() - s.sqrt() * (1.0 / s.sqrt()).atan();
        (arcs + 0.25 * logarithm) / (PI * w)
    }

    fn assert_exchange(exchange: Exchange, truth: f64, tolerance: f64) {
        assert!((exchange.factor - truth).abs() <= tolerance, "{exchange:?} is not {truth}");
        assert!((exchange.factor - truth).abs() <= exchange.error_bound + 1e-15, "{exchange:?} bounds no {truth}");
        assert!(exchange.error_bound <= tolerance, "{exchange:?}");
    }

    #[test]
    fn the_closed_forms_are_howells() {
        for (value, printed) in [
            (opposed(1.0, 1.0), 0.1998248957),
            (opposed(10.0, 10.0), 0.8269945224),
            (opposed(0.5, 0.5), 0.0685895888),
            (at_right_angle(1.0, 1.0), 0.2000437761),
            (at_right_angle(2.0, 1.0), 0.2328526028),
        ] {
            assert!((value - printed).abs() < 5.1e-11, "{value} {printed}");
        }
    }

    #[test]
    fn parallel_squares_near_and_far() {
        for (distance, tolerance) in
            [(1e-4, 1e-9), (1e-2, 1e-11), (0.1, 1e-11), (1.0, 1e-12), (2.0, 1e-12), (5.0, 1e-12), (9.8, 1e-12)]
        {
            let above = reversed(&unit_square_at(distance));
            let side = 1.0 / distance;
            assert_exchange(polygon_to_polygon(&unit_square_at(0.0), &above), opposed(side, side), tolerance);
        }
    }

    #[test]
    fn squares_with_a_common_edge() {
        for height in [1e-3, 0.1, 1.0, 2.0, 30.0] {
            let wall = rectangle(DVec3::ZERO, DVec3::Y, DVec3::Z * height);
            assert_exchange(polygon_to_polygon(&unit_square_at(0.0), &wall), at_right_angle(height, 1.0), 1e-11);
        }
    }

    #[test]
    fn far_apart_no_digits_are_lost() {
        // Two terms of the series in 1 / distance, for unit squares: 1 / (pi d^2) (1 - 2 / (3 d^2)).
        for distance in [30.0_f64, 100.0, 1e4, 1e6] {
            let above = reversed(&unit_square_at(distance));
            let exchange = polygon_to_polygon(&unit_square_at(0.0), &above);
            let series = (1.0 - 2.0 / (3.0 * distance.powi(2))) / (PI * distance.powi(2));
            assert!((exchange.factor / series - 1.0).abs() < 1.0 / distance.powi(4) + 1e-13, "{exchange:?} {series}");
            assert!(exchange.error_bound < 1e-9 * exchange.factor, "{exchange:?}");
        }
    }

    #[test]
    fn both_forms_agree_where_one_hands_over_to_the_other() {
        for distance in [9.6, 9.8, 10.2, 11.0] {
            let above = reversed(&rectangle(DVec3::new(0.3, 0.1, distance), DVec3::X, DVec3::Y));
            let floor = unit_square_at(0.0);
            let (contour, area) = (exchange_area_m2(&floor, &above), apart::exchange_area_m2(&floor, &above));
            assert!((contour.value - area.value).abs() < 1e-13, "{contour:?} {area:?}");
        }
    }

    #[test]
    fn a_wall_that_goes_on_below_the_floor_counts_above_it() {
        let wall = rectangle(DVec3::Z * -3.0, DVec3::Y, DVec3::Z * 4.0);
        assert_exchange(polygon_to_polygon(&unit_square_at(0.0), &wall), at_right_angle(1.0, 1.0), 1e-11);
        let behind = reversed(&unit_square_at(-1.0));
        assert_eq!(polygon_to_polygon(&unit_square_at(0.0), &behind), Exchange::default());
        assert_eq!(polygon_to_polygon(&unit_square_at(0.0), &unit_square_at(0.0)), Exchange::default());
    }

    #[test]
    fn coaxial_discs_as_regular_polygons_of_their_area_converge_with_the_fourth_power() {
        // A polygon of n sides with the disc's area: its second moment differs from the disc's by O(n^-4).
        let disc = |n: u32, radius: f64, z: f64, turn: f64| -> Vec<DVec3> {
            let step = 2.0 * PI / f64::from(n);
            let out = radius * (step / step.sin()).sqrt();
            (0..n)
                .map(|i| DVec3::new(out * (step * f64::from(i)).cos(), turn * out * (step * f64::from(i)).sin(), z))
                .collect()
        };
        for (radius, truth) in [(1.0, 0.3819660112501051), (0.5, 0.1715728752538099)] {
            let error = |n: u32| {
                let exchange = polygon_to_polygon(&disc(n, radius, 0.0, 1.0), &disc(n, radius, 1.0, -1.0));
                assert!(exchange.error_bound < 1e-11, "{exchange:?}");
                (exchange.factor - truth).abs()
            };
            let errors = [8, 16, 32].map(error);
            assert!(errors[0] / errors[1] > 12.0 && errors[1] / errors[2] > 12.0, "{errors:?}");
            assert!(errors[2] < 2e-6, "{errors:?}");
        }
    }

    fn point() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(DVec3::from)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn the_faces_of_a_tetrahedron_see_nothing_but_one_another(p in point(), q in point(), r in point(), s in point()) {
            let volume = (q - p).cross(r - p).dot(s - p);
            prop_assume!(volume.abs() > 1e-3);
            let (q, r) = if volume > 0.0 { (q, r) } else { (r, q) };
            // Looking inward.
            let faces = [[p, q, r], [p, s, q], [q, s, r], [r, s, p]];
            for (i, receiver) in faces.iter().enumerate() {
                let others = faces.iter().enumerate().filter(|(j, _)| *j != i);
                let factors: Vec<Exchange> = others.map(|(_, source)| polygon_to_polygon(receiver, source)).collect();
                let sum: f64 = factors.iter().map(|exchange| exchange.factor).sum();
                prop_assert!((sum - 1.0).abs() < 1e-10, "{sum} {factors:?}");
                prop_assert!((sum - 1.0).abs() <= factors.iter().map(|exchange| exchange.error_bound).sum::<f64>() + 1e-15);
            }
        }

        #[test]
        fn the_faces_of_a_nearly_flat_tetrahedron_too(p in point(), q in point(), r in point(), flat in -9.0..-1.0) {
            let normal = (q - p).cross(r - p);
            prop_assume!(normal.length() > 0.1);
            let top = (p + q + r) / 3.0 + 10.0_f64.powf(flat) * normal.normalize();
            let base = [p, q, r];
            let sum: f64 = [[p, top, q], [q, top, r], [r, top, p]].iter().map(|side| polygon_to_polygon(&base, side).factor).sum();
            prop_assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        }

        #[test]
        fn factors_are_reciprocal_and_do_not_depend_on_the_frame(
            p in point(), q in point(), r in point(), u in point(), v in point(), w in point(), shift in point(),
        ) {
            let (first, second) = ([p, q, r], [u, v, w]);
            let areas = [polygon::area_m2(&first), polygon::area_m2(&second)];
            prop_assume!(areas[0] > 1e-2 && areas[1] > 1e-2);
            let (there, back) = (polygon_to_polygon(&first, &second), polygon_to_polygon(&second, &first));
            prop_assert!((areas[0] * there.factor - areas[1] * back.factor).abs() < 1e-11, "{there:?} {back:?}");
            let turn = DQuat::from_xyzw(0.1, 0.7, -0.3, 0.4).normalize();
            let moved = |corners: [DVec3; 3]| corners.map(|corner| turn * (3.0 * corner + shift));
            let again = polygon_to_polygon(&moved(first), &moved(second));
            prop_assert!((again.factor - there.factor).abs() < 1e-11, "{there:?} {again:?}");
        }
    }
}
