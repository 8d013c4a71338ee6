//! Pieces of different planes that have the same corners: polygons that lie in one plane but for rounding, and overlap.
//!
//! What lies in one plane is divided once, and of polygons that overlap there one is shown ([`super::arrangement`]). Planes that differ by a
//! little more are divided each for itself, and where corners are welded the pieces are the same: two faces in one place, of which
//! neither, or each, would hide the other. The first is kept.

use std::collections::HashMap;

use super::assemble::PlacedPiece;
use super::coplanar::Planes;
use crate::id::VertexId;

/// Takes away what a piece shows on a side that another piece with the same corners shows, too, and says on how many sides.
pub(super) fn take_away(pieces: &mut [PlacedPiece], planes: &Planes) -> usize {
    let mut first_of: HashMap<Vec<VertexId>, usize> = HashMap::with_capacity(pieces.len());
    let mut taken = 0;
    for number in 0..pieces.len() {
        let mut corners = pieces[number].boundary.clone();
        corners.sort_unstable();
        let first = *first_of.entry(corners).or_insert(number);
        if first == number {
            continue;
        }
        let normal = |number: usize| planes.frames[pieces[number].plane].plane.normal;
        let is_turned = normal(first).dot(normal(number)) < 0.0;
        for side in 0..2 {
            let of_first = if is_turned { 1 - side } else { side };
            if pieces[number].label[side].is_none() {
                continue;
            }
            if pieces[first].label[of_first].is_some() {
                taken += 1;
            } else {
                pieces[first].label[of_first] = pieces[number].label[side];
            }
            pieces[number].label[side] = None;
        }
    }
    taken
}
