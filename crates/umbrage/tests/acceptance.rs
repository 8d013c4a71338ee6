//! Whole bakes of the project's scenes, against light that was computed elsewhere.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::f64::consts::PI;
use std::ops::ControlFlow;

use umbrage::bake::{Bake, BakeError, BakeSettings, bake};
use umbrage::progress::{Cancelled, Progress, Stage, Update};
use umbrage::scene::{Scene, cornell};
use umbrage::shade::ShadeSettings;

fn scene(name: &str) -> Scene {
    let path = format!("{}/../../testdata/scenes/{name}.glb", env!("CARGO_MANIFEST_DIR"));
    umbrage_formats::read_scene(path).unwrap().0
}

fn baked(scene: &Scene) -> Bake {
    bake(scene, &BakeSettings::default(), Progress::silent()).unwrap()
}

/// Bakes a scene and holds its relative RMSE, its triangles and its dark points against bounds.
fn holds(name: &str, scene: &Scene, most_error: f64, most_triangles: usize) {
    holds_bake(name, &baked(scene), most_error, most_triangles);
}

/// The same at `--tolerance 0.003`, whatever the triangles.
fn holds_finely(name: &str, scene: &Scene, most_error: f64) {
    let shade = ShadeSettings { tolerance: 0.003, ..ShadeSettings::default() };
    let fine = bake(scene, &BakeSettings { shade, ..BakeSettings::default() }, Progress::silent()).unwrap();
    holds_bake(name, &fine, most_error, usize::MAX);
}

fn holds_bake(name: &str, baked: &Bake, most_error: f64, most_triangles: usize) {
    let (error, leak) = common::error(&baked.mesh, &common::reference(name));
    assert!(error <= most_error, "relative RMSE {error}");
    assert!(leak < 1e-3, "a dark point shows {leak} of the mean");
    assert!(baked.report.triangles <= most_triangles, "{} triangles", baked.report.triangles);
    let triangles = common::lit_triangles(&baked.mesh);
    let eps = 1e-6 * common::extent(&triangles);
    assert!(common::t_vertices(&triangles, eps).is_empty());
    assert_eq!(common::degenerate(&triangles, eps), 0);
}

#[test]
fn the_cornell_box_is_right_to_1_percent() {
    holds("cornell", &cornell::cornell_box(), 0.01, 10_000);
}

#[test]
fn a_square_occluders_penumbra_is_right_to_half_a_percent() {
    holds("occluder", &scene("occluder"), 0.005, 2_500);
}

#[test]
fn touching_boxes_are_right_to_1_percent_and_do_not_leak() {
    holds("touching", &scene("touching"), 0.01, 15_000);
}

#[test]
fn a_fine_cornell_box_is_right_to_half_a_percent() {
    holds_finely("cornell", &cornell::cornell_box(), 0.005);
}

#[test]
fn finely_baked_touching_boxes_are_right_to_half_a_percent_and_do_not_leak() {
    holds_finely("touching", &scene("touching"), 0.005);
}

#[test]
fn a_furnace_glows_evenly() {
    let scene = scene("furnace");
    let exitance = scene.materials.iter().map(|material| PI * material.radiance.x).fold(0.0, f64::max);
    assert!((exitance - 1.0).abs() < 1e-6, "all faces emit 1 W/m2 and reflect a half");
    let triangles = common::lit_triangles(&baked(&scene).mesh);
    let (mut area, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for triangle in &triangles {
        let radiosity = triangle.irradiance.map(|e| 0.5 * e.element_sum() / 3.0 + exitance);
        let mean = radiosity.iter().sum::<f64>() / 3.0;
        area += triangle.area();
        sum += triangle.area() * mean;
        squares += triangle.area() * radiosity.iter().map(|b| (b - 2.0).powi(2)).sum::<f64>() / 3.0;
    }
    assert!((sum / area / 2.0 - 1.0).abs() < 1e-4, "area mean {}", sum / area);
    assert!((squares / area).sqrt() / 2.0 < 0.005, "rms {}", (squares / area).sqrt() / 2.0);
}

/// The bytes of the baked file must not depend on how many threads made it: more than there are cores change who waits
/// for whom.
fn holds_whatever_the_threads(scene: &Scene, tolerance: f64) {
    let shade = ShadeSettings { tolerance, ..ShadeSettings::default() };
    let settings = BakeSettings { shade, ..BakeSettings::default() };
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let baked = pool.install(|| bake(scene, &settings, Progress::silent()).unwrap());
        assert!(baked.report.triangles > 300, "{:?}", baked.report);
        umbrage_formats::baked_glb_bytes(scene, &baked.mesh, &umbrage_formats::BakeFacts::default()).unwrap()
    };
    let alone = bytes(1);
    for threads in [2, 3, 8] {
        assert!(bytes(threads) == alone, "{threads} threads");
    }
}

#[test]
fn any_number_of_threads_bakes_the_same_cornell_box() {
    holds_whatever_the_threads(&cornell::cornell_box(), 0.02);
}

#[test]
fn any_number_of_threads_bakes_the_same_touching_boxes() {
    holds_whatever_the_threads(&scene("touching"), 0.02);
}

#[test]
fn every_stage_can_be_cancelled() {
    for stage in [Stage::Prepare, Stage::Discontinuity, Stage::Transport, Stage::Solve, Stage::Shade] {
        let stop = |update: Update| match update.stage == stage {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let error = bake(&scene("occluder"), &BakeSettings::default(), Progress::new(&stop)).unwrap_err();
        assert_eq!(error, BakeError::Cancelled(Cancelled), "{stage}");
    }
}
