//! Smooth shading: faces that stand for a curved surface show its light, not that of their facets.
//!
//! The light of each facet is exact for that facet, and jumps from one to the next, where the curved surface has one value.
//! So, around a vertex, the values of all corners that smooth edges join become their mean, weighted by angle: that is the value
//! that Gouraud shading wants. What is inside a facet, because a shadow cut it there, moves along: by the mean value
//! coordinates (Floater 2003; Hormann and Floater 2006) of what its boundary moved by, so that the detail stays and no
//! seam is seen.
//!
//! An edge is smooth where two faces agree on the normals along it, and bend by little. Across a contact
//! (D0) nothing is averaged: its two sides never share a value.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::corner_group::{CornerGroup, DisjointSets, Triangle, angle_rad};
use crate::discontinuity::is_contact;
use crate::id::{EdgeId, FaceId, Table, VertexId};
use crate::mesh::Mesh;
use crate::prepare::{Prepared, is_smooth_at};
use crate::scene::Rgb;

/// A point sees the two ends of an edge of its polygon under half a turn, and so lies on it, if the sine of the angle is
/// below this: rounding of `f32` vertices.
const ON_EDGE_SINE: f64 = 1e-6;

/// The values of all groups, smooth where the surface is.
pub(super) fn smooth(
    prepared: &Prepared,
    mesh: &Mesh,
    triangles: &[Triangle],
    groups: &[CornerGroup],
    group_of: &[[usize; 3]],
    values: &[Rgb],
) -> Vec<Rgb> {
    let mut by_face: BTreeMap<FaceId, Vec<usize>> = BTreeMap::new();
    for (number, triangle) in triangles.iter().enumerate().filter(|(_, t)| prepared.is_smooth(t.face)) {
        by_face.entry(triangle.face).or_default().push(number);
    }
    let mut smooth = values.to_vec();
    if by_face.is_empty() {
        return smooth;
    }
    let joints = Joints::new(prepared, mesh, triangles);
    let mut fans = joints.fans(groups.len(), group_of);
    let mut weight = vec![0.0; groups.len()];
    for (corner, &group) in group_of.as_flattened().iter().enumerate() {
        weight[group] += angle_rad(mesh, triangles, corner);
    }
    let mut sums = vec![(Rgb::ZERO, 0.0, 0); groups.len()];
    for (group, (&value, &weight)) in values.iter().zip(&weight).enumerate() {
        let sum = &mut sums[fans.first_of(group)];
        *sum = (sum.0 + weight * value, sum.1 + weight, sum.2 + 1);
    }
    for (group, value) in smooth.iter_mut().enumerate() {
        let (sum, weight, members) = sums[fans.first_of(group)];
        if members > 1 && weight > 0.0 {
            *value = sum / weight;
        }
    }
    for (&face, numbers) in &by_face {
        let facet = Facet { prepared, mesh, triangles, groups, group_of, joints: &joints, face };
        facet.move_along(numbers, values, &mut smooth);
    }
    smooth
}

/// The edges across which a surface is smooth.
struct Joints {
    /// Corners of triangles that lie on each other at the ends of smooth edges.
    pairs: Vec<[usize; 2]>,
    /// Whether a leaf edge is smooth.
    is_smooth: Table<EdgeId, bool>,
}

impl Joints {
    fn new(prepared: &Prepared, mesh: &Mesh, triangles: &[Triangle]) -> Self {
        let mut along: Vec<(EdgeId, usize, usize)> = Vec::new();
        for (number, triangle) in triangles.iter().enumerate().filter(|(_, t)| prepared.is_smooth(t.face)) {
            for (i, &edge) in triangle.edges.iter().enumerate() {
                // Edges within a face are of one facet.
                if mesh.edges().root(edge).index() < prepared.edges.len() {
                    along.push((edge, number, i));
                }
            }
        }
        along.sort_unstable();
        let mut joints = Self { pairs: Vec::new(), is_smooth: vec![false; mesh.edges().len()].into() };
        for sharing in along.chunk_by(|x, y| x.0 == y.0) {
            for (k, &(edge, one, i)) in sharing.iter().enumerate() {
                for &(_, other, j) in &sharing[k + 1..] {
                    let faces = [triangles[one].face, triangles[other].face];
                    let opposite = triangles[one].vertices[i] == triangles[other].vertices[(j + 1) % 3];
                    if opposite && is_smooth(prepared, mesh, edge, faces) {
                        joints.is_smooth[edge] = true;
                        joints.pairs.push([3 * one + i, 3 * other + (j + 1) % 3]);
                        joints.pairs.push([3 * one + (i + 1) % 3, 3 * other + j]);
                    }
                }
            }
        }
        joints
    }

    /// The groups that are joined around vertices.
    fn fans(&self, groups: usize, group_of: &[[usize; 3]]) -> DisjointSets {
        let mut fans = DisjointSets::new(groups);
        for pair in &self.pairs {
            let [one, other] = pair.map(|corner| group_of[corner / 3][corner % 3]);
            fans.join(one, other);
        }
        fans
    }
}

/// Whether the surface is smooth across an edge between two faces that pass along it in opposite directions.
fn is_smooth(prepared: &Prepared, mesh: &Mesh, edge: EdgeId, faces: [FaceId; 2]) -> bool {
    let root = mesh.edges().root(edge);
    let [one, other] = faces;
    one != other
        && prepared.faces[one].plane != prepared.faces[other].plane
        && !mesh.is_jump(root)
        && !faces.iter().any(|&face| is_contact(prepared, root, face))
        && mesh.edges().ends(edge).iter().all(|&end| {
            let at_m = mesh.vertex_m(end);
            is_smooth_at(faces.map(|face| prepared.normal(face)), faces.map(|face| prepared.smooth_normal(face, at_m)))
        })
}

/// A face of a smooth surface.
struct Facet<'a> {
    prepared: &'a Prepared,
    mesh: &'a Mesh,
    triangles: &'a [Triangle],
    groups: &'a [CornerGroup],
    group_of: &'a [[usize; 3]],
    joints: &'a Joints,
    face: FaceId,
}

impl Facet<'_> {
    /// Moves the values inside the face by what those of its boundary have moved. `numbers` are its triangles.
    fn move_along(&self, numbers: &[usize], before: &[Rgb], after: &mut [Rgb]) {
        let pins = self.pins();
        if numbers.iter().all(|&number| self.triangles[number].vertices.iter().all(|v| pins.contains(v))) {
            return;
        }
        let mut moved = vec![None; pins.len()];
        let mut inside = Vec::new();
        for &number in numbers {
            for (vertex, group) in self.triangles[number].vertices.iter().zip(self.group_of[number]) {
                match pins.iter().position(|pin| pin == vertex) {
                    Some(pin) => moved[pin] = moved[pin].or(Some(after[group] - before[group])),
                    None => inside.push(group),
                }
            }
        }
        inside.sort_unstable();
        inside.dedup();
        let frame = self.prepared.face_frame(self.face);
        let flat: Vec<DVec2> = pins.iter().map(|&v| frame.to_2d(self.mesh.vertex_m(v))).collect();
        let moved: Vec<Rgb> = moved.into_iter().map(Option::unwrap_or_default).collect();
        for group in inside {
            let at = frame.to_2d(self.mesh.vertex_m(self.groups[group].vertex));
            let by: Rgb = mean_value_coordinates(&flat, at).iter().zip(&moved).map(|(&share, &by)| share * by).sum();
            after[group] = (before[group] + by).max(Rgb::ZERO);
        }
    }

    /// The points of the boundary whose values are known: the face's own corners, and those on smooth edges.
    fn pins(&self) -> Vec<VertexId> {
        let boundary = self.mesh.boundary(self.mesh.root(self.face));
        let n = boundary.len();
        let is_pin = |i: usize| {
            let smooth = [i, (i + n - 1) % n].iter().any(|&k| self.joints.is_smooth[boundary[k].leaf.edge]);
            smooth || boundary[i].vertex.index() < self.prepared.vertices_m.len()
        };
        (0..n).filter(|&i| is_pin(i)).map(|i| boundary[i].vertex).collect()
    }
}

/// The shares of a polygon's corners in a point inside or on it: they sum to one, and are linear along its edges.
fn mean_value_coordinates(polygon: &[DVec2], at: DVec2) -> Vec<f64> {
    let n = polygon.len();
    let to: Vec<DVec2> = polygon.iter().map(|&p| p - at).collect();
    let mut shares = vec![0.0; n];
    if let Some(corner) = to.iter().position(|d| *d == DVec2::ZERO) {
        shares[corner] = 1.0;
        return shares;
    }
    // The tangent of half the angle under which each edge is seen.
    let mut tangents = Vec::with_capacity(n);
    for i in 0..n {
        let (one, other) = (to[i], to[(i + 1) % n]);
        let (r, s) = (one.length(), other.length());
        let (sine, cosine) = (one.perp_dot(other) / (r * s), one.dot(other) / (r * s));
        if sine.abs() < ON_EDGE_SINE && cosine < 0.0 {
            (shares[i], shares[(i + 1) % n]) = (s / (r + s), r / (r + s));
            return shares;
        }
        tangents.push(if sine == 0.0 { 0.0 } else { (1.0 - cosine) / sine });
    }
    for i in 0..n {
        shares[i] = (tangents[i] + tangents[(i + n - 1) % n]) / to[i].length();
    }
    let sum: f64 = shares.iter().sum();
    shares.iter_mut().for_each(|share| *share /= sum);
    shares
}

/// The normal that a vertex shows: that of the smooth surface that its face stands for.
pub(super) fn normal(prepared: &Prepared, face: FaceId, at_m: DVec3) -> [f32; 3] {
    prepared.smooth_normal(face, at_m).as_vec3().normalize().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: [(f64, f64); 4] = [(0.0, 0.0), (3.0, 0.0), (4.0, 2.0), (0.0, 1.0)];

    #[test]
    fn mean_value_coordinates_reproduce_affine_functions() {
        let polygon = QUAD.map(DVec2::from);
        let value = |p: DVec2| 2.0 * p.x - p.y + 0.5;
        for at in [(1.0, 0.5), (2.9, 0.3), (0.01, 0.01), (1.5, 0.0), (0.0, 0.25), (3.5, 1.0), (4.0, 2.0)] {
            let at = DVec2::from(at);
            let shares = mean_value_coordinates(&polygon, at);
            let sum: f64 = shares.iter().zip(polygon).map(|(share, p)| share * value(p)).sum();
            assert!((sum - value(at)).abs() < 1e-12, "{at}: {shares:?}");
            assert!(shares.iter().all(|share| *share >= -1e-12));
        }
    }

    #[test]
    fn on_an_edge_only_its_ends_count() {
        let shares = mean_value_coordinates(&QUAD.map(DVec2::from), DVec2::new(0.75, 0.0));
        assert_eq!(shares, [0.75, 0.25, 0.0, 0.0]);
    }
}
