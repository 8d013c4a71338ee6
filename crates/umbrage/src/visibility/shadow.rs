//! The source minus its shadows, on the integer grid.
//!
//! Quick answers come from exact sign tests: a convex shadow that contains the whole source, and shadows that only touch
//! it or lie apart. The rest is left to the boolean engine of the crate `i_overlay` (Bentley-Ottmann style splitting
//! with integer arithmetic, fill by winding numbers): all shadows run counter-clockwise, so the non-zero rule makes their
//! union, and opposite copies of a shared edge cancel.
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

/// The contours of the source that no shadow covers.
pub(super) fn source_minus_shadows(source: &GridPolygon, shadows: &[GridPolygon]) -> Vec<GridPolygon> {
    let capacity = source.len() + shadows.iter().map(Vec::len).sum::<usize>();
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
    fn a_remnant_of_rounding_is_dropped_and_a_sliver_is_not() {
        let source = rectangle([-4, 4], [-4, 4]);
        let mut shadow = rectangle([-5, 5], [-5, 5]);
        (shadow[1].x, shadow[2].x) = (4 * STEP - 6, 4 * STEP - 6);
        assert!(source_minus_shadows(&source, std::slice::from_ref(&shadow)).is_empty());
        (shadow[1].x, shadow[2].x) = (4 * STEP - 60, 4 * STEP - 60);
        assert_eq!(source_minus_shadows(&source, &[shadow]).len(), 1);
    }
}
