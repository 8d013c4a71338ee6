//! The codec of `EXT_meshopt_compression`: bytes of a bufferView from its compressed stream.
//!
//! Three modes: attributes (elements as differences of bytes, in groups of sixteen with few bits each), triangles (corners by the
//! edges and vertices that were used last), and sequences of indices. A filter may follow, which turns stored integers into
//! unit vectors, rotations or floats.
//!
//! Holds: every read is checked, so a broken stream ends in an error; what is made has exactly `count * stride` bytes, which the
//! caller has to allow first.
//!
//! Source: appendices A and B of the extension's specification in the registry of glTF extensions.

/// What a stream makes, as its extension says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stream {
    pub(super) mode: Mode,
    pub(super) filter: Filter,
    /// Elements.
    pub(super) count: usize,
    /// Bytes of an element.
    pub(super) stride: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
}

/// Why a stream cannot be decoded.
pub(super) type Broken = &'static str;

const CUT_OFF: Broken = "its compressed data are cut off";

/// Bytes of a block of attributes at most, and its elements at most.
const BLOCK_BYTES: usize = 8192;
const BLOCK_ELEMENTS: usize = 256;
/// Differences that share a number of bits.
const GROUP: usize = 16;

/// Decodes a stream.
pub(super) fn decode(bytes: &[u8], stream: Stream) -> Result<Vec<u8>, Broken> {
    let Stream { mode, filter, count, stride } = stream;
    let mut out = match mode {
        Mode::Attributes if stride == 0 || stride > 256 || !stride.is_multiple_of(4) => {
            return Err("its stride should be a multiple of 4 up to 256");
        }
        Mode::Attributes => attributes(bytes, count, stride)?,
        _ if stride != 2 && stride != 4 => return Err("its indices should have 2 or 4 bytes"),
        Mode::Triangles => packed(&triangles(bytes, count)?, stride),
        Mode::Indices => packed(&indices(bytes, count)?, stride),
    };
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => out.as_chunks_mut::<4>().0.iter_mut().for_each(octahedral_i8),
        (Filter::Octahedral, 8) => out.as_chunks_mut::<8>().0.iter_mut().for_each(octahedral_i16),
        (Filter::Quaternion, 8) => out.as_chunks_mut::<8>().0.iter_mut().for_each(quaternion),
        (Filter::Exponential, _) => out.as_chunks_mut::<4>().0.iter_mut().for_each(exponential),
        _ => return Err("its filter does not suit its stride"),
    }
    Ok(out)
}

/// Bytes that are read one after the other.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], Broken> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(CUT_OFF)?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, Broken> {
        Ok(self.take(1)?[0])
    }

    /// A number of up to five bytes, seven bits in each, the least first.
    fn number(&mut self) -> Result<u32, Broken> {
        let mut number = 0_u32;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                break;
            }
        }
        Ok(number)
    }

    /// A number that is near another.
    fn near(&mut self, other: u32) -> Result<u32, Broken> {
        Ok(other.wrapping_add(signed(self.number()?)))
    }
}

/// 0, -1, 1, -2, ... for 0, 1, 2, 3, ...
fn signed(number: u32) -> u32 {
    (number >> 1) ^ (number & 1).wrapping_neg()
}

fn attributes(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Broken> {
    let mut data = Bytes(bytes);
    if data.byte()? != 0xa0 {
        return Err("its attributes are of a version that is not known");
    }
    // What the first element differs from is at the end, behind bytes that fill it up.
    let tail = stride.max(32);
    let body = data.0.len().checked_sub(tail).ok_or(CUT_OFF)?;
    let mut last = data.0[data.0.len() - stride..].to_vec();
    data.0 = &data.0[..body];
    let in_block = (BLOCK_BYTES / stride / GROUP * GROUP).min(BLOCK_ELEMENTS);
    let mut out = vec![0; count * stride];
    for block in out.chunks_mut(in_block * stride) {
        let groups = (block.len() / stride).div_ceil(GROUP);
        for (k, last) in last.iter_mut().enumerate() {
            let widths = data.take(groups.div_ceil(4))?;
            let mut places = block[k..].iter_mut().step_by(stride);
            for group in 0..groups {
                let width = widths[group / 4] >> (group % 4 * 2) & 3;
                for difference in differences(&mut data, width)? {
                    let difference = (difference >> 1) ^ (difference & 1).wrapping_neg();
                    // The last group is filled up with differences that nothing takes.
                    if let Some(place) = places.next() {
                        *last = last.wrapping_add(difference);
                        *place = *last;
                    }
                }
            }
        }
    }
    if data.0.is_empty() { Ok(out) } else { Err("its compressed data are too long") }
}

/// A group of differences of no, two, four or eight bits. One that is too large for its bits has them all set, and follows.
fn differences(data: &mut Bytes<'_>, width: u8) -> Result<[u8; GROUP], Broken> {
    let mut group = [0; GROUP];
    let bits = match width {
        0 => return Ok(group),
        3 => {
            group.copy_from_slice(data.take(GROUP)?);
            return Ok(group);
        }
        width => 2 * usize::from(width),
    };
    let packed = data.take(GROUP * bits / 8)?;
    let large = (1_u8 << bits) - 1;
    for (i, difference) in group.iter_mut().enumerate() {
        let at = i * bits;
        let few = packed[at / 8] >> (8 - bits - at % 8) & large;
        *difference = if few == large { data.byte()? } else { few };
    }
    Ok(group)
}

/// The last sixteen of something, the latest being number 0.
struct Latest<T> {
    ring: [T; 16],
    next: usize,
}

impl<T: Copy> Latest<T> {
    fn new(none: T) -> Self {
        Self { ring: [none; 16], next: 0 }
    }

    fn push(&mut self, value: T) {
        self.ring[self.next] = value;
        self.next = (self.next + 1) % 16;
    }

    fn get(&self, back: u8) -> T {
        self.ring[(self.next + 31 - usize::from(back)) % 16]
    }
}

fn triangles(bytes: &[u8], count: usize) -> Result<Vec<u32>, Broken> {
    let mut data = Bytes(bytes);
    let version = match data.byte()? {
        0xe0 => 0,
        0xe1 => 1,
        _ => return Err("its triangles are of a version that is not known"),
    };
    if !count.is_multiple_of(3) {
        return Err("its indices make no whole triangles");
    }
    let codes = data.take(count / 3)?;
    let body = data.0.len().checked_sub(16).ok_or(CUT_OFF)?;
    let (body, table) = data.0.split_at(body);
    data.0 = body;
    let (mut edges, mut vertices) = (Latest::new([u32::MAX; 2]), Latest::new(u32::MAX));
    let (mut next, mut last) = (0_u32, 0_u32);
    let fresh = |next: &mut u32| {
        *next = next.wrapping_add(1);
        next.wrapping_sub(1)
    };
    let recent = if version == 0 { 15 } else { 13 };
    let mut out = Vec::with_capacity(count);
    for &code in codes {
        let (high, low) = (code >> 4, code & 15);
        let triangle = if high < 15 {
            // On an edge that was used lately.
            let [a, b] = edges.get(high);
            let c = match low {
                0 => fresh(&mut next),
                low if low < recent => vertices.get(low),
                13 => last.wrapping_sub(1),
                14 => last.wrapping_add(1),
                _ => data.near(last)?,
            };
            if low >= recent {
                last = c;
            }
            if low == 0 || low >= recent {
                vertices.push(c);
            }
            edges.push([c, b]);
            edges.push([a, c]);
            [a, b, c]
        } else {
            // By itself: where each corner is from stands in the table, or follows.
            let (from_a, from_others) = match low {
                14 => (0, data.byte()?),
                15 => (15, data.byte()?),
                low => (0, table[usize::from(low)]),
            };
            if low >= 14 && from_others == 0 {
                next = 0;
            }
            let from = [from_a, from_others >> 4, from_others & 15];
            let mut corners = [0; 3];
            for (corner, from) in corners.iter_mut().zip(from) {
                *corner = match from {
                    0 => fresh(&mut next),
                    15 => 0,
                    back => vertices.get(back - 1),
                };
            }
            for (corner, _) in corners.iter_mut().zip(from).filter(|(_, from)| *from == 15) {
                last = data.near(last)?;
                *corner = last;
            }
            for (&corner, _) in corners.iter().zip(from).filter(|(_, from)| [0, 15].contains(from)) {
                vertices.push(corner);
            }
            let [a, b, c] = corners;
            [[b, a], [c, b], [a, c]].into_iter().for_each(|edge| edges.push(edge));
            corners
        };
        out.extend(triangle);
    }
    if data.0.is_empty() { Ok(out) } else { Err("its compressed data are too long") }
}

fn indices(bytes: &[u8], count: usize) -> Result<Vec<u32>, Broken> {
    let mut data = Bytes(bytes);
    if !matches!(data.byte()?, 0xd0 | 0xd1) {
        return Err("its indices are of a version that is not known");
    }
    // Each is near the last one of one of two rows.
    let mut last = [0_u32; 2];
    let mut out = Vec::new();
    for _ in 0..count {
        let number = data.number()?;
        let row = &mut last[(number & 1) as usize];
        *row = row.wrapping_add(signed(number >> 1));
        out.push(*row);
    }
    if data.0.len() == 4 { Ok(out) } else { Err("its compressed data have no end") }
}

/// Indices of so many bytes.
fn packed(indices: &[u32], stride: usize) -> Vec<u8> {
    indices.iter().flat_map(|index| index.to_le_bytes().into_iter().take(stride)).collect()
}

/// A unit vector from a point of the octahedron, `one` being the length that is stored with it.
fn unit([x, y, one]: [f32; 3]) -> [f32; 3] {
    let z = one - x.abs() - y.abs();
    // The lower half is folded over the edges.
    let fold = z.min(0.0);
    let [x, y] = [x, y].map(|c| if c >= 0.0 { c + fold } else { c - fold });
    let length = (x * x + y * y + z * z).sqrt();
    // A vector without length is none, whatever the filter says.
    [x, y, z].map(|c| if length > 0.0 { c / length } else { 0.0 })
}

fn octahedral_i8(element: &mut [u8; 4]) {
    let [x, y, one, _] = element.map(|byte| f32::from(byte as i8));
    for (byte, c) in element.iter_mut().zip(unit([x, y, one])) {
        *byte = (c * 127.0).round() as i8 as u8;
    }
}

fn i16s(element: &[u8; 8]) -> [i16; 4] {
    let mut numbers = [0; 4];
    for (number, bytes) in numbers.iter_mut().zip(element.as_chunks::<2>().0) {
        *number = i16::from_le_bytes(*bytes);
    }
    numbers
}

fn octahedral_i16(element: &mut [u8; 8]) {
    let [x, y, one, _] = i16s(element).map(f32::from);
    for (bytes, c) in element.as_chunks_mut::<2>().0.iter_mut().zip(unit([x, y, one])) {
        *bytes = ((c * 32_767.0).round() as i16).to_le_bytes();
    }
}

/// A rotation whose largest component was left out; the last number says which, and what is 1.
fn quaternion(element: &mut [u8; 8]) {
    let [x, y, z, packed] = i16s(element);
    let one = f32::from(packed | 3) * std::f32::consts::SQRT_2;
    let [x, y, z] = [x, y, z].map(|c| f32::from(c) / one);
    let largest = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let places = element.as_chunks_mut::<2>().0;
    for (i, c) in [largest, x, y, z].into_iter().enumerate() {
        places[((packed & 3) as usize + i) % 4] = ((c * 32_767.0).round() as i16).to_le_bytes();
    }
}

/// A float of 24 bits of mantissa and 8 of exponent, both signed.
fn exponential(element: &mut [u8; 4]) {
    let bits = i32::from_le_bytes(*element);
    let (exponent, mantissa) = (bits >> 24, (bits << 8) >> 8);
    *element = (mantissa as f32 * (exponent as f32).exp2()).to_le_bytes();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stream(mode: Mode, count: usize, stride: usize) -> Stream {
        Stream { mode, filter: Filter::None, count, stride }
    }

    #[test]
    fn attributes_by_hand() {
        // Two elements of four bytes: the first byte of the second is 1 more, all else as the element at the end.
        let mut bytes = vec![0xa0, 0b01, 0b0010_0000, 0, 0, 0, 0, 0, 0];
        bytes.extend([0; 28]);
        bytes.extend([7, 8, 9, 10]);
        bytes.truncate(bytes.len());
        let made = decode(&bytes, stream(Mode::Attributes, 2, 4));
        assert_eq!(made, Ok(vec![7, 8, 9, 10, 8, 8, 9, 10]));
        for end in 0..bytes.len() {
            assert!(decode(&bytes[..end], stream(Mode::Attributes, 2, 4)).is_err(), "{end}");
        }
    }

    #[test]
    fn filters() {
        let mut up = [0, 0, 127, 5];
        octahedral_i8(&mut up);
        assert_eq!(up, [0, 0, 127, 5]);
        let mut down = [100_u8, 27, 0, 0];
        down[2] = 100;
        octahedral_i8(&mut down);
        // z is 100 - 127, so the point is folded to the lower half.
        assert!((down[2] as i8) < 0, "{down:?}");
        let mut half = ((-1_i32 << 24) | 1).to_le_bytes();
        exponential(&mut half);
        assert_eq!(f32::from_le_bytes(half), 0.5);
        // No rotation: the last component is the largest, and the others are 0.
        let mut rest = [0, 0, 0, 0, 0, 0, 0xff, 0x7f];
        quaternion(&mut rest);
        assert_eq!(i16s(&rest), [0, 0, 0, 32_767]);
    }

    #[test]
    fn sequences_take_turns_between_two_rows() {
        // 5 in the first row, 9 in the second, then one more in each.
        let bytes = [0xd1, 5 << 2, (9 << 2) | 1, 1 << 2, (1 << 2) | 1, 0, 0, 0, 0];
        let made = decode(&bytes, stream(Mode::Indices, 4, 2));
        assert_eq!(made, Ok(vec![5, 0, 9, 0, 6, 0, 10, 0]));
        assert!(decode(&bytes[..8], stream(Mode::Indices, 4, 2)).is_err());
    }

    #[test]
    fn other_versions_and_strides_are_refused() {
        assert!(decode(&[0xa1; 64], stream(Mode::Attributes, 1, 4)).is_err());
        assert!(decode(&[0xa0; 64], stream(Mode::Attributes, 1, 3)).is_err());
        assert!(decode(&[0xe1; 64], stream(Mode::Triangles, 4, 2)).is_err());
        assert!(decode(&[0xe1; 64], stream(Mode::Triangles, 3, 1)).is_err());
    }
}
