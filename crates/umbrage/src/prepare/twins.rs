//! Pieces of different planes that have the same corners: polygons that lie in one plane but for rounding, and overlap.
//!
//! A plane is divided once, and of polygons that overlap in it one is shown ([`super::arrangement`]). Planes that differ by a little more
//! are divided each for itself, and where corners are welded the pieces are the same: two faces in one place, of which neither, or each,
//! would hide the other. As in one plane, the one of the smaller surface is shown: a poster, not its wall. Of two that are as large the
//! one that emits is.

use std::collections::HashMap;

use super::arrangement::Shown;
use super::assemble::PlacedPiece;
use super::coplanar::Planes;
use super::draft::Fronts;
use crate::id::VertexId;

/// Areas that differ by less than this share are equal: those of the same polygon differ by as much where its size is a thousandth of the
/// scene and its corners are welded.
const EQUAL_AREAS: f64 = 1e-2;

/// Leaves each side of pieces with the same corners to one of them, and returns the number of sides that two of them showed.
pub(super) fn take_away(pieces: &mut [PlacedPiece], planes: &Planes, fronts: &Fronts) -> usize {
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
        let front = |number: usize, shown: &Shown| fronts.of(pieces[number].plane, shown.surface);
        let mut of_both = [pieces[first].label, pieces[number].label];
        for side in 0..2 {
            let of_first = if is_turned { 1 - side } else { side };
            let [kept, other] = &mut of_both;
            let (kept, other) = (&mut kept[of_first], &mut other[side]);
            if let (Some(one), Some(two)) = (&kept, &other) {
                taken += 1;
                let (one, two) = (front(first, one), front(number, two));
                let [one_m2, two_m2] = [one, two].map(|front| front.area_m2());
                let is_equal = (one_m2 - two_m2).abs() <= EQUAL_AREAS * one_m2.max(two_m2);
                let first_is_shown = if is_equal { one.emits || !two.emits } else { one_m2 < two_m2 };
                if first_is_shown { *other = None } else { *kept = None }
            }
            *kept = other.take().or(*kept);
        }
        [pieces[first].label, pieces[number].label] = of_both;
    }
    taken
}
