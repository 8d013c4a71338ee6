//! A handful of random scenes (double-sided, smooth, many-lamped, touching, far away), each baked and judged by paths of light.
//!
//! `cargo run --release -p umbrage-bench -- random --scenes 10000` judges as many as one likes.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use umbrage::bake::{BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage::shade::{BakedMesh, ShadeSettings};
use umbrage_verify::BakedTriangle;
use umbrage_verify::judge::{Judged, Judgement, judge};
use umbrage_verify::random::{RandomScene, Size};

/// Scenes that are small enough for every run of the tests.
const SIZE: Size = Size { things: 4, lamps: 3 };
const SEEDS: std::ops::Range<u64> = 1..60;
/// Coarser than a bake's default, for the time that it takes.
const TOLERANCE: f64 = 0.03;

fn triangles(mesh: &BakedMesh) -> Vec<BakedTriangle> {
    let of_part = mesh.parts.iter().flat_map(|part| {
        let triangle = |&corners| BakedTriangle::new(mesh.origin_m, corners, &part.positions_m, &part.irradiance);
        part.triangles.iter().map(triangle)
    });
    of_part.collect()
}

fn judged(scene: &Scene, light: bool) -> Judgement {
    let default = BakeSettings::default();
    let shade = ShadeSettings { tolerance: TOLERANCE, ..default.shade };
    let baked = bake(scene, &BakeSettings { shade, ..default }, Progress::silent()).unwrap();
    assert_eq!(baked.mesh.validate(), Ok(()));
    let surplus = baked.report.energy.error();
    let triangles = triangles(&baked.mesh);
    judge(&Judged { scene, triangles: &triangles, tolerance: TOLERANCE, surplus, light, warned: false }).unwrap()
}

#[test]
fn random_scenes_are_baked_as_paths_tell() {
    for seed in SEEDS {
        let begin = std::time::Instant::now();
        let random = RandomScene::new(seed, SIZE);
        if ["hard spot", "smooth"].iter().any(|name| random.traits.contains(name)) {
            continue;
        }
        let scene = random.scene(|_| true);
        let judgement = judged(&scene, random.is_distinct());
        println!(
            "{seed}: {} polygons, {} lamps, {:?} {:?} {:?}",
            scene.polygon_count(),
            scene.lamps.len(),
            judgement,
            begin.elapsed(),
            random.traits
        );
    }
}
