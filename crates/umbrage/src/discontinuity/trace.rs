//! Tracing a wedge: which faces receive its rays, by a sweep over the directions of the wedge.
//!
//! Between two consecutive ends of pieces the order of the pieces along the rays does not change (surfaces meet in
//! edges only). There a ray is stopped where something hides the occluder feature from the source feature; otherwise
//! the nearest piece beyond receives it, if its front is turned to the ray.
//!
//! Several faces may be at the nearest place: the two sides of a sheet, or the touching sides of two bodies. They lie in
//! one plane, and a ray meets a plane once, so their order along the ray is rounding. The one of them that shows light
//! receives the ray.
//!
//! A face that only touches the wedge's plane lets rays graze past; two that touch it from both sides at the same place
//! are a ridge, and stop them.

use super::wedge::{Crossing, Piece};
use crate::id::{FaceId, PlaneId};

/// Pieces this close in nearness, relative to it, are at the same place.
const SAME_PLACE: f64 = 1e-6;
/// Directions closer than this are one.
const SAME_DIRECTION: f64 = 1e-9;

/// An interval of directions that one face receives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Received {
    pub(super) face: FaceId,
    /// Directions of its ends, ascending.
    pub(super) s: [f64; 2],
    /// Nearness at its ends.
    pub(super) nearness: [f64; 2],
}

impl Received {
    /// The part inside an interval of directions.
    pub(super) fn clipped(&self, [from, to]: [f64; 2]) -> Option<Self> {
        let at = |s: f64| {
            let t = (s - self.s[0]) / (self.s[1] - self.s[0]);
            self.nearness[0] + t * (self.nearness[1] - self.nearness[0])
        };
        let s = [self.s[0].max(from), self.s[1].min(to)];
        (s[0] < s[1]).then(|| Self { s, nearness: s.map(at), ..*self })
    }
}

/// The part of `pieces` that is nearer than `than`, or farther.
pub(super) fn part_at(pieces: &[Piece], than: f64, nearer: bool) -> Vec<Piece> {
    let (least, most) =
        if nearer { (than * (1.0 + SAME_PLACE), f64::INFINITY) } else { (0.0, than * (1.0 - SAME_PLACE)) };
    let inside = |n: f64| n > least && n < most;
    pieces
        .iter()
        .filter_map(|piece| {
            let [n0, n1] = piece.nearness;
            if inside(n0) && inside(n1) {
                return Some(*piece);
            }
            let bound = if nearer { least } else { most };
            let at = piece.s[0] + (piece.s[1] - piece.s[0]) * (bound - n0) / (n1 - n0);
            let cut = if inside(n0) {
                Piece { s: [piece.s[0], at], nearness: [n0, bound], ..*piece }
            } else if inside(n1) {
                Piece { s: [at, piece.s[1]], nearness: [bound, n1], ..*piece }
            } else {
                return None;
            };
            (cut.s[1] - cut.s[0] > SAME_DIRECTION).then_some(cut)
        })
        .collect()
}

/// The faces that receive the rays of a wedge: those that no piece in `hiding` stops, at the nearest of `beyond`.
/// Whether a face's front is turned to the apex is told by `lit`, and in which plane it lies by `plane`. Ascending in
/// direction.
pub(super) fn received(
    hiding: &[Piece],
    beyond: &[Piece],
    lit: impl Fn(FaceId) -> bool,
    plane: impl Fn(FaceId) -> PlaneId,
) -> Vec<Received> {
    let mut ends: Vec<f64> = hiding.iter().chain(beyond).flat_map(|piece| piece.s).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup_by(|next, kept| *next - *kept < SAME_DIRECTION);
    let mut result: Vec<Received> = Vec::new();
    let mut last_piece = usize::MAX;
    for pair in ends.windows(2) {
        let middle = 0.5 * (pair[0] + pair[1]);
        if is_stopped(hiding, middle) {
            continue;
        }
        let Some(stop) = first_stop(beyond, middle) else { continue };
        let receives = |piece: &Piece| {
            piece.crossing == Crossing::Through && stop.is_at(beyond, piece, middle, &plane) && lit(piece.face)
        };
        let Some(number) = beyond.iter().position(receives) else { continue };
        let piece = &beyond[number];
        let nearness = [piece.nearness_at(pair[0]), piece.nearness_at(pair[1])];
        match result.last_mut().filter(|last| last_piece == number && last.s[1] == pair[0]) {
            Some(last) => {
                last.s[1] = pair[1];
                last.nearness[1] = nearness[1];
            }
            None => result.push(Received { face: piece.face, s: [pair[0], pair[1]], nearness }),
        }
        last_piece = number;
    }
    result
}

/// Whether one of `pieces` stops a ray in direction `s`.
pub(super) fn is_stopped(pieces: &[Piece], s: f64) -> bool {
    first_stop(pieces, s).is_some()
}

/// Where a ray is stopped first.
struct Stop {
    nearness: f64,
    /// Numbers of the pieces that stop it: one that goes through, or the two of a ridge.
    pieces: [usize; 2],
}

impl Stop {
    /// Whether a piece is at the same place in direction `s`: by its nearness, or in the plane of what stops the ray.
    fn is_at(&self, pieces: &[Piece], piece: &Piece, s: f64, plane: impl Fn(FaceId) -> PlaneId) -> bool {
        piece.nearness_in(s).is_some_and(|nearness| {
            (nearness - self.nearness).abs() <= SAME_PLACE * self.nearness
                || self.pieces.iter().any(|&own| plane(pieces[own].face) == plane(piece.face))
        })
    }
}

/// What stops a ray in direction `s` first: the nearest piece that goes through, or a ridge before it.
fn first_stop(pieces: &[Piece], s: f64) -> Option<Stop> {
    let of = |crossing: Crossing| {
        let here = move |(i, piece): (usize, &Piece)| {
            let nearness = piece.nearness_in(s).filter(|_| piece.crossing == crossing)?;
            Some((nearness, i))
        };
        pieces.iter().enumerate().filter_map(here)
    };
    let nearest = |best: Stop, next: Stop| if next.nearness > best.nearness { next } else { best };
    let through = of(Crossing::Through)
        .filter(|found| found.0 > 0.0)
        .map(|(nearness, i)| Stop { nearness, pieces: [i; 2] })
        .reduce(nearest);
    let wall = through.as_ref().map_or(0.0, |stop| stop.nearness);
    let ridge = of(Crossing::Front)
        .filter(|found| found.0 > wall)
        .filter_map(|(nearness, i)| {
            let (_, back) = of(Crossing::Back).find(|back| (back.0 - nearness).abs() <= SAME_PLACE * nearness)?;
            Some(Stop { nearness, pieces: [i, back] })
        })
        .reduce(nearest);
    ridge.or(through)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(face: usize, s: [f64; 2], nearness: [f64; 2]) -> Piece {
        Piece { face: FaceId::from(face), crossing: Crossing::Through, s, nearness }
    }

    /// No two faces lie in one plane.
    fn own_plane(face: FaceId) -> PlaneId {
        PlaneId::from(face.index())
    }

    /// Faces 2 i and 2 i + 1 are the two sides of sheet i.
    fn plane_of_sheet(face: FaceId) -> PlaneId {
        PlaneId::from(face.index() / 2)
    }

    #[test]
    fn the_nearest_face_receives_and_the_rest_is_in_its_shadow() {
        let beyond = [piece(0, [0.0, 1.0], [0.2, 0.2]), piece(1, [0.25, 0.5], [0.4, 0.4])];
        let faces: Vec<_> = received(&[], &beyond, |_| true, own_plane).iter().map(|r| (r.face.index(), r.s)).collect();
        assert_eq!(faces, [(0, [0.0, 0.25]), (1, [0.25, 0.5]), (0, [0.5, 1.0])]);
    }

    #[test]
    fn what_hides_the_occluder_stops_its_shadow() {
        let hiding = [piece(7, [0.5, 0.75], [2.0, 2.0])];
        let beyond = [piece(0, [0.0, 1.0], [0.2, 0.2])];
        let s: Vec<_> = received(&hiding, &beyond, |_| true, own_plane).iter().map(|r| r.s).collect();
        assert_eq!(s, [[0.0, 0.5], [0.75, 1.0]]);
    }

    #[test]
    fn a_back_stops_rays_and_receives_none() {
        let beyond = [piece(0, [0.0, 1.0], [0.2, 0.2]), piece(1, [0.0, 1.0], [0.4, 0.4])];
        assert!(received(&[], &beyond, |face| face.index() == 0, own_plane).is_empty());
    }

    #[test]
    fn of_the_two_sides_of_a_sheet_the_lit_one_receives_whichever_rounding_puts_first() {
        // A grazing wedge magnifies rounding: here to much more than what counts as one place.
        for rounding in [-1e-4, -1e-16, 0.0, 1e-16, 1e-4] {
            let sheet = [[0.2, 0.3], [0.2 + rounding, 0.3 - rounding]];
            for lit in 0..2 {
                for numbers in [[0, 1], [1, 0]] {
                    let beyond = numbers.map(|i| piece(i, [0.0, 1.0], sheet[i]));
                    let found = received(&[], &beyond, |face| face.index() == lit, plane_of_sheet);
                    let faces: Vec<_> = found.iter().map(|part| (part.face.index(), part.s)).collect();
                    assert_eq!(faces, [(lit, [0.0, 1.0])], "{rounding} {numbers:?}");
                }
            }
        }
    }

    #[test]
    fn two_sheets_stay_two() {
        // The farther one is lit, the nearer one has its back to the light: it still hides the other.
        let beyond = [piece(0, [0.0, 1.0], [0.2, 0.2]), piece(2, [0.0, 0.5], [0.4, 0.4])];
        let found = received(&[], &beyond, |face| face.index() == 0, plane_of_sheet);
        assert_eq!(found.iter().map(|part| part.s).collect::<Vec<_>>(), [[0.5, 1.0]]);
    }

    #[test]
    fn a_ridge_of_a_sheets_other_side_does_not_keep_light_from_this_side() {
        // The back is cut along the wedge's plane, the front is not.
        let front = Piece { crossing: Crossing::Front, ..piece(1, [0.0, 1.0], [0.2 + 1e-9, 0.2]) };
        let back = Piece { crossing: Crossing::Back, ..front };
        let beyond = [front, back, piece(0, [0.0, 1.0], [0.2, 0.2])];
        let found = received(&[], &beyond, |face| face.index() == 0, plane_of_sheet);
        assert_eq!(found.iter().map(|part| (part.face.index(), part.s)).collect::<Vec<_>>(), [(0, [0.0, 1.0])]);
    }

    #[test]
    fn rays_graze_a_touching_face_but_not_a_ridge() {
        let front = Piece { crossing: Crossing::Front, ..piece(1, [0.0, 1.0], [0.4, 0.4]) };
        let back = Piece { crossing: Crossing::Back, ..piece(2, [0.5, 1.0], [0.4, 0.4]) };
        let floor = piece(0, [0.0, 1.0], [0.2, 0.2]);
        assert_eq!(received(&[], &[floor, front], |_| true, own_plane)[0].s, [0.0, 1.0]);
        assert_eq!(received(&[], &[floor, front, back], |_| true, own_plane)[0].s, [0.0, 0.5]);
    }

    #[test]
    fn a_piece_through_the_occluder_is_cut_there() {
        let slanted = [piece(3, [0.0, 1.0], [0.5, 1.5])];
        let beyond = part_at(&slanted, 1.0, false);
        let hiding = part_at(&slanted, 1.0, true);
        assert!((beyond[0].s[1] - 0.5).abs() < 1e-5 && (hiding[0].s[0] - 0.5).abs() < 1e-5);
    }
}
