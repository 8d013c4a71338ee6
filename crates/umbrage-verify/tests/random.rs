//! A handful of random scenes (double-sided, smooth, many-lamped, touching, far away), each baked and judged by paths of light.
//!
//! `cargo run --release -p umbrage-bench -- random --scenes 10000` judges as many as one likes.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use umbrage::bake::{BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage::shade::{BakedMesh, ShadeSettings};
use umbrage_verify::BakedTriangle;
use umbrage_verify::judge::{FaultKind, Judged, Judgement, judge};
use umbrage_verify::random::{RandomScene, Size};

/// Scenes that are small enough for every run of the tests.
const SIZE: Size = Size { things: 4, lamps: 3 };
/// Seeds of scenes that are quick, and of all kinds.
const SEEDS: [u64; 19] = [2, 1, 4, 5, 6, 7, 8, 35, 12, 13, 14, 15, 16, 18, 19, 20, 21, 22, 23];
/// Coarser than a bake's default, for the time that it takes.
const TOLERANCE: f64 = 0.03;

fn triangles(mesh: &BakedMesh) -> Vec<BakedTriangle> {
    let of_part = mesh.parts.iter().flat_map(|part| {
        let triangle = |&corners| BakedTriangle::new(mesh.origin_m, corners, &part.positions_m, &part.irradiance);
        part.triangles.iter().map(triangle)
    });
    of_part.collect()
}

/// Triangles, and the surplus of the account of energy.
fn baked(scene: &Scene) -> (Vec<BakedTriangle>, f64) {
    let default = BakeSettings::default();
    let shade = ShadeSettings { tolerance: TOLERANCE, ..default.shade };
    let baked = bake(scene, &BakeSettings { shade, ..default }, Progress::silent()).unwrap();
    assert_eq!(baked.mesh.validate(), Ok(()));
    (triangles(&baked.mesh), baked.report.energy.error())
}

fn judged(scene: &Scene, light: bool) -> Judgement {
    let (triangles, surplus) = baked(scene);
    judge(&Judged { scene, triangles: &triangles, tolerance: TOLERANCE, surplus, light, warned: false }).unwrap()
}

#[test]
fn random_scenes_are_baked_as_paths_tell() {
    let mut wrong = Vec::new();
    for seed in SEEDS {
        let random = RandomScene::new(seed, SIZE);
        let faults = judged(&random.scene(|_| true), random.is_distinct()).faults;
        wrong.extend(faults.into_iter().map(|fault| (seed, fault, random.traits.clone())));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_bake_that_is_off_is_judged_so() {
    // A room with an opening under a lamp, which lights all of it.
    let random = RandomScene::new(12, SIZE);
    let scene = random.scene(|_| true);
    let mut triangles = baked(&scene).0;
    let judged = |triangles: &[BakedTriangle]| {
        let judged =
            Judged { scene: &scene, triangles, tolerance: TOLERANCE, surplus: 0.0, light: true, warned: false };
        judge(&judged).unwrap().faults.into_iter().map(|fault| fault.kind).collect::<Vec<_>>()
    };
    assert_eq!(judged(&triangles), []);
    triangles.iter_mut().flat_map(|triangle| &mut triangle.irradiance).for_each(|light| *light *= 1.5);
    assert_eq!(judged(&triangles), [FaultKind::Error]);
}
