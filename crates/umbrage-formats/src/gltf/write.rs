//! The baked mesh as one ordinary GLB.
//!
//! ```text
//! scene -> "umbrage" (translation = origin) -> the input's nodes, transforms identity -> a mesh per node
//!                                                                     -> a primitive per surface
//! ```
//! Every primitive has POSITION, NORMAL, `COLOR_0` (what an unlit renderer multiplies the base colour with), `TEXCOORD_0`
//! where there is an image on it, and `_IRRADIANCE` (what measurements read, unclamped, W/m2). All materials are
//! `KHR_materials_unlit`; one that emits keeps its radiance and reflectance in its extras. What light passes through has no
//! light of its own, and is shown in the mean of the scene's. Nodes and materials without triangles stay; meshes and
//! primitives do not. Cameras and what applications have put beside things are passed on. No time, path or thread count enters: the same input gives the same bytes.

use std::path::Path;

use serde_json::{Map, Value, json};
use umbrage::id::{MaterialId, Table};
use umbrage::scene::{Material, Rgb, Scene, Surface};
use umbrage::shade::{BakedMesh, BakedPart};

use super::container;
use super::exposure;
use super::see_through::SeeThrough;
use super::write_buffer::WriteBuffer;
use super::write_camera;
use super::write_material::{Materials, put_facts, value_of};
use crate::text::shortened;
use crate::{FormatError, write_atomically};

/// What is said about a bake in `asset.extras.umbrage`, and how it is shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakeFacts {
    /// The exposure `k`, per W/(m2 sr); `None` chooses it so that 99.5 % of the reflecting area is not clipped.
    pub exposure: Option<f64>,
    /// The solution's residual; null in the file if it is not finite.
    pub residual: f64,
    /// Whatever else is worth knowing. It must not depend on time, path or thread count. Names that the writer uses
    /// itself (`exposure`, `exposure_percentile`, `residual`, `units`) are the writer's.
    pub extras: Map<String, Value>,
}

/// What a file says of the unit of its `_IRRADIANCE`.
pub(super) const PHOTOMETRIC: &str = "irradiance lx";
const RADIOMETRIC: &str = "irradiance W/m2";

/// What was written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Written {
    /// Bytes of the file.
    pub bytes: u64,
    /// The exposure `k`, per W/(m2 sr): `COLOR_0 = clamp(k E / pi)`.
    pub exposure_k: f64,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// Vertices of surfaces that only reflect whose colour was clipped.
    pub clipped_vertices: usize,
}

/// Writes a baked mesh as a GLB, all or nothing.
///
/// # Errors
/// [`FormatError::BrokenMesh`], [`FormatError::NothingToWrite`], [`FormatError::BadExposure`], [`FormatError::OutputTooLarge`] or
/// [`FormatError::Unwritable`]; the file is then as it was.
pub fn write_baked_glb(
    scene: &Scene,
    baked: &BakedMesh,
    facts: &BakeFacts,
    path: impl AsRef<Path>,
) -> Result<Written, FormatError> {
    let path = path.as_ref();
    let (bytes, written) = encode(scene, baked, facts, &path.display().to_string())?;
    write_atomically(path, &bytes)?;
    Ok(written)
}

/// The bytes that [`write_baked_glb`] writes.
///
/// # Errors
/// As [`write_baked_glb`], but for writing.
pub fn baked_glb_bytes(scene: &Scene, baked: &BakedMesh, facts: &BakeFacts) -> Result<Vec<u8>, FormatError> {
    encode(scene, baked, facts, "the output").map(|(bytes, _)| bytes)
}

fn encode(scene: &Scene, baked: &BakedMesh, facts: &BakeFacts, file: &str) -> Result<(Vec<u8>, Written), FormatError> {
    check_promises(scene, baked).map_err(|what| FormatError::BrokenMesh { file: file.to_owned(), what })?;
    if baked.triangle_count() == 0 {
        return Err(FormatError::NothingToWrite { file: file.to_owned() });
    }
    if let Some(exposure) = facts.exposure.filter(|k| !(k.is_finite() && *k > 0.0)) {
        return Err(FormatError::BadExposure { file: file.to_owned(), exposure });
    }
    let k = facts.exposure.unwrap_or_else(|| exposure::choose(scene, baked));
    let base_colours = exposure::base_colours(scene, baked, k);

    let mut buffer = WriteBuffer::default();
    let materials = Materials::new(scene, &base_colours, &shown_materials(scene, baked), &mut buffer);
    let mut primitives: Vec<Vec<Value>> = vec![Vec::new(); scene.nodes.len()];
    let (mut vertices, mut clipped_vertices) = (0, 0);
    for part in baked.parts.iter().filter(|part| !part.triangles.is_empty()) {
        let surface = &scene.surfaces[part.surface];
        let (colours, clipped) = colours(exposure::material_of(scene, part), base_colours[surface.material], part, k);
        vertices += part.positions_m.len();
        clipped_vertices += clipped;
        let mut attributes = json!({
            "POSITION": buffer.positions(&part.positions_m),
            "NORMAL": buffer.vectors(&part.normals),
            "COLOR_0": buffer.colours(&colours),
            "_IRRADIANCE": buffer.vectors(&part.irradiance),
        });
        if scene.materials[surface.material].look.texture.is_some() && !part.uvs.is_empty() {
            attributes["TEXCOORD_0"] = json!(buffer.coordinates(&part.uvs));
        }
        primitives[usize::from(surface.node)].push(json!({
            "attributes": attributes,
            "indices": buffer.triangles(&part.triangles),
            "material": materials.number_of[surface.material],
        }));
    }
    let mean_light = exposure::mean_colour(scene, baked, k);
    for surface in &scene.see_through {
        if let Some(see_through) = SeeThrough::new(scene, surface, baked.origin_m) {
            // What shines, and lights nothing, shines all the same.
            let light = if scene.materials[surface.material].shines() { Rgb::ONE } else { mean_light };
            let primitive = see_through.primitive(&mut buffer, light, materials.number_of[surface.material]);
            primitives[usize::from(surface.node)].push(primitive);
        }
    }
    let (nodes, meshes) = nodes_and_meshes(scene, baked, primitives);
    let mut shown_scene = json!({"nodes": [0]});
    put_name(&mut shown_scene, Some(&scene.name));
    put_extras(&mut shown_scene, scene.extras.as_deref());
    let mut document = json!({
        "asset": asset(scene, facts, k),
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [shown_scene],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": buffer.bytes.len()}],
    });
    if !scene.cameras.is_empty() {
        document["cameras"] = scene.cameras.iter().map(write_camera::lens).collect();
    }
    materials.put_into(&mut document);
    let bytes = container::glb(document.to_string().into_bytes(), buffer.bytes)
        .map_err(|bytes| FormatError::OutputTooLarge { file: file.to_owned(), bytes })?;
    let triangles = baked.triangle_count();
    let written = Written { bytes: bytes.len() as u64, exposure_k: k, triangles, vertices, clipped_vertices };
    Ok((bytes, written))
}

/// Which materials some primitive has.
fn shown_materials(scene: &Scene, baked: &BakedMesh) -> Table<MaterialId, bool> {
    let mut shown: Table<MaterialId, bool> = scene.materials.iter().map(|_| false).collect();
    let parts = baked.parts.iter().filter(|part| !part.triangles.is_empty());
    let surfaces = parts.map(|part| &scene.surfaces[part.surface]).chain(&scene.see_through);
    surfaces.for_each(|surface| shown[surface.material] = true);
    shown
}

/// What [`BakedMesh`] promises and a sound file needs; in words, with the patch, if it is broken.
fn check_promises(scene: &Scene, baked: &BakedMesh) -> Result<(), String> {
    baked.validate().map_err(|broken| broken.to_string())?;
    if !baked.origin_m.is_finite() {
        return Err(format!("the origin is {}", baked.origin_m));
    }
    for part in &baked.parts {
        let surface = part.surface;
        if usize::from(surface) >= scene.surfaces.len() {
            return Err(format!("{surface:?} is not in the scene"));
        }
        let place = |vertex| {
            let Surface { node, material, .. } = scene.surfaces[surface];
            let node = shortened(scene.nodes[node].name.as_deref().unwrap_or("unnamed"));
            format!("node {node:?}, material {:?}, vertex {vertex}", shortened(&scene.materials[material].name))
        };
        if let Some(vertex) = part.positions_m.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(format!("{} is at {:?}", place(vertex), part.positions_m[vertex]));
        }
        let is_unit = |normal: &[f32; 3]| (normal.iter().map(|x| x * x).sum::<f32>().sqrt() - 1.0).abs() < 1e-3;
        if let Some(vertex) = part.normals.iter().position(|normal| !is_unit(normal)) {
            return Err(format!("{} has normal {:?}", place(vertex), part.normals[vertex]));
        }
    }
    Ok(())
}

/// `COLOR_0` of a part, and how many vertices of a surface that only reflects were clipped.
fn colours(material: &Material, base: Rgb, part: &BakedPart, k: f64) -> (Vec<[u16; 4]>, usize) {
    let one = f64::from(u16::MAX);
    let mut clipped = 0;
    let colour = |vertex| {
        let colour = exposure::colour(material, base, exposure::irradiance(part, vertex), k);
        clipped += usize::from(!material.shines() && colour.max_element() > 1.0);
        let steps = (colour.clamp(Rgb::ZERO, Rgb::ONE) * one).round().to_array();
        let [red, green, blue] = steps.map(|channel| channel as u16);
        [red, green, blue, u16::MAX]
    };
    let colours = (0..part.irradiance.len()).map(colour).collect();
    (colours, clipped)
}

/// The root, then every node of the scene; and a mesh for each that has primitives.
fn nodes_and_meshes(scene: &Scene, baked: &BakedMesh, primitives: Vec<Vec<Value>>) -> (Vec<Value>, Vec<Value>) {
    // The root comes first: the scene's node i is the file's node i + 1.
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); scene.nodes.len() + 1];
    for (node, parent) in scene.nodes.iter().map(|node| node.parent).enumerate() {
        children[parent.map_or(0, |parent| usize::from(parent) + 1)].push(node + 1);
    }
    let mut meshes = Vec::new();
    let mut root = json!({"name": "umbrage", "translation": baked.origin_m.to_array()});
    put_children(&mut root, &children[0]);
    let mut nodes = vec![root];
    for ((node, primitives), children) in scene.nodes.iter().zip(primitives).zip(&children[1..]) {
        let mut out = json!({});
        put_name(&mut out, node.name.as_deref());
        put_extras(&mut out, node.extras.as_deref());
        put_children(&mut out, children);
        if !primitives.is_empty() {
            out["mesh"] = json!(meshes.len());
            let mut mesh = json!({"primitives": primitives});
            put_name(&mut mesh, node.mesh_name.as_deref());
            put_extras(&mut mesh, node.mesh_extras.as_deref());
            meshes.push(mesh);
        }
        nodes.push(out);
    }
    for (number, camera) in scene.cameras.iter().enumerate() {
        write_camera::place(camera, number, baked.origin_m, &mut nodes);
    }
    (nodes, meshes)
}

fn asset(scene: &Scene, facts: &BakeFacts, k: f64) -> Value {
    let mut extras = facts.extras.clone();
    extras.insert("exposure".into(), json!(k));
    extras.remove("exposure_percentile");
    if facts.exposure.is_none() {
        extras.insert("exposure_percentile".into(), json!(exposure::PERCENTILE));
    }
    extras.insert("residual".into(), json!(facts.residual));
    extras.insert("units".into(), json!(if scene.photometric { PHOTOMETRIC } else { RADIOMETRIC }));
    let generator = concat!("Umbrage ", env!("CARGO_PKG_VERSION"));
    let mut asset = json!({"version": "2.0", "generator": generator});
    if let Some(copyright) = &scene.copyright {
        asset["copyright"] = json!(copyright);
    }
    put_extras(&mut asset, scene.asset_extras.as_deref());
    put_facts(&mut asset["extras"], Value::Object(extras));
    asset
}

pub(super) fn put_name(object: &mut Value, name: Option<&str>) {
    if let Some(name) = name.filter(|name| !name.is_empty()) {
        object["name"] = json!(name);
    }
}

fn put_extras(object: &mut Value, extras: Option<&str>) {
    if let Some(extras) = extras.and_then(value_of) {
        object["extras"] = extras;
    }
}

fn put_children(object: &mut Value, children: &[usize]) {
    if !children.is_empty() {
        object["children"] = json!(children);
    }
}
