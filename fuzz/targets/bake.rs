//! Preparation and a coarse bake of small polygon soups.
//!
//! Bytes become polygons whose corners lie on a grid of eight, so that they touch, cross and cover each other often; a
//! corner may be off by a little, and the whole scene may be far away, turned by next to nothing or small.
#![no_main]

#[path = "../../crates/umbrage/tests/common/mod.rs"]
mod common;

use glam::{DQuat, DVec3};
use umbrage::id::{MaterialId, NodeId, SurfaceId};
use umbrage::scene::{Material, Node, Rgb, Scene, Surface};
use umbrage_fuzz::coarse_bake;

/// Polygons of a soup at most: a bake should take milliseconds.
const MOST_POLYGONS: usize = 5;
/// How far a corner may be off its place on the grid, in metres.
const OFF_M: [f64; 4] = [1e-9, 1e-6, 1e-4, 1e-2];

/// A scene of what the bytes say and a lamp above it.
fn soup(bytes: &[u8]) -> Option<Scene> {
    let mut bytes = bytes.iter().copied();
    let frame = bytes.next()?;
    let placed = |p: DVec3| match frame % 4 {
        0 => p,
        1 => p + DVec3::splat(1e6),
        2 => DQuat::from_rotation_z(1e-9) * p,
        _ => 1e-3 * p,
    };
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    // Reflected light takes most of the time of a bake and cuts little: one soup in four has it.
    let reflects = if frame >> 2 & 3 == 3 { 1.0 } else { 0.0 };
    let materials = [
        Material::diffuse("grey", Rgb::splat(0.5 * reflects)),
        Material::diffuse("red", Rgb::new(0.6, 0.1, 0.1) * reflects),
        Material { double_sided: true, ..Material::diffuse("sheet", Rgb::splat(0.5 * reflects)) },
        Material::emitting("lamp", Rgb::splat(5.0)),
    ];
    for material in materials {
        let material: MaterialId = scene.materials.push_and_get_key(material);
        scene.surfaces.push(Surface::new(NodeId::from(0), material));
    }
    let lamp = [[2.0, 2.0], [2.0, 5.0], [5.0, 5.0], [5.0, 2.0]].map(|[x, z]| placed(DVec3::new(x, 9.0, z)));
    scene.surfaces[SurfaceId::from(3)].push_polygon(lamp.into_iter().rev());
    for _ in 0..MOST_POLYGONS {
        let Some(head) = bytes.next() else { break };
        let (count, surface, off_m) = (3 + head % 4, head >> 2 & 3, OFF_M[usize::from(head >> 4 & 3)]);
        let coordinate = |byte: u8| f64::from(byte & 7) + off_m * f64::from((byte >> 3).saturating_sub(24));
        let mut corners = Vec::new();
        for _ in 0..count {
            let (Some(x), Some(y), Some(z)) = (bytes.next(), bytes.next(), bytes.next()) else { return Some(scene) };
            corners.push(placed(DVec3::new(coordinate(x), coordinate(y), coordinate(z))));
        }
        scene.surfaces[SurfaceId::from(usize::from(surface))].push_polygon(corners);
    }
    Some(scene)
}

/// Whether a vertex touches an edge inside a plane from outside of it, by a corner alone: the plane goes on beneath without a gap, and
/// nothing is cut there.
fn only_touches(triangles: &[common::Lit], vertex: DVec3, edge: [DVec3; 2]) -> bool {
    let has = |triangle: &&common::Lit, point: &DVec3| triangle.corners.contains(point);
    let beside: Vec<DVec3> =
        triangles.iter().filter(|t| edge.iter().all(|end| has(t, end))).map(common::Lit::normal).collect();
    let at_vertex: Vec<DVec3> = triangles.iter().filter(|t| has(t, &vertex)).map(common::Lit::normal).collect();
    beside.iter().enumerate().any(|(i, side)| {
        beside[i + 1..].iter().any(|other| side.dot(*other) > 0.9999)
            && at_vertex.iter().all(|normal| side.dot(*normal).abs() < 0.9999)
    })
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some(scene) = soup(bytes) else { return };
    let Some(baked) = coarse_bake(&scene) else { return };
    let triangles = common::lit_triangles(&baked);
    let eps = 1e-6 * common::extent(&triangles);
    let mut found = common::t_vertices(&triangles, eps);
    found.retain(|&(vertex, edge)| !only_touches(&triangles, vertex, edge));
    assert!(found.is_empty(), "{} T-vertices: {:?}", found.len(), found[0]);
    assert_eq!(common::degenerate(&triangles, eps), 0);
});
