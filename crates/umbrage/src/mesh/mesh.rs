//! The mesh: vertices, edge trees and patch trees over the prepared faces.
//!
//! A split adds vertices, edges and two patches; it never touches a neighbour. The leaves of the patch trees cover the
//! faces, and since every leaf reads its boundary down to the leaves of shared edges, they conform: a T-vertex cannot
//! be made, whatever rounding does to coordinates.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::chain::{LampHint, straightened};
use super::count::beside_chord;
use super::patch::{BoundaryPoint, Cut, Patch};
use super::{EdgeHint, EdgeTrees, SplitScore};
use crate::discontinuity::{DSegment, Degree, Event};
use crate::geometry::{PlaneFrame, polygon};
use crate::id::{DSegmentId, EdgeId, FaceId, PatchId, Table, VertexId};
use crate::prepare::{DirectedEdge, Prepared, Side};

/// No split makes an edge shorter than this share of the scene's extent: a hundredth of a millimetre in a room of a metre. A
/// picture of the whole scene has no pixels as small.
const FINEST_OF_SCENE: f64 = 1e-5;
/// Nor shorter than this share of the face, so that no light, however it jumps, makes more than so many triangles along a line.
const FINEST_OF_FACE: f64 = 2e-5;

/// Edges of hard shadows are straightened where no corner is moved by more than this share of the shortest edge: with what cuts may be
/// moved besides, light at jumps is asked for far enough inside (`shade/field.rs`).
const STRAIGHT_OF_FINEST: f64 = 0.4;

/// How patches are split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshSettings {
    /// What `point_split` minimises.
    pub score: SplitScore,
    /// Whether badly shaped patches get point split-hints (the paper's announced next step).
    pub mend_bad_shapes: bool,
    /// Shadow edges of lamps across which light jumps by less than this, in W/m2, are cut only where splits are asked
    /// for; 0 cuts all. Lines of many lamps cross each other, and most change the light by little.
    pub least_jump: f64,
}

impl Default for MeshSettings {
    fn default() -> Self {
        Self { score: SplitScore::default(), mend_bad_shapes: true, least_jump: 0.0 }
    }
}

/// Vertices, edge trees and patch trees.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub(super) settings: MeshSettings,
    /// Vertices nearer than this are one, in metres.
    pub(super) least_edge_m: f64,
    /// No split makes an edge of a face shorter than this, in metres.
    pub(super) finest_m: Table<FaceId, f64>,
    pub(super) vertices_m: Table<VertexId, DVec3>,
    /// Roots of the edges that are cuts of degree 0.
    jump_roots: BTreeSet<EdgeId>,
    /// Whether a cut of degree 0 ends at, or passes, a vertex.
    jump_vertices: Table<VertexId, bool>,
    /// The edge that each vertex split; `None` for those of the prepared faces.
    split_edges: Table<VertexId, Option<EdgeId>>,
    pub(super) edges: EdgeTrees,
    pub(super) patches: Table<PatchId, Patch>,
    /// Whether the triangles of a face are counted.
    pub(super) is_counted: Table<FaceId, bool>,
    /// How many triangles the leaves of counted faces will be.
    pub(super) triangle_count: usize,
    /// The patches that `split` was asked for and were not split yet, in order.
    pub(super) asked: Vec<PatchId>,
    pub(super) frames: Table<FaceId, PlaneFrame>,
}

/// A broken promise of [`Mesh`]: always a defect of this library.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// The boundary of a patch is not a closed loop.
    #[error("{0:?} has a boundary that is not closed")]
    OpenBoundary(PatchId),
    /// Two subpatches do not cover their patch.
    #[error("{patch:?} of {area_m2} m2 has subpatches of {parts_m2:?} m2")]
    AreaLost {
        /// The patch.
        patch: PatchId,
        /// Its area.
        area_m2: f64,
        /// Areas of the subpatches.
        parts_m2: [f64; 2],
    },
    /// An edge is shorter than allowed.
    #[error("{0:?} is shorter than the weld distance")]
    ShortEdge(EdgeId),
}

/// The shortest edge that a split may make on a face, in metres.
fn finest_m(prepared: &Prepared, face: FaceId) -> f64 {
    let corners = prepared.polygon_m(face);
    let size_m = corners.iter().map(|corner| corner.distance(corners[0])).fold(0.0, f64::max);
    let tolerance = prepared.tolerance;
    tolerance.weld_m().max(FINEST_OF_SCENE * tolerance.extent_m).max(FINEST_OF_FACE * size_m)
}

impl Mesh {
    /// A patch for each face, with the d-segments as its edge split-hints. Root patches have the numbers of their
    /// faces.
    pub fn new(prepared: &Prepared, d_segments: &Table<DSegmentId, DSegment>, settings: MeshSettings) -> Self {
        let mut edges = EdgeTrees::default();
        prepared.edges.iter().for_each(|edge| {
            edges.push(edge.ends);
        });
        let mut mesh = Self {
            settings,
            least_edge_m: prepared.tolerance.weld_m(),
            finest_m: prepared.faces.keys().map(|face| finest_m(prepared, face)).collect(),
            vertices_m: prepared.vertices_m.clone(),
            jump_roots: BTreeSet::new(),
            jump_vertices: vec![false; prepared.vertices_m.len()].into(),
            split_edges: vec![None; prepared.vertices_m.len()].into(),
            edges,
            patches: Table::with_capacity(prepared.faces.len()),
            is_counted: Table::new(),
            triangle_count: 0,
            asked: Vec::new(),
            frames: prepared.faces.keys().map(|face| prepared.face_frame(face)).collect(),
        };
        for (id, face) in prepared.faces.iter_enumerated() {
            mesh.push_patch(id, None, face.sides.iter().cloned().collect(), prepared.normal(id));
        }
        mesh.count_triangles_of(|_| true);
        mesh.store_hints(d_segments);
        mesh
    }

    /// Stores each d-segment as an edge split-hint of its face's patch.
    fn store_hints(&mut self, d_segments: &Table<DSegmentId, DSegment>) {
        let mut of_lamps: Table<FaceId, Vec<LampHint>> = vec![Vec::new(); self.frames.len()].into();
        let store = |mesh: &mut Self, root: PatchId, hint: EdgeHint| {
            let satisfied_m = mesh.satisfied_m(root, hint.degree);
            let clipped = hint.clipped(&mesh.polygon_2d_m(root), mesh.finest_of(root), satisfied_m);
            mesh.patches[root].edge_hints.extend(clipped);
        };
        for (d_segment, segment) in d_segments.iter_enumerated() {
            let root = self.root(segment.face);
            let frame = self.frames[segment.face];
            let ends_m = segment.ends_m.map(|end| frame.to_2d(end));
            let (degree, strength) = (segment.degree, segment.strength);
            let is_contact = matches!(segment.event, Event::Contact { .. });
            // Across a contact that is not cut, light would leak.
            let needed = degree == Degree::D0 && (is_contact || strength >= self.settings.least_jump);
            let hint = EdgeHint { d_segment, degree, strength, needed, ends_m };
            match segment.event {
                Event::LampEdge { lamp, .. } | Event::LampCurve { lamp, .. } if degree == Degree::D0 => {
                    of_lamps[segment.face].push((hint, lamp));
                }
                _ => store(self, root, hint),
            }
        }
        for (face, hints) in of_lamps.iter_enumerated() {
            let within_m = STRAIGHT_OF_FINEST * self.finest_m[face];
            straightened(hints, within_m).into_iter().for_each(|hint| store(self, self.root(face), hint));
        }
        self.patches.iter_mut().for_each(|patch| patch.edge_hints.sort_by(EdgeHint::by_priority));
    }

    /// The patch that is the whole face.
    pub fn root(&self, face: FaceId) -> PatchId {
        PatchId::from(face.index())
    }

    /// A patch.
    pub fn patch(&self, patch: PatchId) -> &Patch {
        &self.patches[patch]
    }

    /// All patches, split ones included.
    pub fn patches(&self) -> impl Iterator<Item = (PatchId, &Patch)> {
        self.patches.iter_enumerated()
    }

    /// Number of patches, split ones included.
    pub fn patch_count(&self) -> usize {
        self.patches.len()
    }

    /// Patches that are not split, in the order of their ids.
    pub fn leaves(&self) -> impl Iterator<Item = PatchId> + '_ {
        self.patches.iter_enumerated().filter(|(_, patch)| patch.subpatches.is_none()).map(|(id, _)| id)
    }

    /// A vertex, relative to the prepared scene's origin, in metres.
    pub fn vertex_m(&self, vertex: VertexId) -> DVec3 {
        self.vertices_m[vertex]
    }

    /// The root of the edge that a vertex split; `None` for a vertex of the prepared faces.
    pub fn split_root(&self, vertex: VertexId) -> Option<EdgeId> {
        self.split_edges[vertex].map(|edge| self.edges.root(edge))
    }

    /// The ends of the edge that a vertex split, if it did so in the middle.
    pub fn halved_by(&self, vertex: VertexId) -> Option<[VertexId; 2]> {
        let ends = self.edges.ends(self.split_edges[vertex]?);
        let middle_m = self.vertex_m(ends[0]).midpoint(self.vertex_m(ends[1]));
        (middle_m.distance(self.vertex_m(vertex)) < self.least_edge_m).then_some(ends)
    }

    /// Whether light may jump across an edge because it is a cut along a d-segment of degree 0.
    pub fn is_jump(&self, edge: EdgeId) -> bool {
        self.jump_roots.contains(&self.edges.root(edge))
    }

    /// Whether such a cut ends at a vertex, or passes it.
    pub fn is_jump_vertex(&self, vertex: VertexId) -> bool {
        self.jump_vertices[vertex]
    }

    /// Marks the cut that split a patch as one across which light may jump.
    pub(super) fn mark_jump(&mut self, patch: PatchId) {
        let Some([first, _]) = self.patches[patch].subpatches else { return };
        let Some(&chord) = self.patches[first].sides.last().and_then(|side| side.first()) else { return };
        self.jump_roots.insert(self.edges.root(chord.edge));
        for end in self.edges.ends(chord.edge) {
            self.jump_vertices[end] = true;
        }
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.vertices_m.len()
    }

    /// The edge trees.
    pub fn edges(&self) -> &EdgeTrees {
        &self.edges
    }

    /// The frame of a face, oriented like it: counter-clockwise seen from the front.
    pub fn frame(&self, face: FaceId) -> &PlaneFrame {
        &self.frames[face]
    }

    /// The corners of a patch, counter-clockwise seen from the front, in metres.
    pub fn polygon_m(&self, patch: PatchId) -> Vec<DVec3> {
        self.patches[patch].sides.iter().map(|side| self.vertices_m[self.edges.start(side[0])]).collect()
    }

    /// The vertices at the corners of a patch, counter-clockwise.
    pub fn corners(&self, patch: PatchId) -> impl Iterator<Item = VertexId> + '_ {
        self.patches[patch].sides.iter().map(|side| self.edges.start(side[0]))
    }

    /// The corners of a patch in the frame of its face, counter-clockwise, in metres.
    pub fn polygon_2d_m(&self, patch: PatchId) -> Vec<DVec2> {
        let frame = &self.frames[self.patches[patch].face];
        let sides = &self.patches[patch].sides;
        sides.iter().map(|side| frame.to_2d(self.vertices_m[self.edges.start(side[0])])).collect()
    }

    /// The unsplit patch of a face that a point of it lies in; where it lies on a cut, one beside it.
    pub fn leaf_at(&self, face: FaceId, point_m: DVec3) -> PatchId {
        self.leaf_below(self.root(face), point_m)
    }

    /// The unsplit part of a patch that a point of it lies in; where it lies on a cut, one beside it.
    pub fn leaf_below(&self, mut patch: PatchId, point_m: DVec3) -> PatchId {
        let normal = self.frames[self.patches[patch].face].plane.normal;
        while let Some([first, second]) = self.patches[patch].subpatches {
            let left = self.cut_m(patch).is_none_or(|[p, q]| normal.cross(q - p).dot(point_m - p) >= 0.0);
            patch = if left { first } else { second };
        }
        patch
    }

    /// The ends of the cut that split a patch, in metres: its first part lies to the left.
    pub fn cut_m(&self, patch: PatchId) -> Option<[DVec3; 2]> {
        // The cut is the last side of both parts, with the part to its left.
        let [first, _] = self.patches[patch].subpatches?;
        let chord = *self.patches[first].sides.last()?.first()?;
        Some([self.edges.start(chord), self.edges.end(chord)].map(|vertex| self.vertices_m[vertex]))
    }

    /// The boundary points of a patch in order, those that neighbours made included.
    pub fn boundary(&self, patch: PatchId) -> Vec<BoundaryPoint> {
        let mut points = Vec::new();
        let mut leaves = Vec::new();
        for (side, run) in self.patches[patch].sides.iter().enumerate() {
            leaves.clear();
            run.iter().for_each(|&edge| self.edges.leaves(edge, &mut leaves));
            points.extend(leaves.iter().enumerate().map(|(i, &leaf)| BoundaryPoint {
                vertex: self.edges.start(leaf),
                leaf,
                side,
                corner: i == 0,
            }));
        }
        points
    }

    /// Number of these.
    pub fn boundary_count(&self, patch: PatchId) -> usize {
        self.patches[patch].sides.iter().flatten().map(|edge| self.edges.leaf_count(edge.edge)).sum()
    }

    /// The point split-hints of a patch: boundary points that it did not make.
    pub fn point_hints(&self, patch: PatchId) -> Vec<VertexId> {
        let own: Vec<VertexId> =
            self.patches[patch].sides.iter().flatten().map(|&edge| self.edges.start(edge)).collect();
        self.boundary(patch).iter().map(|point| point.vertex).filter(|vertex| !own.contains(vertex)).collect()
    }

    /// Whether a patch still holds an edge split-hint of degree 0 that must be cut.
    pub fn has_d0_hint(&self, patch: PatchId) -> bool {
        self.patches[patch].edge_hints.first().is_some_and(|hint| hint.needed)
    }

    /// No split makes an edge of a patch shorter than this, in metres; nor is a cut of degree 0 farther from its d-segment.
    pub fn finest_of(&self, patch: PatchId) -> f64 {
        self.finest_m[self.patches[patch].face]
    }

    /// A d-segment that is nowhere farther than this from the boundary is cut already, in metres. One of degree 0 only where it is
    /// the same line: an edge of a round shadow of 1,000 lies nearer to the next one's line than the shortest edge is long, and a
    /// vertex beyond the shadow takes the light of the other side into a triangle, however large that is.
    fn satisfied_m(&self, patch: PatchId, degree: Degree) -> f64 {
        if degree == Degree::D0 { self.least_edge_m } else { self.finest_of(patch) }
    }

    /// Whether a patch is too narrow for light over it to be seen: narrower than the shortest edge that a split may make.
    pub fn is_finest(&self, patch: PatchId) -> bool {
        let corners = self.polygon_m(patch);
        let length_m = |i: usize| corners[i].distance(corners[(i + 1) % corners.len()]);
        let longest_m = (0..corners.len()).map(length_m).fold(0.0, f64::max);
        self.patches[patch].area_m2 < self.finest_of(patch) * longest_m
    }

    /// How well shaped a patch is: see [`polygon::compactness`].
    pub fn compactness(&self, patch: PatchId) -> f64 {
        polygon::compactness(self.patches[patch].area_m2, polygon::perimeter_m(&self.polygon_m(patch)))
    }

    fn push_patch(
        &mut self,
        face: FaceId,
        parent: Option<PatchId>,
        sides: SmallVec<[Side; 4]>,
        normal: DVec3,
    ) -> PatchId {
        let corners: Vec<DVec3> = sides.iter().map(|side| self.vertices_m[self.edges.start(side[0])]).collect();
        self.patches.push_and_get_key(Patch {
            face,
            parent,
            subpatches: None,
            cut: None,
            area_m2: 0.5 * polygon::doubled_area_vector(&corners).dot(normal),
            centroid_m: polygon::centroid(&corners),
            sides,
            edge_hints: Vec::new(),
        })
    }

    /// Splits a leaf edge at `point`, rounded to `f32`; every patch along the edge sees the new vertex from now on.
    pub(super) fn split_edge(&mut self, leaf: EdgeId, point: DVec3) -> VertexId {
        let vertex = self.vertices_m.push_and_get_key(point.as_vec3().as_dvec3());
        self.split_edges.push(Some(leaf));
        self.jump_vertices.push(self.is_jump(leaf));
        self.triangle_count += self.edges.beside(leaf);
        self.edges.split(leaf, vertex);
        vertex
    }

    /// Splits `patch` by the chord between two of its boundary points that do not lie on one side.
    pub(super) fn split_between(&mut self, patch: PatchId, from: &BoundaryPoint, to: &BoundaryPoint, cut: Cut) {
        let face = self.patches[patch].face;
        let chord = self.edges.push([from.vertex, to.vertex]);
        self.edges.add_beside(chord, beside_chord(self.is_counted[face]));
        let chord = DirectedEdge { edge: chord, reversed: false };
        let normal = self.frames[face].plane.normal;
        let first = self.sides_between(patch, from, to, chord.opposite());
        let second = self.sides_between(patch, to, from, chord);
        let subpatches = [first, second].map(|sides| self.push_patch(face, Some(patch), sides, normal));
        self.hand_down_hints(patch, subpatches);
        self.patches[patch].subpatches = Some(subpatches);
        self.patches[patch].cut = Some(cut);
    }

    /// The sides from one boundary point counter-clockwise to another, closed by `chord`.
    fn sides_between(
        &self,
        patch: PatchId,
        from: &BoundaryPoint,
        to: &BoundaryPoint,
        chord: DirectedEdge,
    ) -> SmallVec<[Side; 4]> {
        let sides = &self.patches[patch].sides;
        let mut result = SmallVec::new();
        result.push(self.edges.cut_side(&sides[from.side], from.vertex).1);
        let mut side = (from.side + 1) % sides.len();
        while side != to.side {
            result.push(sides[side].clone());
            side = (side + 1) % sides.len();
        }
        if !to.corner {
            result.push(self.edges.cut_side(&sides[to.side], to.vertex).0);
        }
        result.push(Side::from_elem(chord, 1));
        result
    }

    /// Clips the hints of a patch into its subpatches, and drops those that the cut has satisfied.
    fn hand_down_hints(&mut self, patch: PatchId, subpatches: [PatchId; 2]) {
        let hints = std::mem::take(&mut self.patches[patch].edge_hints);
        for subpatch in subpatches {
            let corners = self.polygon_2d_m(subpatch);
            let finest_m = self.finest_of(subpatch);
            let clipped = |hint: &EdgeHint| hint.clipped(&corners, finest_m, self.satisfied_m(subpatch, hint.degree));
            let mut kept: Vec<EdgeHint> = hints.iter().filter_map(clipped).collect();
            kept.sort_by(EdgeHint::by_priority);
            self.patches[subpatch].edge_hints = kept;
        }
    }

    /// Checks what the heads of `mesh` and `patch` promise.
    ///
    /// # Errors
    /// The first broken promise.
    pub fn validate(&self) -> Result<(), MeshError> {
        for (id, patch) in self.patches.iter_enumerated() {
            let run: Vec<DirectedEdge> = patch.sides.iter().flatten().copied().collect();
            let closed = (0..run.len()).all(|i| self.edges.end(run[i]) == self.edges.start(run[(i + 1) % run.len()]));
            if !closed || patch.sides.len() < 3 {
                return Err(MeshError::OpenBoundary(id));
            }
            if let Some(subpatches) = patch.subpatches {
                let parts_m2 = subpatches.map(|part| self.patches[part].area_m2);
                // The cut's ends are rounded: each moves the boundary by up to half the weld distance.
                let slack_m2 = self.least_edge_m * polygon::perimeter_m(&self.polygon_m(id));
                if parts_m2.iter().any(|&part| part < -slack_m2)
                    || (parts_m2[0] + parts_m2[1] - patch.area_m2).abs() > slack_m2
                {
                    return Err(MeshError::AreaLost { patch: id, area_m2: patch.area_m2, parts_m2 });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::{self, first, rectangle};
    use super::*;
    use proptest::prelude::*;

    /// Two squares side by side; the left one is split so that a vertex lands on their common edge.
    fn neighbours() -> (Mesh, PatchId) {
        let cut = (0, DVec2::new(0.0, 0.5), DVec2::new(1.0, 0.5), Degree::D1);
        let squares = [rectangle((0.0, 0.0), (1.0, 1.0)), rectangle((1.0, 0.0), (2.0, 1.0))];
        let mut mesh = sample::mesh_with(&squares, &[cut]);
        assert!(mesh.split(first()));
        (mesh, PatchId::from(1))
    }

    #[test]
    fn fig_1a_a_split_leaves_a_point_hint_and_does_not_touch_the_neighbour() {
        let (mesh, neighbour) = neighbours();
        assert!(mesh.patch(neighbour).subpatches.is_none());
        let hints = mesh.point_hints(neighbour);
        assert_eq!(hints.iter().map(|&v| mesh.vertex_m(v)).collect::<Vec<_>>(), [DVec3::new(1.0, 0.5, 0.0)]);
        assert_eq!(mesh.polygon_m(neighbour).len(), 4, "the hint is not a corner of the patch");
    }

    #[test]
    fn fig_1c_triangulation_anchors_the_hint() {
        let (mut mesh, neighbour) = neighbours();
        let hint = mesh.point_hints(neighbour)[0];
        mesh.triangulate();
        assert!(mesh.leaves().all(|leaf| mesh.boundary(leaf).len() == 3 && mesh.point_hints(leaf).is_empty()));
        let around_hint = |leaf: &PatchId| mesh.boundary(*leaf).iter().any(|point| point.vertex == hint);
        let on_the_right = mesh.leaves().filter(|&leaf| mesh.patch(leaf).face == FaceId::from(1)).filter(around_hint);
        assert!(on_the_right.count() >= 2, "an edge leads from the hint into the neighbour");
        assert_eq!(sample::t_vertices(&mesh), 0);
    }

    #[test]
    fn the_checker_of_these_tests_finds_a_t_vertex() {
        let apart =
            [rectangle((0.0, 0.0), (1.0, 0.5)), rectangle((0.0, 0.5), (1.0, 1.0)), rectangle((1.0, 0.0), (2.0, 1.0))];
        assert!(sample::t_vertices(&sample::mesh(&apart)) > 0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn random_splits_conform_and_lose_no_area(
            picks in proptest::collection::vec(0usize..1000, 1..40),
            lines in proptest::collection::vec(((0.0..2.0, 0.0..1.0), (0.0..2.0, 0.0..1.0), 0usize..3), 0..6),
        ) {
            let squares = [rectangle((0.0, 0.0), (1.0, 1.0)), rectangle((1.0, 0.0), (2.0, 1.0))];
            let degrees = [Degree::D0, Degree::D1, Degree::D2];
            let segments: Vec<_> = lines
                .iter()
                .flat_map(|&(from, to, degree)| [0, 1].map(|face| (face, DVec2::from(from), DVec2::from(to), degrees[degree])))
                .collect();
            let mut mesh = sample::mesh_with(&squares, &segments);
            for pick in picks {
                let leaves: Vec<PatchId> = mesh.leaves().collect();
                mesh.split(leaves[pick % leaves.len()]);
            }
            mesh.remove_d0_hints();
            prop_assert!(mesh.leaves().all(|leaf| !mesh.has_d0_hint(leaf)));
            mesh.triangulate();
            prop_assert!(mesh.leaves().all(|leaf| mesh.boundary(leaf).len() == 3));
            prop_assert_eq!(mesh.validate(), Ok(()));
            let area: f64 = mesh.leaves().map(|leaf| mesh.patch(leaf).area_m2).sum();
            prop_assert!((area - 2.0).abs() < 1e-5);
            for leaf in mesh.leaves() {
                prop_assert_eq!(mesh.leaf_at(mesh.patch(leaf).face, mesh.patch(leaf).centroid_m), leaf);
            }
            prop_assert_eq!(sample::t_vertices(&mesh), 0);
        }
    }
}
