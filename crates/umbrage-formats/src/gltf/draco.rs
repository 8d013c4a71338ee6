//! `KHR_draco_mesh_compression`: triangles and attributes of a primitive from its compressed stream.

use draco_core::{DataType, DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder};

/// Bytes of a value of an attribute, at most: four floats.
const VALUE_BYTES: u64 = 16;

/// A decoded primitive.
#[derive(Debug)]
pub(super) struct Decoded {
    mesh: Mesh,
}

/// Why a stream cannot be decoded.
#[derive(Debug, PartialEq)]
pub(super) enum Refused {
    /// It is broken.
    Broken(String),
    /// It has more corners than are allowed.
    TooLarge,
}

impl Decoded {
    /// Decodes a stream into so many corners and points at most.
    pub(super) fn new(bytes: &[u8], most: u64) -> Result<Self, Refused> {
        let limits = DecodeLimits::default()
            .with_max_points(most)
            .with_max_faces(most)
            .with_max_decoded_bytes(most.saturating_mul(VALUE_BYTES));
        let mut mesh = Mesh::new();
        MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh).map_err(|error| {
            match error.kind() {
                ErrorKind::LimitExceeded => Refused::TooLarge,
                _ => Refused::Broken(error.to_string()),
            }
        })?;
        Ok(Self { mesh })
    }

    /// The corners of the triangles.
    pub(super) fn corners(&self) -> impl ExactSizeIterator<Item = [u32; 3]> {
        self.mesh.faces().iter().map(|face| face.map(|point| point.0))
    }

    /// Points.
    pub(super) fn point_count(&self) -> usize {
        self.mesh.num_points()
    }

    /// The attribute of a number as floats, point by point, with so many components; normalized integers become shares of one.
    pub(super) fn attribute(&self, number: u32, width: usize, normalized: bool) -> Option<Vec<f32>> {
        let attribute = self.mesh.attribute_by_unique_id(number)?;
        let mut values = attribute.read_f32s(self.point_count(), width);
        let one = match attribute.data_type() {
            DataType::Int8 => 127.0,
            DataType::Uint8 => 255.0,
            DataType::Int16 => 32_767.0,
            DataType::Uint16 => 65_535.0,
            _ => 1.0,
        };
        if normalized && one > 1.0 {
            values.iter_mut().for_each(|value| *value = (*value / one).max(-1.0));
        }
        Some(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_stream_is_refused() {
        assert!(matches!(Decoded::new(b"DRACO and then nothing", 100), Err(Refused::Broken(_))));
        assert!(matches!(Decoded::new(b"", 100), Err(Refused::Broken(_))));
    }
}
