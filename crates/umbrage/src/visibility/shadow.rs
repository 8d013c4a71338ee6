//! Shadows that overlap, made into convex parts that do not.
//!
//! What one shadow leaves of another is convex parts again; their number grows with the square of the number of
//! shadows, and most of a source behind many occluders is behind one of them alone. So a source with many shadows is
//! halved until its parts have few: most parts turn out to be covered, or clear.

use glam::DVec2;

use crate::geometry::convex::{self, Convex};
use crate::geometry::polygon;

/// Convex parts of a source that do not overlap.
pub type Shadows = Vec<Convex>;

/// A part of the source with more shadows than this is halved: the time that cutting takes grows with the square.
const FEW_SHADOWS: usize = 12;
/// Parts are halved at most this often: 1/64 of the source each way.
const MOST_HALVINGS: usize = 12;

/// Lengths and areas that are rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rounding {
    /// Nearer than this, points lie on a line.
    pub(super) slack_m: f64,
    /// Regions of this area or less are nothing.
    pub(super) thin_m2: f64,
}

/// The union of `shadows`, which lie inside `outline`, as parts that do not overlap.
pub(super) fn without_overlap(outline: &[DVec2], shadows: Shadows, rounding: Rounding) -> Shadows {
    let mut parts = Shadows::new();
    if shadows.len() <= 1 {
        return shadows;
    }
    add_parts(outline, shadows, rounding, 0, &mut parts);
    parts
}

fn add_parts(outline: &[DVec2], shadows: Shadows, rounding: Rounding, halvings: usize, parts: &mut Shadows) {
    let Rounding { slack_m, thin_m2 } = rounding;
    if shadows.len() <= FEW_SHADOWS || halvings >= MOST_HALVINGS {
        let first = parts.len();
        for shadow in shadows {
            let mut left: Shadows = vec![shadow];
            for taken in &parts[first..] {
                let before = std::mem::take(&mut left);
                before.into_iter().for_each(|part| convex::difference(part, taken, slack_m, &mut left));
            }
            parts.extend(left);
        }
        return;
    }
    let [low_m, high_m] = convex::bounds_m(outline);
    let line = convex::across(low_m, high_m);
    let halves = convex::halves(outline, &line, slack_m);
    let mut of_halves = [Shadows::new(), Shadows::new()];
    for shadow in &shadows {
        for (of_half, part) in of_halves.iter_mut().zip(convex::halves(shadow, &line, slack_m)) {
            if polygon::signed_area_2d_m2(&part) > thin_m2 {
                of_half.push(part);
            }
        }
    }
    for (half, shadows) in halves.into_iter().zip(of_halves) {
        let most_m2 = polygon::signed_area_2d_m2(&half) - thin_m2;
        if shadows.iter().any(|shadow| polygon::signed_area_2d_m2(shadow) >= most_m2) {
            parts.push(half);
        } else {
            add_parts(&half, shadows, rounding, halvings + 1, parts);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::convex::fixture::rectangle;

    const ROUNDING: Rounding = Rounding { slack_m: 1e-9, thin_m2: 1e-9 };

    fn area_m2(parts: &[Convex]) -> f64 {
        parts.iter().map(|part| polygon::signed_area_2d_m2(part)).sum()
    }

    #[test]
    fn common_parts_count_once() {
        let source = rectangle([-4.0, 4.0], [-4.0, 4.0]);
        let shadows = [rectangle([-1.0, 1.0], [-1.0, 2.0]), rectangle([0.0, 3.0], [0.0, 1.0])];
        let parts = without_overlap(&source, shadows.into_iter().collect(), ROUNDING);
        assert!((area_m2(&parts) - (6.0 + 3.0 - 1.0)).abs() < 1e-12);
    }

    #[test]
    fn many_shadows_cover_what_few_big_ones_do() {
        // A chessboard of 16 x 16 shadows, every one of them twice.
        let source = rectangle([-4.0, 4.0], [-4.0, 4.0]);
        let field = |i: i32| {
            let (x, y) = (0.5 * f64::from(i % 16) - 4.0, 0.5 * f64::from(i / 16) - 4.0);
            rectangle([x, x + 0.5], [y, y + 0.5])
        };
        let black = || (0..256).filter(|i| (i / 16 + i % 16) % 2 == 0).map(field);
        let parts = without_overlap(&source, black().chain(black()).collect(), ROUNDING);
        assert!((area_m2(&parts) - 32.0).abs() < 1e-6);
        let all = without_overlap(&source, (0..256).map(field).collect(), ROUNDING);
        assert!((area_m2(&all) - 64.0).abs() < 1e-6);
    }
}
