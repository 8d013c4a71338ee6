//! A narrow gap that is bright at its mouth and dark inside, as behind books on a shelf: what is reflected to and fro in it must be
//! what paths tell.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::ops::ControlFlow;

use glam::{BVec3, DVec3};
use umbrage::bake::{BakeSettings, bake};
use umbrage::id::NodeId;
use umbrage::progress::Progress;
use umbrage::scene::{Material, Node, Rgb, Scene, Surface};
use umbrage::shade::BakedMesh;
use umbrage_verify::{BakedTriangle, Report, Settings, verify};

/// A surface that is a box, looking outward or inward.
fn box_surface(low: DVec3, high: DVec3, inward: bool) -> Surface {
    let at = |i: u32| DVec3::select(BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), high, low);
    let outward = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut polygons: Vec<Vec<u32>> = outward.map(|corners| corners.to_vec()).to_vec();
    if inward {
        polygons.iter_mut().for_each(|corners| corners.reverse());
    }
    Surface { positions_m: (0..8).map(at).collect(), polygons, ..Surface::new(NodeId::from(0), 0.into()) }
}

/// A room of 1 m with a lamp in its ceiling, and boards upright along one wall, each 2 cm before what is behind it.
fn room() -> Scene {
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    let grey = scene.materials.push_and_get_key(Material::diffuse("grey", Rgb::splat(0.6)));
    let lamp = scene.materials.push_and_get_key(Material::emitting("lamp", Rgb::splat(10.0)));
    let mut add = |surface: Surface, material| scene.surfaces.push(Surface { material, ..surface });
    add(box_surface(DVec3::ZERO, DVec3::ONE, true), grey);
    for board in 0..4 {
        let x = 0.02 + 0.04 * f64::from(board);
        add(box_surface(DVec3::new(x, 0.1, 0.1), DVec3::new(x + 0.02, 0.9, 0.7), false), grey);
    }
    let corners = [(0.5, 0.4), (0.5, 0.6), (0.7, 0.6), (0.7, 0.4)].map(|(x, y)| DVec3::new(x, y, 0.999));
    add(
        Surface {
            positions_m: corners.to_vec(),
            polygons: vec![vec![0, 1, 2, 3]],
            ..Surface::new(NodeId::from(0), lamp)
        },
        lamp,
    );
    scene
}

fn triangles(mesh: &BakedMesh) -> Vec<BakedTriangle> {
    let of_part = |part: &umbrage::shade::BakedPart| {
        let corner = |i: u32| mesh.origin_m + DVec3::from(part.positions_m[i as usize].map(f64::from));
        let light = |i: u32| Rgb::from(part.irradiance[i as usize].map(f64::from));
        let triangle = |of: &[u32; 3]| BakedTriangle { corners_m: of.map(corner), irradiance: of.map(light) };
        part.triangles.iter().map(triangle).collect::<Vec<_>>()
    };
    mesh.parts.iter().flat_map(of_part).collect()
}

#[test]
fn light_in_narrow_gaps_is_what_paths_tell() {
    let scene = room();
    let baked = bake(&scene, &BakeSettings::default(), Progress::silent()).unwrap();
    let settings = Settings { points: 1000, paths: 2048, seed: 3, ..Settings::default() };
    let report: Report = verify(&scene, &triangles(&baked.mesh), &settings, &|_, _| ControlFlow::Continue(())).unwrap();
    println!("{} triangles, {:?} {:?} {:?}", baked.report.triangles, report.error, report.bias, report.noise);
    assert!(report.error.value <= 0.01, "{:?}", report.error);
    assert!(report.bias.value.abs() <= 0.005, "{:?}", report.bias);
}
