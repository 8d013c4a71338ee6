//! How many triangles the leaves will be: known exactly at any time, before a split and after it.
//!
//! A leaf with `n` boundary points becomes `n - 2` triangles ([`Mesh::triangulate`]). A chord between two boundary points
//! gives the two parts `n + 2` points together, and so as many triangles as the whole has. A point in an edge is one
//! point more for each leaf along it, and so one triangle more for each. Along an edge of a face lie as many leaves as
//! faces, along a chord two. So only new points cost triangles, and each costs what lies beside its edge.
//!
//! Holds: [`Mesh::triangle_count`] is the sum over the leaves of the counted faces.

use super::Mesh;
use crate::id::{EdgeId, FaceId, Table};

impl Mesh {
    /// Counts the triangles of these faces alone: those that are written.
    pub fn count_triangles_of(&mut self, is_counted: impl Fn(FaceId) -> bool) {
        self.is_counted = self.frames.keys().map(is_counted).collect();
        let mut of_root: Table<EdgeId, u32> = vec![0; self.edges.len()].into();
        for (face, &counted) in self.is_counted.iter_enumerated() {
            let root = self.root(face);
            let sides = self.patches[root].sides.iter().flatten();
            sides.for_each(|side| of_root[side.edge] += u32::from(counted));
        }
        for (_, patch) in self.patches() {
            if let Some(chord) = patch.subpatches.and_then(|[first, _]| self.chord_of_part(first)) {
                of_root[chord] = beside_chord(self.is_counted[patch.face]);
            }
        }
        self.edges.set_beside(&of_root);
        let counted = |&leaf: &crate::id::PatchId| self.is_counted[self.patches[leaf].face];
        self.triangle_count = self.leaves().filter(counted).map(|leaf| self.boundary_count(leaf) - 2).sum();
    }

    /// How many triangles [`Mesh::triangulate`] makes of the counted faces; all are counted, unless
    /// [`Mesh::count_triangles_of`] was told others.
    pub fn triangle_count(&self) -> usize {
        self.triangle_count
    }

    /// The root of the chord that made a part.
    fn chord_of_part(&self, part: crate::id::PatchId) -> Option<EdgeId> {
        Some(self.edges.root(self.patches[part].sides.last()?.first()?.edge))
    }
}

/// How many counted leaves lie along a chord through a face.
pub(super) fn beside_chord(is_counted: bool) -> u32 {
    if is_counted { 2 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::super::sample::{self, rectangle};
    use super::super::split::Attempt;
    use super::*;
    use crate::discontinuity::Degree;
    use crate::id::PatchId;
    use glam::DVec2;
    use proptest::prelude::*;

    /// The count, leaf by leaf.
    fn counted(mesh: &Mesh, is_counted: impl Fn(FaceId) -> bool) -> usize {
        let counts = |leaf: &PatchId| is_counted(mesh.patch(*leaf).face);
        mesh.leaves().filter(counts).map(|leaf| mesh.boundary(leaf).len() - 2).sum()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn the_count_is_exact_and_no_split_costs_more_than_its_room(
            picks in proptest::collection::vec((0usize..1000, 0usize..6), 1..60),
            lines in proptest::collection::vec(((0.0..2.0, 0.0..1.0), (0.0..2.0, 0.0..1.0), 0usize..3), 0..6),
            one_face in any::<bool>(),
        ) {
            let squares = [rectangle((0.0, 0.0), (1.0, 1.0)), rectangle((1.0, 0.0), (2.0, 1.0))];
            let degrees = [Degree::D0, Degree::D1, Degree::D2];
            let segments: Vec<_> = lines
                .iter()
                .flat_map(|&(from, to, degree)| [0, 1].map(|face| (face, DVec2::from(from), DVec2::from(to), degrees[degree])))
                .collect();
            let is_counted = |face: FaceId| !one_face || face.index() == 1;
            let mut mesh = sample::mesh_with(&squares, &segments);
            mesh.count_triangles_of(is_counted);
            for (pick, room) in picks {
                let leaves: Vec<PatchId> = mesh.leaves().collect();
                let (before, leaf) = (mesh.triangle_count(), leaves[pick % leaves.len()]);
                let attempt = mesh.split_within(leaf, room);
                prop_assert!(mesh.triangle_count() <= before + room);
                prop_assert_eq!(mesh.triangle_count(), counted(&mesh, is_counted));
                prop_assert_eq!(attempt == Attempt::Split, mesh.patch(leaf).subpatches.is_some());
            }
            // Told anew in the middle of the work it is the same.
            let count = mesh.triangle_count();
            mesh.count_triangles_of(is_counted);
            prop_assert_eq!(mesh.triangle_count(), count);
            let most = count + 7;
            let left = mesh.remove_d0_hints_within(most);
            prop_assert!(mesh.triangle_count() <= most);
            prop_assert_eq!(left == 0, mesh.leaves().all(|leaf| !mesh.has_d0_hint(leaf)));
            let count = mesh.triangle_count();
            mesh.triangulate();
            let written = mesh.leaves().filter(|&leaf| is_counted(mesh.patch(leaf).face)).count();
            prop_assert_eq!((mesh.triangle_count(), written), (count, count));
            prop_assert_eq!(sample::t_vertices(&mesh), 0);
        }
    }
}
