//! What comes in goes out: textures and their places, smooth surfaces, cameras, what lets light through, what others have noted.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failure here is a failed test")]

mod common;

use std::f64::consts::PI;

use common::Build;
use glam::{DVec2, DVec3};
use serde_json::{Value, json};
use umbrage::bake::{Bake, BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::scene::{Alpha, Rgb, Scene};
use umbrage::shade::ShadeSettings;
use umbrage_formats::{BakeFacts, BakedFile, Warning, baked_glb_bytes, choose_nodes, read_baked_bytes};

/// A PNG of one row.
fn png(texels: &[[u8; 4]]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, texels.len() as u32, 1);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(texels.as_flattened()).unwrap();
    writer.finish().unwrap();
    file
}

/// Adds texture coordinates; the number of their accessor.
fn coordinates(build: &mut Build, coordinates: &[[f32; 2]]) -> usize {
    let bytes: Vec<u8> = coordinates.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let view = build.view(&bytes);
    build.accessor(json!({"bufferView": view, "componentType": 5126, "count": coordinates.len(), "type": "VEC2"}))
}

/// Adds the texture `images.len()` and a material that shows it.
fn textured(build: &mut Build, texels: &[[u8; 4]], material: Value) -> usize {
    let view = build.view(&png(texels));
    for key in ["images", "textures", "materials"] {
        if build.json.get(key).is_none() {
            build.json[key] = json!([]);
        }
    }
    let image = build.list("images").len();
    build.list("images").push(json!({"bufferView": view, "mimeType": "image/png", "name": format!("image {image}")}));
    build.list("textures").push(json!({"source": image}));
    build.list("materials").push(material);
    build.list("materials").len() - 1
}

/// Where the floor's corners lie in the image: turned, stretched and moved, but for the strip beyond x = 2, which is as if
/// cut out of the image elsewhere.
fn place(x: f64, z: f64) -> DVec2 {
    let place = DVec2::new(0.25 * x - 0.5 * z + 0.1, 0.75 * x + 0.125 * z - 3.0);
    if x > 2.0 { place + DVec2::new(0.3, 0.0) } else { place }
}

/// A floor of 3 x 2 m in squares of 1 m, each of two triangles, with a box's shadow on it, below a lamp.
fn tiled_room() -> Build {
    let mut build = Build::new();
    let material = textured(
        &mut build,
        &[[188; 4]],
        json!({"name": "tiles", "extras": {"walkable": true},
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 0.5, 1, 1]}}),
    );
    build.json["materials"].as_array_mut().unwrap().push(json!({"name": "lamp", "emissiveFactor": [1, 1, 1]}));
    let (mut positions, mut places) = (Vec::new(), Vec::new());
    for x in 0..3 {
        for z in 0..2 {
            let (x, z) = (x as f32, z as f32);
            for (dx, dz) in [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.0, 0.0), (1.0, 1.0), (1.0, 0.0)] {
                positions.push([x + dx, 0.0, z + dz]);
                // The strip's border belongs to both mappings.
                let moved = if x >= 2.0 { 0.3 } else { 0.0 };
                let whole = place(0.0, 0.0) + (place(f64::from(x + dx).min(2.0), f64::from(z + dz)) - place(0.0, 0.0));
                let beyond = f64::from((x + dx - 2.0).max(0.0)) * (place(1.0, 0.0) - place(0.0, 0.0));
                places.push((whole + beyond + DVec2::new(moved, 0.0)).as_vec2().to_array());
            }
        }
    }
    let (position, place) = (build.floats(&positions), coordinates(&mut build, &places));
    build.primitive(json!({"attributes": {"POSITION": position, "TEXCOORD_0": place}, "material": material}));
    let lamp = build.floats(&[
        [0.5, 2.0, 0.5],
        [1.5, 2.0, 0.5],
        [1.5, 2.0, 1.5],
        [0.5, 2.0, 0.5],
        [1.5, 2.0, 1.5],
        [0.5, 2.0, 1.5],
    ]);
    build.primitive(json!({"attributes": {"POSITION": lamp}, "material": 1}));
    build
}

fn baked(scene: &Scene, tolerance: f64) -> Bake {
    let shade = ShadeSettings { tolerance, ..ShadeSettings::default() };
    let settings = BakeSettings { max_form_factor: Some(0.5), shade, ..BakeSettings::default() };
    bake(scene, &settings, Progress::silent()).unwrap()
}

fn written(scene: &Scene, tolerance: f64) -> (Value, BakedFile) {
    let bytes = baked_glb_bytes(scene, &baked(scene, tolerance).mesh, &BakeFacts::default()).unwrap();
    let json_length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&bytes[20..20 + json_length]).unwrap(), read_baked_bytes("test.glb", bytes).unwrap())
}

#[test]
fn a_merged_and_cut_floor_keeps_every_point_where_it_was_in_the_image() {
    let (scene, _) = tiled_room().read().unwrap();
    let bake = baked(&scene, 0.02);
    // The two mappings are two faces, the lamp is one: twelve triangles were merged.
    assert_eq!(bake.report.faces, 3);
    assert!(bake.report.triangles > 12, "{} triangles: nothing was cut", bake.report.triangles);
    let (json, file) = written(&scene, 0.02);
    let floor = &file.parts[0];
    for triangle in &floor.triangles {
        let corners = triangle.map(|v| file.origin_m + DVec3::from(floor.positions_m[v as usize].map(f64::from)));
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        for (corner, vertex) in corners.iter().zip(triangle) {
            let moved = if middle.x > 2.0 { 0.3 } else { 0.0 };
            let expected = place(corner.x.min(2.0), corner.z)
                + DVec2::new(0.25, 0.75) * (corner.x - 2.0).max(0.0)
                + DVec2::new(moved, 0.0);
            let found = DVec2::from(floor.uvs[*vertex as usize].map(f64::from));
            assert!(found.distance(expected) < 1e-5, "{corner}: {found} {expected}");
        }
    }
    assert_eq!(file.images[floor.texture.unwrap().image], png(&[[188; 4]]));
    assert_eq!(json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"], json!([1.0, 0.5, 1.0, 1.0]));
    assert_eq!(json["materials"][0]["extras"], json!({"walkable": true}));
    assert!(file.parts[1].uvs.is_empty() && json["images"].as_array().unwrap().len() == 1);
}

#[test]
fn a_textured_material_reflects_the_mean_of_what_its_primitives_show() {
    // Left half white, right half black: two primitives show one half each.
    let mut build = Build::triangle();
    let halves = [[255; 4], [255; 4], [0, 0, 0, 255], [0, 0, 0, 255]];
    let material = textured(
        &mut build,
        &halves,
        json!({"name": "halves",
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.8, 0.4, 0.2, 1]}}),
    );
    build.json["meshes"][0]["primitives"] = json!([]);
    for at in [0.1_f32, 0.6] {
        let place = coordinates(&mut build, &[[at, 0.0], [at + 0.3, 0.0], [at, 1.0]]);
        build.primitive(json!({"attributes": {"POSITION": 0, "TEXCOORD_0": place}, "material": material}));
    }
    let (scene, warnings) = build.read().unwrap();
    let materials = scene.surfaces.iter().map(|s| &scene.materials[s.material]).collect::<Vec<_>>();
    assert!((materials[0].reflectance - Rgb::new(0.8, 0.4, 0.2)).length() < 1e-9, "{:?}", materials[0]);
    assert_eq!(materials[1].reflectance, Rgb::ZERO);
    assert!(materials.iter().all(|m| m.name == "halves") && scene.materials.len() == 2);
    assert!(warnings.is_empty(), "{warnings:?}");
    // Without coordinates or with a broken image the plain colour is taken, and a warning says why.
    build.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    build.json["images"][0]["uri"] = json!("nowhere.png");
    build.json["images"][0].as_object_mut().unwrap().remove("bufferView");
    let (scene, warnings) = build.read().unwrap();
    assert!(scene.images.is_empty() && scene.surfaces.iter().all(|surface| surface.uvs.is_empty()));
    assert!(matches!(warnings.as_slice(), [Warning::TexturesIgnored { uses: 2, .. }]), "{warnings:?}");
}

#[test]
fn a_webp_is_passed_on_as_a_png_and_a_ktx2_is_named() {
    let mut build = Build::triangle();
    let metallic = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    let material = textured(&mut build, &[[0; 4]], metallic);
    let mut webp = Vec::new();
    let red = [255, 0, 0].repeat(4);
    image_webp::WebPEncoder::new(&mut webp).encode(&red, 2, 2, image_webp::ColorType::Rgb8).unwrap();
    let view = build.view(&webp);
    build.json["images"] = json!([{"bufferView": view, "mimeType": "image/webp"}]);
    build.json["textures"] = json!([{"extensions": {"EXT_texture_webp": {"source": 0}}}]);
    build.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    build.json["meshes"][0]["primitives"] = json!([]);
    let place = coordinates(&mut build, &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    build.primitive(json!({"attributes": {"POSITION": 0, "TEXCOORD_0": place}, "material": material}));
    let (scene, warnings) = build.read().unwrap();
    let shown = &scene.materials[scene.surfaces.raw[0].material];
    assert_eq!(shown.reflectance, Rgb::new(0.9, 0.0, 0.0));
    assert!(scene.images[shown.look.texture.unwrap().image].bytes.starts_with(b"\x89PNG"));
    assert!(matches!(warnings.as_slice(), [Warning::ReflectanceCapped { .. }]), "{warnings:?}");
    build.json["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
    let (_, warnings) = build.read().unwrap();
    let named = |w: &Warning| matches!(w, Warning::TexturesIgnored { first, .. } if first.contains("ktxdecompress"));
    assert!(warnings.iter().any(named), "{warnings:?}");
}

#[test]
fn an_emissive_texture_emits_its_mean_and_is_seen() {
    let mut build = tiled_room();
    let texels = [[255; 4], [0, 0, 0, 255]];
    let screen = textured(
        &mut build,
        &texels,
        json!({"name": "screen", "emissiveTexture": {"index": 1},
        "emissiveFactor": [0.5, 1, 0]}),
    );
    let place = coordinates(&mut build, &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    build.json["meshes"][0]["primitives"][1]["material"] = json!(screen);
    build.json["meshes"][0]["primitives"][1]["attributes"]["TEXCOORD_0"] = json!(place);
    let (scene, _) = build.read().unwrap();
    let material = &scene.materials[scene.surfaces.raw[1].material];
    assert!((material.radiance - Rgb::new(0.25, 0.5, 0.0)).length() < 0.01, "{material:?}");
    let (_, file) = written(&scene, f64::INFINITY);
    let part = &file.parts[1];
    assert_eq!(file.images[part.texture.unwrap().image], png(&texels));
    assert!(part.color.iter().all(|colour| *colour == [1.0; 4]) && part.uvs.len() == part.positions_m.len());
    // k times what the factor emits, and `light` knows it above white, too.
    let k = file.exposure_k;
    assert!((f64::from(part.base_color[0]) - (0.5 * k).min(1.0)).abs() < 1e-6);
    let light = part.light(k)[0];
    assert!((f64::from(part.base_color[1] * light[1]) - k).abs() < 1e-5, "{light:?}");
}

#[test]
fn what_is_blended_or_masked_looks_as_it_did() {
    let mut build = tiled_room();
    build.json["materials"].as_array_mut().unwrap().extend([
        json!({"name": "glass", "alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.8, 0.9, 0.25]}}),
        json!({"name": "leaf", "alphaMode": "MASK", "alphaCutoff": 0.75}),
    ]);
    build.json["materials"][3]["pbrMetallicRoughness"] =
        json!({"baseColorFactor": [1, 1, 1, 0.9], "baseColorTexture": {"index": 0}});
    let place = coordinates(&mut build, &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    for (material, y) in [(2, 1.0_f32), (3, 1.5)] {
        let position = build.floats(&[[0.0, y, 0.0], [0.2, y, 0.0], [0.0, y, 0.2]]);
        build.primitive(json!({"attributes": {"POSITION": position, "TEXCOORD_0": place}, "material": material}));
    }
    let (scene, warnings) = build.read().unwrap();
    assert!(warnings.contains(&Warning::BlendedPassedOn { polygons: 1 }));
    assert_eq!((scene.surfaces.len(), scene.see_through.len()), (3, 1));
    assert_eq!(scene.materials[scene.see_through[0].material].look.alpha, Alpha::Blend { alpha: 0.25 });
    let (json, file) = written(&scene, f64::INFINITY);
    assert_eq!(file.parts.len(), 3, "what is blended was not baked");
    let by_name = |name: &str| json["materials"].as_array().unwrap().iter().find(|m| m["name"] == name).unwrap();
    assert_eq!(by_name("glass")["alphaMode"], "BLEND");
    assert_eq!(by_name("glass")["pbrMetallicRoughness"]["baseColorFactor"], json!([0.5, 0.8, 0.9, 0.25]));
    assert_eq!((&by_name("leaf")["alphaMode"], &by_name("leaf")["alphaCutoff"]), (&json!("MASK"), &json!(0.75)));
    // The image's alpha counts times 0.9.
    assert_eq!(file.parts[2].cutoff, Some(0.75 / 0.9));
    assert_eq!(file.parts[0].cutoff, None);
    let primitives = json["meshes"][0]["primitives"].as_array().unwrap();
    assert_eq!(primitives.len(), 4);
    assert!(primitives[3]["attributes"].get("_IRRADIANCE").is_none());
}

#[test]
fn cameras_extras_and_whose_work_it_is_are_passed_on() {
    let mut build = tiled_room();
    build.json["asset"]["copyright"] = json!("CC BY, somebody");
    build.json["asset"]["extras"] = json!({"title": "tiles"});
    build.json["scenes"][0]["extras"] = json!([1, 2]);
    build.json["nodes"][0]["extras"] = json!({"solid": true});
    build.json["nodes"][0]["translation"] = json!([1, 0, 0]);
    build.json["meshes"][0]["extras"] = json!("of mesh");
    build.json["cameras"] = json!([
        {"name": "lens", "type": "perspective", "perspective": {"yfov": 0.75, "aspectRatio": 1.5, "znear": 0.1, "zfar": 50.0}},
        {"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1, "znear": 0, "zfar": 9}},
    ]);
    // One camera alone on its node, one on the node of the mesh, which must not be moved.
    build.json["nodes"][0]["camera"] = json!(1);
    build.list("nodes").push(json!({"name": "view", "camera": 0, "translation": [4, 5, 6], "scale": [2, 2, 2]}));
    build.json["scenes"][0]["nodes"] = json!([0, 1]);
    let (scene, _) = build.read().unwrap();
    let (json, file) = written(&scene, f64::INFINITY);
    assert_eq!(json["asset"]["copyright"], "CC BY, somebody");
    assert_eq!(json["asset"]["extras"]["title"], "tiles");
    assert!(json["asset"]["extras"]["umbrage"]["exposure"].is_number());
    assert_eq!((&json["scenes"][0]["extras"], &json["meshes"][0]["extras"]), (&json!([1, 2]), &json!("of mesh")));
    assert_eq!(json["nodes"][1]["extras"], json!({"solid": true}));
    assert_eq!(json["cameras"][1]["perspective"], build.json["cameras"][0]["perspective"]);
    assert_eq!(json["cameras"][0]["orthographic"]["xmag"], json!(2.0));
    assert!(json["nodes"][1].get("translation").is_none() && json["nodes"][1].get("camera").is_none());
    let [camera] = file.cameras.as_slice() else { panic!("{:?}", file.cameras) };
    assert_eq!((camera.name.as_str(), camera.eye_m), ("view", DVec3::new(4.0, 5.0, 6.0)));
    assert!(camera.ahead.distance(DVec3::NEG_Z) < 1e-12 && (camera.fov_y_deg.to_radians() - 0.75).abs() < 1e-12);
}

#[test]
fn what_is_not_chosen_lights_and_shades_but_is_not_in_the_file() {
    let mut build = tiled_room();
    let primitives = build.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    let lamp = primitives.pop().unwrap();
    build.json["meshes"].as_array_mut().unwrap().push(json!({"name": "bulb", "primitives": [lamp]}));
    build.list("nodes").push(json!({"name": "lamp", "mesh": 1}));
    build.json["scenes"][0]["nodes"] = json!([0, 1]);
    let (mut scene, _) = build.read().unwrap();
    let (_, whole) = written(&scene, 0.05);
    choose_nodes(&mut scene, &[], &["lamp".into()]).unwrap();
    let (json, file) = written(&scene, 0.05);
    assert_eq!((file.parts.len(), &file.parts[0].irradiance), (1, &whole.parts[0].irradiance));
    assert_eq!(json["nodes"][2], json!({"name": "lamp"}));
    // And the image that is on what was left out is left out.
    let (mut scene, _) = build.read().unwrap();
    choose_nodes(&mut scene, &["lamp".into()], &[]).unwrap();
    let (json, file) = written(&scene, 0.05);
    assert!(json.get("images").is_none() && file.parts.len() == 1);
}

/// A column of `sides` sides and 1 m radius around Y, smooth, with the normals of the cylinder.
fn column(build: &mut Build, sides: usize, material: usize) {
    let (mut positions, mut normals, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..sides {
        let angle = 2.0 * PI * i as f64 / sides as f64;
        let (z, x) = (-angle.sin() as f32, angle.cos() as f32);
        positions.extend([[x, 0.0, z], [x, 1.0, z]]);
        normals.extend([[x, 0.0, z]; 2]);
        let (a, b) = (2 * i as u32, 2 * ((i as u32 + 1) % sides as u32));
        indices.extend([a, b, b + 1, a, b + 1, a + 1]);
    }
    let (position, normal) = (build.floats(&positions), build.floats(&normals));
    let indices = build.indices(&indices, 5125);
    build.primitive(
        json!({"attributes": {"POSITION": position, "NORMAL": normal}, "indices": indices, "material": material}),
    );
}

#[test]
fn a_smooth_column_has_one_value_and_one_normal_at_each_vertex_and_a_flat_one_has_two() {
    let mut build = Build::new();
    build.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}},
        {"emissiveFactor": [1, 1, 1], "doubleSided": true, "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}}]);
    column(&mut build, 12, 0);
    let lamp = build.floats(&[
        [3.0, 0.0, -1.0],
        [3.0, 2.0, -1.0],
        [3.0, 2.0, 1.0],
        [3.0, 0.0, -1.0],
        [3.0, 2.0, 1.0],
        [3.0, 0.0, 1.0],
    ]);
    build.primitive(json!({"attributes": {"POSITION": lamp}, "material": 1}));
    let (scene, _) = build.read().unwrap();
    let spread = |smooth: bool| {
        let mut settings = BakeSettings { max_form_factor: Some(1.0), ..BakeSettings::default() };
        settings.shade.tolerance = f64::INFINITY;
        settings.prepare.smooth = smooth;
        let mesh = bake(&scene, &settings, Progress::silent()).unwrap().mesh;
        let part = &mesh.parts[0];
        // The vertices that stand in one place.
        let mut most: f32 = 0.0;
        for (i, p) in part.positions_m.iter().enumerate() {
            for (j, q) in part.positions_m.iter().enumerate() {
                if p == q {
                    most = most.max((part.irradiance[i][0] - part.irradiance[j][0]).abs());
                }
            }
        }
        let exact = part.positions_m.iter().zip(&part.normals).all(|(p, n)| {
            let p = mesh.origin_m + DVec3::from(p.map(f64::from));
            DVec3::from(n.map(f64::from)).distance(DVec3::new(p.x, 0.0, p.z).normalize()) < 1e-5
        });
        (most, part.positions_m.len(), exact)
    };
    let (jump, vertices, exact) = spread(true);
    assert!(jump == 0.0 && exact, "{jump}");
    let (flat_jump, flat_vertices, flat_exact) = spread(false);
    assert!(flat_jump > 0.01 && !flat_exact, "{flat_jump}");
    assert!(vertices < flat_vertices, "{vertices} {flat_vertices}");
}

#[test]
fn a_cube_is_no_ball_whatever_its_normals_say() {
    let mut build = Build::new();
    build.json["materials"] = json!([{"emissiveFactor": [1, 1, 1]}]);
    column(&mut build, 4, 0);
    let (scene, _) = build.read().unwrap();
    let prepared = umbrage::prepare::prepare(&scene, Progress::silent()).unwrap();
    assert!(prepared.faces.keys().all(|face| !prepared.is_smooth(face)) && prepared.faces.len() == 4);
}
