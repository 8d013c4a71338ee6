//! Small meshes for tests.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::{Mesh, MeshSettings};
use crate::discontinuity::{DSegment, Degree, Event};
use crate::id::{EdgeId, FaceId, PatchId, Table};
use crate::visibility::fixture;

/// A mesh over polygons in the plane z = 0, with d-segments `(face, from, to, degree)`.
pub(super) fn mesh_with(polygons: &[Vec<DVec2>], segments: &[(usize, DVec2, DVec2, Degree)]) -> Mesh {
    let polygons: Vec<Vec<DVec3>> = polygons.iter().map(|p| p.iter().map(|c| c.extend(0.0)).collect()).collect();
    let segments: Table<_, _> = segments
        .iter()
        .map(|&(face, from, to, degree)| DSegment {
            face: FaceId::from(face),
            ends_m: [from.extend(0.0), to.extend(0.0)],
            degree,
            strength: 1.0,
            event: Event::Contact { edge: EdgeId::from(0) },
        })
        .collect();
    Mesh::new(&fixture::prepared(&polygons), &segments, MeshSettings::default())
}

/// A mesh over polygons in the plane z = 0.
pub(super) fn mesh(polygons: &[Vec<DVec2>]) -> Mesh {
    mesh_with(polygons, &[])
}

/// The rectangle between two corners.
pub(super) fn rectangle(lo: (f64, f64), hi: (f64, f64)) -> Vec<DVec2> {
    [(lo.0, lo.1), (hi.0, lo.1), (hi.0, hi.1), (lo.0, hi.1)].map(DVec2::from).to_vec()
}

/// A random convex polygon with at least `least` corners, on a circle.
pub(super) fn convex(least: usize) -> impl Strategy<Value = Vec<DVec2>> {
    proptest::collection::vec(0.2..1.0, least..10).prop_map(|steps: Vec<f64>| {
        let whole: f64 = steps.iter().sum();
        let mut angle = 0.0;
        steps
            .iter()
            .map(|step| {
                angle += step / whole * TAU;
                DVec2::from_angle(angle)
            })
            .collect()
    })
}

/// The patch of the first face.
pub(super) fn first() -> PatchId {
    PatchId::from(0)
}

/// Vertices that lie inside an edge of some leaf without being an end of it, found without the edge trees.
pub(super) fn t_vertices(mesh: &Mesh) -> usize {
    let loops: Vec<Vec<DVec3>> = mesh
        .leaves()
        .map(|leaf| mesh.boundary(leaf).iter().map(|point| mesh.vertex_m(point.vertex)).collect())
        .collect();
    let points: Vec<DVec3> = loops.iter().flatten().copied().collect();
    let inside = |point: DVec3, p: DVec3, q: DVec3| {
        let t = (point - p).dot(q - p) / (q - p).length_squared();
        t > 1e-5 && t < 1.0 - 1e-5 && point.distance(p.lerp(q, t)) < 1e-6
    };
    loops
        .iter()
        .flat_map(|run| (0..run.len()).map(move |i| (run[i], run[(i + 1) % run.len()])))
        .map(|(p, q)| points.iter().filter(|&&point| inside(point, p, q)).count())
        .sum()
}
