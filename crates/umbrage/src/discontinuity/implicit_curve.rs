//! A curve in a convex polygon, given as the zeros of a function, as chords.
//!
//! ```text
//!        ____________          The boundary passes in and out of the region where the function is positive. From each
//!       /      +     |         point where it passes out a piece of the curve leads to the next one where it passes in:
//!      /out____.-o in|         so it is for convex regions, such as what a cone or a ball cuts out of a plane, and for
//!     / o-''      -  |         any curve that crosses once. A closed curve inside is crossed by a cut through its middle.
//! ```
//!
//! Each piece is halved until its chords leave it by little: half-way between two points of the curve its next point is searched across
//! the chord.

use glam::DVec2;

use crate::geometry::clip;

/// Parts of a side in each of which at most one crossing is looked for.
const PARTS_OF_SIDE: usize = 4;
/// Halvings that find a crossing in an interval to rounding.
const HALVINGS: usize = 50;
/// A piece is halved no more often: 256 chords at most.
const MAX_DEPTH: usize = 8;
/// How far from the middle of a chord the curve is searched for, as shares of its length, ascending.
const SEARCHED: [f64; 5] = [1e-3, 0.01, 0.1, 0.5, 2.0];

/// The chords of the curve on which `side` is zero, in a convex polygon with counter-clockwise corners; they leave it by no more than the
/// share `leaves` of their length. `within` is a point on the positive side of a curve that may be closed.
pub(super) fn chords(
    corners: &[DVec2],
    within: Option<DVec2>,
    side: impl Fn(DVec2) -> f64,
    leaves: f64,
) -> Vec<[DVec2; 2]> {
    let mut found = Vec::new();
    let is_inside = |p: DVec2| {
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).all(|(&from, &to)| (to - from).perp_dot(p - from) > 0.0)
    };
    match within.filter(|&p| is_inside(p) && side(p) > 0.0) {
        Some(p) => {
            for half in [clip::left_of(corners, p, p + DVec2::X), clip::left_of(corners, p + DVec2::X, p)] {
                in_polygon(&with_point(half, p), &side, leaves, &mut found);
            }
        }
        None => in_polygon(corners, &side, leaves, &mut found),
    }
    found
}

/// A polygon with a point of one of its sides as a corner: on a long side the curve would be between the points that are looked at.
fn with_point(mut corners: Vec<DVec2>, p: DVec2) -> Vec<DVec2> {
    let distance = |&i: &usize| {
        let (from, to) = (corners[i], corners[(i + 1) % corners.len()]);
        let share = ((p - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
        from.lerp(to, share).distance(p)
    };
    let nearest = (0..corners.len()).min_by(|i, j| distance(i).total_cmp(&distance(j)));
    corners.insert(nearest.map_or(0, |i| i + 1), p);
    corners
}

fn in_polygon(corners: &[DVec2], side: &impl Fn(DVec2) -> f64, leaves: f64, found: &mut Vec<[DVec2; 2]>) {
    // Where the boundary crosses, and whether out of the positive side.
    let mut crossings: Vec<(DVec2, bool)> = Vec::new();
    for (i, &from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % corners.len()];
        let at = |part: usize| from.lerp(to, part as f64 / PARTS_OF_SIDE as f64);
        for part in 0..PARTS_OF_SIDE {
            let ends = [at(part), if part + 1 == PARTS_OF_SIDE { to } else { at(part + 1) }];
            let signs = ends.map(|end| side(end) > 0.0);
            if signs[0] != signs[1] {
                crossings.push((crossing(ends, side), signs[0]));
            }
        }
    }
    for (i, &(out, is_out)) in crossings.iter().enumerate() {
        let (back, _) = crossings[(i + 1) % crossings.len()];
        if is_out {
            halve([out, back], side, leaves, MAX_DEPTH, found);
        }
    }
}

/// The zero between two points whose sides differ.
fn crossing([mut from, mut to]: [DVec2; 2], side: &impl Fn(DVec2) -> f64) -> DVec2 {
    let sign = side(from) > 0.0;
    for _ in 0..HALVINGS {
        let middle = from.midpoint(to);
        if (side(middle) > 0.0) == sign { from = middle } else { to = middle }
    }
    from.midpoint(to)
}

/// Halves a piece of the curve between two points of it until chords are near to it.
fn halve(ends: [DVec2; 2], side: &impl Fn(DVec2) -> f64, leaves: f64, depth: usize, found: &mut Vec<[DVec2; 2]>) {
    let middle = ends[0].midpoint(ends[1]);
    let across = (ends[1] - ends[0]).perp();
    let sign = side(middle) > 0.0;
    let mut reached = [middle; 2];
    let mut on_curve = None;
    'searched: for share in SEARCHED {
        for (i, direction) in [across, -across].into_iter().enumerate() {
            let next = middle + share * direction;
            if (side(next) > 0.0) != sign {
                on_curve = Some(crossing([reached[i], next], side));
                break 'searched;
            }
            reached[i] = next;
        }
    }
    match on_curve {
        // The curve is not where it is thought to be.
        None => {}
        Some(point) if depth > 0 && point.distance(middle) > leaves * across.length() => {
            halve([ends[0], point], side, leaves, depth - 1, found);
            halve([point, ends[1]], side, leaves, depth - 1, found);
        }
        Some(_) => found.push(ends),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn square() -> Vec<DVec2> {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(DVec2::from).to_vec()
    }

    fn length(chords: &[[DVec2; 2]]) -> f64 {
        chords.iter().map(|[from, to]| from.distance(*to)).sum()
    }

    #[test]
    fn a_circle_inside_is_closed() {
        let middle = DVec2::new(0.1, -0.2);
        let found = chords(&square(), Some(middle), |p| 0.6 - p.distance(middle), 0.02);
        assert!((30..70).contains(&found.len()), "{}", found.len());
        assert!((length(&found) / (1.2 * PI) - 1.0).abs() < 2e-3);
        assert!(found.iter().flatten().all(|end| (end.distance(middle) - 0.6).abs() < 1e-12));
    }

    #[test]
    fn a_small_circle_is_not_lost_between_points() {
        let found = chords(&square(), Some(DVec2::new(0.3, 0.4)), |p| 1e-3 - p.distance(DVec2::new(0.3, 0.4)), 0.02);
        assert!((length(&found) / (2e-3 * PI) - 1.0).abs() < 3e-3, "{}", length(&found));
    }

    #[test]
    fn a_circle_over_the_corners_is_cut_off() {
        // It leaves the square over each side.
        let found = chords(&square(), Some(DVec2::ZERO), |p| 1.2 - p.length(), 0.005);
        let beyond = (1.0_f64 / 1.2).acos();
        assert!((length(&found) - 1.2 * (2.0 * PI - 8.0 * beyond)).abs() < 1e-3, "{}", length(&found));
        assert!(found.iter().flatten().all(|end| end.abs().max_element() < 1.0 + 1e-9));
    }

    proptest! {
        #[test]
        fn a_line_is_one_chord(angle in 0.0..6.3_f64, offset in -0.9..0.9_f64) {
            let normal = DVec2::from_angle(angle);
            let found = chords(&square(), None, |p| normal.dot(p) - offset, 0.02);
            prop_assert_eq!(found.len(), 1);
            prop_assert!(found[0].iter().all(|end| (normal.dot(*end) - offset).abs() < 1e-12));
        }

        #[test]
        fn chords_leave_a_conic_by_little(a in 0.3..3.0_f64, b in -3.0..3.0_f64, c in -0.8..0.8_f64) {
            let conic = |p: DVec2| p.y - c - 0.3 * (a * p.x * p.x + b * p.x * p.y);
            for [from, to] in chords(&square(), None, conic, 0.02) {
                let across = 0.021 * (to - from).perp();
                let middle = from.midpoint(to);
                // Two branches may be so near to each other that both are crossed.
                let signs: Vec<bool> = (-10..=10).map(|i| conic(middle + 0.1 * f64::from(i) * across) > 0.0).collect();
                prop_assert!(signs.iter().any(|sign| *sign != signs[0]), "{a} {b} {c}: {from} {to}");
            }
        }
    }
}
