//! Scenes that grow: one generator of box fields for all benchmarks.
//!
//! Boxes of different sizes stand, lean and float on the cells of a square floor, under a number of square lamps that
//! hang at half the width of the field. Twice as many faces are twice as many boxes on twice the floor, each of the
//! same size: the lamps grow with the floor, so that the share of boxes that stand in one another's light stays what it
//! is.

pub mod usage;

use glam::{DQuat, DVec3};
use umbrage::id::NodeId;
use umbrage::scene::{Material, Node, Rgb, Scene, Surface};

/// Faces of a box.
const FACES: usize = 6;
/// Width of a cell of the floor, in metres.
const CELL_M: f64 = 1.0;

/// Numbers that look random (Vigna's splitmix64): the same field in every run.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A box around the origin, looking outward.
fn faces(half: DVec3) -> [[DVec3; 4]; FACES] {
    let corner = |i: usize| half * DVec3::new([-1.0, 1.0][i & 1], [-1.0, 1.0][i >> 1 & 1], [-1.0, 1.0][i >> 2 & 1]);
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]].map(|face| face.map(corner))
}

/// A field of boxes with about `face_count` faces under `lamp_count` lamps. +Y is up.
pub fn box_field(face_count: usize, lamp_count: usize) -> Scene {
    let mut scene = Scene { name: format!("box field of {face_count} faces"), ..Scene::default() };
    scene.nodes.push(Node { name: Some("field".into()), ..Node::default() });
    let grey = scene.materials.push_and_get_key(Material::diffuse("grey", Rgb::splat(0.5)));
    let light = scene.materials.push_and_get_key(Material::emitting("lamp", Rgb::splat(10.0)));
    let [mut ground, mut boxes] = [grey, grey].map(|material| Surface::new(NodeId::from(0), material));
    let side = (face_count as f64 / FACES as f64).sqrt().ceil().max(1.0);
    let half_m = 0.5 * side * CELL_M;
    let square = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    ground.push_polygon(square.map(|(x, z)| half_m * DVec3::new(x, 0.0, z)));
    let mut random = Random(1);
    for i in 0..face_count / FACES {
        let cell = DVec3::new(i as f64 % side + 0.5, 0.0, (i as f64 / side).floor() + 0.5) * CELL_M;
        let half = DVec3::from([0.08, 0.1, 0.08].map(|least| random.between(least, 0.25))) * CELL_M;
        let turn = DQuat::from_rotation_y(random.between(0.0, 6.3));
        // Half of the boxes stand, the others lean in the air.
        let standing = i % 2 == 0;
        let lean = if standing { DQuat::IDENTITY } else { DQuat::from_rotation_x(random.between(0.1, 0.7)) };
        let height_m = if standing { half.y } else { random.between(0.45, 0.6) * CELL_M };
        let at = cell - DVec3::new(half_m, -height_m, half_m);
        for face in faces(half) {
            boxes.push_polygon(face.map(|p| at + turn * (lean * p)));
        }
    }
    let mut lamps = Surface::new(NodeId::from(0), light);
    for _ in 0..lamp_count {
        let at = DVec3::new(random.between(-0.7, 0.7), random.between(0.9, 1.1), random.between(-0.7, 0.7)) * half_m;
        let turn = DQuat::from_rotation_y(random.between(0.0, 6.3)) * DQuat::from_rotation_x(random.between(-0.4, 0.4));
        lamps.push_polygon(square.map(|(x, z)| at + turn * (0.05 * half_m * DVec3::new(x, 0.0, -z))));
    }
    scene.surfaces.extend([ground, boxes, lamps]);
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_has_the_faces_asked_for_and_is_the_same_every_time() {
        for count in [60, 1000, 10_000] {
            let scene = box_field(count, 3);
            assert!(scene.polygon_count().abs_diff(count) < 20, "{}", scene.polygon_count());
            assert!(scene.validate().is_ok());
            assert_eq!(scene, box_field(count, 3));
        }
    }

    #[test]
    fn lamps_look_down() {
        let scene = box_field(60, 5);
        let lamps = umbrage::id::SurfaceId::from(2);
        for polygon in 0..scene.surfaces[lamps].polygons.len() {
            let corners: Vec<DVec3> = scene.corners_m(lamps, polygon).collect();
            assert!(umbrage::geometry::polygon::doubled_area_vector(&corners).y < 0.0);
        }
    }
}
