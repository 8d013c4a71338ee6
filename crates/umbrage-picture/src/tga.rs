//! TGA images: of colours, of greys and of numbers in a table, plain or run-length encoded.
//!
//! Source: Truevision TGA File Format Specification, version 2.0 (1991). The format has no mark at its beginning; a
//! file is one if all that its head says is possible. Alpha counts where the head says that there are bits of it: many
//! programs leave rubbish in the fourth byte otherwise.

use crate::decode::{Codes, TextureError, checked};

/// Bytes of the head.
const HEAD_BYTES: usize = 18;
/// Texels that one packet of a run-length encoded image holds at most.
const MOST_OF_PACKET: usize = 128;

/// What the head of a TGA says.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Head {
    kind: Kind,
    runs: bool,
    /// Bytes of a texel.
    texel_bytes: usize,
    /// First number of the table, its length, and the bytes of an entry.
    table: [usize; 3],
    /// Where the table begins.
    table_at: usize,
    width: usize,
    height: usize,
    alpha_bits: u8,
    from_right: bool,
    from_top: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Table,
    Colour,
    Grey,
}

impl Head {
    /// The head of a file, if it is a TGA's.
    pub(crate) fn of(file: &[u8]) -> Option<Self> {
        let head: [u8; HEAD_BYTES] = file.get(..HEAD_BYTES)?.try_into().ok()?;
        let [id_bytes, has_table, kind, .., bits, descriptor] = head;
        let word = |at: usize| usize::from(u16::from_le_bytes([head[at], head[at + 1]]));
        let runs = kind & 8 != 0;
        let kind = match (kind & !8, bits) {
            (1, 8 | 16) => Kind::Table,
            (2, 15 | 16 | 24 | 32) => Kind::Colour,
            (3, 8 | 16) => Kind::Grey,
            _ => return None,
        };
        let (entries, entry_bits) = (word(5), head[7]);
        let table_fits = match has_table {
            0 => kind != Kind::Table,
            1 => entries > 0 && [15, 16, 24, 32].contains(&entry_bits),
            _ => false,
        };
        if !table_fits || descriptor & 0xc0 != 0 {
            return None;
        }
        let table = if has_table == 1 { [word(3), entries, bytes_of(entry_bits)] } else { [0; 3] };
        Some(Self {
            kind,
            runs,
            texel_bytes: bytes_of(bits),
            table,
            table_at: HEAD_BYTES + usize::from(id_bytes),
            width: word(12),
            height: word(14),
            alpha_bits: descriptor & 0x0f,
            from_right: descriptor & 0x10 != 0,
            from_top: descriptor & 0x20 != 0,
        })
    }
}

fn bytes_of(bits: u8) -> usize {
    usize::from(bits).div_ceil(8)
}

/// Decodes a file with such a head.
pub(crate) fn decode(file: &[u8], head: &Head, most_texels: usize) -> Result<Codes, TextureError> {
    let [width, height] = checked(head.width, head.height, most_texels)?;
    let cut_off = || TextureError::Tga("it is cut off");
    let [first, entries, entry_bytes] = head.table;
    let data_at = head.table_at + entries * entry_bytes;
    let table = file.get(head.table_at..data_at).ok_or_else(cut_off)?;
    let data = &file[data_at..];
    // No packet holds more, so that a short file takes no memory.
    let least = if head.runs { (width * height).div_ceil(MOST_OF_PACKET) } else { width * height };
    if data.len() < least * head.texel_bytes {
        return Err(cut_off());
    }
    let texel = |bytes: &[u8]| match head.kind {
        Kind::Colour => Ok(colour(bytes, head.alpha_bits)),
        Kind::Grey => {
            Ok([bytes[0], bytes[0], bytes[0], bytes.get(1).filter(|_| head.alpha_bits > 0).map_or(255, |a| *a)])
        }
        Kind::Table => {
            let number = bytes.iter().rev().fold(0, |number, byte| number << 8 | usize::from(*byte));
            let entry = number.checked_sub(first).and_then(|n| table.chunks_exact(entry_bytes).nth(n));
            entry.map(|entry| colour(entry, head.alpha_bits)).ok_or(TextureError::Tga("a texel is not in its table"))
        }
    };
    let mut codes = Vec::with_capacity(width * height);
    if head.runs {
        let mut rest = data;
        while codes.len() < width * height {
            let (&packet, after) = rest.split_first().ok_or_else(cut_off)?;
            let count = usize::from(packet & 0x7f) + 1;
            let repeated = packet & 0x80 != 0;
            let bytes = head.texel_bytes * if repeated { 1 } else { count };
            let texels = after.get(..bytes).ok_or_else(cut_off)?;
            for i in 0..count.min(width * height - codes.len()) {
                codes.push(if repeated {
                    texel(texels)?
                } else {
                    texel(&texels[i * head.texel_bytes..][..head.texel_bytes])?
                });
            }
            rest = &after[bytes..];
        }
    } else {
        for bytes in data.chunks_exact(head.texel_bytes).take(width * height) {
            codes.push(texel(bytes)?);
        }
    }
    if head.from_right {
        codes.chunks_exact_mut(width).for_each(<[_]>::reverse);
    }
    if !head.from_top {
        codes = codes.chunks_exact(width).rev().flatten().copied().collect();
    }
    Ok(([width, height], codes))
}

/// A colour of two, three or four bytes: blue first.
fn colour(bytes: &[u8], alpha_bits: u8) -> [u8; 4] {
    match *bytes {
        [low, high] => {
            let packed = u16::from_le_bytes([low, high]);
            let channel = |shift: u32| {
                let five = (packed >> shift & 31) as u8;
                five << 3 | five >> 2
            };
            let alpha = if alpha_bits > 0 && packed & 0x8000 == 0 { 0 } else { 255 };
            [channel(10), channel(5), channel(0), alpha]
        }
        [b, g, r, a] => [r, g, b, if alpha_bits > 0 { a } else { 255 }],
        [b, g, r] => [r, g, b, 255],
        _ => [0; 4],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decode::decode as any;

    const RED: [u8; 4] = [255, 0, 0, 255];
    const GREEN: [u8; 4] = [0, 255, 0, 255];
    const BLUE: [u8; 4] = [0, 0, 255, 255];
    const WHITE: [u8; 4] = [255; 4];

    /// A head for two columns and two rows.
    fn head(kind: u8, bits: u8, descriptor: u8) -> Vec<u8> {
        vec![0, 0, kind, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, bits, descriptor]
    }

    fn with(mut head: Vec<u8>, data: &[u8]) -> Vec<u8> {
        head.extend(data);
        head
    }

    fn texels(file: &[u8]) -> Vec<[u8; 4]> {
        any(file, 4).unwrap().1
    }

    #[test]
    fn the_first_row_is_below_unless_the_head_says_otherwise() {
        let data = [0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255];
        assert_eq!(texels(&with(head(2, 24, 0), &data)), [BLUE, WHITE, RED, GREEN]);
        assert_eq!(texels(&with(head(2, 24, 0x20), &data)), [RED, GREEN, BLUE, WHITE]);
        assert_eq!(texels(&with(head(2, 24, 0x30), &data)), [GREEN, RED, WHITE, BLUE]);
    }

    #[test]
    fn runs_and_single_texels_alternate() {
        // Three greens in a run, one red alone; a run may go beyond the end of its row.
        let file = with(head(10, 24, 0x20), &[0x82, 0, 255, 0, 0x00, 0, 0, 255]);
        assert_eq!(texels(&file), [GREEN, GREEN, GREEN, RED]);
        assert!(matches!(any(&file[..file.len() - 1], 4), Err(TextureError::Tga("it is cut off"))));
    }

    #[test]
    fn alpha_counts_where_the_head_says_so() {
        let data = [9, 9, 9, 7].repeat(4);
        assert_eq!(texels(&with(head(2, 32, 0x28), &data)), [[9, 9, 9, 7]; 4]);
        assert_eq!(texels(&with(head(2, 32, 0x20), &data)), [[9, 9, 9, 255]; 4]);
    }

    #[test]
    fn greys_tables_and_five_bits() {
        assert_eq!(texels(&with(head(3, 8, 0x20), &[0, 50, 100, 255])).map_to_grey(), [0, 50, 100, 255]);
        let mut table = head(1, 8, 0x20);
        // Entries 5 and 6, of three bytes, after a note of two bytes.
        (table[0], table[1], table[3], table[5], table[7]) = (2, 1, 5, 2, 24);
        let file = with(table, &[b'h', b'i', 0, 0, 255, 255, 0, 0, 5, 6, 6, 5]);
        assert_eq!(texels(&file), [RED, BLUE, BLUE, RED]);
        let beyond = [&file[..file.len() - 1], &[9]].concat();
        assert!(matches!(any(&beyond, 4), Err(TextureError::Tga("a texel is not in its table"))));
        let packed: Vec<u8> = [31_u16 << 10, 31 << 5, 31, 0x7fff].iter().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(texels(&with(head(2, 16, 0x20), &packed)), [RED, GREEN, BLUE, WHITE]);
    }

    trait Greys {
        fn map_to_grey(&self) -> Vec<u8>;
    }

    impl Greys for Vec<[u8; 4]> {
        fn map_to_grey(&self) -> Vec<u8> {
            self.iter().map(|&[r, g, b, a]| if r == g && g == b && a == 255 { r } else { 1 }).collect()
        }
    }

    #[test]
    fn a_short_file_takes_no_memory() {
        let mut huge = head(10, 24, 0);
        huge[12..16].copy_from_slice(&[0, 0x20, 0, 0x20]);
        assert!(matches!(any(&huge, 1 << 26), Err(TextureError::Tga("it is cut off"))));
        huge[12..16].copy_from_slice(&[0; 4]);
        assert!(matches!(any(&huge, 1 << 26), Err(TextureError::BadSize { .. })));
    }
}
