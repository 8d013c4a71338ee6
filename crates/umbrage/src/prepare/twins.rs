//! Pieces of different planes that have the same corners: polygons that lie in one plane but for rounding, and overlap.
//!
//! What lies in one plane is divided once, and of polygons that overlap there one is shown ([`super::arrangement`]). Planes that differ
//! by a little more are divided each for itself, and where corners are welded the pieces are the same: two faces in one place, of which
//! neither, or each, would hide the other. As in one plane, the one of the surface that is smaller there is shown: what is laid on
//! another. Of two that are as large the one that emits is.

use std::collections::HashMap;

use super::arrangement::Shown;
use super::assemble::PlacedPiece;
use super::coplanar::Planes;
use super::draft::Fronts;
use crate::id::VertexId;

/// Areas that differ by less than this share are equal: of polygons of a thousandth of the scene, whose sides are welded.
const EQUAL_AREAS: f64 = 1e-2;

/// Takes away what a piece shows on a side that another piece with the same corners shows, too, and says on how many sides.
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
        let of_surface = |number: usize, shown: &Shown| fronts.area_m2(pieces[number].plane, shown.surface);
        let mut of_both = [pieces[first].label, pieces[number].label];
        for side in 0..2 {
            let of_first = if is_turned { 1 - side } else { side };
            let [kept, other] = &mut of_both;
            let (kept, other) = (&mut kept[of_first], &mut other[side]);
            if let (Some(one), Some(two)) = (&kept, &other) {
                taken += 1;
                let ((area_m2, emits), (other_m2, other_emits)) = (of_surface(first, one), of_surface(number, two));
                // Areas of the same polygons differ by rounding, or by what is welded.
                let is_equal = (area_m2 - other_m2).abs() <= EQUAL_AREAS * area_m2.max(other_m2);
                let first_is_shown = if is_equal { emits || !other_emits } else { area_m2 < other_m2 };
                if first_is_shown { *other = None } else { *kept = None }
            }
            *kept = other.take().or(*kept);
        }
        [pieces[first].label, pieces[number].label] = of_both;
    }
    taken
}
