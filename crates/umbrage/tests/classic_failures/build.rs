//! Scenes of quads and boxes, and bakes of them. +Z is up.

use glam::{BVec3, DVec3};
use umbrage::bake::{BakeSettings, bake};
use umbrage::id::NodeId;
use umbrage::progress::Progress;
use umbrage::scene::{Material, Node, Scene, Surface};

use crate::common::{Lit, lit_triangles};

/// Adds polygons of a material.
pub(crate) fn add(scene: &mut Scene, material: Material, polygons: &[Vec<DVec3>]) {
    if scene.nodes.is_empty() {
        scene.nodes.push(Node::default());
    }
    let material = scene.materials.push_and_get_key(material);
    let mut surface = Surface::new(NodeId::from(0), material);
    for polygon in polygons {
        let first = surface.positions_m.len() as u32;
        surface.polygons.push((first..first + polygon.len() as u32).collect());
        surface.positions_m.extend(polygon);
    }
    scene.surfaces.push(surface);
}

/// The faces of a box, looking outward: below, above, and the four around.
pub(crate) fn box_faces(low: DVec3, high: DVec3) -> Vec<Vec<DVec3>> {
    let at = |i: u32| DVec3::select(BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), high, low);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    faces.map(|face| face.map(at).to_vec()).to_vec()
}

/// The same faces, looking inward.
pub(crate) fn room_faces(low: DVec3, high: DVec3) -> Vec<Vec<DVec3>> {
    box_faces(low, high).into_iter().map(|face| face.into_iter().rev().collect()).collect()
}

/// A parallelogram around its middle, looking along `half_u` x `half_v`.
pub(crate) fn quad(middle: DVec3, half_u: DVec3, half_v: DVec3) -> Vec<DVec3> {
    vec![middle - half_u - half_v, middle + half_u - half_v, middle + half_u + half_v, middle - half_u + half_v]
}

/// A bake with the default settings.
pub(crate) fn baked(scene: &Scene) -> Vec<Lit> {
    lit_triangles(&bake(scene, &BakeSettings::default(), Progress::silent()).unwrap().mesh)
}

/// Mean irradiance over the triangles, by area and over the colours.
pub(crate) fn mean<'a>(triangles: impl Iterator<Item = &'a Lit> + Clone) -> f64 {
    let area: f64 = triangles.clone().map(Lit::area).sum();
    triangles.map(|t| t.area() * t.irradiance.iter().map(|e| e.element_sum()).sum::<f64>() / 9.0).sum::<f64>() / area
}
