//! Which corners of triangles share one value of irradiance.
//!
//! Around a vertex, the corners of triangles that meet along edges share a value where these are coplanar and look the same way, or are
//! one smooth surface, except across a contact (D0): there the value jumps, and each side has its own. The side is told by the patch that owns the
//! corner, never by a coordinate. Where a contact ends or turns, the irradiance depends on the direction from which the
//! vertex is approached, and every corner keeps a value of its own.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::field::Places;
use crate::discontinuity::is_contact;
use crate::geometry::DisjointSets;
use crate::id::{EdgeId, FaceId, PatchId, Table, VertexId};
use crate::mesh::Mesh;
use crate::prepare::Prepared;

/// An angle at a vertex that differs from a half or whole turn by less than this, in radians, is one: rounding of `f32`
/// vertices turns the edges of slim triangles by more than that of `f64`.
const SAME_ANGLE_RAD: f64 = 1e-3;
/// On a smooth surface the corners to one side of a contact may make up so much less or more than half a turn, in radians: the surface
/// is curved.
const CURVED_ANGLE_RAD: f64 = 0.6;

/// A triangle of the display mesh: a leaf patch with its three vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) patch: PatchId,
    pub(super) face: FaceId,
    pub(super) vertices: [VertexId; 3],
    edges: [EdgeId; 3],
}

/// Corners that share one value of irradiance.
#[derive(Clone, Debug)]
pub(super) struct CornerGroup {
    pub(super) vertex: VertexId,
    /// A face that the corners lie on: the others are coplanar with it and look the same way, or are one smooth surface with it.
    pub(super) face: FaceId,
    /// The first of its triangles.
    pub(super) first_triangle: usize,
    /// The largest of them: what is far from its border is on the side of a jump that the corners are on.
    pub(super) largest_triangle: usize,
    /// Where to evaluate the irradiance: inside the corners, and at the vertex itself only where they surround it.
    pub(super) at_m: DVec3,
}

/// The leaf triangles of a triangulated mesh, in the order of their patches.
pub(super) fn triangles(mesh: &Mesh) -> Vec<Triangle> {
    mesh.leaves()
        .filter_map(|patch| {
            let boundary = mesh.boundary(patch);
            let [a, b, c] = boundary[..] else { return None };
            Some(Triangle {
                patch,
                face: mesh.patch(patch).face,
                vertices: [a.vertex, b.vertex, c.vertex],
                edges: [a.leaf.edge, b.leaf.edge, c.leaf.edge],
            })
        })
        .collect()
}

/// Groups the corners of all triangles. Returns the groups, in the order of their first corners, and for each triangle
/// the groups of its three corners.
pub(super) fn corner_groups(
    prepared: &Prepared,
    mesh: &Mesh,
    places: &Places<'_>,
    triangles: &[Triangle],
) -> (Vec<CornerGroup>, Vec<[usize; 3]>) {
    let mut links = DisjointSets::new(3 * triangles.len());
    let mut at_contact = vec![false; 3 * triangles.len()];
    let mut along: Table<EdgeId, Vec<(usize, usize)>> = vec![Vec::new(); mesh.edges().len()].into();
    for (number, triangle) in triangles.iter().enumerate() {
        for (i, &edge) in triangle.edges.iter().enumerate() {
            let root = mesh.edges().root(edge);
            let contact = mesh.is_jump(root)
                || (root.index() < prepared.edges.len()
                    && (is_contact(prepared, root, triangle.face) || prepared.has_rim(root, triangle.face)));
            if contact {
                at_contact[3 * number + i] = true;
                at_contact[3 * number + (i + 1) % 3] = true;
            } else {
                along[edge].push((number, i));
            }
        }
    }
    for (edge, sharing) in along.iter_enumerated() {
        let root = mesh.edges().root(edge);
        for (k, &(one, i)) in sharing.iter().enumerate() {
            for &(other, j) in &sharing[k + 1..] {
                if places.is_one_side(root, [one, other].map(|number| triangles[number].face)) {
                    // The two triangles pass along their common edge in opposite directions.
                    links.join(3 * one + i, 3 * other + (j + 1) % 3);
                    links.join(3 * one + (i + 1) % 3, 3 * other + j);
                }
            }
        }
    }
    collect(prepared, mesh, triangles, &mut links, &at_contact)
}

/// Makes groups from joined corners; those at the end or turn of a contact are taken apart.
fn collect(
    prepared: &Prepared,
    mesh: &Mesh,
    triangles: &[Triangle],
    links: &mut DisjointSets,
    at_contact: &[bool],
) -> (Vec<CornerGroup>, Vec<[usize; 3]>) {
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); 3 * triangles.len()];
    (0..members.len()).for_each(|corner| members[links.first_of(corner)].push(corner));
    let mut groups = Vec::new();
    let mut group_of = vec![[0; 3]; triangles.len()];
    for corners in members.iter().filter(|corners| !corners.is_empty()) {
        let turn_rad: f64 = corners.iter().map(|&corner| angle_rad(mesh, triangles, corner)).sum();
        let contact = corners.iter().any(|&corner| at_contact[corner]);
        let is_smooth = prepared.is_smooth(triangles[corners[0] / 3].face);
        let slack_rad = if is_smooth { CURVED_ANGLE_RAD } else { SAME_ANGLE_RAD };
        let apart = contact && (turn_rad - PI).abs() > slack_rad;
        let parts: Vec<&[usize]> = if apart { corners.chunks(1).collect() } else { vec![corners] };
        for part in parts {
            let surrounded = !apart && (turn_rad - TAU).abs() < SAME_ANGLE_RAD;
            part.iter().for_each(|&corner| group_of[corner / 3][corner % 3] = groups.len());
            groups.push(group(prepared, mesh, triangles, part, surrounded));
        }
    }
    (groups, group_of)
}

/// Angle of a triangle at a corner, in radians.
fn angle_rad(mesh: &Mesh, triangles: &[Triangle], corner: usize) -> f64 {
    let [at, next, previous] = corner_points(mesh, triangles, corner);
    (next - at).angle_between(previous - at)
}

/// A corner, the next and the one after, of its triangle.
fn corner_points(mesh: &Mesh, triangles: &[Triangle], corner: usize) -> [DVec3; 3] {
    let vertices = triangles[corner / 3].vertices;
    [0, 1, 2].map(|k| mesh.vertex_m(vertices[(corner + k) % 3]))
}

/// How far inside a triangle its limit is taken, as a share of its height over the corner.
const INSIDE: f64 = 1e-3;
/// And at most this share of the extent.
const INSIDE_OF_EXTENT: f64 = 1e-5;

fn group(prepared: &Prepared, mesh: &Mesh, triangles: &[Triangle], corners: &[usize], surrounded: bool) -> CornerGroup {
    let first = triangles[corners[0] / 3];
    let vertex = first.vertices[corners[0] % 3];
    let at_m = mesh.vertex_m(vertex);
    let mut bisector = DVec3::ZERO;
    let mut reach_m = INSIDE_OF_EXTENT * prepared.tolerance.extent_m;
    let (mut largest_triangle, mut largest_m2) = (corners[0] / 3, 0.0);
    for &corner in corners {
        let [at, next, previous] = corner_points(mesh, triangles, corner);
        let direction = ((next - at).normalize_or_zero() + (previous - at).normalize_or_zero()).normalize_or_zero();
        bisector += direction * (next - at).angle_between(previous - at);
        let doubled_m2 = (next - at).cross(previous - at).length();
        if doubled_m2 > largest_m2 {
            (largest_triangle, largest_m2) = (corner / 3, doubled_m2);
        }
        let height_m = doubled_m2 / next.distance(previous).max(f64::MIN_POSITIVE);
        reach_m = reach_m.min(INSIDE * height_m);
    }
    let inside_m = if surrounded { at_m } else { at_m + reach_m * bisector.normalize_or_zero() };
    CornerGroup { vertex, face: first.face, first_triangle: corners[0] / 3, largest_triangle, at_m: inside_m }
}
