//! Tracing a wedge: which faces receive its rays, by a sweep over the directions of the wedge.
//!
//! Between two consecutive ends of pieces the order of the pieces along the rays does not change (surfaces meet in
//! edges only). There a ray is stopped where something hides the occluder feature from the source feature; otherwise
//! the nearest piece beyond receives it, if its front is turned to the ray.
//!
//! A face that only touches the wedge's plane lets rays graze past; two that touch it from both sides at the same place
//! are a ridge, and stop them.

use super::wedge::{Crossing, Piece};
use crate::id::FaceId;

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
/// Whether a face's front is turned to the apex is told by `lit`. Ascending in direction.
pub(super) fn received(hiding: &[Piece], beyond: &[Piece], lit: impl Fn(FaceId) -> bool) -> Vec<Received> {
    let mut ends: Vec<f64> = hiding.iter().chain(beyond).flat_map(|piece| piece.s).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup_by(|next, kept| *next - *kept < SAME_DIRECTION);
    let mut result: Vec<Received> = Vec::new();
    let mut last_piece = usize::MAX;
    for pair in ends.windows(2) {
        let middle = 0.5 * (pair[0] + pair[1]);
        if first_stop(hiding, middle).is_some() {
            continue;
        }
        let Some(number) = first_stop(beyond, middle) else { continue };
        let piece = &beyond[number];
        if piece.crossing != Crossing::Through || !lit(piece.face) {
            continue;
        }
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

/// The piece that stops a ray in direction `s` first: the nearest that goes through, or a ridge before it.
fn first_stop(pieces: &[Piece], s: f64) -> Option<usize> {
    let here = |piece: &Piece| (piece.s[0] < s && s < piece.s[1]).then(|| piece.nearness_at(s));
    let nearest = |crossing: Crossing, nearer_than: f64| {
        pieces
            .iter()
            .enumerate()
            .filter(|(_, piece)| piece.crossing == crossing)
            .filter_map(|(i, piece)| here(piece).filter(|&n| n > nearer_than).map(|n| (n, i)))
            .reduce(|best, next| if next.0 > best.0 { next } else { best })
    };
    let through = nearest(Crossing::Through, 0.0);
    let wall = through.map_or(0.0, |(n, _)| n);
    let ridge = pieces
        .iter()
        .enumerate()
        .filter(|(_, piece)| piece.crossing == Crossing::Front)
        .filter_map(|(i, piece)| here(piece).filter(|&n| n > wall).map(|n| (n, i)))
        .filter(|&(n, _)| {
            pieces
                .iter()
                .filter(|piece| piece.crossing == Crossing::Back)
                .any(|piece| here(piece).is_some_and(|other| (other - n).abs() <= SAME_PLACE * n))
        })
        .reduce(|best, next| if next.0 > best.0 { next } else { best });
    ridge.or(through).map(|(_, i)| i)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(face: usize, s: [f64; 2], nearness: [f64; 2]) -> Piece {
        Piece { face: FaceId::from(face), crossing: Crossing::Through, s, nearness }
    }

    #[test]
    fn the_nearest_face_receives_and_the_rest_is_in_its_shadow() {
        let beyond = [piece(0, [0.0, 1.0], [0.2, 0.2]), piece(1, [0.25, 0.5], [0.4, 0.4])];
        let faces: Vec<_> = received(&[], &beyond, |_| true).iter().map(|r| (r.face.index(), r.s)).collect();
        assert_eq!(faces, [(0, [0.0, 0.25]), (1, [0.25, 0.5]), (0, [0.5, 1.0])]);
    }

    #[test]
    fn what_hides_the_occluder_stops_its_shadow() {
        let hiding = [piece(7, [0.5, 0.75], [2.0, 2.0])];
        let beyond = [piece(0, [0.0, 1.0], [0.2, 0.2])];
        let s: Vec<_> = received(&hiding, &beyond, |_| true).iter().map(|r| r.s).collect();
        assert_eq!(s, [[0.0, 0.5], [0.75, 1.0]]);
    }

    #[test]
    fn a_back_stops_rays_and_receives_none() {
        let beyond = [piece(0, [0.0, 1.0], [0.2, 0.2]), piece(1, [0.0, 1.0], [0.4, 0.4])];
        assert!(received(&[], &beyond, |face| face.index() == 0).is_empty());
    }

    #[test]
    fn rays_graze_a_touching_face_but_not_a_ridge() {
        let front = Piece { crossing: Crossing::Front, ..piece(1, [0.0, 1.0], [0.4, 0.4]) };
        let back = Piece { crossing: Crossing::Back, ..piece(2, [0.5, 1.0], [0.4, 0.4]) };
        let floor = piece(0, [0.0, 1.0], [0.2, 0.2]);
        assert_eq!(received(&[], &[floor, front], |_| true)[0].s, [0.0, 1.0]);
        assert_eq!(received(&[], &[floor, front, back], |_| true)[0].s, [0.0, 0.5]);
    }

    #[test]
    fn a_piece_through_the_occluder_is_cut_there() {
        let slanted = [piece(3, [0.0, 1.0], [0.5, 1.5])];
        let beyond = part_at(&slanted, 1.0, false);
        let hiding = part_at(&slanted, 1.0, true);
        assert!((beyond[0].s[1] - 0.5).abs() < 1e-5 && (hiding[0].s[0] - 0.5).abs() < 1e-5);
    }
}
