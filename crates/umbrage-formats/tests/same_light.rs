//! The Cornell box has the same light whichever format it comes in.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::DVec3;
use umbrage::bake::{BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage::shade::BakedMesh;
use umbrage_formats::read_scene;

/// How much the mean light of two files may differ, as a share of itself. Their coordinates differ by rounding, and then so do
/// the meshes.
const SAME: f64 = 0.002;

/// The mean irradiance of what has each material, in W/m2.
fn means(scene: &Scene, mesh: &BakedMesh) -> BTreeMap<String, DVec3> {
    let mut sums: BTreeMap<String, (f64, DVec3)> = BTreeMap::new();
    for part in &mesh.parts {
        let material = &scene.materials[scene.surfaces[part.surface].material].name;
        let sum = sums.entry(material.clone()).or_default();
        let point = |p: [f32; 3]| DVec3::from(p.map(f64::from));
        for corners in &part.triangles {
            let [a, b, c] = corners.map(|i| point(part.positions_m[i as usize]));
            let area_m2 = 0.5 * (b - a).cross(c - a).length();
            let irradiance = corners.iter().map(|&i| point(part.irradiance[i as usize])).sum::<DVec3>() / 3.0;
            *sum = (sum.0 + area_m2, sum.1 + area_m2 * irradiance);
        }
    }
    sums.into_iter().map(|(name, (area_m2, sum))| (name, sum / area_m2)).collect()
}

#[test]
fn the_cornell_box_has_the_same_light_as_glb_obj_and_mgf() {
    let of = |file: &str| {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/scenes").join(file);
        let (scene, _) = read_scene(path).unwrap();
        let baked = bake(&scene, &BakeSettings::default(), Progress::silent()).unwrap();
        means(&scene, &baked.mesh)
    };
    let first = of("cornell.glb");
    assert_eq!(first.keys().collect::<Vec<_>>(), ["green", "light", "red", "white"]);
    for file in ["cornell.obj", "cornell.mgf"] {
        let other = of(file);
        assert!(other.keys().eq(first.keys()), "{file}: {other:?}");
        for (material, &mean) in &first {
            let off = ((other[material] - mean) / mean).abs().max_element();
            assert!(off <= SAME, "{file}, {material}: {:.3} % off", 100.0 * off);
        }
    }
}
