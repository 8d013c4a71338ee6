//! The JSON of small scenes, as it was looked at and found right. `UMBRAGE_BLESS=1` writes what is made now: look at
//! the difference before it is committed.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::PathBuf;

use serde_json::Value;
use umbrage::bake::{BakeSettings, bake, subdivided, trace};
use umbrage::prepare::PrepareSettings;
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage::shade::ShadeSettings;
use umbrage_inspect::{d_segments, mesh, patches};

fn testdata(path: &str) -> PathBuf {
    PathBuf::from(format!("{}/../../testdata/{path}", env!("CARGO_MANIFEST_DIR")))
}

fn scene(name: &str) -> Scene {
    umbrage_formats::read_scene(testdata(&format!("scenes/{name}"))).unwrap().0
}

/// Patches as large as the d-segments leave them, for the mesh of the paper.
fn coarse() -> BakeSettings {
    let shade = ShadeSettings { tolerance: f64::INFINITY, ..ShadeSettings::default() };
    BakeSettings { max_form_factor: Some(0.5), min_area_m2: Some(1.0), shade, ..BakeSettings::default() }
}

fn is_as_before(name: &str, text: &str) {
    let path = testdata(&format!("inspect/{name}.json"));
    if std::env::var_os("UMBRAGE_BLESS").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let before = std::fs::read_to_string(&path).unwrap();
    let changed = before.lines().zip(text.lines()).find(|(before, now)| before != now);
    assert!(before == text, "{name} has changed, first here: {changed:?}");
}

fn d_segments_are_as_before(file: &str, name: &str) {
    let scene = scene(file);
    is_as_before(
        name,
        &d_segments::json(&scene, &trace(&scene, PrepareSettings::default(), 0.0, Progress::silent()).unwrap()),
    );
}

#[test]
fn d_segments_of_a_parallel_plate_are_as_before() {
    d_segments_are_as_before("occluder.glb", "occluder.d-segments");
}

#[test]
fn d_segments_of_a_turned_plate_are_as_before() {
    d_segments_are_as_before("events_turned.obj", "events_turned.d-segments");
}

#[test]
fn d_segments_of_two_crossed_bars_are_as_before() {
    d_segments_are_as_before("events_crossed.obj", "events_crossed.d-segments");
}

#[test]
fn d_segments_of_an_upright_plate_are_as_before() {
    d_segments_are_as_before("events_upright.obj", "events_upright.d-segments");
}

#[test]
fn patches_of_an_upright_plate_are_as_before() {
    let scene = scene("events_upright.obj");
    let meshed = subdivided(&scene, &coarse(), Progress::silent()).unwrap();
    is_as_before("events_upright.patches", &patches::json(&scene, &meshed));
}

#[test]
fn every_cut_of_a_patch_is_between_two_that_make_it_up() {
    let scene = scene("touching.glb");
    let meshed = subdivided(&scene, &coarse(), Progress::silent()).unwrap();
    let json: Value = serde_json::from_str(&patches::json(&scene, &meshed)).unwrap();
    let patches = json["patches"].as_array().unwrap();
    let area = |id: &Value| patches[id.as_u64().unwrap() as usize]["area_m2"].as_f64().unwrap();
    let cut: Vec<&Value> = patches.iter().filter(|patch| patch.get("cut").is_some()).collect();
    assert!(!cut.is_empty());
    for patch in cut {
        let parts: f64 = patch["subpatches"].as_array().unwrap().iter().map(area).sum();
        assert!((parts / area(&patch["id"]) - 1.0).abs() < 1e-3, "{patch}");
        assert_eq!(patch["cut"] == "edge-hint", patch.get("d_segment").is_some());
    }
}

#[test]
fn the_triangles_of_a_mesh_cover_its_faces_and_name_their_corners() {
    let scene = scene("occluder.glb");
    let baked = bake(&scene, &BakeSettings::default(), Progress::silent()).unwrap();
    let json: Value = serde_json::from_str(&mesh::json(&scene, &baked.mesh)).unwrap();
    let vertices = json["vertices"].as_array().unwrap();
    let at = |part: &Value, id: &Value| {
        let vertex = vertices.iter().find(|vertex| &vertex["part"] == part && &vertex["id"] == id).unwrap();
        let at: Vec<f64> = vertex["at_m"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        glam::DVec3::from_slice(&at)
    };
    let area: f64 = json["triangles"]
        .as_array()
        .unwrap()
        .iter()
        .map(|triangle| {
            let corners: Vec<glam::DVec3> =
                triangle["corners"].as_array().unwrap().iter().map(|id| at(&triangle["part"], id)).collect();
            0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length()
        })
        .sum();
    assert!((area - 38.0).abs() < 1e-5, "a floor of 36 m2, a plate and a lamp of 1 m2: {area}");
}
