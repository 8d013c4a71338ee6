//! Small prepared scenes for tests: polygons as they are, welded where their corners are equal, with planes shared
//! within the tolerance; nothing is merged or cut.

use std::collections::BTreeMap;

use glam::DVec3;
use smallvec::smallvec;

use crate::geometry::{Plane, PlaneFrame, Tolerance};
use crate::id::{EdgeId, MaterialId, SurfaceId, VertexId};
use crate::prepare::{DirectedEdge, Edge, Face, Facing, PrepareReport, Prepared, Side};
use crate::scene::{Material, Scene};

/// The nearest point that `f32` can hold.
pub(crate) fn f32_point(p: DVec3) -> DVec3 {
    p.as_vec3().as_dvec3()
}

/// Faces of one material.
/// The sides of boxes of half a metre, with their lower corners at these places.
pub(crate) fn boxes(lower_m: &[(f64, f64, f64)]) -> Vec<Vec<DVec3>> {
    let sides = |&lower_m: &(f64, f64, f64)| {
        let low = f32_point(DVec3::from(lower_m));
        outward_box(low, low + 0.5)
    };
    lower_m.iter().flat_map(sides).collect()
}

pub(crate) fn prepared(polygons: &[Vec<DVec3>]) -> Prepared {
    let all: Vec<_> = polygons.iter().map(|p| (p.clone(), 0)).collect();
    prepared_of_materials(&all)
}

/// Faces with the number of their material.
pub(crate) fn prepared_of_materials(polygons: &[(Vec<DVec3>, usize)]) -> Prepared {
    let points = || polygons.iter().flat_map(|(p, _)| p.iter().copied());
    let (lo, hi) = (points().fold(DVec3::INFINITY, DVec3::min), points().fold(DVec3::NEG_INFINITY, DVec3::max));
    let mut prepared = Prepared {
        origin_m: DVec3::ZERO,
        tolerance: Tolerance::new((hi - lo).max_element().max(0.0)),
        planes: Default::default(),
        skins: Default::default(),
        vertices_m: Default::default(),
        edges: Default::default(),
        faces: Default::default(),
        rims: Vec::new(),
        report: PrepareReport::default(),
    };
    let mut vertices: BTreeMap<[u32; 3], VertexId> = BTreeMap::new();
    let mut edges: BTreeMap<[VertexId; 2], EdgeId> = BTreeMap::new();
    for (polygon, material) in polygons {
        let ids: Vec<VertexId> = polygon
            .iter()
            .map(|&p| {
                *vertices
                    .entry((p.as_vec3() + 0.0).to_array().map(f32::to_bits))
                    .or_insert_with(|| prepared.vertices_m.push_and_get_key(f32_point(p)))
            })
            .collect();
        let face = prepared.faces.next_key();
        let sides = (0..ids.len())
            .map(|i| {
                let (from, to) = (ids[i], ids[(i + 1) % ids.len()]);
                let ends = [from.min(to), from.max(to)];
                let edge = *edges
                    .entry(ends)
                    .or_insert_with(|| prepared.edges.push_and_get_key(Edge { ends, faces: smallvec![] }));
                prepared.edges[edge].faces.push(face);
                let side: Side = smallvec![DirectedEdge { edge, reversed: from > to }];
                side
            })
            .collect();
        let plane = Plane::of_polygon(polygon).expect("a polygon with area");
        let slack_m = prepared.tolerance.coplanar_m();
        let shared = prepared
            .planes
            .iter_enumerated()
            .find(|(_, frame)| polygon.iter().all(|&p| frame.plane.signed_distance_m(p).abs() <= slack_m));
        let (plane_id, facing) = match shared {
            Some((id, frame)) if frame.plane.normal.dot(plane.normal) > 0.0 => (id, Facing::Along),
            Some((id, _)) => (id, Facing::Against),
            None => (prepared.planes.push_and_get_key(PlaneFrame::new(plane, polygon[0])), Facing::Along),
        };
        prepared.faces.push(Face {
            plane: plane_id,
            facing,
            surface: SurfaceId::from(0),
            material: MaterialId::from(*material),
            skin: None,
            sides,
        });
    }
    prepared
}

/// A scene that holds these materials and nothing else.
pub(crate) fn scene(materials: Vec<Material>) -> Scene {
    Scene { materials: materials.into(), ..Scene::default() }
}

/// A square with its middle at `middle`, looking up (or down).
pub(crate) fn square(middle: DVec3, half: f64, up: bool) -> Vec<DVec3> {
    let mut corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| f32_point(middle + half * DVec3::new(x, y, 0.0)))
        .to_vec();
    if !up {
        corners.reverse();
    }
    corners
}

/// The six faces of a box, looking outward.
pub(crate) fn outward_box(lo: DVec3, hi: DVec3) -> Vec<Vec<DVec3>> {
    let c = |x: usize, y: usize, z: usize| {
        let pick = |i: usize, l: f64, h: f64| if i == 0 { l } else { h };
        DVec3::new(pick(x, lo.x, hi.x), pick(y, lo.y, hi.y), pick(z, lo.z, hi.z))
    };
    vec![
        vec![c(0, 0, 0), c(0, 1, 0), c(1, 1, 0), c(1, 0, 0)],
        vec![c(0, 0, 1), c(1, 0, 1), c(1, 1, 1), c(0, 1, 1)],
        vec![c(0, 0, 0), c(1, 0, 0), c(1, 0, 1), c(0, 0, 1)],
        vec![c(0, 1, 0), c(0, 1, 1), c(1, 1, 1), c(1, 1, 0)],
        vec![c(0, 0, 0), c(0, 0, 1), c(0, 1, 1), c(0, 1, 0)],
        vec![c(1, 0, 0), c(1, 1, 0), c(1, 1, 1), c(1, 0, 1)],
    ]
}

/// The six faces of a box, looking inward: a room.
pub(crate) fn inward_box(lo: DVec3, hi: DVec3) -> Vec<Vec<DVec3>> {
    outward_box(lo, hi)
        .into_iter()
        .map(|mut polygon| {
            polygon.reverse();
            polygon
        })
        .collect()
}
