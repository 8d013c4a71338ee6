//! What a point sees of a patch, where that is not all of it: an outline less shadows, cut again and again.
//!
//! Most pieces lie wholly on one side of a cut, and go to that part as they are. So pieces are kept in one place with what
//! is known of them, and parts are lists of their numbers.

use glam::DVec2;
use smallvec::SmallVec;

use crate::geometry::convex::{self, Convex, Line, Moments};
use crate::geometry::polygon;
use crate::transport::form_factor::factor_in_view;
use crate::visibility::PlaneView;

/// A part of which less than this share is lit is dark: cuts of patches are rounded to vertices of the output.
const LIT_OF_PART: f64 = 1e-6;
/// Corners nearer to a cut than this share of the height of the point over the plane lie on it.
const SLACK_OF_HEIGHT: f64 = 1e-9;

/// A convex piece of an outline or of a shadow.
#[derive(Debug)]
struct Piece {
    corners_m: Convex,
    area_m2: f64,
    /// Lambert's factor of the point that it is seen from.
    factor: f64,
}

/// The pieces of what a point sees in a plane.
#[derive(Debug)]
pub(super) struct Pieces<'a> {
    pub(super) view: &'a PlaneView,
    pieces: Vec<Piece>,
}

/// What is seen of a patch: the numbers of its outline and of what of it is in shadow.
#[derive(Clone, Debug)]
pub(super) struct Part {
    outline: usize,
    shadows: SmallVec<[usize; 8]>,
}

impl<'a> Pieces<'a> {
    pub(super) fn new(view: &'a PlaneView) -> Self {
        Self { view, pieces: Vec::with_capacity(16) }
    }

    fn push(&mut self, corners_m: Convex) -> usize {
        let (area_m2, factor) = (polygon::signed_area_2d_m2(&corners_m), factor_in_view(self.view, &corners_m));
        self.pieces.push(Piece { corners_m, area_m2, factor });
        self.pieces.len() - 1
    }

    /// An outline less shadows inside it, which do not overlap.
    pub(super) fn part(&mut self, outline: Convex, shadows: Vec<Convex>) -> Part {
        Part { outline: self.push(outline), shadows: shadows.into_iter().map(|shadow| self.push(shadow)).collect() }
    }

    /// Lambert's factor of what is seen.
    pub(super) fn factor(&self, part: &Part) -> f64 {
        self.pieces[part.outline].factor - part.shadows.iter().map(|&shadow| self.pieces[shadow].factor).sum::<f64>()
    }

    /// The share that is in shadow.
    pub(super) fn dark_share(&self, part: &Part) -> f64 {
        part.shadows.iter().map(|&shadow| self.pieces[shadow].area_m2).sum::<f64>() / self.pieces[part.outline].area_m2
    }

    /// Area and moments of what is seen.
    pub(super) fn moments(&self, part: &Part) -> Moments {
        let moments = |piece: usize| Moments::of(&self.pieces[piece].corners_m);
        part.shadows.iter().fold(moments(part.outline), |left, &shadow| left - moments(shadow))
    }

    /// The outline's corners.
    pub(super) fn outline_m(&self, part: &Part) -> &[DVec2] {
        &self.pieces[part.outline].corners_m
    }

    /// The parts to the left and the right of a line; `None` where nothing of one is lit.
    pub(super) fn halves(&mut self, part: &Part, line: &Line) -> [Option<Part>; 2] {
        let mut halves = self
            .cut(part.outline, line)
            .map(|outline| outline.map(|outline| Part { outline, shadows: SmallVec::new() }));
        for &shadow in &part.shadows {
            for (half, piece) in halves.iter_mut().zip(self.cut(shadow, line)) {
                if let Some(half) = half {
                    half.shadows.extend(piece);
                }
            }
        }
        halves.map(|half| half.filter(|half| self.dark_share(half) < 1.0 - LIT_OF_PART))
    }

    /// The numbers of the pieces of a piece to the left and the right of a line.
    fn cut(&mut self, number: usize, line: &Line) -> [Option<usize>; 2] {
        let slack_m = SLACK_OF_HEIGHT * self.view.height_m;
        let whole = &self.pieces[number];
        let (low_m, high_m) = convex::heights_m(&whole.corners_m, line);
        if low_m >= -slack_m {
            return [(high_m > slack_m).then_some(number), None];
        }
        if high_m <= slack_m {
            return [None, Some(number)];
        }
        let (area_m2, factor) = (whole.area_m2, whole.factor);
        let [left, right] = convex::halves(&whole.corners_m, line, slack_m);
        let left = self.push(left);
        let (of_left_m2, of_left) = (self.pieces[left].area_m2, self.pieces[left].factor);
        self.pieces.push(Piece { corners_m: right, area_m2: area_m2 - of_left_m2, factor: factor - of_left });
        [Some(left), Some(left + 1)]
    }
}

impl Part {
    /// Whether nothing of the outline is in shadow.
    pub(super) fn is_clear(&self) -> bool {
        self.shadows.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn halves_make_up_the_part(x in -1.0..1.0, y in -1.0..1.0, angle in 0.0..6.3, a in -2.0..1.0, b in -2.0..1.0) {
            let view = PlaneView { foot_m: DVec2::new(x, y), height_m: 1.0, normal: -DVec3::Z };
            let square = |low: DVec2, size: f64| -> Convex {
                [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|corner| low + size * corner).into_iter().collect()
            };
            let shadows = vec![square(DVec2::new(a, b), 0.9), square(DVec2::new(a + 0.9, b), 0.1)];
            let mut pieces = Pieces::new(&view);
            let part = pieces.part(square(DVec2::splat(-2.0), 4.0), shadows);
            let line = Line::through(DVec2::new(0.1, 0.2), DVec2::new(0.1, 0.2) + DVec2::from_angle(angle));
            let halves = pieces.halves(&part, &line);
            let sum: f64 = halves.iter().flatten().map(|half| pieces.factor(half)).sum();
            prop_assert!((sum - pieces.factor(&part)).abs() < 1e-12);
            let area: f64 = halves.iter().flatten().map(|half| pieces.moments(half).area_m2).sum();
            prop_assert!((area - (16.0 - 0.81 - 0.01)).abs() < 1e-9);
        }
    }

    #[test]
    fn what_is_covered_is_no_part() {
        let view = PlaneView { foot_m: DVec2::ZERO, height_m: 1.0, normal: -DVec3::Z };
        let rectangle = convex::fixture::rectangle;
        let shadows = vec![rectangle([-1.0, 0.0], [-1.0, 0.5]), rectangle([-1.0, 0.0], [0.5, 1.0])];
        let mut pieces = Pieces::new(&view);
        let part = pieces.part(rectangle([-1.0, 1.0], [-1.0, 1.0]), shadows);
        let [left, right] = pieces.halves(&part, &Line::through(DVec2::ZERO, DVec2::Y));
        assert!(left.is_none() && right.is_some_and(|right| right.is_clear()));
    }
}
