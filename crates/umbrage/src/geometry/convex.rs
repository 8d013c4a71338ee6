//! Convex polygons in a plane frame, made to be cut by the thousand: lines through them, one less another, moments.
//!
//! Corners run counter-clockwise. What lies within a slack of a line counts as on it, so that polygons which share a
//! side leave no hairline between them when one is taken from the other; what has no area is empty.

use glam::{DMat2, DVec2};
use smallvec::SmallVec;

use super::polygon;

/// A convex counter-clockwise polygon; empty where nothing is left.
pub type Convex = SmallVec<[DVec2; 8]>;

/// A directed line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// A point of it.
    pub from_m: DVec2,
    /// Unit normal to its left.
    pub left: DVec2,
}

impl Line {
    /// The line from one point towards another; through two equal ones, a line that has nothing on either side.
    pub fn through(from_m: DVec2, to_m: DVec2) -> Self {
        Self { from_m, left: (to_m - from_m).perp().normalize_or_zero() }
    }

    /// Distance of a point, positive to the left, in metres.
    pub fn height_m(&self, point_m: DVec2) -> f64 {
        self.left.dot(point_m - self.from_m)
    }
}

/// Sides of a polygon, from each corner to the next.
pub fn sides(corners: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
    (0..corners.len()).map(|i| (corners[i], corners[if i + 1 == corners.len() { 0 } else { i + 1 }]))
}

/// Sides longer than `least_m`: shorter ones have no direction but that of rounding.
pub fn long_sides(corners: &[DVec2], least_m: f64) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
    sides(corners).filter(move |(p, q)| p.distance_squared(*q) > least_m * least_m)
}

/// The least and the greatest height of a polygon over a line, in metres.
pub fn heights_m(corners: &[DVec2], line: &Line) -> (f64, f64) {
    corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &corner| {
        let height = line.height_m(corner);
        (low.min(height), high.max(height))
    })
}

/// The parts to the left and to the right of a line; corners nearer to it than `slack_m` lie on it.
pub fn halves(corners: &[DVec2], line: &Line, slack_m: f64) -> [Convex; 2] {
    let height = |p: DVec2| {
        let height_m = line.height_m(p);
        if height_m.abs() <= slack_m { 0.0 } else { height_m }
    };
    let heights: SmallVec<[f64; 16]> = corners.iter().map(|&p| height(p)).collect();
    if heights.iter().all(|&h| h <= 0.0) {
        let on_it = heights.iter().all(|&h| h == 0.0);
        return [Convex::new(), if on_it { Convex::new() } else { corners.into() }];
    }
    if heights.iter().all(|&h| h >= 0.0) {
        return [corners.into(), Convex::new()];
    }
    let [mut left, mut right] = [Convex::new(), Convex::new()];
    let (mut p, mut at_p) = (corners[corners.len() - 1], heights[heights.len() - 1]);
    for (&q, &at_q) in corners.iter().zip(&heights) {
        if at_p * at_q < 0.0 {
            let crossing = p + (q - p) * (at_p / (at_p - at_q));
            left.push(crossing);
            right.push(crossing);
        }
        if at_q >= 0.0 {
            left.push(q);
        }
        if at_q <= 0.0 {
            right.push(q);
        }
        (p, at_p) = (q, at_q);
    }
    [left, right]
}

/// Whether two polygons have no area in common, but for what is narrower than `slack_m`, as a side of one of them
/// shows.
pub fn are_apart(first: &[DVec2], second: &[DVec2], slack_m: f64) -> bool {
    let beyond_a_side = |of: &[DVec2], other: &[DVec2]| {
        long_sides(of, slack_m).any(|(p, q)| {
            let (left, most) = ((q - p).perp(), slack_m * (q - p).length());
            other.iter().all(|&r| left.dot(r - p) <= most)
        })
    };
    beyond_a_side(first, second) || beyond_a_side(second, first)
}

/// Adds convex parts that make up `polygon` less `taken`.
pub fn difference(polygon: Convex, taken: &[DVec2], slack_m: f64, parts: &mut impl Extend<Convex>) {
    if are_apart(&polygon, taken, slack_m) {
        return parts.extend([polygon]);
    }
    let mut rest = polygon;
    for (p, q) in long_sides(taken, slack_m) {
        let [inside, outside] = halves(&rest, &Line::through(p, q), slack_m);
        if !outside.is_empty() {
            parts.extend([outside]);
        }
        rest = inside;
    }
}

/// The smallest box around a polygon: its least and its greatest corner.
pub fn bounds_m(corners: &[DVec2]) -> [DVec2; 2] {
    [
        corners.iter().copied().fold(DVec2::INFINITY, DVec2::min),
        corners.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max),
    ]
}

/// The line across the longer axis of a box, through its middle.
pub fn across(low_m: DVec2, high_m: DVec2) -> Line {
    let size_m = high_m - low_m;
    let left = if size_m.x >= size_m.y { DVec2::X } else { DVec2::Y };
    Line { from_m: 0.5 * (low_m + high_m), left }
}

/// Length of the boundary, in metres.
pub fn perimeter_m(corners: &[DVec2]) -> f64 {
    sides(corners).map(|(p, q)| p.distance(q)).sum()
}

/// The convex hull of points, counter-clockwise; corners in line are left out (Andrew, *Another efficient algorithm for
/// convex hulls in two dimensions*, 1979).
pub fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    points.dedup();
    let chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., q, r] = chain[..]
                && (r - q).perp_dot(p - r) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut border = chain(&mut points.iter().copied());
    border.extend(chain(&mut points.iter().rev().copied()));
    border
}

/// A convex polygon without the corners that matter least: one after another goes that cuts off least area, until there
/// are `most` of them, and each that is left would take at least `least_share` of the area with it.
pub fn with_few_corners(mut corners: Vec<DVec2>, most: usize, least_share: f64) -> Vec<DVec2> {
    let least_m2 = least_share * polygon::signed_area_2d_m2(&corners);
    while corners.len() > 3 {
        let n = corners.len();
        let cut_off_m2 = |i: usize| {
            let (before, at, after) = (corners[(i + n - 1) % n], corners[i], corners[(i + 1) % n]);
            0.5 * (at - before).perp_dot(after - at)
        };
        let least = (0..n).map(|i| (cut_off_m2(i), i)).reduce(|best, next| if next.0 < best.0 { next } else { best });
        match least.filter(|&(area_m2, _)| n > most || area_m2 < least_m2) {
            Some((_, i)) => corners.remove(i),
            None => break,
        };
    }
    corners
}

/// Area and its moments up to the second about the origin of the frame: they add up, and can be subtracted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Area, in square metres.
    pub area_m2: f64,
    /// Integral of the position, in cubic metres.
    pub first_m3: DVec2,
    /// Integral of the outer product of the position with itself, in m^4.
    pub second_m4: DMat2,
}

impl Moments {
    /// Of nothing.
    pub const ZERO: Self = Self { area_m2: 0.0, first_m3: DVec2::ZERO, second_m4: DMat2::ZERO };

    /// Of a polygon.
    pub fn of(corners: &[DVec2]) -> Self {
        let Some(&first) = corners.first() else { return Self::ZERO };
        let outer = |p: DVec2| DMat2::from_cols(p * p.x, p * p.y);
        // About its own first corner, which keeps the digits of what is small.
        let (mut doubled_m2, mut moment, mut second) = (0.0, DVec2::ZERO, DMat2::ZERO);
        for pair in corners.windows(2) {
            let (p, q) = (pair[0] - first, pair[1] - first);
            let of_triangle = p.perp_dot(q);
            doubled_m2 += of_triangle;
            moment += of_triangle / 6.0 * (p + q);
            second += of_triangle / 24.0 * (outer(p) + outer(q) + outer(p + q));
        }
        let area_m2 = 0.5 * doubled_m2;
        let cross = DMat2::from_cols(moment * first.x, moment * first.y);
        Self {
            area_m2,
            first_m3: moment + area_m2 * first,
            second_m4: second + cross + cross.transpose() + area_m2 * outer(first),
        }
    }

    /// Centroid and the area mean of the outer product of the offset from it with itself; `None` where there is no
    /// area.
    pub fn centroid_and_spread(&self) -> Option<(DVec2, DMat2)> {
        if self.area_m2 <= 0.0 {
            return None;
        }
        let centroid_m = self.first_m3 / self.area_m2;
        let outer = DMat2::from_cols(centroid_m * centroid_m.x, centroid_m * centroid_m.y);
        Some((centroid_m, self.second_m4 * (1.0 / self.area_m2) - outer))
    }
}

impl std::ops::Sub for Moments {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            area_m2: self.area_m2 - other.area_m2,
            first_m3: self.first_m3 - other.first_m3,
            second_m4: self.second_m4 - other.second_m4,
        }
    }
}

/// Polygons for tests.
#[cfg(test)]
pub(crate) mod fixture {
    use super::*;
    use proptest::prelude::*;

    /// A rectangle with sides along the axes.
    pub(crate) fn rectangle(x: [f64; 2], y: [f64; 2]) -> Convex {
        [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| DVec2::new(x[i], y[j])).into_iter().collect()
    }

    /// Regular polygons.
    pub(crate) fn regular() -> impl Strategy<Value = Convex> {
        ((-1.0..1.0, -1.0..1.0), 0.2..2.0, 3..9usize, 0.0..1.0).prop_map(
            |((x, y), r, n, turn): ((f64, f64), f64, _, f64)| {
                (0..n)
                    .map(|i| {
                        DVec2::new(x, y) + r * DVec2::from_angle((i as f64 + turn) * std::f64::consts::TAU / n as f64)
                    })
                    .collect()
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::fixture::{rectangle, regular};
    use super::*;
    use proptest::prelude::*;
    use smallvec::smallvec;

    fn area_m2(corners: &[DVec2]) -> f64 {
        polygon::signed_area_2d_m2(corners)
    }

    proptest! {
        #[test]
        fn a_line_divides_a_polygon_without_loss(p in regular(), a in -1.0..1.0, b in -1.0..1.0, angle in 0.0..6.3) {
            let line = Line::through(DVec2::new(a, b), DVec2::new(a, b) + DVec2::from_angle(angle));
            let parts = halves(&p, &line, 0.0);
            prop_assert!((area_m2(&parts[0]) + area_m2(&parts[1]) - area_m2(&p)).abs() < 1e-12);
            let [left, right] = parts.map(|part| part.iter().map(|&q| line.height_m(q)).sum::<f64>());
            prop_assert!(left >= -1e-12 && right <= 1e-12);
        }

        #[test]
        fn what_is_left_and_what_is_taken_make_up_the_whole(p in regular(), q in regular()) {
            let mut left = Vec::new();
            difference(p.clone(), &q, 1e-9, &mut left);
            let common = area_m2(&crate::geometry::clip::intersection(&p, &q));
            prop_assert!((left.iter().map(|part| area_m2(part)).sum::<f64>() + common - area_m2(&p)).abs() < 1e-7);
            prop_assert!(left.iter().all(|part| are_apart(part, &q, 1e-8)));
        }

        #[test]
        fn moments_add_up_and_tell_the_spread(p in regular(), angle in 0.0..6.3) {
            let whole = Moments::of(&p);
            let [left, right] = halves(&p, &Line::through(p[0], p[0] + DVec2::from_angle(angle)), 0.0);
            let difference = whole - Moments::of(&left) - Moments::of(&right);
            prop_assert!(difference.area_m2.abs() < 1e-12 && difference.first_m3.length() < 1e-12);
            prop_assert!(difference.second_m4.abs_diff_eq(DMat2::ZERO, 1e-12));
            let spread = whole.centroid_and_spread().unwrap().1;
            prop_assert!(spread.abs_diff_eq(polygon::second_moment_m2(&p), 1e-12));
        }
    }

    proptest! {
        #[test]
        fn a_hull_holds_its_points_and_turns_left_at_each_of_its_corners(p in regular(), inside in 0.0..1.0) {
            let middle = p.iter().sum::<DVec2>() / p.len() as f64;
            let shrunk = p.iter().map(|&q| middle.lerp(q, inside));
            let hull = hull(p.iter().copied().chain(shrunk).collect());
            prop_assert_eq!(hull.len(), p.len());
            prop_assert!(hull.iter().all(|corner| p.contains(corner)));
            prop_assert!((area_m2(&hull) - area_m2(&p)).abs() < 1e-12);
        }
    }

    #[test]
    fn of_a_polygon_with_few_corners_those_are_left_that_span_most() {
        // A square with a blunt corner, and a point next to the middle of a side.
        let blunt =
            [(0.0, 0.0), (0.5, -1e-3), (1.0, 0.0), (1.0, 0.9), (0.9, 1.0), (0.0, 1.0)].map(DVec2::from).to_vec();
        let square = [blunt[0], blunt[2], blunt[3], blunt[4], blunt[5]];
        assert_eq!(with_few_corners(blunt.clone(), 8, 2e-3), square);
        assert_eq!(with_few_corners(blunt.clone(), 8, 1e-5), blunt);
        assert_eq!(with_few_corners(blunt.clone(), 4, 1e-5).len(), 4);
        assert_eq!(with_few_corners(blunt, 8, 2.0).len(), 3);
    }

    #[test]
    fn neighbours_leave_no_hairline() {
        let skew = [DVec2::new(-5.0, -5.0), DVec2::new(1.0 / 3.0, 5.0)];
        let left: Convex = smallvec![skew[0], skew[1], DVec2::new(-5.0, 5.0)];
        let mut parts = Vec::new();
        difference(rectangle([-6.0, 6.0], [-4.0, 4.0]), &left, 1e-9, &mut parts);
        let right: Convex = smallvec![skew[0], DVec2::new(5.0, -5.0), DVec2::new(5.0, 5.0), skew[1]];
        let mut rest = Vec::new();
        parts.into_iter().for_each(|part| difference(part, &right, 1e-9, &mut rest));
        assert!(rest.iter().all(|part| part.iter().all(|p| p.x.abs() >= 0.9 * skew[0].x.abs() || p.x < 0.0)));
        let expected = 12.0 * 8.0
            - area_m2(&crate::geometry::clip::intersection(&rectangle([-6.0, 6.0], [-4.0, 4.0]), &left))
            - area_m2(&crate::geometry::clip::intersection(&rectangle([-6.0, 6.0], [-4.0, 4.0]), &right));
        assert!((rest.iter().map(|part| area_m2(part)).sum::<f64>() - expected).abs() < 1e-9);
    }
}
