//! What files a scene is made of.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::json;
use tempfile::TempDir;
use umbrage_formats::{ReadOptions, read_scene_and_files};

use common::Build;

/// A folder with these files.
fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    folder
}

/// Reads `scene` in the folder; the names of its files in the folder, and whether it could be read.
fn files_of(folder: &TempDir, scene: &str) -> (Vec<String>, bool) {
    let read = read_scene_and_files(folder.path().join(scene), &ReadOptions::default());
    let name = |file: PathBuf| -> String { relative(folder, &file).to_string_lossy().replace('\\', "/") };
    (read.files.into_iter().map(name).collect(), read.scene.is_ok())
}

fn relative<'a>(folder: &TempDir, file: &'a Path) -> &'a Path {
    file.strip_prefix(folder.path()).unwrap()
}

fn known(files: &[&str]) -> Vec<String> {
    files.iter().map(|&file| file.to_owned()).collect()
}

#[test]
fn an_obj_is_made_of_its_libraries_and_their_images() {
    let obj = b"mtllib a b.mtl none.mtl lib/c.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl c\nf 1 2 3\n";
    let library = b"newmtl c\nmap_Kd ../wood.png\nnewmtl d\nmap_Kd ../../secret.png\n";
    let folder = folder(&[("in/room.obj", obj), ("in/lib/c.mtl", library)]);
    // The whole line may be one name. What is named like the OBJ is taken where a library is not there. What lies outside is
    // not asked for.
    let all = ["room.obj", "a", "a b.mtl none.mtl lib/c.mtl", "b.mtl", "lib/c.mtl", "none.mtl", "room.mtl", "wood.png"];
    let all: Vec<String> = all.iter().map(|name| format!("in/{name}")).collect();
    assert_eq!(files_of(&folder, "in/room.obj"), (all, true));
}

#[test]
fn an_mgf_is_made_of_its_includes_until_one_is_missing() {
    let folder = folder(&[
        ("room.mgf", b"i lib/a.mgf\ni lib/a.mgf\ni none.mgf\ni never.mgf\n"),
        ("lib/a.mgf", b"i b.mgf\n"),
        ("lib/b.mgf", b"v a =\n"),
    ]);
    let asked = known(&["room.mgf", "lib/a.mgf", "lib/b.mgf", "none.mgf"]);
    assert_eq!(files_of(&folder, "room.mgf"), (asked, false));
}

#[test]
fn a_gltf_is_made_of_the_buffers_and_images_that_it_needs() {
    let mut build = Build::triangle();
    let view = build.view(&[0; 24]);
    let uv = build.accessor(json!({"bufferView": view, "componentType": 5126, "count": 3, "type": "VEC2"}));
    build.json["images"] = json!([{"uri": "wood%20floor.png"}, {"uri": "unused.png"}]);
    build.json["textures"] = json!([{"source": 0}]);
    build.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    build.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    build.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uv);
    build.json["buffers"] = json!([{"byteLength": build.bin.len(), "uri": "data/room.bin"}]);
    let json = build.json.to_string();
    let with_buffer = folder(&[("room.gltf", json.as_bytes()), ("data/room.bin", &build.bin)]);
    let all = known(&["room.gltf", "data/room.bin", "wood floor.png"]);
    assert_eq!(files_of(&with_buffer, "room.gltf"), (all, true));
    let without = folder(&[("room.gltf", json.as_bytes())]);
    assert_eq!(files_of(&without, "room.gltf"), (known(&["room.gltf", "data/room.bin"]), false));
}

#[test]
fn a_scene_that_is_not_there_is_made_of_itself() {
    assert_eq!(files_of(&folder(&[]), "room.glb"), (known(&["room.glb"]), false));
    let binary = folder(&[("room.glb", &Build::triangle().glb())]);
    assert_eq!(files_of(&binary, "room.glb"), (known(&["room.glb"]), true));
}
