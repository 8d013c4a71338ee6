//! Compressed geometry, made by compressors of others, is what it was before.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::path::PathBuf;

use glam::DVec3;
use umbrage::scene::{Rgb, Scene};
use umbrage_formats::{Warning, read_scene};

fn sheet(name: &str) -> (Scene, Vec<Warning>) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/compressed");
    read_scene(folder.join(format!("{name}.glb"))).unwrap()
}

/// The corners of each triangle with their normals, the least corner first.
fn triangles(scene: &Scene) -> Vec<[(DVec3, DVec3); 3]> {
    let [surface] = scene.surfaces.raw.as_slice() else { panic!("{} surfaces", scene.surfaces.len()) };
    let corner = |&i: &u32| (surface.positions_m[i as usize], surface.normals[i as usize]);
    let all = surface.polygons.iter().map(|polygon| {
        let mut corners: [_; 3] = polygon.iter().map(corner).collect::<Vec<_>>().try_into().unwrap();
        let least = (0..3).min_by(|&i, &j| {
            (corners[i].0.x + 9.0 * corners[i].0.z).total_cmp(&(corners[j].0.x + 9.0 * corners[j].0.z))
        });
        corners.rotate_left(least.unwrap());
        corners
    });
    all.collect()
}

#[test]
fn a_sheet_is_the_same_however_it_is_compressed() {
    let (plain, warnings) = sheet("sheet");
    assert!(warnings.is_empty());
    let plain = triangles(&plain);
    assert_eq!(plain.len(), 216);
    for name in [
        "sheet_draco_edgebreaker",
        "sheet_draco_sequential",
        "sheet_draco_valence",
        "sheet_meshopt",
        "sheet_meshopt_quantized",
        "sheet_meshopt_filtered",
    ] {
        let (scene, warnings) = sheet(name);
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
        let found = triangles(&scene);
        assert_eq!(found.len(), plain.len(), "{name}");
        for expected in &plain {
            // Positions have 12 bits and more, over 3 m; normals have 8.
            let same = |other: &&[(DVec3, DVec3); 3]| {
                (0..3).all(|i| other[i].0.distance(expected[i].0) < 1e-3 && other[i].1.distance(expected[i].1) < 0.03)
            };
            assert_eq!(found.iter().filter(same).count(), 1, "{name}: {expected:?}");
        }
        // 0.8 times the colour of the vertices, which has 8 bits.
        let reflectance = scene.materials[scene.surfaces.raw[0].material].reflectance;
        assert!((reflectance - Rgb::new(0.4, 0.2, 0.6)).abs().max_element() < 0.003, "{name}: {reflectance}");
    }
}
