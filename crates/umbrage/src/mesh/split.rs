//! `split` (paper, section 6): a patch gets two subpatches, by the best means that it has.
//!
//! ```text
//! split(patch p) {
//!     if (p has two subpatches)                          return;
//!     else if (p has edge split-hints)                   edge_split(p);
//!     else if (p has more than three boundary points)    point_split(p);
//!     else                                               triangle_split(p);
//! }
//! ```
//!
//! A patch without edge hints that is badly shaped first gets point hints into its long edges (the paper's announced
//! next step, `bad_shape`). Where rounding leaves no room for any cut, the patch stays whole and `split` says so.

use super::Mesh;
use crate::id::PatchId;

/// Boundary points of a triangle without split-hints.
pub(super) const TRIANGLE: usize = 3;

impl Mesh {
    /// Splits a patch into two subpatches, unless it has them. False where it cannot be split: it is then no wider than
    /// the weld distance.
    pub fn split(&mut self, patch: PatchId) -> bool {
        if self.patches[patch].subpatches.is_some() {
            return true;
        }
        while !self.patches[patch].edge_hints.is_empty() {
            if self.edge_split(patch) {
                return true;
            }
        }
        if self.settings.mend_bad_shapes {
            self.add_point_hints(patch);
        }
        if self.boundary(patch).len() > TRIANGLE { self.point_split(patch) } else { self.triangle_split(patch) }
    }

    /// Splits leaves until no edge hint of degree 0 is left: else shadows and light would leak (paper, section 4).
    pub fn remove_d0_hints(&mut self) {
        let mut open: Vec<PatchId> = self.leaves().filter(|&leaf| self.has_d0_hint(leaf)).collect();
        while let Some(patch) = open.pop() {
            if self.has_d0_hint(patch) && self.split(patch) {
                open.extend(self.patches[patch].subpatches.into_iter().flatten());
            }
        }
    }
}
