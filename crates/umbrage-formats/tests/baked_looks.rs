//! What a baked file says of its looks beside its colours: cameras, textures, light that `COLOR_0` cannot hold.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failure here is a failed test")]

mod common;

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use common::made_up_bake;
use glam::DVec3;
use serde_json::{Value, json};
use umbrage::scene::cornell::cornell_box;
use umbrage::scene::{Rgb, Scene};
use umbrage::shade::BakedMesh;
use umbrage_formats::{BakeFacts, BakedFile, FormatError, TextureWrap, baked_glb_bytes, read_baked_bytes};

/// The box's own polygons as triangles, under an irradiance that grows with height.
fn bake(scene: &Scene) -> BakedMesh {
    made_up_bake(scene, DVec3::ZERO, |corner| [0.5 + 3.0 * corner.y as f32, 0.5, 0.25])
}

/// A baked file whose JSON was altered, and to whose buffer `more` was added.
fn altered(
    scene: &Scene,
    exposure: f64,
    more: &[u8],
    alter: impl FnOnce(&mut Value, usize),
) -> Result<BakedFile, FormatError> {
    let facts = BakeFacts { exposure: Some(exposure), ..BakeFacts::default() };
    let bytes = baked_glb_bytes(scene, &bake(scene), &facts).unwrap();
    let json_length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut json: Value = serde_json::from_slice(&bytes[20..20 + json_length]).unwrap();
    let mut buffer = bytes[28 + json_length..].to_vec();
    let start = buffer.len();
    buffer.extend(more);
    json["buffers"][0]["byteLength"] = json!(buffer.len());
    alter(&mut json, start);
    read_baked_bytes("test.glb", common::frame(json.to_string().as_bytes(), &buffer))
}

/// Gives the first primitive a texture: four coordinates a polygon, then five bytes that stand for an image.
fn with_texture(json: &mut Value, start: usize, vertices: usize) {
    let view = json["bufferViews"].as_array().unwrap().len();
    let accessor = json["accessors"].as_array().unwrap().len();
    let views = json["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 0, "byteOffset": start, "byteLength": 8 * vertices}));
    views.push(json!({"buffer": 0, "byteOffset": start + 8 * vertices, "byteLength": 5}));
    let accessors = json["accessors"].as_array_mut().unwrap();
    accessors.push(json!({"bufferView": view, "componentType": 5126, "count": vertices, "type": "VEC2"}));
    json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(accessor);
    json["images"] = json!([{"uri": "not/loaded.png"}, {"bufferView": view + 1, "mimeType": "image/png"}]);
    json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648}]);
    json["textures"] = json!([{"source": 1, "sampler": 0}]);
    json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({
        "index": 0, "texCoord": 0,
        "extensions": {"KHR_texture_transform": {"offset": [0.25, 0.5], "scale": [2, 4], "texCoord": 1}},
    });
}

fn texture_bytes(vertices: usize) -> Vec<u8> {
    let coordinates = (0..vertices).flat_map(|i| [i as f32, 0.5]);
    let mut bytes: Vec<u8> = coordinates.flat_map(f32::to_le_bytes).collect();
    bytes.extend(b"image");
    bytes
}

#[test]
fn a_texture_comes_with_its_image_and_places() {
    let scene = cornell_box();
    let vertices = bake(&scene).parts[0].positions_m.len();
    let file =
        altered(&scene, 1.0, &texture_bytes(vertices), |json, start| with_texture(json, start, vertices)).unwrap();
    let texture = file.parts[0].texture.unwrap();
    assert_eq!(texture.wrap, [TextureWrap::Clamp, TextureWrap::Mirror]);
    assert_eq!(file.images[texture.image], b"image");
    assert_eq!(file.parts[0].uvs.len(), vertices);
    assert_eq!(file.parts[0].uvs[3], [0.25 + 2.0 * 3.0, 0.5 + 4.0 * 0.5]);
    assert!(file.images[0].is_empty(), "an image that no part shows was loaded");
    assert!(file.parts[1].texture.is_none() && file.parts[1].uvs.is_empty());
}

#[test]
fn a_texture_that_cannot_be_shown_is_named() {
    let scene = cornell_box();
    let vertices = bake(&scene).parts[0].positions_m.len();
    let message = |alter: fn(&mut Value)| {
        let file = altered(&scene, 1.0, &texture_bytes(vertices), |json, start| {
            with_texture(json, start, vertices);
            alter(json);
        });
        file.unwrap_err().to_string()
    };
    let missing = message(|json| {
        json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_1");
    });
    assert!(missing.contains("TEXCOORD_1"), "{missing}");
    let ktx2 = message(|json| json["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 1}}}]));
    assert!(ktx2.contains("KHR_texture_basisu") && ktx2.contains("ktxdecompress"), "{ktx2}");
    let gone = message(|json| json["images"] = json!([]));
    assert!(gone.contains("image") && gone.contains("only 0"), "{gone}");
    let away = message(|json| json["images"][1] = json!({"uri": "../secret.png"}));
    assert!(away.contains("image 1"), "{away}");
    let wrap = message(|json| json["samplers"][0]["wrapS"] = json!(1));
    assert!(wrap.contains("wrapS"), "{wrap}");
}

#[test]
fn cameras_stand_where_their_nodes_are() {
    let file = altered(&cornell_box(), 1.0, &[], |json, _| {
        // A quarter turn about Y: the camera's -Z becomes -X.
        json["nodes"].as_array_mut().unwrap().push(json!({
            "name": "by the door", "camera": 1, "translation": [1, 2, 3],
            "rotation": [0, FRAC_1_SQRT_2, 0, FRAC_1_SQRT_2], "scale": [2, 2, 2],
        }));
        let node = json["nodes"].as_array().unwrap().len() - 1;
        json["nodes"][0]["translation"] = json!([10, 0, 0]);
        json["nodes"][0]["children"].as_array_mut().unwrap().push(json!(node));
        json["nodes"][1]["camera"] = json!(0);
        json["cameras"] = json!([
            {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 1}},
            {"type": "perspective", "perspective": {"yfov": PI / 3.0, "znear": 0.1}},
        ]);
    });
    let cameras = file.unwrap().cameras;
    assert_eq!(cameras.len(), 1);
    assert_eq!((cameras[0].name.as_str(), cameras[0].eye_m), ("by the door", DVec3::new(11.0, 2.0, 3.0)));
    assert!(cameras[0].ahead.abs_diff_eq(DVec3::NEG_X, 1e-12) && cameras[0].up.abs_diff_eq(DVec3::Y, 1e-12));
    assert!((cameras[0].fov_y_deg - 60.0).abs() < 1e-9);
}

#[test]
fn a_camera_that_sees_nothing_is_refused() {
    for (field_of_view, scale) in [(json!(0.0), 1), (json!(4), 1), (json!(null), 1), (json!(1), 0)] {
        let file = altered(&cornell_box(), 1.0, &[], |json, _| {
            json["nodes"][1]["camera"] = json!(0);
            json["nodes"][0]["scale"] = json!([scale, scale, scale]);
            json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": field_of_view, "znear": 0.1}}]);
        });
        assert!(file.is_err(), "{field_of_view} {scale}");
    }
}

#[test]
fn light_goes_on_above_white() {
    let mut scene = cornell_box();
    // The green wall glows and reflects, in red and green alone.
    scene.materials[umbrage::id::MaterialId::from(2)].radiance = Rgb::new(0.5, 0.1, 0.0);
    scene.materials[umbrage::id::MaterialId::from(2)].reflectance = Rgb::new(0.4, 0.4, 0.0);
    for k in [0.5, 40.0] {
        let file = altered(&scene, k, &[], |_, _| {}).unwrap();
        for (part, source) in file.parts.iter().zip(&bake(&scene).parts) {
            let material = &scene.materials[scene.surfaces[source.surface].material];
            for (light, e) in part.light(file.exposure_k).iter().zip(&source.irradiance) {
                for c in 0..3 {
                    let radiance = material.radiance[c] + material.reflectance[c] * f64::from(e[c]) / PI;
                    let shown = f64::from(part.base_color[c] * light[c]);
                    // A step of COLOR_0 is 1.5e-5 where it is not cut off.
                    assert!((shown - k * radiance).abs() <= 1e-5 * (1.0 + shown), "{}: {shown}", material.name);
                }
            }
        }
    }
}

#[test]
fn a_quantile_of_the_irradiance_weighs_by_area() {
    // Red is 0.5 + 3 y. The triangles reach from the floor to the ceiling at 0.5488 m: a third of their corners, by area,
    // is on the floor, a third on the ceiling, and the few others belong to the blocks.
    let file = altered(&cornell_box(), 1.0, &[], |_, _| {}).unwrap();
    let red = |share| file.irradiance_quantile(share, [1.0, 0.0, 0.0]);
    let most = f64::from(0.5 + 3.0 * 0.5488f32);
    assert_eq!([0.0, 0.33, 0.67, 1.0].map(red), [0.5, 0.5, most, most]);
    // Green is the same everywhere; the weights add.
    assert!((file.irradiance_quantile(0.5, [0.0, 1.0, 2.0]) - 1.0).abs() < 1e-6);
    assert_eq!(BakedFile { parts: Vec::new(), ..file }.irradiance_quantile(0.5, [1.0; 3]), 0.0);
}
