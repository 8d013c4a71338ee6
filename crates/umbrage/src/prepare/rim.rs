//! Rims: how far what is shown goes on into area that is hidden.
//!
//! Where a wall stands on a floor, the floor beneath it is hidden and is not shown. A narrow strip of it stays beside the
//! edge and carries on the light of the visible side: a renderer that cannot tell apart two surfaces that only touch, by
//! its rounding of depths or of pixels, then shows the one as bright as the other, and nothing dark between them.
//!
//! ```text
//!   a ------------------- b    edge; above it the visible side
//!     \                 /
//!      q --------------- r     hidden area below
//! ```
//!
//! The strip narrows away from the edge, so that the strips of two edges that meet do not overlap; it is halved in width
//! until one of twice its width would lie inside the hidden piece that it belongs to.
//!
//! Holds after: no two strips of one side of a piece touch, so no vertex of one lies on a side of another.

use glam::DVec2;

/// The greatest width of a rim, as a share of the scene's extent: 1 cm in a room of 10 m. A renderer with 24 bits of
/// depth and a near plane at a thousandth of the farthest distance resolves a tenth of that.
pub(super) const RIM_OF_EXTENT: f64 = 1e-3;
/// How much shorter a rim is at each end of its far side, in widths. At 1 the rims of two edges at a right angle share a side.
pub(super) const TAPER: f64 = 1.25;
/// A piece has room for a strip so many times as wide: beyond 2, strips from opposite sides of it do not meet.
const ROOM_OF_WIDTH: f64 = 2.1;
/// A rim's edge is this many widths long at least.
const MIN_LENGTH_OF_WIDTH: f64 = 4.0;
/// A hidden piece that is narrower than the rim halved so often has none: vertices must stay farther apart than they are welded.
const MAX_HALVINGS: u8 = 7;

/// How often the width of a rim is halved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RimWidth(u8);

impl RimWidth {
    /// The width along the side `[from, to]` of a convex polygon whose corners run counter-clockwise; `None` where the
    /// polygon is too narrow.
    pub(super) fn along([from, to]: [DVec2; 2], polygon: &[DVec2], extent_m: f64) -> Option<Self> {
        let length_m = from.distance(to);
        let along = (to - from).try_normalize()?;
        let inside = |p: DVec2| {
            let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
            sides.into_iter().all(|(&a, &b)| (b - a).perp_dot(p - a) >= 0.0)
        };
        (0..=MAX_HALVINGS).map(Self).find(|width| {
            let width_m = width.width_m(extent_m);
            let room_m = ROOM_OF_WIDTH * width_m;
            let far = room_m * along.perp();
            let ends = [from + TAPER * room_m * along + far, to - TAPER * room_m * along + far];
            length_m >= MIN_LENGTH_OF_WIDTH * width_m && ends.into_iter().all(inside)
        })
    }

    /// The width in metres, in a scene of this extent.
    pub(super) fn width_m(self, extent_m: f64) -> f64 {
        RIM_OF_EXTENT * extent_m * 0.5_f64.powi(i32::from(self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn width_m(polygon: &[[f64; 2]]) -> Option<f64> {
        let polygon: Vec<DVec2> = polygon.iter().copied().map(DVec2::from).collect();
        RimWidth::along([polygon[0], polygon[1]], &polygon, 1000.0).map(|width| width.width_m(1000.0))
    }

    #[test]
    fn a_rim_is_as_wide_as_its_piece_allows() {
        assert_eq!(width_m(&[[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]]), Some(1.0));
        assert_eq!(width_m(&[[0.0, 0.0], [9.0, 0.0], [9.0, 2.0], [0.0, 2.0]]), Some(0.5));
        assert_eq!(width_m(&[[0.0, 0.0], [3.0, 0.0], [3.0, 9.0], [0.0, 9.0]]), Some(0.5));
        // Where the corner rises by 1 in 2, the strip's end lies inside at any width; by 1 in 1.2 at none.
        assert_eq!(width_m(&[[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]]), Some(1.0));
        assert_eq!(width_m(&[[0.0, 0.0], [9.0, 0.0], [9.0, 6.0]]), None);
        assert_eq!(width_m(&[[0.0, 0.0], [9.0, 0.0], [9.0, 1e-4], [0.0, 1e-4]]), None);
    }
}
