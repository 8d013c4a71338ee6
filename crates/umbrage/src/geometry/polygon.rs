//! Measures of polygons: area, centroid, perimeter, and how well shaped they are.

use std::f64::consts::PI;

use glam::{DMat2, DVec2, DVec3};

use super::Plane;

/// Twice the area of a plane polygon times its normal (Newell): robust for any simple polygon, zero for a degenerate
/// one.
pub fn doubled_area_vector(corners: &[DVec3]) -> DVec3 {
    let Some(&first) = corners.first() else { return DVec3::ZERO };
    corners.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first)).sum()
}

/// Area of a plane polygon, in square metres.
pub fn area_m2(corners: &[DVec3]) -> f64 {
    0.5 * doubled_area_vector(corners).length()
}

/// Signed area of a polygon in a plane frame, positive where it is counter-clockwise, in square metres.
pub fn signed_area_2d_m2(corners: &[DVec2]) -> f64 {
    let Some(&first) = corners.first() else { return 0.0 };
    0.5 * corners.windows(2).map(|pair| (pair[0] - first).perp_dot(pair[1] - first)).sum::<f64>()
}

/// Centroid of a convex polygon with area; the mean corner of one without.
pub fn centroid(corners: &[DVec3]) -> DVec3 {
    let mean = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let Some(&first) = corners.first() else { return DVec3::ZERO };
    let (mut moment, mut weight) = (DVec3::ZERO, 0.0);
    for pair in corners.windows(2) {
        let doubled_area = (pair[0] - first).cross(pair[1] - first).length();
        moment += doubled_area * (first + pair[0] + pair[1]);
        weight += 3.0 * doubled_area;
    }
    if weight > 0.0 { moment / weight } else { mean }
}

/// Area mean of the outer product of the offset from the centroid with itself, of a convex polygon in a plane frame, in
/// square metres; zero for one without area.
pub fn second_moment_m2(corners: &[DVec2]) -> DMat2 {
    let outer = |p: DVec2| DMat2::from_cols(p * p.x, p * p.y);
    let Some(&first) = corners.first() else { return DMat2::ZERO };
    let (mut area, mut moment, mut second) = (0.0, DVec2::ZERO, DMat2::ZERO);
    for pair in corners.windows(2) {
        let (p, q) = (pair[0] - first, pair[1] - first);
        let doubled_area = p.perp_dot(q);
        area += doubled_area;
        moment += doubled_area * (p + q) / 3.0;
        // Of a triangle with one corner at the origin.
        second += doubled_area / 12.0 * (outer(p) + outer(q) + outer(p + q));
    }
    if area > 0.0 { second * (1.0 / area) - outer(moment / area) } else { DMat2::ZERO }
}

/// A point of a convex polygon, evenly by area for `s` and `t` that are even.
pub fn point_of(corners: &[DVec3], s: f64, t: f64) -> DVec3 {
    let doubled_m2 = |i: usize| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]).length();
    let (i, away) = triangle_of(corners.len(), doubled_m2, s);
    corners[0] + away * (corners[i].lerp(corners[i + 1], t) - corners[0])
}

/// The same of a convex counter-clockwise polygon in a plane frame.
pub fn point_of_2d(corners: &[DVec2], s: f64, t: f64) -> DVec2 {
    let doubled_m2 = |i: usize| (corners[i] - corners[0]).perp_dot(corners[i + 1] - corners[0]).max(0.0);
    let (i, away) = triangle_of(corners.len(), doubled_m2, s);
    corners[0] + away * (corners[i].lerp(corners[i + 1], t) - corners[0])
}

/// Which triangle of the fan from the first of so many corners an even number falls on, by area, and how far the point is then from that
/// corner, as a share of the way across.
fn triangle_of(corners: usize, doubled_m2: impl Fn(usize) -> f64, number: f64) -> (usize, f64) {
    let last = corners - 2;
    let mut left = number * (1..=last).map(&doubled_m2).sum::<f64>();
    let mut triangle = 1;
    while triangle < last && left >= doubled_m2(triangle) {
        left -= doubled_m2(triangle);
        triangle += 1;
    }
    (triangle, (left / doubled_m2(triangle).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0).sqrt())
}

/// Length of the boundary, in metres.
pub fn perimeter_m(corners: &[DVec3]) -> f64 {
    (0..corners.len()).map(|i| corners[i].distance(corners[(i + 1) % corners.len()])).sum()
}

/// Distance of `point` from a convex polygon in `plane`, in metres.
pub fn distance_m(point: DVec3, corners: &[DVec3], plane: &Plane) -> f64 {
    let sides = || (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]));
    if sides().all(|(from, to)| (to - from).cross(point - from).dot(plane.normal) >= 0.0) {
        return plane.signed_distance_m(point).abs();
    }
    let to_side = |(from, to): (DVec3, DVec3)| {
        let along = to - from;
        let t = ((point - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        point.distance(from + if t.is_nan() { 0.0 } else { t } * along)
    };
    sides().map(to_side).fold(f64::INFINITY, f64::min)
}

/// How well shaped a polygon is: `4 pi A / P^2`, 1 for a circle, pi/4 for a square, towards 0 for a needle.
pub fn compactness(area_m2: f64, perimeter_m: f64) -> f64 {
    if perimeter_m > 0.0 { 4.0 * PI * area_m2 / (perimeter_m * perimeter_m) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_has_a_twelfth_of_its_squared_sides() {
        let corners = [(1.0, 2.0), (4.0, 2.0), (4.0, 4.0), (1.0, 4.0)].map(DVec2::from);
        let moment = second_moment_m2(&corners);
        assert!(
            (moment - DMat2::from_diagonal(DVec2::new(9.0 / 12.0, 4.0 / 12.0)))
                .to_cols_array()
                .iter()
                .all(|x| x.abs() < 1e-14)
        );
    }

    fn rectangle(width: f64, height: f64) -> Vec<DVec3> {
        [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)].map(|(x, y)| DVec3::new(x, y, 3.0)).to_vec()
    }

    #[test]
    fn measures_of_a_rectangle() {
        let corners = rectangle(4.0, 2.0);
        assert_eq!(area_m2(&corners), 8.0);
        assert_eq!(perimeter_m(&corners), 12.0);
        assert_eq!(centroid(&corners), DVec3::new(2.0, 1.0, 3.0));
    }

    #[test]
    fn a_square_is_well_shaped_and_a_needle_is_not() {
        let square = rectangle(1.0, 1.0);
        assert!((compactness(area_m2(&square), perimeter_m(&square)) - PI / 4.0).abs() < 1e-15);
        let needle = rectangle(20.0, 1.0);
        assert!(compactness(area_m2(&needle), perimeter_m(&needle)) < 0.15);
    }

    #[test]
    fn distances_from_a_rectangle() {
        let (corners, plane) = (rectangle(4.0, 2.0), Plane::through(DVec3::Z * 3.0, DVec3::Z));
        assert_eq!(distance_m(DVec3::new(1.0, 1.0, 5.0), &corners, &plane), 2.0);
        assert_eq!(distance_m(DVec3::new(7.0, 1.0, 7.0), &corners, &plane), 5.0);
        assert_eq!(distance_m(DVec3::new(-3.0, -4.0, 3.0), &corners, &plane), 5.0);
    }

    #[test]
    fn the_centroid_of_a_line_is_its_mean() {
        assert_eq!(centroid(&[DVec3::ZERO, DVec3::X, DVec3::X * 2.0]), DVec3::X);
    }

    #[test]
    fn points_of_a_polygon_are_even() {
        let corners = [DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::X + DVec3::Y, DVec3::Y];
        let mean = |point: &dyn Fn(f64, f64) -> DVec3| {
            let at = |i: u32| point((f64::from(i) + 0.5) / 4096.0, (0.618_034 * f64::from(i)).fract());
            (0..4096).map(at).sum::<DVec3>() / 4096.0
        };
        let flat = corners.map(DVec3::truncate);
        let means = [mean(&|s, t| point_of(&corners, s, t)), mean(&|s, t| point_of_2d(&flat, s, t).extend(0.0))];
        for mean in means {
            assert!((mean - DVec3::new(1.0, 0.5, 0.0)).length() < 2e-3, "{mean}");
        }
    }
}
