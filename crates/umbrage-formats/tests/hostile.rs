//! Bad files: each ends in an error that names the file, the place and the trouble, never in a panic, and no count in a
//! file makes memory be taken.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failure here is a failed test")]

mod common;

use std::time::Instant;

use common::{Build, frame, read, scene_path};
use proptest::prelude::*;
use serde_json::{Value, json};
use umbrage_formats::{FormatError, ReadOptions, read_baked, read_baked_bytes, read_scene, read_scene_bytes};

/// What a test does to the JSON of a sound file.
type Change = fn(&mut Value);

/// A small file that uses most of what a file can use.
fn rich() -> Build {
    let mut build = Build::triangle();
    let indices = build.indices(&[0, 1, 2, 2, 1, 0], 5123);
    let position = build.floats(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let sparse_index = build.view(&[1, 0]);
    let sparse_value = build.view(&[0; 12]);
    build.json["accessors"][position]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": sparse_index, "componentType": 5121}, "values": {"bufferView": sparse_value}});
    build.primitive(json!({"attributes": {"POSITION": position}, "indices": indices, "material": 0, "mode": 5}));
    build.json["materials"] = json!([{"emissiveFactor": [1, 1, 1], "name": "lamp"}]);
    build.json["nodes"].as_array_mut().unwrap().push(json!({"children": [0], "scale": [1, -1, 1]}));
    build.json["scenes"][0]["nodes"] = json!([1]);
    build
}

/// A small file with all that passes by the bake: an image, its places, normals, a camera, glass, notes.
fn kept() -> Build {
    let mut build = rich();
    let mut image = Vec::new();
    let mut encoder = png::Encoder::new(&mut image, 2, 2);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(&[9; 16]).unwrap();
    let image = build.view(&image);
    let places: Vec<u8> = [0.0_f32, 0.0, 1.0, 0.0, 0.0, 1.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let places = build.view(&places);
    let places = build.accessor(json!({"bufferView": places, "componentType": 5126, "count": 3, "type": "VEC2"}));
    let normal = build.floats(&[[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [0.0, 0.0, 2.0]]);
    let slot = json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2], "rotation": 1}}});
    build.json["images"] = json!([{"bufferView": image, "mimeType": "image/png", "name": "wood"}]);
    build.json["samplers"] = json!([{"wrapS": 33071, "magFilter": 9728}]);
    build.json["textures"] = json!([{"source": 0, "sampler": 0}]);
    build.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    build.json["nodes"][1]["camera"] = json!(0);
    build.json["materials"].as_array_mut().unwrap().extend([
        json!({"pbrMetallicRoughness": {"baseColorTexture": slot}, "alphaMode": "MASK", "extras": {"a": 1}}),
        json!({"pbrMetallicRoughness": {"baseColorTexture": slot}, "alphaMode": "BLEND"}),
        json!({"emissiveTexture": slot, "emissiveFactor": [1, 1, 1]}),
    ]);
    for material in 1..4 {
        let attributes = json!({"POSITION": 0, "TEXCOORD_0": places, "NORMAL": normal});
        build.primitive(json!({"attributes": attributes, "material": material}));
    }
    build
}

#[test]
fn unreadable_empty_and_unknown_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none.glb");
    assert!(matches!(read_scene(&path), Err(FormatError::Unreadable { .. })));
    assert!(matches!(read_scene(folder.path()), Err(FormatError::Unreadable { .. })));
    let refused = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let error = read_scene(&path).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
        error
    };
    assert!(matches!(refused("empty.glb", b""), FormatError::Empty { .. }));
    assert!(matches!(refused("wrong.glb", b"PK\x03\x04 this is a zip"), FormatError::BadContainer { .. }));
    assert!(matches!(refused("wrong.gltf", b"nothing"), FormatError::BadJson { .. }));
    for (name, word) in [("a.fbx", "FBX"), ("a.xyz", ".xyz"), ("noending", "without ending")] {
        let error = refused(name, b"something else");
        assert!(matches!(error, FormatError::UnknownFormat { .. }));
        let message = error.to_string();
        assert!(message.contains(word) && message.contains("glTF 2.0"), "{message}");
    }
    // The beginning of a file says more than its name.
    std::fs::write(folder.path().join("really.bin"), rich().glb()).unwrap();
    assert!(read_scene(folder.path().join("really.bin")).is_ok());
}

#[test]
fn every_prefix_of_a_glb_is_an_error() {
    let bytes = rich().glb();
    assert!(read(bytes.clone()).is_ok() && read(kept().glb()).is_ok());
    for end in 0..bytes.len() {
        let message = read(bytes[..end].to_vec()).expect_err("a cut file should be refused").to_string();
        assert!(message.starts_with("test.glb: "), "{message}");
    }
}

#[test]
fn json_cut_anywhere_is_an_error() {
    let (json, bin) = (rich().json.to_string(), rich().bin);
    for end in 0..json.len() {
        assert!(read(frame(&json.as_bytes()[..end], &bin)).is_err());
    }
    assert!(read(frame("[".repeat(100_000).as_bytes(), &bin)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn flipped_bytes_never_panic(
        all in any::<bool>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = if all { kept().glb() } else { rich().glb() };
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Ok((scene, _)) = read(bytes.clone()) {
            for surface in scene.surfaces.iter().chain(&scene.see_through) {
                prop_assert!(surface.polygons.iter().flatten().all(|&i| (i as usize) < surface.positions_m.len()));
                prop_assert!(surface.positions_m.iter().all(|p| p.is_finite()));
                prop_assert!(surface.uvs.iter().all(|p| p.is_finite()) && surface.normals.iter().all(|p| p.is_finite()));
            }
        }
        let _ = read_baked_bytes("test.glb", bytes);
    }

    #[test]
    fn odd_values_in_the_json_never_panic(
        place in any::<prop::sample::Index>(),
        value in prop::sample::select(vec![
            "-1", "0", "1", "2", "3", "5", "7", "1e308", "-1e308", "0.5", "4294967295", "4294967296", "18446744073709551615",
            "1e400", "null", "true", "\"\"", "[]", "{}", "[0]", "[[]]",
        ]),
    ) {
        // Replaces the value of one property by something odd.
        let json = kept().json.to_string();
        let colons: Vec<usize> = json.match_indices(':').map(|(at, _)| at + 1).collect();
        let start = colons[place.index(colons.len())];
        let length = json[start..].find([',', '}']).unwrap_or(0);
        let odd = format!("{}{value}{}", &json[..start], &json[start + length..]);
        if let Err(error) = read(frame(odd.as_bytes(), &kept().bin)) {
            prop_assert!(error.to_string().starts_with("test.glb: "), "{error}");
        }
    }
}

#[test]
fn a_nan_is_named_by_node_mesh_primitive_and_vertex() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut build = Build::new();
        let position = build.floats(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, bad, 0.0]]);
        build.primitive(json!({"attributes": {"POSITION": position}}));
        let message = build.message();
        for part in ["node 0 \"chair\"", "mesh 0 \"seat\"", "primitive 0", "vertex 2", "not finite"] {
            assert!(message.contains(part), "no {part} in: {message}");
        }
    }
    let mut build = Build::triangle();
    build.json["nodes"][0]["scale"] = json!([1e200, 1e200, 1e200]);
    build.json["nodes"].as_array_mut().unwrap().push(json!({"children": [0], "scale": [1e200, 1, 1]}));
    build.json["scenes"][0]["nodes"] = json!([1]);
    assert!(build.message().contains("transform is not finite"));
}

#[test]
fn an_index_out_of_range_is_named_by_triangle() {
    let mut build = Build::new();
    let (position, indices) = (build.floats(&[[0.0; 3]; 3]), build.indices(&[0, 1, 2, 0, 1, 4_294_967_295], 5125));
    build.primitive(json!({"attributes": {"POSITION": position}, "indices": indices}));
    let message = build.message();
    assert!(
        message.contains("primitive 0, triangle 1: refers to vertex 4294967295, but there are only 3"),
        "{message}"
    );
}

#[test]
fn huge_counts_take_neither_memory_nor_time() {
    let start = Instant::now();
    for count in [4_294_967_295_u64, 1_000_000_000_000, u64::MAX] {
        for accessor in [
            json!({"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}),
            json!({"componentType": 5126, "count": count, "type": "VEC3"}),
        ] {
            let mut build = Build::triangle();
            build.json["accessors"][0] = accessor;
            let message = build.message();
            assert!(message.contains("node 0"), "{message}");
        }
        let mut build = rich();
        build.json["bufferViews"][0]["byteLength"] = json!(count);
        assert!(build.message().contains("bufferView 0"));
        let mut build = rich();
        build.json["buffers"][0]["byteLength"] = json!(count);
        assert!(build.message().contains("buffer 0"));
        let mut build = rich();
        build.json["bufferViews"][0]["byteStride"] = json!(count);
        build.message();
        let mut build = rich();
        let sparse = build.json["accessors"].as_array().unwrap().iter().position(|a| a.get("sparse").is_some());
        build.json["accessors"][sparse.unwrap()]["sparse"]["count"] = json!(count);
        assert!(build.message().contains("sparse"));
    }
    assert!(start.elapsed().as_secs() < 20);
}

#[test]
fn a_small_file_cannot_unfold_into_a_huge_scene() {
    // Ten thousand nodes show one mesh of ten thousand primitives.
    let mut build = Build::triangle();
    for _ in 0..10_000 {
        build.primitive(json!({"attributes": {"POSITION": 0}}));
    }
    build.json["nodes"] = json!(vec![json!({"mesh": 0}); 10_000]);
    build.json["scenes"][0]["nodes"] = json!((0..10_000).collect::<Vec<_>>());
    assert!(matches!(build.read(), Err(FormatError::TooLarge { .. })));
    // A long name is as long in every node.
    let mut build = Build::triangle();
    build.json["meshes"][0]["name"] = json!("x".repeat(1_000_000));
    build.json["nodes"] = json!(vec![json!({"mesh": 0}); 10_000]);
    build.json["scenes"][0]["nodes"] = json!((0..10_000).collect::<Vec<_>>());
    assert!(matches!(build.read(), Err(FormatError::TooLarge { .. })));
}

#[test]
fn nodes_that_are_no_forest_are_refused() {
    let cases = [
        (json!([{"children": [1]}, {"children": [0]}]), json!([0]), "own ancestor"),
        (json!([{"children": [0]}]), json!([]), "own ancestor"),
        (json!([{"mesh": 0}, {"children": [2]}, {"children": [1]}]), json!([0]), "own ancestor"),
        (json!([{"children": [2]}, {"children": [2]}, {}]), json!([0, 1]), "child of both"),
        (json!([{}]), json!([0, 0]), "twice"),
        (json!([{"children": [7]}]), json!([0]), "node 0, node: refers to number 7"),
    ];
    for (nodes, roots, words) in cases {
        let mut build = Build::triangle();
        build.json["nodes"] = nodes;
        build.json["scenes"][0]["nodes"] = roots;
        let message = build.message();
        assert!(message.contains(words), "no {words:?} in: {message}");
    }
    let mut build = Build::triangle();
    build.json["nodes"] =
        (0..100_000).map(|i| json!({"children": if i < 99_999 { vec![i + 1] } else { vec![] }})).collect();
    assert!(build.message().contains("more than 512 levels deep"));
}

#[test]
fn broken_references_and_properties_are_named() {
    let edit = |change: Change| {
        let mut build = Build::triangle();
        change(&mut build.json);
        build.message()
    };
    let cases: [(Change, &str); 12] = [
        (|j| j["nodes"][0]["mesh"] = json!(3), "node 0 \"chair\", mesh: refers to number 3"),
        (|j| j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9), "accessor: refers to number 9"),
        (
            |j| j["meshes"][0]["primitives"][0]["material"] = json!(0),
            "material: refers to number 0, but there are only 0",
        ),
        (|j| j["meshes"][0]["primitives"][0]["mode"] = json!(8), "8 is not a mode"),
        (|j| j["accessors"][0]["bufferView"] = json!(4), "bufferView: refers to number 4"),
        (|j| j["accessors"][0]["type"] = json!("SCALAR"), "does not suit"),
        (|j| j["accessors"][0]["componentType"] = json!(5130), "not a component type"),
        (|j| j["accessors"][0]["count"] = json!(4), "reaches to byte 48, but there are only 36"),
        (|j| j["bufferViews"][0]["buffer"] = json!(2), "buffer: refers to number 2"),
        (|j| j["scene"] = json!(2), "scene: refers to number 2"),
        (|j| j["nodes"][0]["rotation"] = json!([0, 0, 0, 0]), "no quaternion"),
        (|j| j["asset"]["version"] = json!("1.0"), "glTF 1.0"),
    ];
    for (change, words) in cases {
        let message = edit(change);
        assert!(message.contains(words), "no {words:?} in: {message}");
    }
}

#[test]
fn bad_materials_are_named() {
    for (material, words) in [
        (json!({"name": "wall", "pbrMetallicRoughness": {"baseColorFactor": [-1, 0, 0, 1]}}), "not be negative"),
        (json!({"name": "wall", "pbrMetallicRoughness": {"baseColorFactor": [1, 0]}}), "4 finite numbers"),
        (json!({"name": "wall", "emissiveFactor": "red"}), "3 finite numbers"),
        (
            json!({"name": "wall", "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": -1}}}),
            "negative",
        ),
    ] {
        let mut build = Build::triangle();
        build.json["materials"] = json!([material]);
        let message = build.message();
        assert!(message.contains("material 0 \"wall\"") && message.contains(words), "{message}");
    }
}

#[test]
fn buffers_that_cannot_be_had_are_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("in")).unwrap();
    std::fs::write(folder.path().join("secret.bin"), [0; 36]).unwrap();
    std::fs::write(folder.path().join("in/short.bin"), [0; 35]).unwrap();
    for (uri, words) in [
        (json!("none.bin"), "none.bin"),
        (json!("../secret.bin"), "leaves the folder"),
        (json!("%2e%2e/secret.bin"), "leaves the folder"),
        (json!("/etc/hostname"), "not a relative path"),
        (json!("https://example.com/a.bin"), "nothing is fetched"),
        (json!("short.bin"), "there are only 35"),
        (json!("."), "is not a file"),
        (json!("data:application/octet-stream;base64,@"), "not Base64"),
        (json!(null), "neither a uri nor a binary chunk"),
        (json!(5), "should be a text"),
    ] {
        let mut json = Build::triangle().json;
        json["buffers"] = json!([{"byteLength": 36, "uri": uri}]);
        let path = folder.path().join("in/scene.gltf");
        let error = read_scene_bytes(&path, json.to_string().into_bytes(), &ReadOptions::default()).unwrap_err();
        let message = error.to_string();
        let named = message.starts_with(&path.display().to_string()) && message.contains("buffer 0");
        assert!(named && message.contains(words), "no {words:?} in: {message}");
    }
}

#[test]
fn broken_compressed_meshes_are_named() {
    let mut build = Build::triangle();
    build.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    build.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}});
    let message = build.message();
    assert!(message.contains("KHR_draco_mesh_compression") && message.contains("Draco data"), "{message}");
    let mut build = Build::triangle();
    build.json["buffers"].as_array_mut().unwrap().push(json!({"byteLength": 36}));
    let stream = json!({"buffer": 0, "byteLength": 36, "byteStride": 12, "count": 3, "mode": "ATTRIBUTES"});
    build.json["bufferViews"][0] =
        json!({"buffer": 1, "byteLength": 36, "extensions": {"EXT_meshopt_compression": stream}});
    let message = build.message();
    assert!(message.contains("EXT_meshopt_compression") && message.contains("version"), "{message}");
}

/// The compressed sheets, which a compressor of others made.
fn compressed() -> Vec<Vec<u8>> {
    let folder = scene_path("../compressed");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
        .iter()
        .filter(|path| path.extension().is_some_and(|e| e == "glb"))
        .map(|p| std::fs::read(p).unwrap())
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn flipped_bytes_in_compressed_meshes_never_panic(
        file in any::<prop::sample::Index>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let mut bytes = file.get(&compressed()).clone();
        // The JSON is flipped elsewhere; here what is compressed is, which is the end of the file.
        let json = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        for (at, value) in flips {
            let at = json + at.index(bytes.len() - json);
            bytes[at] = value;
        }
        if let Ok((scene, _)) = read(bytes) {
            for surface in &scene.surfaces {
                prop_assert!(surface.polygons.iter().flatten().all(|&i| (i as usize) < surface.positions_m.len()));
                prop_assert!(surface.positions_m.iter().all(|p| p.is_finite()));
            }
        }
    }
}

#[test]
fn a_compressed_stream_cannot_unfold_into_a_huge_scene() {
    for count in [1_u64 << 34, u64::MAX / 16] {
        let mut build = Build::triangle();
        build.json["buffers"].as_array_mut().unwrap().push(json!({"byteLength": 36}));
        let stream = json!({"buffer": 0, "byteLength": 36, "byteStride": 16, "count": count, "mode": "ATTRIBUTES"});
        build.json["bufferViews"][0] =
            json!({"buffer": 1, "byteLength": 36, "extensions": {"EXT_meshopt_compression": stream}});
        assert!(matches!(build.read(), Err(FormatError::TooLarge { .. })));
    }
}

#[test]
fn a_plain_scene_is_no_baked_file() {
    let error = read_baked(scene_path("cornell.glb")).unwrap_err();
    assert!(matches!(error, FormatError::NotBaked { .. }));
    assert!(error.to_string().contains("bake it first"), "{error}");
}
