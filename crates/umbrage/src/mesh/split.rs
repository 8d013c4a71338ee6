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
        self.asked.push(patch);
        if self.edge_split(patch) {
            return true;
        }
        if self.settings.mend_bad_shapes {
            self.add_point_hints(patch);
        }
        if self.boundary(patch).len() > TRIANGLE { self.point_split(patch) } else { self.triangle_split(patch) }
    }

    /// The patches that `split` was asked for and were not split before, in order. Where nothing but `split` cut the
    /// mesh, they make the same one again of the same faces and d-segments: what a split does depends on those before
    /// it alone; those that fail count, since they may leave point hints.
    pub fn splits_asked(&self) -> &[PatchId] {
        &self.asked
    }

    /// Splits as another mesh of the same faces and d-segments was. False, and broken off, where it cannot have been
    /// that one's.
    pub fn split_as(&mut self, asked: &[PatchId]) -> bool {
        asked.iter().all(|&patch| {
            let is_leaf = self.patches.get(patch).is_some_and(|patch| patch.subpatches.is_none());
            if is_leaf {
                self.split(patch);
            }
            is_leaf
        })
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

#[cfg(test)]
mod tests {
    use super::super::sample::{self, first, rectangle};
    use super::super::{Cut, MeshSettings};
    use crate::discontinuity::Degree;
    use glam::DVec2;

    fn cut_of(corners: Vec<DVec2>, hint: bool) -> Option<Cut> {
        let segments = [(0, DVec2::new(0.1, 0.1), DVec2::new(0.4, 0.3), Degree::D1)];
        let mut mesh = sample::mesh_with(&[corners], if hint { &segments } else { &[] });
        mesh.settings = MeshSettings { mend_bad_shapes: false, ..mesh.settings };
        assert!(mesh.split(first()));
        mesh.patch(first()).cut
    }

    #[test]
    fn edge_hints_come_before_points_and_points_before_the_triangle() {
        let (square, triangle) = (rectangle((0.0, 0.0), (1.0, 1.0)), vec![DVec2::ZERO, DVec2::X, DVec2::Y]);
        assert!(matches!(cut_of(square.clone(), true), Some(Cut::EdgeHint(_))));
        assert!(matches!(cut_of(triangle.clone(), true), Some(Cut::EdgeHint(_))));
        assert_eq!(cut_of(square, false), Some(Cut::Points));
        assert_eq!(cut_of(triangle, false), Some(Cut::Triangle));
    }

    #[test]
    fn a_split_patch_stays_as_it_is() {
        let mut mesh = sample::mesh(&[rectangle((0.0, 0.0), (1.0, 1.0))]);
        assert!(mesh.split(first()));
        let (patches, vertices) = (mesh.patch_count(), mesh.vertex_count());
        assert!(mesh.split(first()));
        assert_eq!((mesh.patch_count(), mesh.vertex_count()), (patches, vertices));
    }

    #[test]
    fn d0_hints_are_removed_and_others_left() {
        let d0 = (0, DVec2::new(0.2, 0.2), DVec2::new(0.6, 0.3), Degree::D0);
        let d1 = (0, DVec2::new(0.1, 0.9), DVec2::new(0.9, 0.8), Degree::D1);
        let mut mesh = sample::mesh_with(&[rectangle((0.0, 0.0), (1.0, 1.0))], &[d0, d1]);
        assert!(mesh.has_d0_hint(first()));
        mesh.remove_d0_hints();
        assert_eq!(mesh.leaves().count(), 2);
        assert!(mesh.leaves().any(|leaf| !mesh.patch(leaf).edge_hints().is_empty()));
    }

    #[test]
    fn a_speck_cannot_be_split() {
        let speck = vec![DVec2::ZERO, DVec2::new(1e-7, 0.0), DVec2::new(0.0, 1e-7)];
        let mut mesh = sample::mesh(&[speck, rectangle((1.0, 0.0), (2.0, 1.0))]);
        assert!(!mesh.split(first()));
    }
}
