//! Compressed geometry made plain: `EXT_meshopt_compression` and `KHR_draco_mesh_compression`.
//!
//! Idea: what is decoded becomes buffers of its own, and bufferViews and accessors are led there, so that all that reads a document
//! sees a plain one. Where a file has a plain copy beside the compressed one, that is taken.

use std::mem::size_of;

use serde_json::{Value, json};

use super::document::{Document, List};
use super::draco::{Decoded, Refused};
use super::item::Item;
use super::meshopt::{self, Filter, Mode, Stream};
use super::tally::Tally;
use crate::FormatError;
use crate::builder::{CORNERS_PER_BYTE, FREE_CORNERS};

const DRACO: &str = "KHR_draco_mesh_compression";
/// The extension and its successor, whose streams are the same as far as they are known here.
const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
/// Bytes that weigh as much as a corner.
const CORNER_BYTES: usize = 16;
/// Component types, in glTF's numbers.
const U32: usize = 5125;
const F32: usize = 5126;
/// The mode of triangles.
const TRIANGLES: usize = 4;

/// Makes all of a document plain.
pub(super) fn unpack(document: &mut Document) -> Result<(), FormatError> {
    let mut tally = Tally::default();
    for view in 0..document.count(List::BufferViews)? {
        if let Some((bytes, stride)) = meshopt_view(document, view, &mut tally)? {
            let length = bytes.len();
            let buffer = document.add_buffer(bytes);
            document.replace(
                List::BufferViews,
                view,
                json!({"buffer": buffer, "byteLength": length, "byteStride": stride}),
            );
        }
    }
    for mesh in 0..document.count(List::Meshes)? {
        let count = document.item(List::Meshes, mesh, "the document")?.list("primitives")?.len();
        for primitive in 0..count {
            for Change { accessor, bytes, changes } in draco_primitive(document, (mesh, primitive), &mut tally)? {
                let length = bytes.len();
                let buffer = document.add_buffer(bytes);
                let view = document.add_view(json!({"buffer": buffer, "byteLength": length}));
                document.change_accessor(accessor, view, changes);
            }
        }
    }
    Ok(())
}

/// What a bufferView holds that only has compressed bytes, and its stride if it states one.
fn meshopt_view(document: &Document, view: usize, tally: &mut Tally) -> Result<Option<(Vec<u8>, Value)>, FormatError> {
    let item = document.item(List::BufferViews, view, "the document")?;
    if item.whole("buffer")?.is_none_or(|buffer| document.has_bytes(buffer)) {
        return Ok(None);
    }
    for name in MESHOPT {
        let Some(extension) = item.extension(name)? else { continue };
        let bytes = document.bytes_of(&extension)?;
        let stream = stream(&extension)?;
        let length = stream.count.saturating_mul(stream.stride);
        tally.unfold(length / CORNER_BYTES, document, &item.place)?;
        let decoded = meshopt::decode(bytes, stream).map_err(|what| extension.bad("mode", what))?;
        return Ok(Some((decoded, item.get("byteStride").cloned().unwrap_or_default())));
    }
    Ok(None)
}

fn stream(extension: &Item<'_>) -> Result<Stream, FormatError> {
    let mode = match extension.text("mode")? {
        Some("ATTRIBUTES") => Mode::Attributes,
        Some("TRIANGLES") => Mode::Triangles,
        Some("INDICES") => Mode::Indices,
        _ => return Err(extension.bad("mode", "is not one that is known")),
    };
    let filter = match extension.text("filter")?.unwrap_or("NONE") {
        "NONE" => Filter::None,
        "OCTAHEDRAL" => Filter::Octahedral,
        "QUATERNION" => Filter::Quaternion,
        "EXPONENTIAL" => Filter::Exponential,
        _ => return Err(extension.bad("filter", "is not one that is known")),
    };
    let (count, stride) = (extension.required_whole("count")?, extension.required_whole("byteStride")?);
    Ok(Stream { mode, filter, count, stride })
}

/// An accessor that is led to other bytes, and properties of it that change.
struct Change {
    accessor: usize,
    bytes: Vec<u8>,
    changes: Value,
}

/// The plain accessors of a primitive that has none.
fn draco_primitive(
    document: &Document,
    (mesh, primitive): (usize, usize),
    tally: &mut Tally,
) -> Result<Vec<Change>, FormatError> {
    let mesh = document.item(List::Meshes, mesh, "the document")?;
    let Some(value) = mesh.list("primitives")?.get(primitive) else { return Ok(Vec::new()) };
    let primitive = Item::new(&document.file, format!("{}, primitive {primitive}", mesh.place), value)?;
    let Some(extension) = primitive.extension(DRACO)? else { return Ok(Vec::new()) };
    let Some(attributes) = primitive.child("attributes")? else { return Ok(Vec::new()) };
    let Some(position) = attributes.whole("POSITION")? else { return Ok(Vec::new()) };
    let position = document.item(List::Accessors, position, &primitive.place)?;
    if position.get("bufferView").is_some() || position.get("sparse").is_some() {
        return Ok(Vec::new());
    }
    let view = extension.required_whole("bufferView")?;
    let (bytes, _) = document.view(view, &extension.place)?;
    let most = FREE_CORNERS.saturating_add(CORNERS_PER_BYTE.saturating_mul(document.input_bytes()));
    let decoded = Decoded::new(bytes, most).map_err(|refused| match refused {
        Refused::Broken(what) => extension.bad("bufferView", format!("its Draco data cannot be decoded: {what}")),
        Refused::TooLarge => FormatError::TooLarge {
            file: document.file.clone(),
            place: extension.place.clone(),
            wanted: most.saturating_add(1),
            limit: most,
        },
    })?;
    tally.unfold(3 * decoded.corners().len() + decoded.point_count(), document, &primitive.place)?;

    if primitive.whole("mode")?.unwrap_or(TRIANGLES) != TRIANGLES {
        return Err(primitive.bad("mode", "should be that of triangles, which is what the compressed data are"));
    }
    let accessor = primitive.required_whole("indices")?;
    document.item(List::Accessors, accessor, &primitive.place)?;
    let bytes: Vec<u8> = decoded.corners().flatten().flat_map(u32::to_le_bytes).collect();
    let count = bytes.len() / size_of::<u32>();
    let mut changes = vec![Change { accessor, bytes, changes: json!({"componentType": U32, "count": count}) }];
    let numbers = extension.child("attributes")?.ok_or_else(|| extension.bad("attributes", "is missing"))?;
    for name in numbers.object().keys() {
        let Some(accessor) = attributes.whole(name)? else { continue };
        let item = document.item(List::Accessors, accessor, &attributes.place)?;
        let width = match item.text("type")?.unwrap_or_default() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => return Err(item.bad("type", "does not suit this use")),
        };
        let number = numbers.required_whole(name)?;
        let values =
            u32::try_from(number).ok().and_then(|n| decoded.attribute(n, width, item.flag("normalized").ok()?));
        let values = values.ok_or_else(|| numbers.bad(name, format!("there is no attribute {number} in its data")))?;
        tally.unfold(values.len() * size_of::<f32>() / CORNER_BYTES, document, &item.place)?;
        let bytes = values.into_iter().flat_map(f32::to_le_bytes).collect();
        let changes_of = json!({"componentType": F32, "normalized": false, "count": decoded.point_count()});
        changes.push(Change { accessor, bytes, changes: changes_of });
    }
    Ok(changes)
}
