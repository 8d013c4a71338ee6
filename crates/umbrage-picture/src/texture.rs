//! Base colour textures: decoding, mip levels, and the colour at a point.
//!
//! Idea: texels become linear light once, when the file is decoded; each level of the pyramid is the mean of four texels
//! of the level below, so that it has the same mean light; a sample reads two levels, four texels each (trilinear), and
//! chooses the levels by how far apart neighbouring samples are in the texture. The picture has many samples per pixel,
//! so it stays sharp where a surface is seen at a grazing angle.
//!
//! Holds: colours lie within 0..1; a texture of one colour has that colour everywhere; memory is 4/3 of the texels'.
//! Alpha is averaged like a colour, as graphics processors do it; what it means is the caller's to say.

use std::io::Cursor;

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::color::linear_from_srgb;

/// Largest width and height of a texture, in texels: what graphics processors take.
const MAX_SIZE_TEXELS: usize = 16384;

/// What a texture does beyond its border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Begins anew.
    #[default]
    Repeat,
    /// Begins anew, every other time turned over.
    Mirror,
    /// Goes on with its last texel.
    Clamp,
}

/// An image on a surface, with all its mip levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// From the finest to a single texel.
    levels: Vec<Level>,
    /// Along u and along v.
    wrap: [Wrap; 2],
}

#[derive(Clone, Debug, PartialEq)]
struct Level {
    size: [usize; 2],
    texels: Vec<Texel>,
}

/// Linear RGB and alpha.
pub type Texel = [f32; 4];

/// An image that cannot be a texture.
#[derive(Debug, thiserror::Error)]
pub enum TextureError {
    /// It begins like neither format.
    #[error("it is neither a PNG nor a JPEG: convert it to one of them")]
    UnknownFormat,
    /// It is a broken PNG.
    #[error("its PNG is broken: save it again")]
    Png(#[from] png::DecodingError),
    /// It is a broken JPEG, or one of a rare kind.
    #[error("its JPEG cannot be decoded ({0}): save it again as a baseline or progressive JPEG")]
    Jpeg(String),
    /// It is empty or too large.
    #[error(
        "it has {width} x {height} texels: each side must be between 1 and {MAX_SIZE_TEXELS}, and to be baked there must be at \
         most 2^26 in all"
    )]
    BadSize {
        /// Width in texels.
        width: usize,
        /// Height in texels.
        height: usize,
    },
}

impl Texture {
    /// Decodes a PNG or a JPEG.
    ///
    /// # Errors
    /// [`TextureError`] where it is neither, broken or too large.
    pub fn decode(file: &[u8], wrap: [Wrap; 2]) -> Result<Self, TextureError> {
        let (size, codes) = decode(file, MAX_SIZE_TEXELS * MAX_SIZE_TEXELS)?;
        let linear: Vec<f32> = (0..=255u8).map(|code| linear_from_srgb(f64::from(code) / 255.0) as f32).collect();
        let texel = |&[r, g, b, a]: &[u8; 4]| {
            let [r, g, b] = [r, g, b].map(|c| linear[usize::from(c)]);
            [r, g, b, f32::from(a) / 255.0]
        };
        let texels = codes.iter().map(texel).collect();
        Ok(Self { levels: pyramid(Level { size, texels }), wrap })
    }

    /// Its levels, from the finest to a single texel: columns and rows, and the texels row by row from the top.
    pub fn levels(&self) -> impl ExactSizeIterator<Item = ([usize; 2], &[Texel])> {
        self.levels.iter().map(|level| (level.size, level.texels.as_slice()))
    }

    /// What it does beyond its border, along u and along v.
    pub fn wrap(&self) -> [Wrap; 2] {
        self.wrap
    }

    /// Colour and alpha at `uv`, where the next samples to the right and below are `steps` away, as shares of the texture.
    pub(crate) fn sample(&self, uv: [f64; 2], steps: [[f64; 2]; 2]) -> Texel {
        let [width, height] = self.levels[0].size.map(|side| side as f64);
        let texels = steps.map(|[u, v]| (u * width).hypot(v * height)).into_iter().fold(0.0, f64::max);
        let last = self.levels.len() - 1;
        // A NaN or negative logarithm means the finest level, an infinite one the coarsest.
        let level = texels.log2().max(0.0).min(last as f64);
        let (fine, share) = (level as usize, level.fract() as f32);
        let near = self.levels[fine].sample(uv, self.wrap);
        if share == 0.0 {
            return near;
        }
        let far = self.levels[fine + 1].sample(uv, self.wrap);
        std::array::from_fn(|i| near[i] + share * (far[i] - near[i]))
    }
}

impl Level {
    /// Colour and alpha at `uv`, between the four texels around it.
    fn sample(&self, uv: [f64; 2], wrap: [Wrap; 2]) -> Texel {
        let [(x0, x1, sx), (y0, y1, sy)] = [0, 1].map(|axis| between(uv[axis], self.size[axis], wrap[axis]));
        let texel = |x: usize, y: usize| self.texels[y * self.size[0] + x];
        let (a, b, c, d) = (texel(x0, y0), texel(x1, y0), texel(x0, y1), texel(x1, y1));
        std::array::from_fn(|i| {
            let (top, bottom) = (a[i] + sx * (b[i] - a[i]), c[i] + sx * (d[i] - c[i]));
            top + sy * (bottom - top)
        })
    }
}

/// Decodes a PNG or a JPEG of so many texels at most: the others take no memory.
pub(crate) fn decode(file: &[u8], most_texels: usize) -> Result<Codes, TextureError> {
    match file {
        [0x89, b'P', b'N', b'G', ..] => decode_png(file, most_texels),
        [0xff, 0xd8, 0xff, ..] => decode_jpeg(file, most_texels),
        _ => Err(TextureError::UnknownFormat),
    }
}

/// The two texels of a row of `size` around `at`, and how far the point is on its way to the second.
fn between(at: f64, size: usize, wrap: Wrap) -> (usize, usize, f32) {
    let place = at * size as f64 - 0.5;
    let first = place.floor();
    // A cast from float to integer saturates.
    let index = first as i64;
    (wrapped(index, size, wrap), wrapped(index.saturating_add(1), size, wrap), (place - first) as f32)
}

/// The texel that stands for texel `index` of a row of `size`.
pub(crate) fn wrapped(index: i64, size: usize, wrap: Wrap) -> usize {
    let size = size as i64;
    let texel = match wrap {
        Wrap::Repeat => index.rem_euclid(size),
        Wrap::Clamp => index.clamp(0, size - 1),
        Wrap::Mirror => {
            let there_and_back = index.rem_euclid(2 * size);
            there_and_back.min(2 * size - 1 - there_and_back)
        }
    };
    texel as usize
}

/// All levels, from `finest` to a single texel.
fn pyramid(finest: Level) -> Vec<Level> {
    let mut levels = vec![finest];
    while let Some(below) = levels.last().filter(|level| level.size != [1, 1]) {
        let size = below.size.map(|side| (side / 2).max(1));
        let mut texels = Vec::with_capacity(size[0] * size[1]);
        for y in 0..size[1] {
            for x in 0..size[0] {
                texels.push(mean(below, size, [x, y]));
            }
        }
        levels.push(Level { size, texels });
    }
    levels
}

/// The mean of the texels of `below` that texel `at` of a level of `size` covers.
fn mean(below: &Level, size: [usize; 2], at: [usize; 2]) -> Texel {
    let [columns, rows] =
        [0, 1].map(|axis| at[axis] * below.size[axis] / size[axis]..(at[axis] + 1) * below.size[axis] / size[axis]);
    let count = (columns.len() * rows.len()) as f32;
    let mut sum = [0.0f32; 4];
    for y in rows {
        for x in columns.clone() {
            let texel = below.texels[y * below.size[0] + x];
            sum = std::array::from_fn(|i| sum[i] + texel[i]);
        }
    }
    sum.map(|s| s / count)
}

/// Size, and sRGB codes with alpha.
pub(crate) type Codes = ([usize; 2], Vec<[u8; 4]>);

fn checked(width: usize, height: usize, most_texels: usize) -> Result<[usize; 2], TextureError> {
    let fits = |side: usize| (1..=MAX_SIZE_TEXELS).contains(&side);
    if fits(width) && fits(height) && width * height <= most_texels {
        Ok([width, height])
    } else {
        Err(TextureError::BadSize { width, height })
    }
}

fn decode_png(file: &[u8], most_texels: usize) -> Result<Codes, TextureError> {
    let mut decoder = png::Decoder::new(Cursor::new(file));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info()?;
    let size = checked(reader.info().width as usize, reader.info().height as usize, most_texels)?;
    let too_large = || TextureError::BadSize { width: size[0], height: size[1] };
    let mut bytes = vec![0; reader.output_buffer_size().ok_or_else(too_large)?];
    let frame = reader.next_frame(&mut bytes)?;
    let channels = frame.color_type.samples();
    let codes = bytes[..frame.buffer_size()].chunks_exact(channels).map(|texel| match *texel {
        [r, g, b, a] => [r, g, b, a],
        [r, g, b] => [r, g, b, u8::MAX],
        [grey, a] => [grey, grey, grey, a],
        [grey, ..] => [grey, grey, grey, u8::MAX],
        [] => [0; 4],
    });
    Ok((size, codes.collect()))
}

fn decode_jpeg(file: &[u8], most_texels: usize) -> Result<Codes, TextureError> {
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::RGB)
        .set_max_width(MAX_SIZE_TEXELS)
        .set_max_height(MAX_SIZE_TEXELS);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(file), options);
    let broken = |what: &str| TextureError::Jpeg(what.to_owned());
    decoder.decode_headers().map_err(|error| TextureError::Jpeg(error.to_string()))?;
    let (width, height) = decoder.dimensions().ok_or_else(|| broken("it has no size"))?;
    let size = checked(width, height, most_texels)?;
    let bytes = decoder.decode().map_err(|error| TextureError::Jpeg(error.to_string()))?;
    let codes: Vec<[u8; 4]> = bytes.chunks_exact(3).map(|texel| [texel[0], texel[1], texel[2], u8::MAX]).collect();
    if codes.len() == width * height { Ok((size, codes)) } else { Err(broken("it is cut off")) }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::color::linear_from_srgb8;

    /// Samples that are as good as in one place.
    const NEAR: [[f64; 2]; 2] = [[0.0; 2]; 2];

    pub(crate) fn png_of(width: u32, height: u32, color: png::ColorType, bytes: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(color);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(bytes).unwrap();
        writer.finish().unwrap();
        file
    }

    /// Black and white, one row.
    fn two(wrap: Wrap) -> Texture {
        Texture::decode(&png_of(2, 1, png::ColorType::Grayscale, &[0, 255]), [wrap; 2]).unwrap()
    }

    #[test]
    fn a_point_between_texels_has_their_mean_light() {
        let seen = |u| two(Wrap::Clamp).sample([u, 0.5], NEAR)[0];
        assert_eq!([-1.0, 0.25, 0.5, 0.625, 0.75, 2.0].map(seen), [0.0, 0.0, 0.5, 0.75, 1.0, 1.0]);
    }

    #[test]
    fn borders_wrap_as_asked() {
        let seen = |wrap, u| two(wrap).sample([u, 0.5], NEAR)[0];
        assert_eq!([0.0, 1.0, 1.25, -0.25].map(|u| seen(Wrap::Repeat, u)), [0.5, 0.5, 0.0, 1.0]);
        assert_eq!([0.0, 1.0, 1.25, -0.25].map(|u| seen(Wrap::Mirror, u)), [0.0, 1.0, 1.0, 0.0]);
        assert!(seen(Wrap::Repeat, 1e300).is_finite() && seen(Wrap::Mirror, -1e300).is_finite());
    }

    #[test]
    fn far_away_a_texture_has_its_mean_light() {
        // An odd size: rows and columns of unequal share.
        let bytes: Vec<u8> = (0..35 * 3).map(|i| (i * 7 % 256) as u8).collect();
        let texture = Texture::decode(&png_of(7, 5, png::ColorType::Rgb, &bytes), [Wrap::Repeat; 2]).unwrap();
        assert_eq!(texture.levels.iter().map(|level| level.size).collect::<Vec<_>>(), [[7, 5], [3, 2], [1, 1]]);
        let one = Texture::decode(&png_of(8, 2, png::ColorType::Rgb, &[200, 100, 50].repeat(16)), [Wrap::Repeat; 2]);
        let one = one.unwrap();
        for footprint in [0.0, 0.1, 0.4, f64::INFINITY, f64::NAN] {
            for (seen, expected) in
                one.sample([0.3, 0.9], [[footprint, 0.0], [0.0; 2]]).iter().zip(linear_from_srgb8([200, 100, 50]))
            {
                assert!((seen - expected).abs() < 1e-6, "{footprint}: {seen} {expected}");
            }
        }
        assert_eq!(two(Wrap::Repeat).sample([0.1, 0.1], [[1.0, 0.0], [0.0; 2]]), [0.5, 0.5, 0.5, 1.0]);
    }

    #[test]
    fn a_jpeg_is_decoded() {
        // A grey square of 8 x 8, baseline, code 128 throughout: all coefficients are 0.
        let texture = Texture::decode(&grey_jpeg(), [Wrap::Repeat; 2]).unwrap();
        assert_eq!(texture.levels[0].size, [8, 8]);
        assert_eq!(texture.sample([0.5, 0.5], NEAR)[..3], linear_from_srgb8([128; 3]));
    }

    /// The smallest JPEG by hand: one component, tables of one code each.
    fn grey_jpeg() -> Vec<u8> {
        let mut file = vec![0xff, 0xd8, 0xff, 0xdb, 0, 67, 0];
        file.extend([1; 64]);
        file.extend([0xff, 0xc0, 0, 11, 8, 0, 8, 0, 8, 1, 1, 0x11, 0]);
        for class in [0x00, 0x10] {
            // One code of one bit, for the symbol 0.
            file.extend([0xff, 0xc4, 0, 20, class, 1]);
            file.extend([0; 15]);
            file.push(0);
        }
        // Two bits of 0: no difference, end of block; the rest is padding.
        file.extend([0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0, 0x3f, 0xff, 0xd9]);
        file
    }

    #[test]
    fn what_is_no_image_is_refused() {
        let decode = |bytes: &[u8]| Texture::decode(bytes, [Wrap::Repeat; 2]);
        assert!(matches!(decode(b"GIF89a"), Err(TextureError::UnknownFormat)));
        assert!(matches!(decode(b"\x89PNG but not really"), Err(TextureError::Png(_))));
        assert!(matches!(decode(&[0xff, 0xd8, 0xff, 0xe0, 0]), Err(TextureError::Jpeg(_))));
        let whole = png_of(4, 4, png::ColorType::Rgb, &[9; 48]);
        assert!(decode(&whole[..whole.len() / 2]).is_err());
    }
}
