//! Scenes of quads and boxes.

use glam::{BVec3, DVec3};
use umbrage::id::NodeId;
use umbrage::scene::{Material, Node, Scene, Surface};

/// Adds polygons of a material, as a surface of their own.
pub fn add(scene: &mut Scene, material: Material, polygons: &[Vec<DVec3>]) {
    if scene.nodes.is_empty() {
        scene.nodes.push(Node::default());
    }
    let material = scene.materials.push_and_get_key(material);
    let mut surface = Surface::new(NodeId::from(0), material);
    for polygon in polygons {
        surface.push_polygon(polygon.iter().copied());
    }
    scene.surfaces.push(surface);
}

/// The faces of a box, looking outward: z low, z high, y low, y high, x low, x high.
pub fn box_faces(low: DVec3, high: DVec3) -> Vec<Vec<DVec3>> {
    let at = |i: u32| DVec3::select(BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), high, low);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    faces.map(|face| face.map(at).to_vec()).to_vec()
}

/// The same faces, looking inward.
pub fn room_faces(low: DVec3, high: DVec3) -> Vec<Vec<DVec3>> {
    box_faces(low, high).into_iter().map(|face| face.into_iter().rev().collect()).collect()
}

/// A parallelogram around its middle, looking along `half_u` x `half_v`.
pub fn quad(middle: DVec3, half_u: DVec3, half_v: DVec3) -> Vec<DVec3> {
    vec![middle - half_u - half_v, middle + half_u - half_v, middle + half_u + half_v, middle - half_u + half_v]
}
