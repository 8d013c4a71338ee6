//! The spatial index: a binary tree of boxes over the prepared faces.
//!
//! The tree is built by the crate `obvhs` (PLOC: Meister and Bittner, *Parallel Locally-Ordered Clustering for Bounding
//! Volume Hierarchy Construction*, 2018) over `f32` boxes that are rounded outward; its nodes are walked here, with a
//! box test of the caller's, in `f64`. The faces' boundaries lie flat beside it, with every vertex that other faces
//! have on them: two faces that share an edge then meet in the same points, and no query sees a crack between them.
//!
//! Holds: a face that a walk's box test would keep is visited, each at most once; the order is that of the tree, which
//! depends on the faces only and never on threads.

use std::fmt;
use std::ops::ControlFlow;

use glam::{DVec3, Vec3A};
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::node::Bvh2Node;

use super::around::Around;
use super::slim::SlimTree;
use crate::geometry::{Plane, Tolerance};
use crate::id::{FaceId, PlaneId, Table};
use crate::prepare::Prepared;
use rayon::prelude::*;

/// Distances from planes are good to this share of the extent, at points within a few extents.
const ROUNDED_OF_EXTENT: f64 = 1e-13;

/// What the index knows of a face.
#[derive(Clone, Copy, Debug)]
struct IndexedFace {
    /// The plane that it lies in.
    plane: PlaneId,
    /// Where its boundary starts and ends in the table of corners.
    boundary: (u32, u32),
    /// Its box, in metres.
    min_m: DVec3,
    /// Its box, in metres.
    max_m: DVec3,
    /// A plane that its corners lie in, within a distance in metres.
    near: (Plane, f64),
}

impl Boundable for IndexedFace {
    fn aabb(&self) -> Aabb {
        Aabb::new(rounded(self.min_m, f32::next_down), rounded(self.max_m, f32::next_up))
    }
}

/// A corner of a box in `f32`, moved outward where rounding moved it inward (or nowhere: one step too many is
/// harmless).
pub(super) fn rounded(p: DVec3, outward: fn(f32) -> f32) -> Vec3A {
    let step = |x: f64| if f64::from(x as f32) == x { x as f32 } else { outward(x as f32) };
    Vec3A::new(step(p.x), step(p.y), step(p.z))
}

/// The spatial index over the prepared faces, and the queries that it answers.
#[derive(Clone)]
pub struct Visibility {
    tree: Bvh2,
    /// Where faces are slim, another tree for rays.
    slim: Option<SlimTree>,
    faces: Table<FaceId, IndexedFace>,
    /// Their boxes in `f32`, rounded outward: four of them lie where one of the others does.
    boxes: Table<FaceId, Aabb>,
    corners_m: Vec<DVec3>,
    /// The faces around each facet of a smooth surface.
    around: Around,
    /// The faces that may cover points of each.
    covering: Table<FaceId, Box<[FaceId]>>,
    tolerance: Tolerance,
}

impl fmt::Debug for Visibility {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Visibility({} faces, {} nodes)", self.faces.len(), self.tree.nodes.len())
    }
}

impl Visibility {
    /// Builds the index of all faces.
    pub fn new(prepared: &Prepared) -> Self {
        let index = Self::with_tree(prepared, |faces| {
            build_bvh2(faces, obvhs::BvhBuildParams::medium_build(), &mut Default::default())
        });
        let faces: Vec<FaceId> = prepared.faces.keys().collect();
        let slim = SlimTree::new(faces.par_iter().map(|&face| index.boundary_m(face)), faces.len());
        Self { slim, ..index }
    }

    /// An index without a tree, whose queries look at every face: the same answers, slowly. It is what benchmarks
    /// compare with.
    pub fn without_tree(prepared: &Prepared) -> Self {
        Self::with_tree(prepared, |faces| {
            let aabb = faces.iter().fold(Aabb::empty(), |all, face| all.union(&face.aabb()));
            Bvh2 {
                nodes: vec![Bvh2Node::new(aabb, faces.len() as u32, 0)],
                primitive_indices: (0..faces.len() as u32).collect(),
                ..Bvh2::default()
            }
        })
    }

    fn with_tree(prepared: &Prepared, build: impl FnOnce(&[IndexedFace]) -> Bvh2) -> Self {
        let mut corners_m = Vec::new();
        let mut faces: Table<FaceId, IndexedFace> = Table::new();
        for (id, face) in prepared.faces.iter_enumerated() {
            let start = corners_m.len();
            corners_m.extend(prepared.boundary(id).map(|v| prepared.vertices_m[v]));
            let mine = &corners_m[start..];
            let near = prepared.oriented_plane(id);
            let apart_m = mine.iter().map(|corner| near.signed_distance_m(*corner).abs()).fold(0.0, f64::max);
            faces.push(IndexedFace {
                plane: face.plane,
                boundary: (start as u32, corners_m.len() as u32),
                min_m: mine.iter().copied().fold(DVec3::INFINITY, DVec3::min),
                max_m: mine.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max),
                near: (near, apart_m + ROUNDED_OF_EXTENT * prepared.tolerance.extent_m),
            });
        }
        let tree = if faces.is_empty() { Bvh2::default() } else { build(faces.raw.as_slice()) };
        let boxes = faces.iter().map(Boundable::aabb).collect();
        let (around, covering) = (Around::new(prepared), Table::new());
        let index = Self { tree, slim: None, faces, boxes, corners_m, around, covering, tolerance: prepared.tolerance };
        let covering: Vec<_> =
            (0..prepared.faces.len()).into_par_iter().map(|own| index.lying_over(own.into())).collect();
        Self { covering: covering.into(), ..index }
    }

    /// The faces around the facets of smooth surfaces.
    pub(super) fn around(&self) -> &Around {
        &self.around
    }

    /// The faces that may cover points of a face ([`super::pair`]); hardly any face has one.
    pub(super) fn covering(&self, own: FaceId) -> &[FaceId] {
        &self.covering[own]
    }

    /// The tree of boxes that rays walk: they may meet a face more than once.
    pub(super) fn ray_tree(&self) -> &Bvh2 {
        self.slim.as_ref().map_or(&self.tree, SlimTree::tree)
    }

    /// The face of a primitive of that tree.
    pub(super) fn face_met(&self, primitive: u32) -> FaceId {
        self.slim.as_ref().map_or(FaceId::from(primitive as usize), |slim| slim.face(primitive))
    }

    /// The tree of boxes.
    pub(super) fn tree(&self) -> &Bvh2 {
        &self.tree
    }

    /// Whether there are no faces.
    pub(super) fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Tolerances of the scene that was indexed.
    pub fn tolerance(&self) -> Tolerance {
        self.tolerance
    }

    /// Whether both points are on one side of a face, farther from its plane than any of its corners: they may be where this is false.
    pub(super) fn is_beside(&self, face: FaceId, from_m: DVec3, to_m: DVec3) -> bool {
        let (plane, apart_m) = &self.faces[face].near;
        let [from, to] = [from_m, to_m].map(|end| plane.signed_distance_m(end));
        from.min(to) > *apart_m || from.max(to) < -apart_m
    }

    /// The plane of a face, towards its front.
    pub(super) fn near_plane(&self, face: FaceId) -> &Plane {
        &self.faces[face].near.0
    }

    /// The box of a face, in metres.
    pub(super) fn bounds_m(&self, face: FaceId) -> [DVec3; 2] {
        [self.faces[face].min_m, self.faces[face].max_m]
    }

    /// The plane that a face lies in.
    pub fn plane(&self, face: FaceId) -> PlaneId {
        self.faces[face].plane
    }

    /// The middle of a face's box and half its size, in metres.
    pub fn box_m(&self, face: FaceId) -> [DVec3; 2] {
        let IndexedFace { min_m, max_m, .. } = self.faces[face];
        [0.5 * (min_m + max_m), 0.5 * (max_m - min_m)]
    }

    /// All boundary vertices of a face, those inside straight sides included, counter-clockwise seen from its front, in
    /// metres.
    pub fn boundary_m(&self, face: FaceId) -> &[DVec3] {
        let (start, end) = self.faces[face].boundary;
        &self.corners_m[start as usize..end as usize]
    }

    /// Visits every face whose box passes `meets(min_m, max_m)`, until `visit` breaks. A box that contains a passing
    /// box must pass too.
    pub(crate) fn walk(&self, meets: impl Fn(DVec3, DVec3) -> bool, visit: impl FnMut(FaceId) -> ControlFlow<()>) {
        let rounded = |aabb: &Aabb| meets(aabb.min.as_dvec3(), aabb.max.as_dvec3());
        self.walk_among(None, rounded, &meets, visit);
    }

    /// Visits those of some faces whose boxes pass, as [`Self::walk`]; of all faces where none are given. The boxes are rounded outward
    /// for `may_meet`, which may pass more.
    pub(super) fn walk_among(
        &self,
        among: Option<&[FaceId]>,
        may_meet: impl Fn(&Aabb) -> bool,
        meets: impl Fn(DVec3, DVec3) -> bool,
        mut visit: impl FnMut(FaceId) -> ControlFlow<()>,
    ) {
        let mut visit_met = |face: FaceId| {
            let bounds = &self.faces[face];
            if meets(bounds.min_m, bounds.max_m) { visit(face) } else { ControlFlow::Continue(()) }
        };
        let Some(faces) = among else {
            return walk_nodes(&self.tree, may_meet, |primitive| visit_met(FaceId::from(primitive as usize)));
        };
        for &face in faces {
            if may_meet(&self.boxes[face]) && visit_met(face).is_break() {
                return;
            }
        }
    }

    /// The same along a ray, which may visit a face more than once.
    pub(super) fn walk_ray(
        &self,
        among: Option<&[FaceId]>,
        may_meet: impl Fn(&Aabb) -> bool,
        meets: impl Fn(DVec3, DVec3) -> bool,
        mut visit: impl FnMut(FaceId) -> ControlFlow<()>,
    ) {
        let Some(slim) = self.slim.as_ref().filter(|_| among.is_none()) else {
            return self.walk_among(among, may_meet, meets, visit);
        };
        walk_nodes(slim.tree(), may_meet, |primitive| visit(slim.face(primitive)));
    }
}

/// Visits the primitives in the nodes that pass.
fn walk_nodes(tree: &Bvh2, may_meet: impl Fn(&Aabb) -> bool, mut visit: impl FnMut(u32) -> ControlFlow<()>) {
    let mut stack: smallvec::SmallVec<[u32; 64]> = smallvec::SmallVec::new();
    if !tree.nodes.is_empty() {
        stack.push(0);
    }
    while let Some(index) = stack.pop() {
        let node = &tree.nodes[index as usize];
        if !may_meet(node.aabb()) {
            continue;
        }
        let first = node.first_index;
        if !node.is_leaf() {
            stack.push(first + 1);
            stack.push(first);
            continue;
        }
        let range = first as usize..(first + node.prim_count) as usize;
        for &primitive in &tree.primitive_indices[range] {
            if visit(primitive).is_break() {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn a_walk_finds_the_same_faces_as_a_search(
            centres in prop::collection::vec((-5.0..5.0, -5.0..5.0, -5.0..5.0), 1..60),
            lo in (-5.0..5.0, -5.0..5.0, -5.0..5.0),
            size in 0.0..5.0,
        ) {
            let polygons: Vec<_> = centres
                .iter()
                .map(|&c| [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| fixture::f32_point(DVec3::from(c) + p)).to_vec())
                .collect();
            let prepared = fixture::prepared(&polygons);
            let index = Visibility::new(&prepared);
            let (lo, hi) = (DVec3::from(lo), DVec3::from(lo) + size);
            let meets = |min: DVec3, max: DVec3| min.cmple(hi).all() && max.cmpge(lo).all();
            let mut found = Vec::new();
            index.walk(meets, |face| {
                found.push(face);
                ControlFlow::Continue(())
            });
            found.sort_unstable();
            let expected: Vec<FaceId> = prepared.faces.keys().filter(|&f| {
                let corners = index.boundary_m(f);
                meets(
                    corners.iter().copied().fold(DVec3::INFINITY, DVec3::min),
                    corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max),
                )
            }).collect();
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn an_empty_scene_has_an_empty_index() {
        let index = Visibility::new(&fixture::prepared(&[]));
        index.walk(|_, _| true, |_| panic!("a face in an empty scene"));
    }
}
