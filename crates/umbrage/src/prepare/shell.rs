//! Shells: faces that hang together along edges, and whether light can pass between their edges.
//!
//! A face and its back side, where a material is double-sided, are one sheet. An edge is open if one sheet ends at it;
//! a shell without open edges is closed: a room without gaps, a box, also a box without a bottom on a floor. Open edges
//! where none should be are the gaps through which light leaks.

use std::collections::BTreeSet;

use super::{DirectedEdge, Facing, Prepared};
use crate::geometry::DisjointSets;
use crate::id::{EdgeId, FaceId};

/// The shells of a scene, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shells {
    /// Shells without open edges.
    pub closed: usize,
    /// Shells with open edges.
    pub open: usize,
    /// Edges at which one sheet ends.
    pub open_edges: usize,
}

/// Counts the shells of prepared faces.
pub fn shells(prepared: &Prepared) -> Shells {
    let mut shells = DisjointSets::new(prepared.faces.len());
    for edge in &prepared.edges {
        edge.faces.windows(2).for_each(|pair| shells.join(pair[0].index(), pair[1].index()));
    }
    let mut open_shells = BTreeSet::new();
    let mut open_edges = 0;
    for (id, edge) in prepared.edges.iter_enumerated() {
        let Some(&first) = edge.faces.first() else { continue };
        let wing = |face: FaceId| (prepared.faces[face].plane, lies_left(prepared, face, id));
        if edge.faces.iter().all(|&face| wing(face) == wing(first)) {
            open_edges += 1;
            open_shells.insert(shells.first_of(first.index()));
        }
    }
    let all: BTreeSet<usize> = (0..prepared.faces.len()).map(|face| shells.first_of(face)).collect();
    Shells { closed: all.len() - open_shells.len(), open: open_shells.len(), open_edges }
}

/// Whether a face lies left of an edge of its own, seen against the normal of its plane.
fn lies_left(prepared: &Prepared, face: FaceId, edge: EdgeId) -> bool {
    let face = &prepared.faces[face];
    let reversed = face.sides.iter().flatten().any(|&e| e == DirectedEdge { edge, reversed: true });
    reversed == (face.facing == Facing::Against)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::MaterialId;
    use crate::prepare::prepare;
    use crate::progress::Progress;
    use crate::scene::Scene;
    use crate::scene::cornell::cornell_box;

    fn shells_of(scene: &Scene) -> Shells {
        shells(&prepare(scene, Progress::silent()).unwrap())
    }

    #[test]
    fn the_cornell_box_is_open_towards_us() {
        let all = shells_of(&cornell_box());
        assert_eq!((all.closed, all.open), (0, 1));
        // Four edges around the missing wall.
        assert_eq!(all.open_edges, 4);
    }

    #[test]
    fn a_double_sided_sheet_is_open_all_around() {
        let mut scene = cornell_box();
        scene.surfaces.truncate(1);
        scene.surfaces.raw[0].polygons.truncate(1);
        for double_sided in [false, true] {
            scene.materials[MaterialId::from(0)].double_sided = double_sided;
            let all = shells_of(&scene);
            assert_eq!((all.closed, all.open), (0, 1));
            assert_eq!(all.open_edges, 4);
        }
    }

    #[test]
    fn a_box_apart_is_a_shell_of_its_own() {
        let mut scene = cornell_box();
        // Without the floor and the bottoms the blocks stand alone.
        scene.surfaces.raw[0].polygons.remove(0);
        let all = shells_of(&scene);
        assert_eq!((all.closed, all.open), (0, 3));
    }
}
