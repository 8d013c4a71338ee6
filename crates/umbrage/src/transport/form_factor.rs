//! Form factors: Lambert's of a point to a polygon, and the paper's estimate (section 6, `formfactor_estimate`).
//!
//! Lambert (*Photometria*, 1760): the factor of a differential area at a point with normal `n` to a polygon is
//! `1 / (2 pi)` times the sum over its edges of the angle that the edge subtends times `n . unit(R_i x R_i+1)`. The sum is
//! linear in oriented contours, so a polygon with holes, or the visible part of a source, is summed as it is, with no
//! decomposition. It is exact while the polygon lies above the receiver's horizon.
//!
//! An edge whose ends lie in line with the point subtends no angle and adds nothing: the cross product vanishes there, so
//! its unit vector must not be taken.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use wide::f64x4;

use crate::geometry::clip;
use crate::id::FaceId;
use crate::visibility::{FlatSource, PlaneView, ReceiverPoint, Visibility};

/// Lambert's sum over one oriented contour, seen from `position_m` with the unit normal `normal`: positive where the
/// contour runs counter-clockwise seen from its front, and the point is in front. The contour lies above the horizon.
pub fn contour_factor(position_m: DVec3, normal: DVec3, contour_m: &[DVec3]) -> f64 {
    let Some(&last) = contour_m.last() else { return 0.0 };
    let mut sum = 0.0;
    let mut from = last - position_m;
    for &corner in contour_m {
        let to = corner - position_m;
        // From its front a polygon runs counter-clockwise, so the cross product of its edge points away from its axis.
        let cross = to.cross(from);
        let sine = cross.length();
        if sine > 0.0 {
            sum += sine.atan2(from.dot(to)) * normal.dot(cross) / sine;
        }
        from = to;
    }
    sum / (2.0 * PI)
}

/// The factor of a point with the unit normal `normal` to an unoccluded convex polygon, clipped to the point's horizon
/// here; zero behind the polygon. Corners run counter-clockwise seen from its front.
pub fn point_to_polygon(position_m: DVec3, normal: DVec3, corners_m: &[DVec3]) -> f64 {
    let height = |corner: &DVec3| normal.dot(corner - position_m);
    let above = corners_m.iter().filter(|corner| height(corner) >= 0.0).count();
    if above == 0 {
        return 0.0;
    }
    if above == corners_m.len() {
        return factor_by_lanes(position_m, normal, corners_m).max(0.0);
    }
    let above = clip::where_not_negative(corners_m, |corner| height(&corner));
    factor_by_lanes(position_m, normal, &above).max(0.0)
}

/// [`contour_factor`], for four edges at a time.
fn factor_by_lanes(position_m: DVec3, normal: DVec3, corners_m: &[DVec3]) -> f64 {
    let mut sums = f64x4::ZERO;
    for first in (0..corners_m.len()).step_by(EDGES) {
        let (mut from, mut to) = ([[0.0; EDGES]; 3], [[0.0; EDGES]; 3]);
        // What is missing of four edges is one without length.
        for (lane, &corner) in corners_m[first..].iter().take(EDGES).enumerate() {
            let before = corners_m[(first + lane).checked_sub(1).unwrap_or(corners_m.len() - 1)];
            let ends = [before, corner].map(|end| end - position_m);
            for axis in 0..3 {
                (from[axis][lane], to[axis][lane]) = (ends[0][axis], ends[1][axis]);
            }
        }
        let ([fx, fy, fz], [tx, ty, tz]) = (from.map(f64x4::new), to.map(f64x4::new));
        let cross = [ty * fz - tz * fy, tz * fx - tx * fz, tx * fy - ty * fx];
        let sine = (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt();
        let cosine = fx * tx + fy * ty + fz * tz;
        let over_edge = cross[0] * normal.x + cross[1] * normal.y + cross[2] * normal.z;
        // An edge without a sine has no cross product either.
        sums += sine.atan2(cosine) * over_edge / sine.max(f64x4::splat(f64::MIN_POSITIVE));
    }
    sums.reduce_add() / (2.0 * PI)
}

/// The factor of a point to a polygon of a plane that it views, above its horizon: as [`contour_factor`], in two dimensions, for four
/// edges at a time.
pub fn factor_in_view(view: &PlaneView, corners_m: &[DVec2]) -> f64 {
    let (h, n) = (f64x4::splat(view.height_m), view.normal);
    let mut sums = f64x4::ZERO;
    for first in (0..corners_m.len()).step_by(EDGES) {
        let (mut from, mut to) = ([[0.0; EDGES]; 2], [[0.0; EDGES]; 2]);
        // What is missing of four edges is one without length.
        for (lane, &corner) in corners_m[first..].iter().take(EDGES).enumerate() {
            let before = corners_m[(first + lane).checked_sub(1).unwrap_or(corners_m.len() - 1)];
            let ends = [before, corner].map(|end| end - view.foot_m);
            (from[0][lane], from[1][lane], to[0][lane], to[1][lane]) = (ends[0].x, ends[0].y, ends[1].x, ends[1].y);
        }
        let ([from_x, from_y], [to_x, to_y]) = (from.map(f64x4::new), to.map(f64x4::new));
        // The cross product of `to` and `from`, which both have the height `-h`.
        let cross = [h * (from_y - to_y), h * (to_x - from_x), to_x * from_y - to_y * from_x];
        let sine = (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt();
        let cosine = from_x * to_x + from_y * to_y + h * h;
        let over_edge = cross[0] * n.x + cross[1] * n.y + cross[2] * n.z;
        // An edge without a sine has no cross product either.
        sums += sine.atan2(cosine) * over_edge / sine.max(f64x4::splat(f64::MIN_POSITIVE));
    }
    sums.reduce_add() / (2.0 * PI)
}

/// Edges that are summed at once.
const EDGES: usize = 4;

/// The factor of a point to what it sees of a source past some faces, or past all where none are given.
pub fn factor_of_seen(
    visibility: &Visibility,
    receiver: &ReceiverPoint,
    source: &FlatSource,
    among: Option<&[FaceId]>,
) -> f64 {
    let Some(view) = visibility.view(receiver, source) else { return 0.0 };
    let factor = |corners_m: &[DVec2]| factor_in_view(&view, corners_m);
    let is_clear = among.is_some_and(<[FaceId]>::is_empty) && !visibility.is_in_closed_gap(receiver, &view);
    if receiver.near.is_none() && is_clear {
        let above = view.above_horizon(&source.corners_m);
        return factor(above.as_deref().unwrap_or(&source.corners_m)).max(0.0);
    }
    visibility.seen(receiver, view, source, among).measure(factor).max(0.0)
}

/// A patch as the estimate sees it: a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its centre, in metres.
    pub centre_m: DVec3,
    /// Its unit normal, towards the front.
    pub normal: DVec3,
    /// Its area, in square metres.
    pub area_m2: f64,
}

/// The paper's `formfactor_estimate`: the factor from `receiver` to `source`, taken as a disc facing its own normal,
/// `cos_i cos_j A_j / (pi r^2 + A_j)` (Wallace, Elmquist and Haines, 1989). It ignores occluders, and errs by 35 % between
/// equal parallel squares at half their side.
pub fn disc_estimate(receiver: &Disc, source: &Disc) -> f64 {
    let between = source.centre_m - receiver.centre_m;
    let distance_squared = between.length_squared();
    let (cos_receiver, cos_source) = (receiver.normal.dot(between), -source.normal.dot(between));
    if cos_receiver <= 0.0 || cos_source <= 0.0 {
        return 0.0;
    }
    cos_receiver * cos_source / distance_squared * source.area_m2 / (PI * distance_squared + source.area_m2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::FaceId;
    use crate::visibility::fixture;
    use proptest::prelude::*;

    /// A unit square over the origin's first quadrant, at height `z`, looking down.
    fn square_above(z: f64) -> Vec<DVec3> {
        [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| DVec3::new(x, y, z)).to_vec()
    }

    /// The mean over the unit square of what points see, by Gauss's product rule with 8 x 8 points in each of n x n cells.
    fn mean_over_unit_square(cells: usize, point_factor: impl Fn(f64, f64) -> f64) -> f64 {
        const NODES: [(f64, f64); 4] = [
            (0.1834346424956498, 0.362683783378362),
            (0.525532409916329, 0.3137066458778873),
            (0.7966664774136267, 0.2223810344533745),
            (0.9602898564975363, 0.1012285362903763),
        ];
        let nodes: Vec<(f64, f64)> = NODES.iter().flat_map(|&(t, w)| [(-t, w), (t, w)]).collect();
        let h = 1.0 / cells as f64;
        let mut sum = 0.0;
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            for (&(s, ws), &(t, wt)) in nodes.iter().flat_map(|s| nodes.iter().map(move |t| (s, t))) {
                let (x, y) = (h * (i as f64 + 0.5 + 0.5 * s), h * (j as f64 + 0.5 + 0.5 * t));
                sum += 0.25 * h * h * ws * wt * point_factor(x, y);
            }
        }
        sum
    }

    fn assert_close(value: f64, truth: f64, tolerance: f64) {
        assert!((value - truth).abs() <= tolerance, "{value} is not {truth} within {tolerance}");
    }

    proptest! {
        #[test]
        fn in_two_dimensions_and_four_edges_at_a_time_it_is_the_same_sum(
            count in 3..11usize, radius in 1e-3..2.0, middle in (-2.0..2.0, -2.0..2.0), height in 1e-3..2.0,
            up in (-1.0..1.0, -1.0..1.0),
        ) {
            let on_circle = |i: usize| DVec2::from(middle) + radius * DVec2::from_angle(i as f64 * 2.0 * PI / count as f64);
            let corners: Vec<DVec2> = (0..count).map(on_circle).collect();
            let normal = DVec3::new(up.0, up.1, -1.0).normalize();
            let view = PlaneView { foot_m: DVec2::ZERO, height_m: height, normal };
            let contour: Vec<DVec3> = corners.iter().map(|corner| corner.extend(0.0)).collect();
            let truth = contour_factor(DVec3::Z * height, normal, &contour);
            prop_assert!((factor_in_view(&view, &corners) - truth).abs() < 1e-14, "not {truth}");
        }
    }

    #[test]
    fn a_point_under_corner_and_centre_of_a_unit_square() {
        assert_close(point_to_polygon(DVec3::ZERO, DVec3::Z, &square_above(1.0)), 0.1385316060, 5e-11);
        assert_close(point_to_polygon(DVec3::new(0.5, 0.5, 0.0), DVec3::Z, &square_above(1.0)), 0.2394564705, 5e-11);
    }

    #[test]
    fn a_point_to_a_perpendicular_unit_square() {
        let wall = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(y, z)| DVec3::new(0.0, y, z));
        assert_close(point_to_polygon(DVec3::X, DVec3::Z, &wall), 0.0557341970, 5e-11);
    }

    #[test]
    fn parallel_unit_squares() {
        for (distance, truth, cells) in [(1.0, 0.1998248957, 1), (0.1, 0.8269945224, 8), (2.0, 0.0685895888, 1)] {
            let source = square_above(distance);
            let mean = mean_over_unit_square(cells, |x, y| point_to_polygon(DVec3::new(x, y, 0.0), DVec3::Z, &source));
            assert_close(mean, truth, 1e-9);
        }
    }

    #[test]
    fn perpendicular_squares_with_a_common_edge() {
        // The point factor is not smooth at the common edge and its ends: x = t^4 and y = s^2 (3 - 2 s) smooth it.
        for (height, truth) in [(1.0, 0.2000437761), (2.0, 0.2328526028)] {
            let wall = [(0.0, 0.0), (1.0, 0.0), (1.0, height), (0.0, height)].map(|(y, z)| DVec3::new(0.0, y, z));
            let mean = mean_over_unit_square(8, |t, s| {
                let (x, y, density) = (t.powi(4), s * s * (3.0 - 2.0 * s), 24.0 * t.powi(3) * s * (1.0 - s));
                density * point_to_polygon(DVec3::new(x, y, 0.0), DVec3::Z, &wall)
            });
            assert_close(mean, truth, 1e-9);
        }
    }

    #[test]
    fn coaxial_discs() {
        // A polygon of n corners and the disc's area differs from the disc by O(1 / n^4) in a radial mean.
        let n = 720;
        for (radius, truth) in [(1.0, 0.3819660113), (0.5, 0.1715728753)] {
            let source: Vec<DVec3> = (0..n)
                .map(|i| {
                    let (sine, cosine) = (-f64::from(i) * 2.0 * PI / f64::from(n)).sin_cos();
                    DVec3::new(radius * cosine, radius * sine, 1.0)
                })
                .collect();
            let mean = mean_over_unit_square(1, |t, _| {
                2.0 * t * point_to_polygon(DVec3::new(radius * t, 0.0, 0.0), DVec3::Z, &source)
            });
            assert_close(mean, truth, 2e-5);
        }
    }

    /// The mean factor between parallel unit squares at distance 1, with a rectangle between them at height `z`.
    fn mean_past_blocker(x: [f64; 2], y: [f64; 2], z: f64) -> f64 {
        let floor: Vec<DVec3> = square_above(0.0).into_iter().rev().collect();
        let blocker = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])].map(|(x, y)| DVec3::new(x, y, z));
        let prepared = fixture::prepared(&[floor, blocker.to_vec(), square_above(1.0)]);
        let index = Visibility::new(&prepared);
        let source = FlatSource::of_face(&prepared, FaceId::from(2));
        mean_over_unit_square(12, |x, y| {
            let receiver = ReceiverPoint::on_face(&prepared, FaceId::from(0), DVec3::new(x, y, 0.0));
            factor_of_seen(&index, &receiver, &source, None)
        })
    }

    #[test]
    fn shapiros_blocker_and_three_blockers_half_way() {
        assert_close(mean_past_blocker([0.25, 0.75], [0.25, 0.75], 0.75), 0.1156206021, 1e-6);
        assert_close(mean_past_blocker([0.25, 0.75], [0.25, 0.75], 0.25), 0.1156206021, 1e-6);
        assert_close(mean_past_blocker([0.25, 0.75], [0.25, 0.75], 0.5), 0.0995062946, 1e-6);
        assert_close(mean_past_blocker([0.0, 0.5], [0.0, 0.5], 0.5), 0.1498686718, 1e-6);
        assert_close(mean_past_blocker([0.0, 0.5], [0.0, 1.0], 0.5), 0.0999124478, 1e-6);
    }

    #[test]
    fn the_estimate_errs_as_is_known() {
        let disc = |z: f64, normal| Disc { centre_m: DVec3::new(0.5, 0.5, z), normal, area_m2: 1.0 };
        for (distance, truth, error) in [(1.0, 0.1998248957, 0.21), (2.0, 0.0685895888, 0.075)] {
            let estimate = disc_estimate(&disc(0.0, DVec3::Z), &disc(distance, DVec3::NEG_Z));
            assert_close(estimate / truth - 1.0, error, 0.006);
        }
        assert_eq!(disc_estimate(&disc(0.0, DVec3::Z), &disc(1.0, DVec3::Z)), 0.0);
    }

    #[test]
    fn limits_on_the_polygon_are_finite() {
        let wall = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(y, z)| DVec3::new(0.0, y, z));
        for y in [0.0, 0.5, 1.0] {
            let on_edge = point_to_polygon(DVec3::Y * y, DVec3::Z, &wall);
            assert!(on_edge.is_finite() && (0.0..=0.5).contains(&on_edge), "{on_edge} at {y}");
        }
        assert_close(point_to_polygon(DVec3::new(1e-9, 0.5, 0.0), DVec3::Z, &wall), 0.5, 1e-8);
    }

    proptest! {
        #[test]
        fn parts_sum_to_the_whole(x in -2.0..2.0, y in -2.0..2.0, z in 0.01..2.0, cut in 0.1..0.9) {
            let source = square_above(z);
            let (low, high) = (source.clone(), source.clone());
            let part = |mut corners: Vec<DVec3>, first: usize, second: usize| {
                (corners[first].x, corners[second].x) = (cut, cut);
                point_to_polygon(DVec3::new(x, y, 0.0), DVec3::Z, &corners)
            };
            let sum = part(low, 2, 3) + part(high, 0, 1);
            prop_assert!((sum - point_to_polygon(DVec3::new(x, y, 0.0), DVec3::Z, &source)).abs() < 1e-14);
        }
    }
}
