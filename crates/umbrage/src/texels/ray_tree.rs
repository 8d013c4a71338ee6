//! Rays near the hardware: a tree of boxes, eight side by side, over the triangles of all faces, in `f32`.
//!
//! [`Visibility`](crate::visibility::Visibility) answers by exact signs; a ray of a random sample need not. Its error is a share of
//! the scene's extent ([`RayTree::start`] lifts rays off their faces by more), and it is some ten times as fast: eight boxes or
//! eight triangles are tested at once (Wald, Benthin and Boulos, *Getting rid of packets*, 2008; triangles: Möller and
//! Trumbore, 1997). The tree comes from the builder of [`Visibility`](crate::visibility::Visibility), with eight children pulled up
//! to each node.
//!
//! A sheet with two sides is two faces with one boundary: it is one triangle here, which names the face of each side.
//!
//! Holds: no ray passes between triangles that share an edge; the answer does not depend on threads.

use std::fmt;

use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use rustc_hash::FxHashMap;
use smallvec::{SmallVec, smallvec};
use wide::f32x8;

use crate::id::{FaceId, VertexId};
use crate::prepare::Prepared;

/// Children of a node, and triangles of a block.
const WIDE: usize = 8;
/// A ray starts so far before its face, as a share of the extent: 30 times the rounding of coordinates in `f32`.
const OFF_FACE_OF_EXTENT: f64 = 4e-6;
/// A triangle reaches so far beyond its edges, as a share of them: neighbours overlap by rounding, and nothing passes between.
const BEYOND_EDGE: f32 = 1e-6;
/// A box is entered no later than told, but for this share: rounding of two products.
const BOX_SLACK: f32 = 1.0 + 4e-7;
/// In place of zero along an axis that a ray does not follow.
const LEAST_ALONG: f32 = 1e-12;
/// What a further box costs in tests of one triangle, where eight are tested at once: the builder fills blocks.
const BLOCK_OF_TRIANGLE: f32 = 6.0;

/// No child, no face.
const NONE: u32 = u32::MAX;
/// Marks children that are blocks of triangles.
const BLOCK: u32 = 1 << 31;

/// Eight boxes.
#[derive(Clone)]
struct Node {
    low: [f32x8; 3],
    high: [f32x8; 3],
    child: [u32; WIDE],
}

/// Eight triangles: a corner and the edges from it.
#[derive(Clone)]
struct Block {
    corner: [f32x8; 3],
    edges: [[f32x8; 3]; 2],
    /// The face whose front looks along the triangle's normal, and the one that looks the other way.
    faces: [[u32; 2]; WIDE],
}

/// A triangle of the sheet of a face.
#[derive(Clone, Copy)]
struct Triangle {
    corners: [Vec3; 3],
    faces: [u32; 2],
}

impl Boundable for Triangle {
    fn aabb(&self) -> Aabb {
        let mut aabb = Aabb::empty();
        self.corners.iter().for_each(|&corner| {
            aabb.extend(Vec3A::from(corner.map(f32::next_down)));
            aabb.extend(Vec3A::from(corner.map(f32::next_up)));
        });
        aabb
    }
}

/// A ray: a start before a face, and a unit direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) from: Vec3,
    pub(crate) along: Vec3,
}

/// The first side of a sheet that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayHit {
    /// The face whose front it is; `None` for a back.
    pub(crate) front: Option<FaceId>,
    /// How far away it is, in metres.
    pub(crate) distance_m: f32,
}

/// The triangles of all faces, for rays.
#[derive(Clone)]
pub struct RayTree {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
    /// How far before faces rays start, in metres.
    off_face_m: f32,
    /// A ray of this length leaves the scene from anywhere inside, in metres.
    far_m: f32,
}

impl fmt::Debug for RayTree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "RayTree({} nodes, {} blocks)", self.nodes.len(), self.blocks.len())
    }
}

impl RayTree {
    /// Builds the tree over all faces.
    pub(crate) fn new(prepared: &Prepared) -> Self {
        let triangles = triangles_of(prepared);
        let extent_m = prepared.tolerance.extent_m;
        let mut tree = Self {
            nodes: Vec::new(),
            blocks: Vec::new(),
            off_face_m: (OFF_FACE_OF_EXTENT * extent_m) as f32,
            far_m: (4.0 * extent_m) as f32,
        };
        if !triangles.is_empty() {
            tree.collapse(&triangles);
        }
        tree
    }

    /// Where a ray starts that leaves a point of a face in the direction of its normal.
    pub(crate) fn start(&self, at_m: DVec3, normal: DVec3) -> Vec3 {
        (at_m + f64::from(self.off_face_m) * normal).as_vec3()
    }

    /// Finds the first side that a ray meets.
    pub(crate) fn first(&self, ray: Ray) -> Option<RayHit> {
        self.trace::<false>(ray, self.far_m)
    }

    /// Whether nothing stands between two points, but at their very ends.
    pub(crate) fn is_clear(&self, from: Vec3, to: Vec3) -> bool {
        let between = to - from;
        let length = between.length();
        let ray = Ray { from, along: between / length };
        length <= 0.0 || self.trace::<true>(ray, length - 4.0 * self.off_face_m).is_none()
    }

    /// The first side that a ray meets within a distance; with `ANY`, any of them.
    fn trace<const ANY: bool>(&self, ray: Ray, within_m: f32) -> Option<RayHit> {
        let slabs = Slabs::new(&ray);
        let mut nearest = within_m;
        let mut hit = None;
        let mut stack: SmallVec<[(u32, f32); 96]> = SmallVec::new();
        if self.nodes.is_empty() {
            return None;
        }
        let mut next = Some(0_u32);
        loop {
            let current = match next.take() {
                Some(current) => current,
                None => match stack.pop() {
                    Some((child, enters)) if enters <= nearest => child,
                    Some(_) => continue,
                    None => break,
                },
            };
            if current & BLOCK != 0 {
                let block = &self.blocks[(current & !BLOCK) as usize];
                if block.meet(&ray, &mut nearest, &mut hit) && ANY {
                    return hit;
                }
                continue;
            }
            let node = &self.nodes[current as usize];
            let (mut met, enters) = slabs.meet(node, nearest);
            let base = stack.len();
            while met != 0 {
                let i = met.trailing_zeros() as usize;
                met &= met - 1;
                let (child, at) = (node.child[i], enters[i]);
                // Nearest on top.
                let mut place = stack.len();
                stack.push((child, at));
                while place > base && stack[place - 1].1 < at {
                    stack[place] = stack[place - 1];
                    place -= 1;
                }
                stack[place] = (child, at);
            }
            if stack.len() > base {
                next = stack.pop().map(|(child, _)| child);
            }
        }
        hit
    }

    /// Makes the nodes and blocks: to each node the largest boxes below it are pulled up until it has eight.
    fn collapse(&mut self, triangles: &[Triangle]) {
        let params = BvhBuildParams {
            max_prims_per_leaf: WIDE as u32,
            collapse_traversal_cost: BLOCK_OF_TRIANGLE,
            ..BvhBuildParams::medium_build()
        };
        let tree = build_bvh2(triangles, params, &mut Default::default());
        let nodes = &tree.nodes;
        // Nodes that are not made yet, and the places where they are named.
        let mut open: Vec<(usize, Option<(usize, usize)>)> = vec![(0, None)];
        while let Some((index, named)) = open.pop() {
            let number = self.nodes.len();
            if let Some((parent, place)) = named {
                self.nodes[parent].child[place] = number as u32;
            }
            let parts = |index: usize| {
                let first = nodes[index].first_index as usize;
                [first, first + 1]
            };
            let mut children: SmallVec<[usize; WIDE]> =
                if nodes[index].is_leaf() { smallvec![index] } else { SmallVec::from_slice(&parts(index)) };
            while children.len() < WIDE {
                let inner = (0..children.len()).filter(|&i| !nodes[children[i]].is_leaf());
                let half_area = |i: usize| nodes[children[i]].aabb().half_area();
                let Some(largest) = inner.max_by(|&a, &b| half_area(a).total_cmp(&half_area(b))) else { break };
                let [one, other] = parts(children[largest]);
                children[largest] = one;
                children.push(other);
            }
            let (mut low, mut high) = ([[f32::INFINITY; WIDE]; 3], [[f32::NEG_INFINITY; WIDE]; 3]);
            let mut child = [NONE; WIDE];
            for (place, &index) in children.iter().enumerate() {
                let node = &nodes[index];
                for k in 0..3 {
                    (low[k][place], high[k][place]) = (node.aabb().min[k], node.aabb().max[k]);
                }
                if node.is_leaf() {
                    let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
                    let members = tree.primitive_indices[range].iter().map(|&member| &triangles[member as usize]);
                    child[place] = BLOCK | self.blocks.len() as u32;
                    self.blocks.push(Block::new(members));
                } else {
                    open.push((index, Some((number, place))));
                }
            }
            self.nodes.push(Node { low: low.map(f32x8::from), high: high.map(f32x8::from), child });
        }
    }
}

/// A ray, made for the question which boxes it meets.
struct Slabs {
    per_m: [f32x8; 3],
    from_m: [f32x8; 3],
    is_backward: [bool; 3],
}

impl Slabs {
    fn new(ray: &Ray) -> Self {
        let per_m = ray.along.map(|x| 1.0 / if x.abs() < LEAST_ALONG { LEAST_ALONG.copysign(x) } else { x });
        Self {
            per_m: per_m.to_array().map(f32x8::splat),
            from_m: ray.from.to_array().map(f32x8::splat),
            is_backward: per_m.to_array().map(|per_m| per_m < 0.0),
        }
    }

    /// The boxes that the ray meets within a distance, as bits, and where it enters them.
    fn meet(&self, node: &Node, within_m: f32) -> (u32, [f32; WIDE]) {
        let (mut enters, mut leaves) = (f32x8::ZERO, f32x8::splat(within_m));
        for k in 0..3 {
            let ends = [node.low[k], node.high[k]].map(|end| (end - self.from_m[k]) * self.per_m[k]);
            let [near, far] = if self.is_backward[k] { [ends[1], ends[0]] } else { ends };
            enters = enters.fast_max(near);
            leaves = leaves.fast_min(far);
        }
        (enters.simd_le(leaves * f32x8::splat(BOX_SLACK)).to_bitmask(), enters.to_array())
    }
}

impl Block {
    fn new<'a>(triangles: impl Iterator<Item = &'a Triangle>) -> Self {
        let mut corner = [[f32::INFINITY; WIDE]; 3];
        let mut edges = [[[0.0; WIDE]; 3]; 2];
        let mut faces = [[NONE; 2]; WIDE];
        for (place, triangle) in triangles.enumerate().take(WIDE) {
            let [a, b, c] = triangle.corners;
            for k in 0..3 {
                corner[k][place] = a[k];
                edges[0][k][place] = b[k] - a[k];
                edges[1][k][place] = c[k] - a[k];
            }
            faces[place] = triangle.faces;
        }
        Self { corner: corner.map(f32x8::from), edges: edges.map(|edge| edge.map(f32x8::from)), faces }
    }

    /// Notes the nearest of the triangles that a ray meets before `nearest`; whether there is any.
    fn meet(&self, ray: &Ray, nearest: &mut f32, hit: &mut Option<RayHit>) -> bool {
        let along = ray.along.to_array().map(f32x8::splat);
        let from = ray.from.to_array().map(f32x8::splat);
        let [first, second] = &self.edges;
        let across = cross(&along, second);
        let volume = dot(first, &across);
        let per_volume = f32x8::ONE / volume;
        let to_from = [0, 1, 2].map(|k| from[k] - self.corner[k]);
        let turned = cross(&to_from, first);
        let u = dot(&to_from, &across) * per_volume;
        let v = dot(&along, &turned) * per_volume;
        let distance = dot(second, &turned) * per_volume;
        let least = f32x8::splat(-BEYOND_EDGE);
        // What is not a number, as in places without a triangle, compares as false.
        let inside = u.simd_ge(least) & v.simd_ge(least) & (u + v).simd_le(f32x8::splat(1.0 + BEYOND_EDGE));
        let met = inside & distance.simd_gt(f32x8::ZERO) & distance.simd_lt(f32x8::splat(*nearest));
        let mut met = met.to_bitmask();
        if met == 0 {
            return false;
        }
        let (distances, volumes) = (distance.to_array(), volume.to_array());
        while met != 0 {
            let place = met.trailing_zeros() as usize;
            met &= met - 1;
            if distances[place] < *nearest {
                *nearest = distances[place];
                let face = self.faces[place][usize::from(volumes[place] < 0.0)];
                let front = (face != NONE).then(|| FaceId::from(face as usize));
                *hit = Some(RayHit { front, distance_m: *nearest });
            }
        }
        true
    }
}

fn cross(a: &[f32x8; 3], b: &[f32x8; 3]) -> [f32x8; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: &[f32x8; 3], b: &[f32x8; 3]) -> f32x8 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The triangles of all sheets. They have all boundary vertices, so that faces that share an edge meet in the same points.
fn triangles_of(prepared: &Prepared) -> Vec<Triangle> {
    let mut sheets: FxHashMap<Vec<VertexId>, usize> = FxHashMap::default();
    let mut faces: Vec<(FaceId, Option<FaceId>)> = Vec::new();
    for face in prepared.faces.keys() {
        let mut boundary: Vec<VertexId> = prepared.boundary(face).collect();
        boundary.sort_unstable();
        let sheet = *sheets.entry(boundary).or_insert(faces.len());
        let is_other_side = faces
            .get(sheet)
            .is_some_and(|&(front, back)| back.is_none() && prepared.normal(front).dot(prepared.normal(face)) < 0.0);
        if is_other_side {
            faces[sheet].1 = Some(face);
        } else {
            faces.push((face, None));
        }
    }
    let mut triangles = Vec::new();
    for (front, back) in faces {
        let boundary: Vec<Vec3> =
            prepared.boundary(front).map(|vertex| prepared.vertices_m[vertex].as_vec3()).collect();
        let sides = [front.index() as u32, back.map_or(NONE, |back| back.index() as u32)];
        let mut push = |corners: [Vec3; 3]| triangles.push(Triangle { corners, faces: sides });
        if boundary.len() == prepared.faces[front].sides.len() {
            boundary[1..].windows(2).for_each(|pair| push([boundary[0], pair[0], pair[1]]));
        } else {
            let middle = boundary.iter().sum::<Vec3>() / boundary.len() as f32;
            (0..boundary.len()).for_each(|i| push([middle, boundary[i], boundary[(i + 1) % boundary.len()]]));
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::polygon;
    use crate::visibility::fixture;
    use crate::visibility::{FirstMet, Visibility};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_meets_the_same_sides_as_exact_signs(
            centres in prop::collection::vec((-2.0..2.0, -2.0..2.0, -2.0..2.0), 1..60),
            from in (-3.0..3.0, -3.0..3.0, -3.0..3.0), to in (-3.0..3.0, -3.0..3.0, -3.0..3.0),
        ) {
            let prepared = fixture::prepared(&fixture::boxes(&centres));
            let (tree, index) = (RayTree::new(&prepared), Visibility::new(&prepared));
            let from = DVec3::from(from).as_vec3();
            let along = (DVec3::from(to).as_vec3() - from).normalize();
            prop_assume!(along.is_finite());
            let far_m = from.as_dvec3() + f64::from(tree.far_m) * along.as_dvec3();
            let found = tree.first(Ray { from, along });
            // Beside an edge, rounding decides.
            let at_edge = |face: FaceId, at_m: DVec3| {
                polygon::distance_m(at_m, &prepared.polygon_m(face), &prepared.oriented_plane(face)) > 0.0
                    || prepared.polygon_m(face).iter().zip(prepared.polygon_m(face).iter().cycle().skip(1)).any(|(p, q)| {
                        (at_m - p).cross((q - p).normalize()).length() < 1e-5
                    })
            };
            let front = match index.first_met(from.as_dvec3(), far_m, None) {
                FirstMet::Front(face, at_m) => { prop_assume!(!at_edge(face, at_m)); Some(Some(face)) }
                FirstMet::Back(_) => Some(None),
                FirstMet::Nothing => None,
            };
            let same = found.map(|hit| hit.front) == front;
            // A face may be one of two that overlap.
            let near = found.is_some_and(|hit| {
                let at_m = (from + hit.distance_m * along).as_dvec3();
                hit.front.is_some_and(|face| at_edge(face, at_m))
            });
            prop_assert!(same || near || found.is_some() == front.is_some(), "{found:?} is not {front:?}");
        }
    }

    #[test]
    fn nothing_slips_through_shared_edges() {
        // A floor of many triangles around one point.
        let rim = |i: u32| DVec3::new((f64::from(i) * 0.7).cos(), (f64::from(i) * 0.7).sin(), 0.0);
        let fan: Vec<_> = (0..8).map(|i| [DVec3::ZERO, rim(i), rim(i + 1)].map(fixture::f32_point).to_vec()).collect();
        let prepared = fixture::prepared(&fan);
        let tree = RayTree::new(&prepared);
        for i in 0..5_000_u32 {
            let [s, t] = [0.618_034, 0.754_878].map(|step| (f64::from(i) * step).fract());
            let edge = rim(i % 8) * s * 0.999;
            let from = DVec3::new(2.0 * t - 1.0, s - 0.5, 1.0).as_vec3();
            let along = (edge.as_vec3() - from).normalize();
            assert!(tree.first(Ray { from, along }).is_some_and(|hit| hit.front.is_some()), "{i}");
        }
    }

    #[test]
    fn a_sheet_of_two_sides_is_one_triangle_with_two_names() {
        let (up, down) = (fixture::square(DVec3::Z, 1.0, true), fixture::square(DVec3::Z, 1.0, false));
        for sheet in [[up.clone(), down.clone()], [down, up]] {
            let prepared = fixture::prepared(&sheet);
            let tree = RayTree::new(&prepared);
            assert_eq!(triangles_of(&prepared).len(), 2);
            for height in [0.0, 2.0_f32] {
                let ray = Ray { from: Vec3::new(0.3, 0.2, height), along: Vec3::new(0.0, 0.0, 1.0 - height) };
                let hit = tree.first(ray).unwrap();
                let normal = prepared.normal(hit.front.unwrap());
                assert!(normal.z as f32 * (height - 1.0) > 0.0 && hit.distance_m == 1.0);
            }
        }
    }
}
