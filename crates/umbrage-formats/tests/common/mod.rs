//! Small glTF files, made in code, for the tests of this crate.
#![allow(dead_code, reason = "every test binary uses a part of it")]
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failure here is a failed test")]

use glam::DVec3;
use serde_json::{Value, json};
use umbrage::scene::Scene;
use umbrage::shade::{BakedMesh, BakedPart};
use umbrage_formats::{FormatError, ReadOptions, Warning, read_scene, read_scene_bytes};

/// A folder of this project's scenes.
pub(crate) fn scene_path(name: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/scenes").join(name)
}

/// Writes files into a folder of their own and reads the first.
pub(crate) fn read_files(files: &[(&str, &str)]) -> Result<(Scene, Vec<Warning>), FormatError> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    read_scene(folder.path().join(files[0].0))
}

/// A scene's own polygons as triangles, with an irradiance made up from the position.
pub(crate) fn made_up_bake(scene: &Scene, origin_m: DVec3, irradiance: impl Fn(DVec3) -> [f32; 3]) -> BakedMesh {
    let parts = scene.surfaces.iter_enumerated().map(|(surface, s)| {
        let mut part = BakedPart::new(surface);
        for polygon in 0..s.polygons.len() {
            let corners: Vec<DVec3> = scene.corners_m(surface, polygon).collect();
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            let first = part.positions_m.len() as u32;
            for &corner in &corners {
                part.positions_m.push(corner.as_vec3().into());
                part.normals.push(normal.as_vec3().into());
                part.irradiance.push(irradiance(corner));
            }
            part.triangles.extend((1..corners.len() as u32 - 1).map(|i| [first, first + i, first + i + 1]));
        }
        part
    });
    BakedMesh { origin_m, parts: parts.collect() }
}

/// A glTF under construction: its JSON, and the one buffer.
#[derive(Clone)]
pub(crate) struct Build {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

impl Build {
    /// One node that shows one mesh of no primitives yet.
    pub(crate) fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"name": "chair", "mesh": 0}], "meshes": [{"name": "seat", "primitives": []}],
            "accessors": [], "bufferViews": [], "buffers": [{}],
        });
        Self { json, bin: Vec::new() }
    }

    /// One triangle, not indexed.
    pub(crate) fn triangle() -> Self {
        let mut build = Self::new();
        let position = build.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
        build.primitive(json!({"attributes": {"POSITION": position}}));
        build
    }

    pub(crate) fn list(&mut self, key: &str) -> &mut Vec<Value> {
        self.json[key].as_array_mut().unwrap()
    }

    pub(crate) fn primitive(&mut self, primitive: Value) {
        self.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    }

    /// Adds bytes; the number of their bufferView.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()});
        self.bin.extend_from_slice(bytes);
        self.list("bufferViews").push(view);
        self.list("bufferViews").len() - 1
    }

    /// Adds an accessor; its number.
    pub(crate) fn accessor(&mut self, accessor: Value) -> usize {
        self.list("accessors").push(accessor);
        self.list("accessors").len() - 1
    }

    pub(crate) fn floats(&mut self, vectors: &[[f32; 3]]) -> usize {
        let bytes: Vec<u8> = vectors.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.accessor(json!({"bufferView": view, "componentType": 5126, "count": vectors.len(), "type": "VEC3"}))
    }

    /// Adds indices of a component type.
    pub(crate) fn indices(&mut self, indices: &[u32], component: u32) -> usize {
        let width = [(5121, 1), (5123, 2), (5125, 4)].iter().find(|(c, _)| *c == component).unwrap().1;
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()[..width].to_vec()).collect();
        let view = self.view(&bytes);
        self.accessor(json!({"bufferView": view, "componentType": component, "count": indices.len(), "type": "SCALAR"}))
    }

    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"][0].get("byteLength").is_none() {
            json["buffers"][0]["byteLength"] = json!(self.bin.len());
        }
        frame(json.to_string().as_bytes(), &self.bin)
    }

    pub(crate) fn read(&self) -> Result<(Scene, Vec<Warning>), FormatError> {
        read(self.glb())
    }

    /// The message of the error that reading must end in.
    pub(crate) fn message(&self) -> String {
        let message = self.read().expect_err("this file should be refused").to_string();
        assert!(message.starts_with("test.glb: "), "no file in: {message}");
        message
    }
}

pub(crate) fn read(bytes: Vec<u8>) -> Result<(Scene, Vec<Warning>), FormatError> {
    read_scene_bytes("test.glb", bytes, &ReadOptions::default())
}

/// A GLB frame, written here a second time so as not to test the writer by itself.
pub(crate) fn frame(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let pad = |bytes: &[u8], with: u8| {
        let mut padded = bytes.to_vec();
        padded.resize(bytes.len().next_multiple_of(4), with);
        padded
    };
    let (json, bin) = (pad(json, b' '), pad(bin, 0));
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(((28 + json.len() + bin.len()) as u32).to_le_bytes());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(json);
    out.extend((bin.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(bin);
    out
}

/// All triangles or polygons of a scene, as points.
pub(crate) fn polygons(scene: &Scene) -> Vec<Vec<[f64; 3]>> {
    let surfaces = scene.surfaces.iter();
    surfaces
        .flat_map(|s| s.polygons.iter().map(|p| p.iter().map(|&i| s.positions_m[i as usize].to_array()).collect()))
        .collect()
}

/// All polygons with the names of their materials, sorted: what a scene shows, however it is divided.
pub(crate) fn material_polygons(scene: &Scene) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = Vec::new();
    for surface in &scene.surfaces {
        for polygon in &surface.polygons {
            let corners: Vec<_> = polygon.iter().map(|&i| surface.positions_m[i as usize].to_array()).collect();
            all.push((scene.materials[surface.material].name.clone(), format!("{corners:?}")));
        }
    }
    all.sort();
    all
}
