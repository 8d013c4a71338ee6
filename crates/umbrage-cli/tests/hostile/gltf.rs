//! Hostile glTF: floods of objects, numbers that cannot be, bombs, names, changed bytes.

use fastrand::Rng;
use serde_json::{Value, json};

use crate::{Hostile, Kind};

pub(crate) const KINDS: &[(&str, Kind)] = &[
    ("gltf-numbers", numbers),
    ("gltf-empty-primitives", empty_primitives),
    ("gltf-attributes", attributes),
    ("gltf-materials", materials),
    ("gltf-nodes", nodes),
    ("gltf-depth", depth),
    ("gltf-weights", weights),
    ("gltf-lamps", lamps),
    ("gltf-instances", instances),
    ("gltf-extensions", extensions),
    ("gltf-names", names),
    ("gltf-image-bomb", image_bomb),
    ("gltf-skins", skins),
    ("gltf-sparse", sparse),
    ("gltf-bytes", changed_bytes),
    ("gltf-cut", cut),
];

/// Three corners, three normals, three places in an image, and three indices.
fn bin() -> Vec<u8> {
    let floats = [
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].as_slice(),
        &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0],
        &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0],
    ];
    let mut bytes: Vec<u8> = floats.concat().iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0_u32, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

fn base() -> Value {
    json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "n", "mesh": 0, "translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}],
        "meshes": [{"name": "m", "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0, "mode": 4}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "byteOffset": 0},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"},
            {"bufferView": 3, "componentType": 5125, "count": 3, "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 36},
            {"buffer": 0, "byteOffset": 72, "byteLength": 24}, {"buffer": 0, "byteOffset": 96, "byteLength": 12}],
        "buffers": [{"byteLength": 108}],
        "materials": [{"name": "lamp", "emissiveFactor": [1, 1, 1], "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.5,
            "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1]},
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 3}}}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 5, "range": 4, "color": [1, 1, 1],
            "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.4}}]}},
    })
}

fn glb(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(((28 + json.len() + bin.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json[..]), (b"BIN\0", bin)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    out
}

fn hostile(json: &Value) -> Hostile {
    Hostile::new("a.glb", glb(json, &bin()))
}

/// One value of a document, whichever it is, becomes another.
fn numbers(rng: &mut Rng) -> Hostile {
    let mut json = base();
    json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    let wild = [
        json!(1e308),
        json!(-1e308),
        json!(1e100),
        json!(-1),
        json!(0),
        json!(9_007_199_254_740_993_u64),
        json!(u64::MAX),
        json!(1.5),
        json!(null),
        json!("x"),
        json!([]),
        json!({}),
        json!([1e308, 1e308, 1e308]),
        json!(1e-320),
    ];
    for _ in 0..rng.usize(1..3) {
        let mut paths = Vec::new();
        list_paths(&json, String::new(), &mut paths);
        let path = paths[rng.usize(..paths.len())].clone();
        *json.pointer_mut(&path).unwrap() = wild[rng.usize(..wild.len())].clone();
    }
    Hostile { baked: true, ..hostile(&json) }
}

fn list_paths(value: &Value, path: String, paths: &mut Vec<String>) {
    match value {
        Value::Object(map) => map.iter().for_each(|(key, value)| list_paths(value, format!("{path}/{key}"), paths)),
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, value)| list_paths(value, format!("{path}/{i}"), paths))
        }
        _ => {}
    }
    if !path.is_empty() {
        paths.push(path);
    }
}

fn empty_primitives(rng: &mut Rng) -> Hostile {
    let mut json = base();
    let all = json["meshes"][0]["primitives"].as_array_mut().unwrap();
    all.extend((0..rng.usize(20_000..30_000)).map(|_| json!({"attributes": {}})));
    hostile(&json)
}

fn attributes(rng: &mut Rng) -> Hostile {
    let mut json = base();
    let all = json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap();
    all.extend((0..rng.usize(30_000..40_000)).map(|i| (format!("_A{i}"), json!(0))));
    hostile(&json)
}

fn materials(rng: &mut Rng) -> Hostile {
    let mut json = base();
    let count = rng.usize(5_000..40_000);
    json["materials"] = (0..count).map(|i| json!({"name": format!("m{i}"), "emissiveFactor": [1, 1, 1]})).collect();
    let used = rng.usize(1..count);
    json["meshes"][0]["primitives"] =
        (0..used).map(|i| json!({"attributes": {"POSITION": 0}, "material": i})).collect();
    hostile(&json)
}

fn nodes(rng: &mut Rng) -> Hostile {
    let mut json = base();
    let count = rng.usize(10_000..40_000);
    json["nodes"] =
        (0..count).map(|i| json!({"name": format!("n{i}"), "mesh": 0, "translation": [2 * i, 0, 0]})).collect();
    json["scenes"][0]["nodes"] = (0..count).collect();
    hostile(&json)
}

fn depth(rng: &mut Rng) -> Hostile {
    let mut json = base();
    let count = rng.usize(400..60_000);
    json["nodes"] =
        (0..count).map(|i| json!({"children": [if i + 1 < count || rng.bool() { i + 1 } else { 0 }]})).collect();
    hostile(&json)
}

fn weights(rng: &mut Rng) -> Hostile {
    let (targets, count) = (rng.usize(100..6_000), rng.usize(100..6_000));
    let mut json = base();
    json["meshes"][0]["weights"] = json!(vec![0.5; targets]);
    json["meshes"][0]["primitives"][0]["targets"] = json!(vec![json!({"POSITION": 0}); targets]);
    json["nodes"] = (0..count).map(|_| json!({"mesh": 0})).collect();
    json["scenes"][0]["nodes"] = (0..count).collect();
    hostile(&json)
}

fn lamps(rng: &mut Rng) -> Hostile {
    let mut json = base();
    let count = rng.usize(500..2_000);
    let values = [0.0, -1.0, 1e100, 0.5, 3.0, 1e-30];
    let mut value = || values[rng.usize(..values.len())];
    let light = |i: usize| {
        json!({"type": (["point", "spot", "directional"][i % 3]), "intensity": value(), "range": value(), "color": [1, value(), 1],
        "spot": {"innerConeAngle": value(), "outerConeAngle": value()}})
    };
    json["extensions"]["KHR_lights_punctual"]["lights"] = (0..count).map(light).collect();
    let node = |i: usize| json!({"extensions": {"KHR_lights_punctual": {"light": i}}, "scale": [i % 2, i % 2, i % 2], "translation": [i, 1, 0]});
    json["nodes"].as_array_mut().unwrap().extend((0..count).map(node));
    json["scenes"][0]["nodes"] = (0..count).collect();
    hostile(&json)
}

fn instances(rng: &mut Rng) -> Hostile {
    let mut json = base();
    let count = rng.usize(10_000..100_000);
    let mut bytes = bin();
    bytes.extend((0..count).flat_map(|i| [(i % 300) as f32, (i / 300) as f32, 0.0]).flat_map(f32::to_le_bytes));
    json["bufferViews"].as_array_mut().unwrap().push(json!({"buffer": 0, "byteOffset": 108, "byteLength": 12 * count}));
    json["accessors"]
        .as_array_mut()
        .unwrap()
        .push(json!({"bufferView": 4, "componentType": 5126, "count": count, "type": "VEC3"}));
    json["buffers"][0]["byteLength"] = json!(bytes.len());
    json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 4}}});
    Hostile::new("a.glb", glb(&json, &bytes))
}

fn extensions(rng: &mut Rng) -> Hostile {
    let mut json = base();
    json["extensionsUsed"] = (0..rng.usize(1_000..40_000)).map(|i| format!("X_{}{i}", "y".repeat(i % 300))).collect();
    hostile(&json)
}

fn names(rng: &mut Rng) -> Hostile {
    let mut json = base();
    let parts = ["\u{1b}[31m", "\u{7}", "\u{202e}", "x", "\n", "\u{0}", "\u{e9}", "\"", "/../"];
    let name: String = (0..rng.usize(1..300_000)).map(|_| parts[rng.usize(..parts.len())]).collect();
    for place in ["/nodes/0/name", "/meshes/0/name", "/materials/0/name"] {
        *json.pointer_mut(place).unwrap() = json!(name);
    }
    // One that is refused, so that the names are told.
    json["nodes"][0]["scale"] = json!([1e200, 1, 1]);
    json["nodes"][0]["translation"] = json!([1e308, 1, 1]);
    hostile(&json)
}

fn image_bomb(rng: &mut Rng) -> Hostile {
    let mut json = base();
    let side = [4096_u32, 8192, 16384, 60_000, u32::MAX][rng.usize(..5)];
    let mut picture = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR".to_vec();
    picture.extend(side.to_be_bytes().into_iter().chain(side.to_be_bytes()).chain([8, rng.u8(..7), 0, 0, 0]));
    picture.extend((0..rng.usize(8..64)).map(|_| rng.u8(..)));
    let mut bytes = bin();
    bytes.extend(&picture);
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    json["buffers"][0]["byteLength"] = json!(bytes.len());
    json["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({"buffer": 0, "byteOffset": 108, "byteLength": picture.len()}));
    let count = rng.usize(1..200);
    json["images"] = (0..count).map(|_| json!({"bufferView": 4})).collect();
    json["textures"] = (0..count).map(|i| json!({"source": i})).collect();
    json["materials"] = (0..count)
        .map(|i| json!({"emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {"baseColorTexture": {"index": i}}}))
        .collect();
    json["meshes"][0]["primitives"] =
        (0..count).map(|i| json!({"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "material": i})).collect();
    Hostile::new("a.glb", glb(&json, &bytes))
}

fn skins(rng: &mut Rng) -> Hostile {
    let mut json = base();
    let count = rng.usize(10..4_000);
    json["nodes"] = (0..count).map(|i| json!({"mesh": 0, "skin": i % 7})).collect();
    json["scenes"][0]["nodes"] = (0..count).collect();
    json["skins"] =
        (0..5).map(|_| json!({"joints": (0..count).map(|_| rng.usize(..2 * count)).collect::<Vec<_>>()})).collect();
    hostile(&json)
}

fn sparse(rng: &mut Rng) -> Hostile {
    let mut json = base();
    let count = [3_u64, 1 << 20, 1 << 40, u64::MAX][rng.usize(..4)];
    json["accessors"][0] = json!({"componentType": 5126, "count": count, "type": "VEC3",
        "sparse": {"count": rng.u64(..5), "indices": {"bufferView": 3, "componentType": 5125}, "values": {"bufferView": 0}}});
    hostile(&json)
}

fn changed_bytes(rng: &mut Rng) -> Hostile {
    let mut bytes = glb(&base(), &bin());
    for _ in 0..rng.usize(1..12) {
        let place = rng.usize(..bytes.len());
        bytes[place] = rng.u8(..);
    }
    Hostile { baked: true, ..Hostile::new("a.glb", bytes) }
}

fn cut(rng: &mut Rng) -> Hostile {
    let mut bytes = glb(&base(), &bin());
    bytes.truncate(rng.usize(1..bytes.len()));
    Hostile::new("a.glb", bytes)
}
