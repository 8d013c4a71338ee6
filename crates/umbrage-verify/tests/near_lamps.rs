//! Lamps that touch surfaces or nearly do: what paths tell of them is what the same lamp a little farther off brings.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::ops::ControlFlow;

use glam::{BVec3, DVec3};
use umbrage::id::NodeId;
use umbrage::scene::{Lamp, LampKind, Material, Node, Rgb, Scene, Surface};
use umbrage_verify::{BakedTriangle, Settings, verify};

/// A room of 4 x 3 x 5 m with a bulb so far under its ceiling.
fn room(below_m: f64) -> Scene {
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    let grey = scene.materials.push_and_get_key(Material::diffuse("grey", Rgb::splat(0.5)));
    let size = DVec3::new(4.0, 3.0, 5.0);
    let at = |i: u32| DVec3::select(BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), size, DVec3::ZERO);
    let inward = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let polygons = inward.map(|corners: [u32; 4]| corners.to_vec()).to_vec();
    scene.surfaces.push(Surface {
        positions_m: (0..8).map(at).collect(),
        polygons,
        ..Surface::new(NodeId::from(0), grey)
    });
    let kind =
        LampKind::Point { position_m: DVec3::new(2.1, 1.4, 5.0 - below_m), intensity: Rgb::splat(10.0), range_m: None };
    scene.lamps.push(Lamp { name: "bulb".into(), kind });
    scene
}

/// Mean light by paths, and its noise as a share of it.
fn mean_light(below_m: f64) -> [f64; 2] {
    let scene = room(below_m);
    // Of a bake that shows no light.
    let black: Vec<BakedTriangle> = scene
        .surfaces
        .iter()
        .flat_map(|surface| {
            surface.polygons.iter().map(|p| p.iter().map(|&i| surface.positions_m[i as usize]).collect())
        })
        .flat_map(|p: Vec<DVec3>| [[p[0], p[1], p[2]], [p[0], p[2], p[3]]])
        .map(|corners_m| BakedTriangle { corners_m, irradiance: [Rgb::ZERO; 3] })
        .collect();
    let settings = Settings { points: 6000, paths: 128, seed: 2, ..Settings::default() };
    let report = verify(&scene, &black, &settings, &|_, _| ControlFlow::Continue(())).unwrap();
    [report.mean_irradiance, report.noise]
}

#[test]
fn a_bulb_that_nearly_touches_a_ceiling_lights_a_room_as_one_beside_it() {
    // What falls on the ceiling itself is in a spot that no point lies in: half of the flux, 62.8 W on 94 m2, and what it reflects stays.
    let (area_m2, flux_w) = (94.0, 4.0 * std::f64::consts::PI * 10.0);
    let truth = flux_w / area_m2 / (1.0 - 0.5) - 0.5 * flux_w / area_m2;
    for below_m in [0.0, 3e-13, 1e-6, 1e-5, 1e-3] {
        let [mean, noise] = mean_light(below_m);
        assert!((mean / truth - 1.0).abs() < 0.03, "{mean} is not {truth} at {below_m} m");
        assert!(noise < 0.1, "{noise} at {below_m} m");
    }
}
