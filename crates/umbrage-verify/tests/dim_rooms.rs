//! A dim room beside a lit one, whose door is ajar: what is reflected there, and the streak of direct light, must be right as a share of
//! the light of that room, by paths of light.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::ops::ControlFlow;

use glam::{BVec3, DQuat, DVec3};
use umbrage::bake::{BakeSettings, bake};
use umbrage::id::NodeId;
use umbrage::progress::Progress;
use umbrage::scene::{Material, Node, Rgb, Scene, Surface};
use umbrage::shade::BakedMesh;
use umbrage_verify::{BakedTriangle, Settings, verify};

/// The faces of a box, looking outward.
fn box_faces(low: DVec3, high: DVec3) -> Vec<Vec<DVec3>> {
    let at = |i: u32| DVec3::select(BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), high, low);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    faces.map(|face| face.map(at).to_vec()).to_vec()
}

fn inward(faces: Vec<Vec<DVec3>>) -> impl Iterator<Item = Vec<DVec3>> {
    faces.into_iter().map(|face| face.into_iter().rev().collect())
}

/// Two rooms of 4 x 4 x 3 m: a lit one, and one behind a wall of 10 cm with a door that is ajar by so many degrees. All that is lit
/// emits `spark` besides.
fn rooms(ajar_degrees: f64, spark: f64) -> Scene {
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    let mut add = |material: Material, faces: Vec<Vec<DVec3>>| {
        let material = scene.materials.push_and_get_key(material);
        let mut surface = Surface::new(NodeId::from(0), material);
        faces.into_iter().for_each(|face| surface.push_polygon(face));
        scene.surfaces.push(surface);
    };
    let part = |y: [f64; 2], z: [f64; 2]| box_faces(DVec3::new(-0.1, y[0], z[0]), DVec3::new(0.0, y[1], z[1]));
    let is_x = |face: &[DVec3], x: f64| face.iter().all(|p| p.x == x);
    // Each room without the side that is open towards the other, and the wall without its ends on floor, ceiling and sides.
    let lit = inward(box_faces(DVec3::new(-4.0, -2.0, 0.0), DVec3::new(-0.1, 2.0, 3.0)));
    let mut lit: Vec<_> = lit.filter(|face| !is_x(face, -0.1)).collect();
    let dim = inward(box_faces(DVec3::new(-0.1, -2.0, 0.0), DVec3::new(4.0, 2.0, 3.0)));
    let mut dim: Vec<_> = dim.filter(|face| !is_x(face, -0.1)).collect();
    let wall = [part([-2.0, -0.45], [0.0, 3.0]), part([0.45, 2.0], [0.0, 3.0]), part([-0.45, 0.45], [2.0, 3.0])];
    for face in wall.into_iter().flatten() {
        if is_x(&face, -0.1) { lit.push(face) } else { dim.push(face) }
    }
    // The leaf hangs in the face of the dim room's side, a millimetre clear of its frame.
    let hinge = DVec3::new(0.0, 0.45, 0.0);
    let turn = DQuat::from_rotation_z(ajar_degrees.to_radians());
    let leaf = box_faces(DVec3::new(-0.04, -0.899, 0.0), DVec3::new(0.0, -0.001, 1.999));
    dim.extend(leaf.into_iter().map(|face| face.into_iter().map(|p| hinge + turn * p).collect()));
    let grey = Material::diffuse("dim", Rgb::splat(0.5));
    add(grey.clone(), dim);
    add(Material { radiance: Rgb::splat(spark), ..grey }, lit);
    let lamp = [(-0.25, -0.25), (-0.25, 0.25), (0.25, 0.25), (0.25, -0.25)];
    add(
        Material::emitting("lamp", Rgb::splat(10.0)),
        vec![lamp.map(|(x, y)| DVec3::new(x - 2.0, y - 0.5, 2.9)).to_vec()],
    );
    scene
}

fn triangles(mesh: &BakedMesh) -> Vec<BakedTriangle> {
    let of_part = |part: &umbrage::shade::BakedPart| {
        let triangle = |of: &[u32; 3]| BakedTriangle::new(mesh.origin_m, *of, &part.positions_m, &part.irradiance);
        part.triangles.iter().map(triangle).collect::<Vec<_>>()
    };
    mesh.parts.iter().flat_map(of_part).collect()
}

#[test]
fn a_room_behind_an_ajar_door_is_right_as_a_share_of_its_own_light() {
    for ajar_degrees in [1.0, 4.0] {
        let scene = rooms(ajar_degrees, 0.0);
        let baked = bake(&scene, &BakeSettings::default(), Progress::silent()).unwrap();
        // What emits is not compared: so little changes nothing, and leaves the dim room.
        let dim = rooms(ajar_degrees, 1e-12);
        let settings = Settings { points: 600, paths: 4096, seed: 5, ..Settings::default() };
        let check = |scene: &Scene| {
            verify(scene, &triangles(&baked.mesh), &settings, &|_, _| ControlFlow::Continue(())).unwrap()
        };
        let (report, all) = (check(&dim), check(&scene));
        assert!(report.mean_irradiance < 0.1 * all.mean_irradiance, "not dim");
        assert!(report.error.value < 0.1, "{:?}", report.error);
        assert!(report.bias.value.abs() < 0.03, "{:?}", report.bias);
    }
}
