//! The furnished room of `testdata/scenes` is what its generator says, and a sound scene.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failure here is a failed test")]

mod common;

#[path = "../examples/room.rs"]
mod generator;

use std::collections::BTreeMap;

use common::scene_path;
use glam::DVec3;
use umbrage_formats::read_scene;

#[test]
fn the_files_are_what_the_generator_writes() {
    let (obj, mtl) = generator::room();
    assert_eq!(std::fs::read_to_string(scene_path("room.obj")).unwrap(), obj);
    assert_eq!(std::fs::read_to_string(scene_path("room.mtl")).unwrap(), mtl);
}

#[test]
fn the_room_has_three_lamps_and_encloses_all_its_boxes() {
    let (scene, warnings) = read_scene(scene_path("room.obj")).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    scene.validate().unwrap();
    assert_eq!(scene.polygon_count(), 260);
    let emitting = scene.surfaces.iter_enumerated().filter(|(_, s)| scene.materials[s.material].emits());
    assert_eq!(emitting.map(|(_, s)| s.polygons.len()).sum::<usize>(), 3);

    // Every edge has one polygon on each side, which run along it in opposite directions: all is closed. By the theorem of
    // Gauss the volume then is that of the boxes less that of the room, whose fronts look inwards.
    let mut edges: BTreeMap<[[i64; 3]; 2], i32> = BTreeMap::new();
    let mut volume_m3 = 0.0;
    for (surface, s) in scene.surfaces.iter_enumerated() {
        for polygon in 0..s.polygons.len() {
            let corners: Vec<DVec3> = scene.corners_m(surface, polygon).collect();
            for (i, &from) in corners.iter().enumerate() {
                let to = corners[(i + 1) % corners.len()];
                let [from_key, to_key] = [from, to].map(|p| p.to_array().map(|x| (x * 1e4).round() as i64));
                *edges.entry([from_key, to_key]).or_default() += 1;
                *edges.entry([to_key, from_key]).or_default() -= 1;
                volume_m3 += corners[0].dot(from.cross(to)) / 6.0;
            }
        }
    }
    assert!(edges.values().all(|&open| open == 0));
    let room_m3 = 5.0 * 2.7 * 4.0 + 1.6 * 1.2 * 0.15;
    let boxes_m3 = room_m3 + volume_m3;
    assert!((1.5..3.0).contains(&boxes_m3), "{boxes_m3} m3 of furniture");
}
