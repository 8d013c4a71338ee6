//! The source minus its shadows, on the integer grid.
//!
//! Quick answers come from exact sign tests: a convex shadow that contains the whole source, and shadows that only touch
//! it or lie apart. The rest is left to the boolean engine of the crate `i_overlay` (Bentley-Ottmann style splitting
//! with integer arithmetic, fill by winding numbers): all shadows run counter-clockwise, so the non-zero rule makes their
//! union, and opposite copies of a shared edge cancel.
//!
//! The engine's time grows with the square of the number of shadows, and most of a source behind many occluders is
//! behind one of them alone. So a source with many shadows is halved until its parts have few: most parts turn out to be
//! covered, or clear.
//!
//! Holds after: contours of what is left, outer ones counter-clockwise, holes clockwise; regions that are no wider than
//! the engine's rounding are left out.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::i_float::int::point::IntPoint;

use super::project::{GridPolygon, doubled_area};

/// A region whose area is at most this many grid steps times its perimeter is rounding: it is at most eight steps wide,
/// 3e-8 of the source, where the engine moves crossings by one or two.
const THIN_STEPS: f64 = 4.0;

/// How much of a source a shadow takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cover {
    /// Certainly nothing.
    None,
    /// Something, perhaps.
    Some,
    /// All.
    All,
}

/// Positive where `r` lies to the left of the line from `p` to `q`; exact for grid points inside the window.
fn turn(p: IntPoint<i32>, q: IntPoint<i32>, r: IntPoint<i32>) -> i64 {
    let d = |s: i32, t: i32| i64::from(s) - i64::from(t);
    d(q.x, p.x) * d(r.y, p.y) - d(q.y, p.y) * d(r.x, p.x)
}

/// Sides of a polygon on the grid that have a length.
fn sides(polygon: &[IntPoint<i32>]) -> impl Iterator<Item = (IntPoint<i32>, IntPoint<i32>)> + '_ {
    (0..polygon.len()).map(|i| (polygon[i], polygon[(i + 1) % polygon.len()])).filter(|(p, q)| p != q)
}

/// What a counter-clockwise shadow does to a convex source.
pub(super) fn cover(shadow: &[IntPoint<i32>], source: &[IntPoint<i32>]) -> Cover {
    let mut contains = true;
    for (p, q) in sides(shadow) {
        contains &= source.iter().all(|&r| turn(p, q, r) >= 0);
    }
    if contains {
        return Cover::All;
    }
    let apart = sides(source).any(|(p, q)| shadow.iter().all(|&r| turn(p, q, r) <= 0));
    if apart { Cover::None } else { Cover::Some }
}

/// A part of the source with more shadows than this is halved: the time that cutting takes grows with the square.
pub(crate) const FEW_SHADOWS: usize = 12;
/// Parts are halved at most this often: 1/64 of the source each way.
const MOST_HALVINGS: usize = 12;

/// The contours of the source that no shadow covers.
pub(super) fn source_minus_shadows(source: &GridPolygon, shadows: &[GridPolygon]) -> Vec<GridPolygon> {
    let mut lit = Vec::new();
    take_shadows(source, &shadows.iter().collect::<Vec<_>>(), 0, &mut lit);
    lit
}

/// Adds the contours of a part of the source, of which each of `shadows` takes something, that none of them covers.
fn take_shadows(source: &GridPolygon, shadows: &[&GridPolygon], halvings: usize, lit: &mut Vec<GridPolygon>) {
    if shadows.is_empty() {
        lit.push(source.clone());
    } else if shadows.len() <= FEW_SHADOWS || halvings >= MOST_HALVINGS {
        lit.extend(difference(source, shadows));
    } else {
        for part in halves(source) {
            let covers: Vec<Cover> = shadows.iter().map(|shadow| cover(shadow, &part)).collect();
            if !part.is_empty() && !covers.contains(&Cover::All) {
                let touching = shadows.iter().zip(covers).filter(|(_, cover)| *cover == Cover::Some);
                let touching: Vec<&GridPolygon> = touching.map(|(shadow, _)| *shadow).collect();
                take_shadows(&part, &touching, halvings + 1, lit);
            }
        }
    }
}

/// A convex polygon cut across its longer axis; empty where a half has no area.
fn halves(polygon: &[IntPoint<i32>]) -> [GridPolygon; 2] {
    let bounds = |of: fn(&IntPoint<i32>) -> i32| {
        let values = || polygon.iter().map(of);
        (values().min().unwrap_or(0), values().max().unwrap_or(0))
    };
    let (x, y) = (bounds(|p| p.x), bounds(|p| p.y));
    let middle = |(lo, hi): (i32, i32)| ((i64::from(lo) + i64::from(hi)) / 2) as i32;
    let wide = i64::from(x.1) - i64::from(x.0) >= i64::from(y.1) - i64::from(y.0);
    let at = if wide { middle(x) } else { middle(y) };
    [-1, 1].map(|sign| {
        let height = |p: IntPoint<i32>| sign * (i64::from(if wide { p.x } else { p.y }) - i64::from(at));
        let mut half = GridPolygon::new();
        for (p, q) in sides(polygon) {
            let (from, to) = (height(p), height(q));
            if from >= 0 {
                half.push(p);
            }
            if (from < 0 && to > 0) || (from > 0 && to < 0) {
                half.push(crossing(p, q, at, wide));
            }
        }
        if doubled_area(&half) > 0 { half } else { GridPolygon::new() }
    })
}

/// The grid point next to where the side from `p` to `q` meets the line `x = at`, or `y = at` where not `wide`.
fn crossing(p: IntPoint<i32>, q: IntPoint<i32>, at: i32, wide: bool) -> IntPoint<i32> {
    let along = |from: i32, to: i32, other_from: i32, other_to: i32| {
        let t = (f64::from(at) - f64::from(from)) / (f64::from(to) - f64::from(from));
        (f64::from(other_from) + t * (f64::from(other_to) - f64::from(other_from))).round() as i32
    };
    // From the lesser end, so that both halves get the same point.
    let (p, q) = if (p.x, p.y) <= (q.x, q.y) { (p, q) } else { (q, p) };
    if wide { IntPoint::new(at, along(p.x, q.x, p.y, q.y)) } else { IntPoint::new(along(p.y, q.y, p.x, q.x), at) }
}

/// The contours of a part of the source that no shadow covers, by the boolean engine.
fn difference(source: &GridPolygon, shadows: &[&GridPolygon]) -> Vec<GridPolygon> {
    let capacity = source.len() + shadows.iter().map(|shadow| shadow.len()).sum::<usize>();
    let mut overlay = Overlay::<i32>::new(capacity);
    overlay.add_contour(source, ShapeType::Subject);
    for shadow in shadows {
        overlay.add_contour(shadow, ShapeType::Clip);
    }
    let shapes = overlay.overlay(OverlayRule::Difference, FillRule::NonZero);
    shapes.into_iter().filter(|shape| !is_thin(shape)).flatten().collect()
}

/// Whether a region with its holes is no wider than rounding.
fn is_thin(contours: &[GridPolygon]) -> bool {
    let area = 0.5 * contours.iter().map(|c| doubled_area(c)).sum::<i128>() as f64;
    let length = |(p, q): (IntPoint<i32>, IntPoint<i32>)| {
        f64::hypot(f64::from(q.x) - f64::from(p.x), f64::from(q.y) - f64::from(p.y))
    };
    let perimeter: f64 = contours.iter().flat_map(|c| sides(c)).map(length).sum();
    area <= THIN_STEPS * perimeter
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: i32 = 1 << 24;

    fn rectangle(x: [i32; 2], y: [i32; 2]) -> GridPolygon {
        [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
            .map(|(x, y)| IntPoint::new(x * STEP, y * STEP))
            .to_vec()
    }

    fn area(contours: &[GridPolygon]) -> f64 {
        let step = f64::from(STEP);
        0.5 * contours.iter().map(|c| doubled_area(c)).sum::<i128>() as f64 / (step * step)
    }

    #[test]
    fn covers_are_told_apart() {
        let source = rectangle([-4, 4], [-4, 4]);
        assert_eq!(cover(&rectangle([-4, 4], [-4, 5]), &source), Cover::All);
        assert_eq!(cover(&rectangle([4, 8], [-4, 5]), &source), Cover::None);
        assert_eq!(cover(&rectangle([3, 8], [-4, 5]), &source), Cover::Some);
    }

    #[test]
    fn a_shadow_inside_makes_a_hole() {
        let source = rectangle([-4, 4], [-4, 4]);
        let lit = source_minus_shadows(&source, &[rectangle([-1, 1], [-1, 2])]);
        assert_eq!(lit.len(), 2);
        assert_eq!(area(&lit), 64.0 - 6.0);
    }

    #[test]
    fn shadows_that_share_an_edge_leave_no_hairline() {
        let source = rectangle([-4, 4], [-4, 4]);
        let skew = [IntPoint::new(-5 * STEP, -5 * STEP), IntPoint::new(STEP / 3, 5 * STEP)];
        let left = vec![skew[0], skew[1], IntPoint::new(-5 * STEP, 5 * STEP)];
        let right = vec![skew[0], IntPoint::new(5 * STEP, -5 * STEP), IntPoint::new(5 * STEP, 5 * STEP), skew[1]];
        assert!(source_minus_shadows(&source, &[left, right]).is_empty());
    }

    #[test]
    fn many_shadows_leave_what_few_big_ones_do() {
        // A chessboard of 16 x 16 shadows, of which the black fields are left.
        let source = rectangle([-4, 4], [-4, 4]);
        let field = 1 << 23;
        let shadows: Vec<GridPolygon> = (0..256)
            .filter(|i| (i / 16 + i % 16) % 2 == 0)
            .map(|i| {
                let (x, y) = ((i % 16 - 8) * field, (i / 16 - 8) * field);
                [(x, y), (x + field, y), (x + field, y + field), (x, y + field)]
                    .map(|(x, y)| IntPoint::new(x, y))
                    .to_vec()
            })
            .collect();
        assert!((area(&source_minus_shadows(&source, &shadows)) - 32.0).abs() < 1e-6);
        let whole: Vec<GridPolygon> = shadows
            .iter()
            .cloned()
            .chain(shadows.iter().map(|s| s.iter().map(|p| IntPoint::new(-p.x, p.y)).rev().collect()))
            .collect();
        assert!(source_minus_shadows(&source, &whole).is_empty(), "the mirrored board covers the rest, exactly");
    }

    #[test]
    fn halves_lose_nothing() {
        let skew = vec![IntPoint::new(-7, -100), IntPoint::new(90, -31), IntPoint::new(55, 77)];
        let parts = halves(&skew);
        let sum: i128 = parts.iter().map(|part| doubled_area(part)).sum();
        assert!((sum - doubled_area(&skew)).abs() < 200, "but for rounding of the cut");
        assert!(parts.iter().all(|part| !part.is_empty()));
    }

    #[test]
    fn a_remnant_of_rounding_is_dropped_and_a_sliver_is_not() {
        let source = rectangle([-4, 4], [-4, 4]);
        let mut shadow = rectangle([-5, 5], [-5, 5]);
        (shadow[1].x, shadow[2].x) = (4 * STEP - 6, 4 * STEP - 6);
        assert!(source_minus_shadows(&source, std::slice::from_ref(&shadow)).is_empty());
        (shadow[1].x, shadow[2].x) = (4 * STEP - 60, 4 * STEP - 60);
        assert_eq!(source_minus_shadows(&source, &[shadow]).len(), 1);
    }
}
