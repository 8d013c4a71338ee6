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
//! Edge hints that are short for the patch wait until it is smaller. A patch without others that is badly shaped first gets point hints into its long edges (the paper's announced
//! next step, `bad_shape`). Where rounding leaves no room for any cut, the patch stays whole and `split` says so.

use std::cmp::Ordering;
use std::collections::{BTreeSet, BinaryHeap};

use super::Mesh;
use crate::id::PatchId;

/// What became of a patch that was to be split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attempt {
    /// It has subpatches.
    Split,
    /// It cannot be split: it is no wider than the weld distance.
    Whole,
    /// The split would make more triangles than there is room for; nothing changed.
    NoRoom,
}

/// A leaf that may be split.
#[derive(Debug)]
struct Open {
    weight: f64,
    patch: PatchId,
}

impl Ord for Open {
    /// The heaviest is the greatest, and the first of equals.
    fn cmp(&self, other: &Self) -> Ordering {
        self.weight.total_cmp(&other.weight).then(other.patch.cmp(&self.patch))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

/// Boundary points of a triangle without split-hints.
pub(super) const TRIANGLE: usize = 3;

impl Mesh {
    /// Splits a patch into two subpatches, unless it has them. False where it cannot be split: it is then no wider than
    /// the weld distance.
    pub fn split(&mut self, patch: PatchId) -> bool {
        self.split_within(patch, usize::MAX) == Attempt::Split
    }

    /// Splits a patch into two subpatches, unless it has them, if that makes no more than `room` triangles in all (see
    /// [`Mesh::triangle_count`]).
    pub fn split_within(&mut self, patch: PatchId, room: usize) -> Attempt {
        if self.patches[patch].subpatches.is_some() {
            return Attempt::Split;
        }
        self.asked.push(patch);
        let attempt = self.edge_split(patch, room);
        if attempt != Attempt::Whole {
            return attempt;
        }
        let attempt = self.split_without_hints(patch, room);
        // Nothing but the hints that wait is left.
        if attempt == Attempt::Whole { self.edge_split_from(patch, room, 0) } else { attempt }
    }

    /// Splits a patch by its boundary points, or as a triangle.
    fn split_without_hints(&mut self, patch: PatchId, room: usize) -> Attempt {
        let before = self.triangle_count;
        if self.settings.mend_bad_shapes {
            self.add_point_hints(patch, room);
        }
        if self.boundary(patch).len() > TRIANGLE {
            return if self.point_split(patch) { Attempt::Split } else { Attempt::Whole };
        }
        self.triangle_split(patch, room - (self.triangle_count - before))
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

    /// Splits leaves along their hints of degree 0, those of the greatest strength times length first, until there is none
    /// or the leaves would be more than `most` triangles. Tells how many d-segments are left of which a part is not cut.
    pub fn remove_d0_hints_within(&mut self, most: usize) -> usize {
        let mut open: BinaryHeap<Open> = self.leaves().filter_map(|leaf| self.open_at_d0(leaf)).collect();
        let mut left = BTreeSet::new();
        while let Some(Open { patch, .. }) = open.pop() {
            match self.split_within(patch, most.saturating_sub(self.triangle_count)) {
                Attempt::Split => {
                    let parts = self.patches[patch].subpatches.into_iter().flatten();
                    open.extend(parts.filter_map(|part| self.open_at_d0(part)));
                }
                Attempt::Whole => {}
                Attempt::NoRoom => {
                    let hints = self.patches[patch].edge_hints.iter().filter(|hint| hint.needed);
                    left.extend(hints.map(|hint| hint.d_segment));
                }
            }
        }
        left.len()
    }

    /// Splits leaves, the largest first, as long as they are no more than `most` triangles.
    pub fn split_largest_within(&mut self, most: usize) {
        let is_counted = |mesh: &Self, leaf: PatchId| mesh.is_counted[mesh.patches[leaf].face];
        let open = |mesh: &Self, patch: PatchId| Open { weight: mesh.patches[patch].area_m2, patch };
        let leaves = self.leaves().filter(|&leaf| is_counted(self, leaf));
        let mut queue: BinaryHeap<Open> = leaves.map(|leaf| open(self, leaf)).collect();
        while let Some(Open { patch, .. }) = queue.pop() {
            match self.split_within(patch, most.saturating_sub(self.triangle_count)) {
                Attempt::Split => {
                    queue.extend(self.patches[patch].subpatches.into_iter().flatten().map(|part| open(self, part)));
                }
                Attempt::Whole => {}
                // Smaller ones would cost as much.
                Attempt::NoRoom => break,
            }
        }
    }

    /// A leaf with a hint of degree 0, by how much its first one matters.
    fn open_at_d0(&self, patch: PatchId) -> Option<Open> {
        let hint = self.patches[patch].edge_hints.first().filter(|hint| hint.needed)?;
        Some(Open { weight: hint.strength * hint.length_m(), patch })
    }

    /// Splits leaves until no edge hint of degree 0 is left that must be cut: else shadows and light would leak (paper, section 4).
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
    use super::super::{Cut, Mesh, MeshSettings};
    use crate::discontinuity::{DSegment, Degree, Event};
    use crate::id::{EdgeId, FaceId, LampId};
    use crate::visibility::fixture;
    use glam::{DVec2, DVec3};

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
    fn weak_shadow_edges_of_lamps_wait_and_strong_ones_and_contacts_do_not() {
        let along = |y: f64, strength: f64, event: Event| DSegment {
            face: FaceId::from(0),
            ends_m: [DVec3::new(0.2, y, 0.0), DVec3::new(0.8, y, 0.0)],
            degree: Degree::D0,
            strength,
            event,
        };
        let (edge, lamp) = (EdgeId::from(0), LampId::from(0));
        let shadow = Event::LampEdge { lamp, occluder: edge };
        let segments = [
            along(0.2, 0.9, shadow),
            along(0.4, 1.1, shadow),
            along(0.6, 0.1, Event::Contact { edge }),
            along(0.8, 0.5, shadow),
        ];
        let square = rectangle((0.0, 0.0), (1.0, 1.0)).iter().map(|corner| corner.extend(0.0)).collect();
        let settings = MeshSettings { least_jump: 1.0, ..MeshSettings::default() };
        let mut mesh = Mesh::new(&fixture::prepared(&[square]), &segments.to_vec().into(), settings);
        mesh.remove_d0_hints();
        assert_eq!(mesh.leaves().count(), 3, "two cuts");
        let waiting: usize = mesh.leaves().map(|leaf| mesh.patch(leaf).edge_hints().len()).sum();
        assert_eq!(waiting, 2);
        // Once light asks for a split, they say where.
        let lowest = mesh.leaf_at(FaceId::from(0), DVec3::new(0.5, 0.1, 0.0));
        assert!(mesh.split(lowest));
        assert!(matches!(mesh.patch(lowest).cut, Some(Cut::EdgeHint(_))));
    }

    #[test]
    fn a_speck_cannot_be_split() {
        let speck = vec![DVec2::ZERO, DVec2::new(1e-7, 0.0), DVec2::new(0.0, 1e-7)];
        let mut mesh = sample::mesh(&[speck, rectangle((1.0, 0.0), (2.0, 1.0))]);
        assert!(!mesh.split(first()));
    }
}
