//! What is written is sound, is read back with the same bits, and shows what it should.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failure here is a failed test")]

mod common;

use std::f64::consts::PI;

use common::{polygons, scene_path};
use glam::DVec3;
use serde_json::{Value, json};
use umbrage::id::{MaterialId, NodeId, SurfaceId};
use umbrage::scene::cornell::cornell_box;
use umbrage::scene::{Material, Node, Rgb, Scene};
use umbrage::shade::{BakedMesh, BakedPart};
use umbrage_formats::{
    BakeFacts, BakedFile, FormatError, baked_glb_bytes, read_baked, read_baked_bytes, read_scene, write_baked_glb,
};

/// The scene's own polygons as triangles, with an irradiance made up from the position.
fn made_up_bake(scene: &Scene) -> BakedMesh {
    common::made_up_bake(scene, DVec3::new(0.1, -3.0, 1e6 / 3.0), |corner| (corner.abs() * 7.0).as_vec3().into())
}

fn facts() -> BakeFacts {
    let extras = json!({"d_segments": [1, 2, 3], "exposure": "not this"});
    BakeFacts { exposure: None, residual: 1.5e-4, extras: extras.as_object().unwrap().clone() }
}

fn written(scene: &Scene, baked: &BakedMesh, facts: &BakeFacts) -> (Value, BakedFile) {
    let bytes = baked_glb_bytes(scene, baked, facts).unwrap();
    let json_length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json = serde_json::from_slice(&bytes[20..20 + json_length]).unwrap();
    (json, read_baked_bytes("test.glb", bytes).unwrap())
}

/// A scene with nested nodes, a node without surfaces, and a surface whose part will be empty.
fn nested_scene() -> Scene {
    let mut scene = cornell_box();
    scene.nodes.push(Node {
        name: Some("lamp".into()),
        parent: Some(0.into()),
        mesh_name: Some("bulb".into()),
        ..Node::default()
    });
    scene.nodes.push(Node { name: None, parent: Some(1.into()), ..Node::default() });
    scene.nodes.push(Node {
        name: Some("gone".into()),
        parent: None,
        mesh_name: Some("gone".into()),
        ..Node::default()
    });
    scene.surfaces[SurfaceId::from(3)].node = NodeId::from(1);
    scene.surfaces[SurfaceId::from(2)].node = NodeId::from(3);
    scene
}

fn bits(vectors: &[[f32; 3]]) -> Vec<[u32; 3]> {
    vectors.iter().map(|v| v.map(f32::to_bits)).collect()
}

#[test]
fn what_is_read_back_has_the_bits_that_were_written() {
    let scene = nested_scene();
    let mut baked = made_up_bake(&scene);
    assert_eq!(baked.parts[0].positions_m[1], [0.0; 3]);
    baked.parts[0].positions_m[1] = [-0.0; 3];
    let (_, file) = written(&scene, &baked, &facts());
    assert_eq!(file.origin_m, baked.origin_m);
    assert_eq!((file.name.as_str(), file.parts.len()), ("cornell", 4));
    assert_eq!(file.triangle_count(), baked.triangle_count());
    assert_eq!(file.vertex_count(), baked.vertex_count());
    // Parts come in the order of the nodes.
    for (part, surface) in file.parts.iter().zip([0, 1, 3, 2]) {
        let source = &baked.parts[surface];
        let material = &scene.materials[scene.surfaces[source.surface].material];
        assert_eq!(part.material_name, material.name);
        assert_eq!(bits(&part.positions_m), bits(&source.positions_m));
        assert_eq!(bits(&part.normals), bits(&source.normals));
        assert_eq!(bits(&part.irradiance), bits(&source.irradiance));
        assert_eq!(part.triangles, source.triangles);
    }
    let names: Vec<_> = file.parts.iter().map(|p| (p.node_name.as_str(), p.name.as_str())).collect();
    assert_eq!(names, [("cornell", "cornell"), ("cornell", "cornell"), ("lamp", "bulb"), ("gone", "gone")]);
}

#[test]
fn nodes_stay_and_only_parts_with_triangles_become_meshes() {
    let scene = nested_scene();
    let mut baked = made_up_bake(&scene);
    for part in [1, 2] {
        let surface = baked.parts[part].surface;
        baked.parts[part] = BakedPart::new(surface);
    }
    let (json, _) = written(&scene, &baked, &facts());
    assert_eq!(
        json["nodes"],
        json!([
            {"name": "umbrage", "translation": [0.1, -3.0, 1e6 / 3.0], "children": [1, 4]},
            {"name": "cornell", "mesh": 0, "children": [2]},
            {"name": "lamp", "mesh": 1, "children": [3]},
            {},
            {"name": "gone"},
        ])
    );
    assert_eq!(json["meshes"].as_array().unwrap().len(), 2);
    assert_eq!(json["meshes"][0]["primitives"].as_array().unwrap().len(), 1);
    assert_eq!(json["materials"].as_array().unwrap().len(), 4);
}

#[test]
fn facts_are_in_the_extras() {
    let scene = cornell_box();
    let baked = made_up_bake(&scene);
    let (json, file) = written(&scene, &baked, &facts());
    let extras = &json["asset"]["extras"]["umbrage"];
    assert_eq!(extras["exposure"].as_f64(), Some(file.exposure_k));
    assert_eq!(extras["exposure_percentile"], json!(99.5));
    assert_eq!(extras["units"], json!("irradiance W/m2"));
    assert_eq!(extras["residual"], json!(1.5e-4));
    assert_eq!(extras["d_segments"], json!([1, 2, 3]));
    assert_eq!(Value::Object(file.extras.clone()), *extras);
    assert_eq!(json["asset"]["generator"], json!(concat!("Umbrage ", env!("CARGO_PKG_VERSION"))));
    let (json, file) = written(&scene, &baked, &BakeFacts { exposure: Some(0.25), ..facts() });
    assert_eq!(file.exposure_k, 0.25);
    assert_eq!(json["asset"]["extras"]["umbrage"].get("exposure_percentile"), None);
}

#[test]
fn colours_show_the_exposed_radiance() {
    let mut scene = cornell_box();
    // The green wall also glows; the lamp stays a plain one.
    scene.materials[MaterialId::from(2)].radiance = Rgb::new(0.05, 0.0, 0.2);
    let baked = made_up_bake(&scene);
    for exposure in [None, Some(0.3), Some(50.0)] {
        let (_, file) = written(&scene, &baked, &BakeFacts { exposure, ..facts() });
        let k = file.exposure_k;
        for (part, source) in file.parts.iter().zip(&baked.parts) {
            let material = &scene.materials[scene.surfaces[source.surface].material];
            for (color, e) in part.color.iter().zip(&source.irradiance) {
                assert_eq!(color[3], 1.0);
                for c in 0..3 {
                    let radiance = material.radiance[c] + material.reflectance[c] * f64::from(e[c]) / PI;
                    let shown = f64::from(part.base_color[c]) * f64::from(color[c]);
                    let wanted = if material.emits() {
                        (k * radiance).min(1.0)
                    } else {
                        material.reflectance[c] * (k * f64::from(e[c]) / PI).min(1.0)
                    };
                    assert!((shown - wanted).abs() < 1e-5, "{}: {shown} {wanted}", material.name);
                }
            }
            if !material.emits() {
                assert_eq!(part.base_color[..3], material.reflectance.as_vec3().to_array());
            } else if material.reflectance == Rgb::ZERO {
                assert!(part.color.iter().all(|c| *c == [1.0; 4]));
            }
        }
    }
}

#[test]
fn the_chosen_exposure_clips_little() {
    let scene = cornell_box();
    let folder = tempfile::tempdir().unwrap();
    let written = write_baked_glb(&scene, &made_up_bake(&scene), &facts(), folder.path().join("a.glb")).unwrap();
    assert!(written.clipped_vertices <= 4, "{written:?}");
    assert_eq!(written.bytes, std::fs::metadata(folder.path().join("a.glb")).unwrap().len());
    // A dark bake has no brightest part, and a bake of nothing but lamps takes these.
    let mut dark = made_up_bake(&scene);
    dark.parts.iter_mut().flat_map(|p| &mut p.irradiance).for_each(|e| *e = [0.0; 3]);
    let (_, file) = self::written(&scene, &dark, &facts());
    // To three digits, and not above.
    assert_eq!(file.exposure_k, 0.0543);
}

#[test]
fn materials_are_unlit_and_plain() {
    let scene = cornell_box();
    let (json, _) = written(&scene, &made_up_bake(&scene), &facts());
    assert_eq!(json["extensionsUsed"], json!(["KHR_materials_unlit"]));
    for material in json["materials"].as_array().unwrap() {
        assert_eq!(material["extensions"], json!({"KHR_materials_unlit": {}}));
        assert!(material.get("emissiveFactor").is_none() && material.get("doubleSided").is_none());
    }
    assert_eq!(json["materials"][3]["extras"]["umbrage"]["radiance"][0], json!(18.387));
    assert_eq!(json["materials"][0].get("extras"), None);
}

#[test]
fn a_baked_file_is_also_a_scene() {
    let scene = cornell_box();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.glb");
    let mut baked = made_up_bake(&scene);
    baked.origin_m = DVec3::ZERO;
    write_baked_glb(&scene, &baked, &facts(), &path).unwrap();
    let (again, warnings) = read_scene(&path).unwrap();
    assert_eq!(again.polygon_count(), baked.triangle_count());
    let first = baked.parts[0].triangles[0].map(|i| baked.parts[0].positions_m[i as usize].map(f64::from));
    assert_eq!(polygons(&again)[0], first);
    assert_eq!(again.nodes.len(), 2);
    assert!(warnings.iter().any(|w| w.to_string().contains("vertex colours")), "{warnings:?}");
    assert_eq!(read_baked(&path).unwrap().parts.len(), 4);
}

#[test]
fn the_same_bake_gives_the_same_bytes() {
    let (scene, _) = read_scene(scene_path("grid_1k.glb")).unwrap();
    let baked = made_up_bake(&scene);
    let first = baked_glb_bytes(&scene, &baked, &facts()).unwrap();
    assert_eq!(first.len() % 4, 0);
    assert_eq!(baked_glb_bytes(&scene, &baked.clone(), &facts()).unwrap(), first);
}

#[test]
fn a_write_that_fails_leaves_the_old_file() {
    let scene = cornell_box();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.glb");
    std::fs::write(&path, b"old").unwrap();
    let baked = made_up_bake(&scene);
    for exposure in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = write_baked_glb(&scene, &baked, &BakeFacts { exposure: Some(exposure), ..facts() }, &path);
        assert!(matches!(refused, Err(FormatError::BadExposure { .. })));
    }
    let nothing = BakedMesh { parts: vec![], ..baked };
    let refused = write_baked_glb(&scene, &nothing, &facts(), &path).unwrap_err();
    assert!(matches!(refused, FormatError::NothingToWrite { .. }) && refused.to_string().contains("out.glb"));
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_broken_promise_is_an_error_that_names_the_vertex() {
    let scene = cornell_box();
    let mut baked = made_up_bake(&scene);
    baked.parts[0].normals[3] = [0.0; 3];
    let message = baked_glb_bytes(&scene, &baked, &facts()).unwrap_err().to_string();
    assert!(message.contains("vertex 3 has normal") && message.contains("material \"white\""), "{message}");
}

#[test]
fn an_altered_file_is_read_in_world_space() {
    let scene = cornell_box();
    let mut baked = made_up_bake(&scene);
    baked.origin_m = DVec3::ZERO;
    let bytes = baked_glb_bytes(&scene, &baked, &facts()).unwrap();
    let json_length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut json: Value = serde_json::from_slice(&bytes[20..20 + json_length]).unwrap();
    json["nodes"][1]["scale"] = json!([-2.0, 2.0, 2.0]);
    let altered = common::frame(json.to_string().as_bytes(), &bytes[28 + json_length..]);
    let file = read_baked_bytes("test.glb", altered).unwrap();
    let (part, source) = (&file.parts[0], &baked.parts[0]);
    let [x, y, z] = source.positions_m[2];
    assert_eq!(part.positions_m[2], [-2.0 * x, 2.0 * y, 2.0 * z]);
    let [a, b, c] = source.triangles[0];
    assert_eq!(part.triangles[0], [a, c, b]);
    let [nx, ny, nz] = source.normals[0];
    assert_eq!(part.normals[0].map(|n| n + 0.0), [-nx, ny, nz].map(|n| n + 0.0));
}

#[test]
fn a_lamp_alone_shows() {
    let mut scene = cornell_box();
    scene.materials.iter_mut().for_each(|m| *m = Material::emitting("lamp", Rgb::new(2.0, 1.0, 0.0)));
    let (_, file) = written(&scene, &made_up_bake(&scene), &facts());
    assert_eq!(file.exposure_k, 0.5);
    assert_eq!(file.parts[0].base_color, [1.0, 0.5, 0.0, 1.0]);
}

/// Leaves files for `ci/validate-glb`, which runs the glTF validator on them.
#[test]
fn files_for_the_validator() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("validate");
    std::fs::create_dir_all(&folder).unwrap();
    let mut glowing = nested_scene();
    glowing.materials[MaterialId::from(2)].radiance = Rgb::new(0.05, 0.0, 0.2);
    let (grid, _) = read_scene(scene_path("grid_1k.glb")).unwrap();
    for (name, scene) in [("cornell", cornell_box()), ("glowing", glowing), ("grid_1k", grid)] {
        write_baked_glb(&scene, &made_up_bake(&scene), &facts(), folder.join(format!("{name}.glb"))).unwrap();
    }
}
