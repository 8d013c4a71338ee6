//! What is read from a glTF: geometry, transforms, materials, warnings.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Build, polygons, scene_path};
use glam::DVec3;
use serde_json::{Value, json};
use umbrage::id::SurfaceId;
use umbrage::scene::cornell::cornell_box;
use umbrage::scene::{Alpha, LampKind, Rgb, Scene};
use umbrage_formats::{LampUnits, ReadOptions, UpAxis, Warning, read_scene, read_scene_bytes, read_scene_with};

fn vector_area(corners: &[[f64; 3]]) -> DVec3 {
    let p: Vec<DVec3> = corners.iter().map(|&c| DVec3::from(c)).collect();
    (1..p.len() - 1).map(|i| (p[i] - p[0]).cross(p[i + 1] - p[0]) / 2.0).sum()
}

/// Area of each material, in square metres, and the sum of its vector areas.
fn areas(scene: &Scene) -> Vec<(String, f64, DVec3)> {
    let mut areas: Vec<_> = scene.materials.iter().map(|m| (m.name.clone(), 0.0, DVec3::ZERO)).collect();
    for (id, surface) in scene.surfaces.iter_enumerated() {
        for polygon in 0..surface.polygons.len() {
            let corners: Vec<[f64; 3]> = scene.corners_m(id, polygon).map(|c| c.to_array()).collect();
            let area = vector_area(&corners);
            let entry = &mut areas[usize::from(surface.material)];
            entry.1 += area.length();
            entry.2 += area;
        }
    }
    areas
}

#[test]
fn the_cornell_file_is_the_built_in_cornell_box() {
    let (read, warnings) = read_scene(scene_path("cornell.glb")).unwrap();
    let built = cornell_box();
    assert_eq!(warnings, []);
    assert_eq!(read.validate(), Ok(()));
    assert_eq!((&read.name, &read.nodes), (&built.name, &built.nodes));
    assert_eq!(read.materials.len(), built.materials.len());
    for (r, b) in read.materials.iter().zip(&built.materials) {
        assert_eq!((&r.name, r.double_sided), (&b.name, b.double_sided));
        assert!((r.reflectance - b.reflectance).abs().max_element() < 1e-12, "{r:?}");
        assert!((r.radiance - b.radiance).abs().max_element() < 1e-9, "{r:?}");
    }
    for ((name, area, vector), (_, built_area, built_vector)) in areas(&read).into_iter().zip(areas(&built)) {
        assert!((area - built_area).abs() < 1e-6, "{name}: {area} {built_area}");
        assert!((vector - built_vector).length() < 1e-6, "{name}");
    }
    // Every corner of the one is a corner of the other, up to rounding to f32.
    for (surface, other) in read.surfaces.iter().zip(&built.surfaces) {
        assert_eq!(surface.material, other.material);
        for p in &surface.positions_m {
            assert!(other.positions_m.iter().any(|q| p.distance(*q) < 1e-7), "{p}");
        }
    }
    assert_eq!(read.polygon_count(), 16 * 2 + 2 + 2 + 2);
}

#[test]
fn the_other_scenes_open_without_warnings() {
    for (name, triangles, emitters) in
        [("occluder.glb", 6, 1), ("touching.glb", 38, 1), ("furnace.glb", 12, 1), ("grid_1k.glb", 1964, 1)]
    {
        let (scene, warnings) = read_scene(scene_path(name)).unwrap();
        assert_eq!(warnings, [], "{name}");
        assert_eq!(scene.validate(), Ok(()), "{name}");
        assert_eq!(scene.polygon_count(), triangles, "{name}");
        assert_eq!(scene.materials.iter().filter(|m| m.emits()).count(), emitters, "{name}");
    }
}

#[test]
fn indices_of_every_width_and_none() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    for component in [5121, 5123, 5125] {
        let mut build = Build::new();
        let (position, indices) = (build.floats(&corners), build.indices(&[0, 1, 2, 0, 2, 3], component));
        build.primitive(json!({"attributes": {"POSITION": position}, "indices": indices}));
        let (scene, _) = build.read().unwrap();
        assert_eq!(scene.surfaces.raw[0].polygons, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(scene.surfaces.raw[0].positions_m.len(), 4);
    }
    let (scene, _) = Build::triangle().read().unwrap();
    assert_eq!(polygons(&scene), [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]]);
    assert_eq!(scene.place(0.into(), 0), "node \"chair\", material \"default\", polygon 0");
}

#[test]
fn only_the_vertices_that_are_used_are_taken() {
    let mut build = Build::new();
    let position = build.floats(&[[9.0; 3], [0.0; 3], [f32::NAN; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let indices = build.indices(&[4, 1, 3], 5125);
    build.primitive(json!({"attributes": {"POSITION": position}, "indices": indices}));
    let (scene, _) = build.read().unwrap();
    assert_eq!(scene.surfaces.raw[0].positions_m.len(), 3);
    assert_eq!(polygons(&scene), [[[0.0, 1.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0]]]);
}

#[test]
fn strips_and_fans_keep_one_side_in_front() {
    let strip = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0]];
    let fan = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    for (mode, corners) in [(5, strip), (6, fan)] {
        let mut build = Build::new();
        let position = build.floats(&corners);
        build.primitive(json!({"attributes": {"POSITION": position}, "mode": mode}));
        let triangles = polygons(&build.read().unwrap().0);
        assert_eq!(triangles.len(), 3);
        for triangle in &triangles {
            assert_eq!(vector_area(triangle), DVec3::new(0.0, 0.0, 0.5), "mode {mode}: {triangle:?}");
        }
    }
}

#[test]
fn points_lines_and_left_over_corners_are_counted() {
    let mut build = Build::new();
    let four = build.floats(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0; 3]]);
    for mode in [0, 1, 3, 4] {
        build.primitive(json!({"attributes": {"POSITION": four}, "mode": mode}));
    }
    build.primitive(json!({"attributes": {}}));
    let (scene, warnings) = build.read().unwrap();
    assert_eq!(scene.polygon_count(), 1);
    for expected in [
        Warning::PointsAndLines { primitives: 3 },
        Warning::LeftOverCorners { primitives: 1 },
        Warning::NoPositions { primitives: 1 },
    ] {
        assert!(warnings.contains(&expected), "{warnings:?}");
    }
}

#[test]
fn sparse_positions_replace_others_or_zero() {
    for base in [true, false] {
        let mut build = Build::new();
        let plain = build.floats(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 5.0, 0.0]]);
        let index_bytes: Vec<u8> = [1_u16, 2].iter().flat_map(|i| i.to_le_bytes()).collect();
        let index_view = build.view(&index_bytes);
        let value_bytes: Vec<u8> = [2.0_f32, 0.0, 0.0, 0.0, 2.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        let value_view = build.view(&value_bytes);
        build.json["accessors"][plain]["sparse"] = json!({"count": 2,
            "indices": {"bufferView": index_view, "componentType": 5123}, "values": {"bufferView": value_view}});
        if !base {
            build.json["accessors"][plain].as_object_mut().unwrap().remove("bufferView");
        }
        build.primitive(json!({"attributes": {"POSITION": plain}}));
        assert_eq!(polygons(&build.read().unwrap().0), [[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]]);
    }
}

#[test]
fn quantized_positions_and_strides() {
    let mut build = Build::new();
    build.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    // i16 normalized, four to a vertex for alignment.
    let bytes: Vec<u8> = [[0_i16, 0, 0, 9], [32767, 0, 0, 9], [0, -32768, 0, 9]]
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let view = build.view(&bytes);
    build.json["bufferViews"][view]["byteStride"] = json!(8);
    let normalized = build
        .accessor(json!({"bufferView": view, "componentType": 5122, "count": 3, "type": "VEC3", "normalized": true}));
    let plain = build.accessor(json!({"bufferView": view, "componentType": 5122, "count": 3, "type": "VEC3"}));
    build.primitive(json!({"attributes": {"POSITION": normalized}}));
    build.primitive(json!({"attributes": {"POSITION": plain}}));
    let (scene, warnings) = build.read().unwrap();
    assert!(!warnings.iter().any(|w| matches!(w, Warning::UnknownExtension { .. })));
    let all = polygons(&scene);
    assert_eq!(all[0], [[0.0; 3], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
    assert_eq!(all[1], [[0.0; 3], [32767.0, 0.0, 0.0], [0.0, -32768.0, 0.0]]);
}

#[test]
fn nested_transforms_multiply_and_parents_come_first() {
    let mut build = Build::triangle();
    build.json["nodes"] = json!([
        {"name": "leaf", "mesh": 0, "translation": [1.0, 0.0, 0.0]},
        {"name": "root", "translation": [10.0, 0.0, 0.0], "children": [2, 3]},
        {"rotation": [0, 0, 1, 1], "scale": [2.0, 2.0, 2.0], "children": [0]},
        {"name": "empty", "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 5,5,5,1]},
    ]);
    build.json["scenes"][0]["nodes"] = json!([1]);
    let (scene, _) = build.read().unwrap();
    let names: Vec<_> = scene.nodes.iter().map(|n| n.name.as_deref()).collect();
    assert_eq!(names, [Some("root"), None, Some("leaf"), Some("empty")]);
    let parents: Vec<_> = scene.nodes.iter().map(|n| n.parent.map(usize::from)).collect();
    assert_eq!(parents, [None, Some(0), Some(1), Some(0)]);
    assert_eq!(scene.nodes.raw[2].mesh_name.as_deref(), Some("seat"));
    let expected = [[10.0, 2.0, 0.0], [10.0, 4.0, 0.0], [6.0, 2.0, 0.0]];
    for (p, q) in polygons(&scene)[0].iter().zip(expected) {
        assert!(DVec3::from(*p).distance(q.into()) < 1e-12, "{p:?}");
    }
}

#[test]
fn a_mirror_turns_triangles_over_so_that_fronts_stay_in_front() {
    // A face looking up stays a face looking up when mirrored in x.
    for (scale, mirrored) in [([-1.0, 1.0, 1.0], true), ([-1.0, 1.0, -1.0], false), ([-1.0, -1.0, -1.0], true)] {
        let mut build = Build::triangle();
        build.json["nodes"][0]["scale"] = json!(scale);
        let triangle = &polygons(&build.read().unwrap().0)[0];
        let first = triangle.iter().position(|p| p[0] != 0.0).unwrap();
        assert_eq!(first, if mirrored { 2 } else { 1 }, "{triangle:?}");
        let normal = DVec3::new(0.0, 0.0, 1.0) * DVec3::from(scale);
        assert!(vector_area(triangle).dot(normal) > 0.0);
    }
}

#[test]
fn every_instance_is_a_surface_of_its_own() {
    let mut build = Build::triangle();
    build.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "translation": [0, 0, 1]}]);
    build.json["scenes"][0]["nodes"] = json!([0, 1]);
    let (scene, _) = build.read().unwrap();
    assert_eq!(scene.surfaces.len(), 2);
    assert_eq!(polygons(&scene)[1][0], [0.0, 0.0, 1.0]);
}

#[test]
fn gpu_instances_become_nodes() {
    let mut build = Build::triangle();
    let shifts = build.floats(&[[0.0, 0.0, 1.0], [0.0, 0.0, 2.0]]);
    build.json["nodes"][0]["translation"] = json!([5, 0, 0]);
    build.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": shifts}}});
    let (scene, _) = build.read().unwrap();
    assert_eq!((scene.nodes.len(), scene.surfaces.len()), (3, 2));
    assert_eq!(polygons(&scene).iter().map(|p| p[0]).collect::<Vec<_>>(), [[5.0, 0.0, 1.0], [5.0, 0.0, 2.0]]);
}

#[test]
fn materials() {
    let mut build = Build::triangle();
    build.json["materials"] = json!([
        {"name": "wall", "doubleSided": true, "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.95, 0.25, 1.0]}},
        {"emissiveFactor": [1.0, 0.5, 0.0], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}},
            "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}},
    ]);
    build.json["meshes"][0]["primitives"][0]["material"] = json!(1);
    let (scene, warnings) = build.read().unwrap();
    let [wall, lamp] = [&scene.materials.raw[0], &scene.materials.raw[1]];
    assert_eq!((wall.name.as_str(), wall.double_sided), ("wall", true));
    assert_eq!(wall.reflectance, Rgb::new(0.5, 0.9, 0.25));
    assert_eq!((lamp.name.as_str(), lamp.radiance), ("material 1", Rgb::new(8.0, 4.0, 0.0)));
    assert_eq!(scene.surfaces.raw[0].material, 1.into());
    assert_eq!(warnings, [Warning::ReflectanceCapped { materials: 1, max_reflectance: 0.9 }]);
}

#[test]
fn the_cap_is_an_option_and_counts_the_default_material_once() {
    let mut build = Build::triangle();
    build.json["meshes"][0]["primitives"] = json!([{"attributes": {"POSITION": 0}}, {"attributes": {"POSITION": 0}}]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("white room.glb");
    std::fs::write(&path, build.glb()).unwrap();
    let (scene, warnings) =
        read_scene_with(&path, &ReadOptions { max_reflectance: 0.5, ..ReadOptions::default() }).unwrap();
    assert_eq!(scene.name, "white room");
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(scene.materials.raw[0].reflectance, Rgb::splat(0.5));
    assert_eq!(warnings, [Warning::ReflectanceCapped { materials: 1, max_reflectance: 0.5 }]);
}

#[test]
fn what_is_not_used_is_counted() {
    let mut build = Build::triangle();
    build.json["extensionsUsed"] = json!(["FOO_bar", "FOO_baz", "KHR_materials_specular"]);
    build.json["extensionsRequired"] = json!(["FOO_bar"]);
    build.json["materials"] = json!([{"alphaMode": "MASK", "emissiveTexture": {"index": 0}, "emissiveFactor": [1, 1, 1],
        "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "baseColorTexture": {"index": 0}}}]);
    build.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    build.json["meshes"][0]["primitives"][0]["targets"] = json!([{}]);
    build.json["nodes"][0]["skin"] = json!(0);
    build.json["animations"] = json!([{}, {}]);
    build.list("nodes").push(json!({"mesh": 0}));
    let (scene, warnings) = build.read().unwrap();
    assert_eq!(scene.polygon_count(), 1);
    let unknown = |name: &str, required| Warning::UnknownExtension { name: name.into(), required };
    for expected in [
        Warning::AlphaIgnored { materials: 1 },
        Warning::MorphTargetsAtRest { primitives: 1 },
        Warning::SkinsAtRest { nodes: 1 },
        Warning::AnimationsIgnored { animations: 2 },
        Warning::NodesOutsideScene { nodes: 1 },
        unknown("FOO_bar", true),
        unknown("FOO_baz", false),
    ] {
        assert!(warnings.contains(&expected), "{expected:?} not in {warnings:?}");
        assert!(!expected.to_string().is_empty());
    }
    let dangling = |w: &&Warning| matches!(w, Warning::TexturesIgnored { uses: 2, first } if first.contains("texture"));
    assert_eq!(warnings.iter().filter(dangling).count(), 1, "{warnings:?}");
    assert_eq!(warnings.len(), 8);
}

#[test]
fn morph_targets_stand_as_the_weights_state() {
    // A target that lifts the triangle by 2, and one that widens it.
    let mut build = Build::triangle();
    let (lift, widen) = (build.floats(&[[0.0, 0.0, 2.0]; 3]), build.floats(&[[0.0; 3], [4.0, 0.0, 0.0], [0.0; 3]]));
    build.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": lift}, {"POSITION": widen}, {}]);
    let corners = |build: &Build| {
        let (scene, warnings) = build.read().unwrap();
        assert!(warnings.contains(&Warning::MorphTargetsAtRest { primitives: 1 }), "{warnings:?}");
        scene.corners_m(SurfaceId::from(0), 0).collect::<Vec<_>>()
    };
    let plain = corners(&build);
    build.json["meshes"][0]["weights"] = json!([0.5, 0.0, 1.0]);
    let lifted: Vec<DVec3> = plain.iter().map(|&corner| corner + DVec3::Z).collect();
    assert_eq!(corners(&build), lifted);
    // Those of the node come first.
    build.json["nodes"][0]["weights"] = json!([0, 0.25, 0]);
    let widened: Vec<DVec3> = (0..3).map(|i| plain[i] + DVec3::X * if i == 1 { 1.0 } else { 0.0 }).collect();
    assert_eq!(corners(&build), widened);
    build.json["nodes"][0]["weights"] = json!(["much"]);
    assert!(build.read().unwrap_err().to_string().contains("node 0"));
}

#[test]
fn vertex_colours_multiply_the_reflectance() {
    let varying = [[1.0, 1.0, 1.0], [0.4, 1.0, 0.1], [1.0, 0.1, 0.1]];
    for (colours, expected, varies) in [
        ([[1.0; 3]; 3], Rgb::splat(0.9), false),
        ([[1.0, 0.5, 0.0]; 3], Rgb::new(0.9, 0.45, 0.0), false),
        (varying, 0.9 * Rgb::new(0.8, 0.7, 0.4), true),
        ([[f32::NAN, 7.0, -1.0]; 3], Rgb::new(0.0, 0.9, 0.0), false),
    ] {
        let mut build = Build::triangle();
        let colour = build.floats(&colours);
        build.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colour);
        build.json["materials"] = json!([{"name": "wall"}]);
        build.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        let (scene, warnings) = build.read().unwrap();
        let material = &scene.materials[scene.surfaces.raw[0].material];
        assert!((material.reflectance - expected).length() < 1e-6, "{material:?}");
        assert_eq!(material.name, "wall");
        assert_eq!(warnings.contains(&Warning::VertexColoursAveraged { primitives: 1 }), varies, "{warnings:?}");
    }
}

#[test]
fn what_is_blended_blocks_nothing_and_what_is_masked_blocks_whole() {
    for (material, polygons, warning) in [
        (json!({"alphaMode": "BLEND"}), 1, None),
        (
            json!({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 0.5]}}),
            0,
            Some(Warning::BlendedPassedOn { polygons: 1 }),
        ),
        (
            json!({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}),
            0,
            Some(Warning::BlendedPassedOn { polygons: 1 }),
        ),
        (json!({"alphaMode": "MASK"}), 1, Some(Warning::AlphaIgnored { materials: 1 })),
        (json!({"alphaMode": "OPAQUE"}), 1, None),
    ] {
        let mut build = Build::triangle();
        build.json["materials"] = json!([material]);
        build.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        let (scene, warnings) = build.read().unwrap();
        assert_eq!(scene.polygon_count(), polygons, "{material}");
        let of_alpha = |w: &&Warning| matches!(w, Warning::AlphaIgnored { .. } | Warning::BlendedPassedOn { .. });
        assert_eq!(warnings.iter().find(of_alpha), warning.as_ref(), "{material}");
    }
}

#[test]
fn glass_blocks_nothing_and_what_transmits_less_than_half_is_opaque() {
    let transmits = |share: f64| json!({"KHR_materials_transmission": {"transmissionFactor": share}});
    let with_volume = |mut extensions: Value| {
        extensions["KHR_materials_volume"] = json!({"thicknessFactor": 0.01, "attenuationColor": [0.5, 1, 1]});
        extensions
    };
    let glass = Some(Warning::GlassPassedOn { polygons: 1 });
    let opaque = Some(Warning::TransmissionIgnored { materials: 1 });
    for (extensions, alpha_mode, alpha, warning) in [
        (transmits(1.0), "OPAQUE", Alpha::Blend { alpha: 0.0 }, glass.clone()),
        (with_volume(transmits(0.75)), "OPAQUE", Alpha::Blend { alpha: 0.25 }, glass.clone()),
        (transmits(0.5), "MASK", Alpha::Blend { alpha: 0.5 }, glass),
        (with_volume(transmits(0.25)), "OPAQUE", Alpha::Opaque, opaque.clone()),
        (transmits(0.25), "MASK", Alpha::Mask { alpha: 0.5, cutoff: 0.5 }, opaque),
        (with_volume(json!({})), "OPAQUE", Alpha::Opaque, None),
        (json!({"KHR_materials_transmission": {}}), "OPAQUE", Alpha::Opaque, None),
        // What is blended as well has the alpha of that.
        (transmits(1.0), "BLEND", Alpha::Blend { alpha: 0.5 }, Some(Warning::BlendedPassedOn { polygons: 1 })),
    ] {
        let mut build = Build::triangle();
        let base = json!({"baseColorFactor": [1, 1, 1, 0.5]});
        build.json["materials"] =
            json!([{"alphaMode": alpha_mode, "pbrMetallicRoughness": base, "extensions": extensions}]);
        build.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        build.json["extensionsUsed"] = json!(["KHR_materials_transmission", "KHR_materials_volume"]);
        let (scene, warnings) = build.read().unwrap();
        let is_passed_on = matches!(alpha, Alpha::Blend { .. });
        assert_eq!((scene.surfaces.len(), scene.see_through.len()), if is_passed_on { (0, 1) } else { (1, 0) });
        assert_eq!(scene.materials.raw[0].look.alpha, alpha, "{extensions}");
        let of_light = |w: &&Warning| !matches!(w, Warning::AlphaIgnored { .. } | Warning::ReflectanceCapped { .. });
        assert_eq!(warnings.iter().filter(of_light).collect::<Vec<_>>(), warning.iter().collect::<Vec<_>>());
    }
}

#[test]
fn without_a_scene_all_roots_are_shown() {
    let mut build = Build::triangle();
    let json = build.json.as_object_mut().unwrap();
    json.remove("scene");
    json.remove("scenes");
    json["nodes"] = json!([{"children": [1]}, {"mesh": 0}, {"mesh": 0}]);
    let (scene, _) = build.read().unwrap();
    assert_eq!((scene.nodes.len(), scene.surfaces.len()), (3, 2));
    assert_eq!(scene.name, "test");
}

#[test]
fn buffers_beside_the_file_and_embedded() {
    let build = Build::triangle();
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("a folder")).unwrap();
    std::fs::write(folder.path().join("a folder/tri.bin"), &build.bin).unwrap();
    let base64 = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAEAAAAAA";
    for uri in ["a%20folder/tri.bin", &format!("data:application/octet-stream;base64,{base64}")] {
        let mut json = build.json.clone();
        json["buffers"] = json!([{"byteLength": build.bin.len(), "uri": uri}]);
        let path = folder.path().join("scene.gltf");
        std::fs::write(&path, json.to_string()).unwrap();
        let (scene, _) = read_scene(&path).unwrap();
        assert_eq!(polygons(&scene), [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]], "{uri}");
    }
}

/// A triangle and three lamps: a point, a spot that hangs in a turned, moved and scaled node, a sun.
fn with_lamps() -> Build {
    let mut build = Build::triangle();
    build.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1]}}]);
    build.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    build.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "name": "bulb", "intensity": 683.0, "color": [1.0, 0.5, 0.0], "range": 7.0},
        {"type": "spot", "intensity": 2.0, "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}},
        {"type": "directional"},
    ]}});
    let lamp = |number: usize| json!({"KHR_lights_punctual": {"light": number}});
    // A quarter turn about x takes -z to +y.
    let half = 0.5_f64.sqrt();
    build.list("nodes").extend([
        json!({"translation": [1, 2, 3], "extensions": lamp(0)}),
        json!({"translation": [0, 1, 0], "scale": [2, 2, 2], "children": [3]}),
        json!({"name": "hanging", "translation": [0, 0, 1], "rotation": [half, 0, 0, half], "extensions": lamp(1)}),
        json!({"name": "sun", "extensions": lamp(2)}),
    ]);
    build.json["scenes"][0]["nodes"] = json!([0, 1, 2, 4]);
    build
}

#[test]
fn lamps_stand_where_their_nodes_do_and_shine_along_minus_z() {
    let (scene, warnings) = with_lamps().read().unwrap();
    assert_eq!(warnings, []);
    assert_eq!(scene.lamps.iter().map(|lamp| lamp.name.as_str()).collect::<Vec<_>>(), ["bulb", "hanging", "sun"]);
    let point = LampKind::Point {
        position_m: DVec3::new(1.0, 2.0, 3.0),
        intensity: Rgb::new(683.0, 341.5, 0.0),
        range_m: Some(7.0),
    };
    assert_eq!(scene.lamps.raw[0].kind, point);
    let LampKind::Spot { position_m, direction, intensity, range_m, inner_rad, outer_rad } = scene.lamps.raw[1].kind
    else {
        panic!("{:?}", scene.lamps.raw[1])
    };
    assert_eq!((position_m, intensity, range_m), (DVec3::new(0.0, 1.0, 2.0), Rgb::splat(2.0), None));
    assert!(direction.distance(DVec3::Y) < 1e-12 && (inner_rad, outer_rad) == (0.25, 0.5), "{direction}");
    assert_eq!(scene.lamps.raw[2].kind, LampKind::Directional { direction: DVec3::NEG_Z, irradiance: Rgb::ONE });
    // A lamp is light enough for a bake.
    assert_eq!(scene.validate(), Ok(()));
}

#[test]
fn lamps_take_units_and_axes_of_the_file() {
    let options = ReadOptions { unit_m: 0.001, up: UpAxis::Z, lamp_units: LampUnits::Lumens, ..ReadOptions::default() };
    let (scene, _) = read_scene_bytes("test.glb", with_lamps().glb(), &options).unwrap();
    let LampKind::Point { position_m, intensity, range_m } = scene.lamps.raw[0].kind else { panic!() };
    assert!(position_m.distance(DVec3::new(0.001, 0.003, -0.002)) < 1e-15, "{position_m}");
    assert!((intensity - Rgb::new(1.0, 0.5, 0.0)).abs().max_element() < 1e-12 && range_m == Some(0.007));
    let LampKind::Directional { direction, .. } = scene.lamps.raw[2].kind else { panic!() };
    assert_eq!(direction, DVec3::NEG_Y);
}

#[test]
fn blenders_factor_is_told_where_it_matters() {
    let mut build = with_lamps();
    build.json["asset"]["generator"] = json!("Khronos glTF Blender I/O v4.3.47");
    assert_eq!(build.read().unwrap().1, []);
    build.json["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
    let warnings = build.read().unwrap().1;
    assert!(warnings.contains(&Warning::LampsFromBlender { lamps: 3 }), "{warnings:?}");
    let options = ReadOptions { lamp_units: LampUnits::Lumens, ..ReadOptions::default() };
    let warnings = read_scene_bytes("test.glb", build.glb(), &options).unwrap().1;
    assert!(!warnings.contains(&Warning::LampsFromBlender { lamps: 3 }), "{warnings:?}");
}

#[test]
fn bad_lamps_are_refused_by_place() {
    let refused = |light: Value| {
        let mut build = with_lamps();
        build.json["extensions"]["KHR_lights_punctual"]["lights"][0] = light;
        build.message()
    };
    for (light, words) in [
        (json!({"type": "area"}), "should be point, spot or directional"),
        (json!({}), "type: is missing"),
        (json!({"type": "point", "intensity": 1e300, "color": [1e300, 1, 1]}), "too large"),
    ] {
        let message = refused(light);
        assert!(message.contains("light 0") && message.contains(words), "{message}");
    }
    let mut build = with_lamps();
    build.json["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = json!(9);
    assert!(build.message().contains("node 1, light: refers to number 9, but there are only 3"), "{}", build.message());
}

#[test]
fn lamps_that_cannot_be_are_mended_and_the_first_is_told() {
    let mended = |light: Value, node: Value| {
        let mut build = with_lamps();
        build.json["extensions"]["KHR_lights_punctual"]["lights"][0] = light;
        for (key, value) in node.as_object().unwrap() {
            build.json["nodes"][1][key] = value.clone();
        }
        let (scene, warnings) = build.read().unwrap();
        assert_eq!(scene.validate(), Ok(()));
        let told = warnings.iter().find(|warning| matches!(warning, Warning::LampsMended { lamps: 1, .. }));
        (scene.lamps.raw[0].kind, told.map(ToString::to_string))
    };
    let spot = |inner: f64, outer: f64| {
        let light = json!({"type": "spot", "spot": {"innerConeAngle": inner, "outerConeAngle": outer}});
        let (kind, told) = mended(light, json!({}));
        let LampKind::Spot { inner_rad, outer_rad, .. } = kind else { panic!("{kind:?}") };
        (inner_rad, outer_rad, told)
    };
    let near = |a: f64, b: f64| (a - b).abs() < 3e-6;
    // Equal cones are a common exporter's default, also after rounding to f32.
    for inner in [0.5, 0.5 + 1e-7, 0.5 - 1e-7] {
        let (inner_rad, outer_rad, told) = spot(inner, 0.5);
        assert!(near(inner_rad, 0.5) && near(outer_rad, 0.5) && told.is_none(), "{told:?}");
    }
    let (inner_rad, outer_rad, told) = spot(0.8, 0.5);
    assert!(near(inner_rad, 0.5) && near(outer_rad, 0.5) && told.unwrap().contains("cones of 0.8 and 0.5"));
    let (_, outer_rad, told) = spot(0.1, 2.0);
    assert!(near(outer_rad, std::f64::consts::FRAC_PI_2) && told.is_some());
    assert!(spot(-0.1, 0.0).2.is_some());

    for range in [0.0, -2.0] {
        let (kind, told) = mended(json!({"type": "point", "range": range}), json!({}));
        assert!(matches!(kind, LampKind::Point { range_m: None, .. }) && told.unwrap().contains("range"), "{kind:?}");
    }
    let (kind, told) = mended(json!({"type": "point", "intensity": -3}), json!({}));
    assert!(matches!(kind, LampKind::Point { intensity: Rgb::ZERO, .. }) && told.unwrap().contains("below 0"));
    // The scale of a node does not change where its lamp looks.
    let half = 0.5_f64.sqrt();
    let turned = json!({"scale": [0, 0, 0], "rotation": [half, 0, 0, half]});
    let (kind, told) = mended(json!({"type": "spot"}), turned);
    let LampKind::Spot { direction, .. } = kind else { panic!("{kind:?}") };
    assert!(direction.distance(DVec3::Y) < 1e-12 && told.is_none());
}

/// A square in a material, with colours of its corners.
fn square(material: Value, colours: Option<[f32; 4]>) -> Build {
    let mut build = Build::new();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]];
    let (position, coordinates) = (build.floats(&corners), build.floats(&corners));
    build.json["accessors"][coordinates]["type"] = json!("VEC2");
    let view = build.json["accessors"][coordinates]["bufferView"].as_u64().unwrap() as usize;
    build.json["bufferViews"][view]["byteStride"] = json!(12);
    let indices = build.indices(&[0, 2, 1, 0, 3, 2], 5125);
    let mut attributes = json!({"POSITION": position, "TEXCOORD_0": coordinates});
    if let Some(alphas) = colours {
        let bytes: Vec<u8> = alphas.iter().flat_map(|a| [1.0, 1.0, 1.0, *a]).flat_map(f32::to_le_bytes).collect();
        let view = build.view(&bytes);
        let colours = json!({"bufferView": view, "componentType": 5126, "count": 4, "type": "VEC4"});
        attributes["COLOR_0"] = json!(build.accessor(colours));
    }
    build.json["materials"] = json!([material]);
    build.primitive(json!({"attributes": attributes, "indices": indices, "material": 0}));
    build
}

fn with_picture(mut build: Build, alphas: [u8; 2]) -> Build {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 2, 1);
    encoder.set_color(png::ColorType::Rgba);
    let texels = [255, 255, 255, alphas[0], 255, 255, 255, alphas[1]];
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&texels).unwrap();
    writer.finish().unwrap();
    let view = build.view(&file);
    build.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    build.json["textures"] = json!([{"source": 0}]);
    build
}

#[test]
fn what_alpha_leaves_of_a_blended_material_decides_what_light_does() {
    let textured = json!({"alphaMode": "BLEND", "pbrMetallicRoughness":
        {"baseColorFactor": [0.5, 0.5, 0.5, 1], "baseColorTexture": {"index": 0}}});
    let parts = |build: Build| {
        let (scene, warnings) = build.read().unwrap();
        let alpha = scene.see_through.first().map(|surface| scene.materials[surface.material].look.alpha);
        (scene.polygon_count(), alpha, warnings)
    };
    // A texture without an alpha below 1 is opaque, whatever the mode says.
    let (solid, passing, warnings) = parts(with_picture(square(textured.clone(), None), [255, 255]));
    assert!((solid, passing, warnings.len()) == (2, None, 0), "{warnings:?}");
    let (solid, passing, _) = parts(with_picture(square(textured, None), [255, 0]));
    assert!(solid == 0 && passing == Some(Alpha::Blend { alpha: 1.0 }), "{passing:?}");
    // Alpha of the vertices counts as that of the factor does.
    let grey = json!({"baseColorFactor": [0.5, 0.5, 0.5, 1]});
    let plain = json!({"alphaMode": "BLEND", "pbrMetallicRoughness": grey});
    let (solid, passing, warnings) = parts(square(plain.clone(), Some([0.0; 4])));
    assert_eq!((solid, passing, warnings), (0, None, vec![Warning::TransparentLeftOut { polygons: 2 }]));
    let (solid, passing, _) = parts(square(plain.clone(), Some([0.5; 4])));
    assert!(solid == 0 && passing == Some(Alpha::Blend { alpha: 0.5 }), "{passing:?}");
    assert_eq!(parts(square(plain, Some([1.0; 4]))).0, 2);
    let masked = json!({"alphaMode": "MASK"});
    assert_eq!(parts(square(masked.clone(), Some([0.4; 4]))).0, 0, "below the cutoff nothing is seen");
    assert_eq!(parts(square(masked, Some([0.6; 4]))).0, 2);
    // In an opaque material alpha means nothing.
    assert_eq!(parts(square(json!({}), Some([0.0; 4]))).0, 2);
}

#[test]
fn an_emitter_that_is_blended_gives_alpha_times_its_light() {
    let neon = |alpha: f64| {
        json!({"alphaMode": "BLEND", "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, alpha]},
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 50}}})
    };
    let radiance = |build: Build| {
        let (scene, _) = build.read().unwrap();
        scene.surfaces.iter().map(|surface| scene.materials[surface.material].radiance.x).collect::<Vec<_>>()
    };
    assert_eq!(radiance(square(neon(0.5), None)), [25.0]);
    assert_eq!(radiance(square(neon(1.0), Some([0.5; 4]))), [25.0]);
    assert_eq!(radiance(square(neon(1.0), None)), [50.0]);
    assert!(radiance(square(neon(0.0), None)).is_empty());
    let mut sign = neon(1.0);
    sign["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    let [half] = radiance(with_picture(square(sign, None), [255, 0]))[..] else { panic!() };
    assert!((half - 25.0).abs() < 2.0, "{half}");
}

#[test]
fn hidden_nodes_do_nothing_with_all_below_them() {
    let mut build = with_lamps();
    let hidden = json!({"visible": false});
    build.json["nodes"][2]["extensions"] = json!({"KHR_node_visibility": hidden});
    build.json["nodes"][0]["extensions"] = json!({"KHR_node_visibility": hidden});
    build.json["extensionsUsed"] = json!(["KHR_node_visibility"]);
    let (scene, warnings) = build.read().unwrap();
    assert_eq!((scene.polygon_count(), scene.lamps.len(), scene.nodes.len()), (0, 2, 5));
    assert_eq!(warnings, [Warning::HiddenLeftOut { nodes: 3 }]);
    build.json["nodes"][0]["extensions"]["KHR_node_visibility"] = json!({"visible": true});
    assert_eq!(build.read().unwrap().0.polygon_count(), 1);
}

#[test]
fn a_skinned_mesh_stands_where_its_joints_take_it() {
    let mut build = Build::triangle();
    let joints = build.view(&[0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0]);
    let joints = build.accessor(json!({"bufferView": joints, "componentType": 5121, "count": 3, "type": "VEC4"}));
    let weights = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0_f32]];
    let weights = build.view(&weights.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>());
    let weights = build.accessor(json!({"bufferView": weights, "componentType": 5126, "count": 3, "type": "VEC4"}));
    // The inverse bind matrix of the second joint moves by -1 along x.
    let mut binds = [[0.0_f32; 16]; 2];
    binds.iter_mut().for_each(|bind| [0, 5, 10, 15].iter().for_each(|&i| bind[i] = 1.0));
    binds[1][12] = -1.0;
    let binds = build.view(&binds.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>());
    let binds = build.accessor(json!({"bufferView": binds, "componentType": 5126, "count": 2, "type": "MAT4"}));
    let attributes = &mut build.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(joints), json!(weights));
    build.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": binds}]);
    build.json["nodes"][0]["skin"] = json!(0);
    build.json["nodes"][0]["translation"] = json!([50, 0, 0]);
    build.list("nodes").extend([json!({"translation": [0, 3, 0]}), json!({"translation": [0, 0, 4]})]);
    build.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    build.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1]}}]);
    build.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let (scene, warnings) = build.read().unwrap();
    assert_eq!(warnings, []);
    // Of (0, 0, 0), (1, 0, 0) and (0, 2, 0): the first joint; half of each; the second, with a weight that is no share.
    assert_eq!(polygons(&scene), [[[0.0, 3.0, 0.0], [0.5, 1.5, 2.0], [-1.0, 2.0, 4.0]]]);
    // Without its joints a mesh stays at rest, under its node.
    build.json["scenes"][0]["nodes"] = json!([0]);
    let (scene, warnings) = build.read().unwrap();
    assert_eq!(polygons(&scene)[0][0], [50.0, 0.0, 0.0]);
    assert!(warnings.contains(&Warning::SkinsAtRest { nodes: 1 }), "{warnings:?}");
}

#[test]
fn json_may_be_padded_with_nul() {
    let build = Build::triangle();
    let mut json = build.json.clone();
    json["buffers"][0]["byteLength"] = json!(build.bin.len());
    let mut text = json.to_string().into_bytes();
    text.extend([0; 5]);
    let bytes = common::frame(&text, &build.bin);
    assert_eq!(common::read(bytes).unwrap().0.polygon_count(), 1);
}

#[test]
fn what_gives_no_light_shows_its_base_colour_with_its_texture() {
    let lava = json!({"name": "lava", "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0},
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}});
    let mut build = with_picture(square(lava, None), [255, 255]);
    build.json["images"] = json!([build.json["images"][0], build.json["images"][0]]);
    build.json["textures"] = json!([{"source": 0}, {"source": 1}]);
    let of =
        |options: &ReadOptions| read_scene_bytes("test.glb", build.glb(), options).unwrap().0.materials.raw[0].clone();
    assert!(of(&ReadOptions::default()).emits());
    let dark = of(&ReadOptions { dark: vec!["lava".into()], ..ReadOptions::default() });
    assert!(!dark.emits() && dark.look.texture.unwrap().factor == Rgb::ONE, "{dark:?}");
    assert!(dark.reflectance.min_element() > 0.8, "{}", dark.reflectance);
}
