//! The binary buffer of an output file, with its accessors and bufferViews.
//!
//! Every accessor and every image has a bufferView of its own; all elements are multiples of four bytes long and images are
//! filled up, so all of them lie aligned.

use serde_json::{Value, json};

const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

/// A buffer being filled.
#[derive(Debug, Default)]
pub(super) struct WriteBuffer {
    pub(super) bytes: Vec<u8>,
    pub(super) views: Vec<Value>,
    pub(super) accessors: Vec<Value>,
}

impl WriteBuffer {
    /// Adds positions, with their bounds.
    pub(super) fn positions(&mut self, positions: &[[f32; 3]]) -> usize {
        let mut accessor = json!({"componentType": F32, "type": "VEC3"});
        let bound = |pick: fn(f32, f32) -> f32| {
            let first = positions.first().copied().unwrap_or_default();
            json!(positions.iter().fold(first, |bound, p| [0, 1, 2].map(|i| pick(bound[i], p[i]))))
        };
        accessor["min"] = bound(f32::min);
        accessor["max"] = bound(f32::max);
        self.push(accessor, ARRAY_BUFFER, positions.as_flattened().iter().map(|x| x.to_le_bytes()), positions.len())
    }

    /// Adds vectors of floats.
    pub(super) fn vectors(&mut self, vectors: &[[f32; 3]]) -> usize {
        let accessor = json!({"componentType": F32, "type": "VEC3"});
        self.push(accessor, ARRAY_BUFFER, vectors.as_flattened().iter().map(|x| x.to_le_bytes()), vectors.len())
    }

    /// Adds normalized colours.
    pub(super) fn colours(&mut self, colours: &[[u16; 4]]) -> usize {
        let accessor = json!({"componentType": U16, "type": "VEC4", "normalized": true});
        self.push(accessor, ARRAY_BUFFER, colours.as_flattened().iter().map(|x| x.to_le_bytes()), colours.len())
    }

    /// Adds texture coordinates.
    pub(super) fn coordinates(&mut self, coordinates: &[[f32; 2]]) -> usize {
        let accessor = json!({"componentType": F32, "type": "VEC2"});
        let components = coordinates.as_flattened().iter().map(|x| x.to_le_bytes());
        self.push(accessor, ARRAY_BUFFER, components, coordinates.len())
    }

    /// Adds the bytes of a file; returns the number of their bufferView.
    pub(super) fn file(&mut self, bytes: &[u8]) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        // What follows must lie aligned.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({"buffer": 0, "byteOffset": start, "byteLength": bytes.len()}));
        self.views.len() - 1
    }

    /// Adds the indices of triangles.
    pub(super) fn triangles(&mut self, triangles: &[[u32; 3]]) -> usize {
        let accessor = json!({"componentType": U32, "type": "SCALAR"});
        let indices = triangles.as_flattened();
        self.push(accessor, ELEMENT_ARRAY_BUFFER, indices.iter().map(|x| x.to_le_bytes()), indices.len())
    }

    fn push<const N: usize>(
        &mut self,
        mut accessor: Value,
        target: u32,
        components: impl Iterator<Item = [u8; N]>,
        count: usize,
    ) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(components.flatten());
        let length = self.bytes.len() - start;
        assert!(length.is_multiple_of(4), "{length} bytes would leave what follows unaligned");
        accessor["bufferView"] = json!(self.views.len());
        accessor["count"] = json!(count);
        self.views.push(json!({"buffer": 0, "byteOffset": start, "byteLength": length, "target": target}));
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}
