//! Polygonal emitters: touching coplanar faces of one radiance, and the outline of their union.
//!
//! Events come from the outline of the whole emitter, never from the inner edges of its convex pieces.

use glam::DVec3;

use crate::geometry::{Plane, polygon};
use crate::id::{EdgeId, EmitterId, FaceId, Table, VertexId};
use crate::prepare::{DirectedEdge, Prepared};
use crate::scene::{Rgb, Scene};

/// A polygonal light.
#[derive(Clone, Debug, PartialEq)]
pub struct Emitter {
    /// Its faces, ascending.
    pub faces: Vec<FaceId>,
    /// Its plane, front towards where it shines.
    pub plane: Plane,
    /// Emitted radiance, in W/(m2 sr).
    pub radiance: Rgb,
    /// Area, in square metres.
    pub area_m2: f64,
    /// Centroid, in metres.
    pub centroid_m: DVec3,
    /// Edges of its outline, ascending.
    pub outline: Vec<EdgeId>,
    /// Vertices where the outline turns, ascending.
    pub corners: Vec<VertexId>,
}

impl Emitter {
    /// Mean of the radiance over the three colours, in W/(m2 sr).
    pub fn mean_radiance(&self) -> f64 {
        self.radiance.element_sum() / 3.0
    }
}

/// The emitters of a scene, in the order of their first faces.
pub fn emitters(scene: &Scene, prepared: &Prepared) -> Table<EmitterId, Emitter> {
    let mut result = Table::new();
    let mut taken: Table<FaceId, bool> = prepared.faces.iter().map(|_| false).collect();
    let radiance = |face: FaceId| scene.materials[prepared.faces[face].material].radiance;
    for first in prepared.faces.keys() {
        if taken[first] || radiance(first).max_element() <= 0.0 {
            continue;
        }
        let alike = |face: FaceId| {
            let (one, other) = (&prepared.faces[face], &prepared.faces[first]);
            one.plane == other.plane && one.facing == other.facing && radiance(face) == radiance(first)
        };
        let mut faces = vec![first];
        taken[first] = true;
        let mut next = 0;
        while let Some(&face) = faces.get(next) {
            for edge in prepared.faces[face].sides.iter().flatten() {
                for &neighbour in &prepared.edges[edge.edge].faces {
                    if !taken[neighbour] && alike(neighbour) {
                        taken[neighbour] = true;
                        faces.push(neighbour);
                    }
                }
            }
            next += 1;
        }
        faces.sort_unstable();
        result.push(emitter_of(prepared, faces, radiance(first)));
    }
    result
}

fn emitter_of(prepared: &Prepared, faces: Vec<FaceId>, radiance: Rgb) -> Emitter {
    let mut outline: Vec<DirectedEdge> = faces
        .iter()
        .flat_map(|&face| prepared.faces[face].sides.iter().flatten().copied())
        .filter(|edge| prepared.edges[edge.edge].faces.iter().filter(|face| faces.contains(face)).count() == 1)
        .collect();
    outline.sort_unstable();
    let polygons: Vec<Vec<DVec3>> = faces.iter().map(|&face| prepared.polygon_m(face)).collect();
    let area_m2: f64 = polygons.iter().map(|corners| polygon::area_m2(corners)).sum();
    let moment: DVec3 = polygons.iter().map(|corners| polygon::area_m2(corners) * polygon::centroid(corners)).sum();
    Emitter {
        plane: prepared.oriented_plane(faces[0]),
        corners: corners_of(prepared, &outline),
        outline: outline.into_iter().map(|edge| edge.edge).collect(),
        faces,
        radiance,
        area_m2,
        centroid_m: moment / area_m2,
    }
}

/// The vertices at which an outline does not go straight on.
fn corners_of(prepared: &Prepared, outline: &[DirectedEdge]) -> Vec<VertexId> {
    let mut ends: Vec<(VertexId, DVec3)> = outline
        .iter()
        .flat_map(|&edge| {
            let (start, end) = (prepared.start(edge), prepared.end(edge));
            let along = (prepared.vertices_m[end] - prepared.vertices_m[start]).normalize_or_zero();
            [(start, along), (end, along)]
        })
        .collect();
    ends.sort_by_key(|end| end.0);
    ends.chunk_by(|p, q| p.0 == q.0)
        .filter(|directions| {
            // A sine below this is rounding of f32 vertices on an edge of a hundredth of the extent.
            const STRAIGHT_SINE: f64 = 1e-5;
            !(directions.len() == 2 && directions[0].1.cross(directions[1].1).length() < STRAIGHT_SINE)
        })
        .map(|directions| directions[0].0)
        .collect()
}
