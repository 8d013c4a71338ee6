//! What the fuzz targets share.
//!
//! Each target panics where a promise is broken; libFuzzer then keeps the bytes that did it, and stops where memory or
//! time run out of all proportion.

use std::path::Path;

use umbrage::bake::{BakeError, BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage::shade::{BakedMesh, ShadeSettings};
use umbrage::solve::SolveSettings;
use umbrage_formats::{ReadOptions, read_scene_bytes};

/// Reads a scene whose name ends in `ending`. Nothing beside it can be read, so the bytes are all that counts.
///
/// # Panics
/// Where an error does not name the file, or a scene has numbers that nothing later could take.
pub fn read(ending: &str, bytes: &[u8]) {
    let name = format!("no/such/folder/fuzz.{ending}");
    match read_scene_bytes(Path::new(&name), bytes.to_vec(), &ReadOptions::default()) {
        Err(error) => assert!(error.to_string().starts_with("no/such/folder/"), "{error}"),
        Ok((scene, warnings)) => {
            for surface in scene.surfaces.iter().chain(&scene.see_through) {
                let count = surface.positions_m.len();
                assert!(surface.polygons.iter().flatten().all(|&i| (i as usize) < count), "an index out of range");
                assert!(surface.positions_m.iter().chain(&surface.normals).all(|p| p.is_finite()), "not finite");
                assert!(surface.uvs.iter().all(|uv| uv.is_finite()), "texture coordinates that are not finite");
                assert!([0, count].contains(&surface.uvs.len()) && [0, count].contains(&surface.normals.len()));
            }
            assert!(scene.materials.iter().all(|m| m.reflectance.is_finite() && m.radiance.is_finite()));
            warnings.iter().for_each(|warning| assert!(!warning.to_string().is_empty()));
        }
    }
}

/// Bakes a small scene coarsely; `None` where it is refused.
///
/// # Panics
/// Where the baked mesh breaks a promise, or a refusal says nothing.
pub fn coarse_bake(scene: &Scene) -> Option<BakedMesh> {
    let settings = BakeSettings {
        max_form_factor: Some(0.5),
        min_area_m2: Some(f64::INFINITY),
        solve: SolveSettings { max_iterations: 3, ..SolveSettings::default() },
        // Enough for the shapes of all soups but the largest, which are refused.
        shade: ShadeSettings { tolerance: 2.0, max_triangles: 1000 },
        ..BakeSettings::default()
    };
    let baked = match bake(scene, &settings, Progress::silent()) {
        Ok(baked) => baked.mesh,
        Err(BakeError::Cancelled(_)) => unreachable!("nobody cancels"),
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return None;
        }
    };
    assert_eq!(baked.validate(), Ok(()));
    Some(baked)
}
