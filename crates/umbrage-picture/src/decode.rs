//! Images as they are found on surfaces: PNG, JPEG, WebP and TGA, told by how they begin.
//!
//! Holds: no image takes more memory than its texels ask for, and none is larger than the caller allows; what a file's
//! head says is looked at before anything is allocated for it.

use std::io::Cursor;

use image_webp::WebPDecoder;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::tga;

/// Largest width and height of an image, in texels: what graphics processors take.
pub(crate) const MAX_SIZE_TEXELS: usize = 16384;

/// An image that cannot be a texture.
#[derive(Debug, thiserror::Error)]
pub enum TextureError {
    /// It begins like none of the formats.
    #[error("it is none of PNG, JPEG, WebP and TGA: convert it to one of them")]
    UnknownFormat,
    /// It is in a container for graphics processors, which only their makers' programs unpack.
    #[error("it is a KTX2: convert it to PNG (`ktx extract` or `gltf-transform ktxdecompress` does)")]
    Ktx2,
    /// It is a broken PNG.
    #[error("its PNG is broken: save it again")]
    Png(#[from] png::DecodingError),
    /// It is a broken JPEG, or one of a rare kind.
    #[error("its JPEG cannot be decoded ({0}): save it again as a baseline or progressive JPEG")]
    Jpeg(String),
    /// It is a broken WebP.
    #[error("its WebP is broken ({0}): save it again")]
    WebP(String),
    /// It is a broken TGA, or one of a rare kind.
    #[error("its TGA cannot be decoded ({0}): save it again as a PNG")]
    Tga(&'static str),
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

/// Columns and rows, and sRGB codes with alpha, row by row from the top.
pub(crate) type Codes = ([usize; 2], Vec<[u8; 4]>);

/// Decodes an image of so many texels at most: the others take no memory.
pub(crate) fn decode(file: &[u8], most_texels: usize) -> Result<Codes, TextureError> {
    match file {
        [0x89, b'P', b'N', b'G', ..] => decode_png(file, most_texels),
        [0xff, 0xd8, 0xff, ..] => decode_jpeg(file, most_texels),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => decode_webp(file, most_texels),
        [0xab, b'K', b'T', b'X', b' ', b'2', b'0', ..] => Err(TextureError::Ktx2),
        // A TGA has no mark at its beginning, so it comes last.
        _ => match tga::Head::of(file) {
            Some(head) => tga::decode(file, &head, most_texels),
            None => Err(TextureError::UnknownFormat),
        },
    }
}

/// The size, if an image may have it.
pub(crate) fn checked(width: usize, height: usize, most_texels: usize) -> Result<[usize; 2], TextureError> {
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

/// Of an animation, its first picture.
fn decode_webp(file: &[u8], most_texels: usize) -> Result<Codes, TextureError> {
    let broken = |error: image_webp::DecodingError| TextureError::WebP(error.to_string());
    let mut decoder = WebPDecoder::new(Cursor::new(file)).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let size = checked(width as usize, height as usize, most_texels)?;
    let channels = if decoder.has_alpha() { 4 } else { 3 };
    let mut bytes = vec![0; channels * size[0] * size[1]];
    decoder.read_image(&mut bytes).map_err(broken)?;
    let texel = |texel: &[u8]| match *texel {
        [r, g, b, a] => [r, g, b, a],
        [r, g, b, ..] => [r, g, b, u8::MAX],
        _ => [0; 4],
    };
    Ok((size, bytes.chunks_exact(channels).map(texel).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::tests::png_of;

    fn decoded(file: &[u8]) -> Result<Codes, TextureError> {
        decode(file, 1 << 20)
    }

    #[test]
    fn a_jpeg_is_decoded() {
        // A grey square of 8 x 8, baseline, code 128 throughout: all coefficients are 0.
        assert_eq!(decoded(&grey_jpeg()).unwrap(), ([8, 8], vec![[128, 128, 128, 255]; 64]));
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
    fn a_webp_is_decoded_with_and_without_alpha() {
        for (color, texels) in [
            (image_webp::ColorType::Rgba8, vec![[9, 80, 200, 255], [0, 0, 0, 128], [255; 4], [1, 2, 3, 4]]),
            (image_webp::ColorType::Rgb8, vec![[9, 80, 200, 255], [0, 0, 0, 255], [255; 4], [1, 2, 3, 255]]),
        ] {
            let channels = if color == image_webp::ColorType::Rgba8 { 4 } else { 3 };
            let bytes: Vec<u8> = texels.iter().flat_map(|texel: &[u8; 4]| texel[..channels].to_vec()).collect();
            let mut file = Vec::new();
            image_webp::WebPEncoder::new(&mut file).encode(&bytes, 2, 2, color).unwrap();
            assert_eq!(decoded(&file).unwrap(), ([2, 2], texels));
            assert!(matches!(decoded(&file[..file.len() / 2]), Err(TextureError::WebP(_))));
        }
    }

    #[test]
    fn what_is_no_image_is_refused() {
        assert!(matches!(decoded(b"GIF89a"), Err(TextureError::UnknownFormat)));
        assert!(matches!(decoded(b"\xabKTX 20\xbb\r\n\x1a\n"), Err(TextureError::Ktx2)));
        assert!(matches!(decoded(b"\x89PNG but not really"), Err(TextureError::Png(_))));
        assert!(matches!(decoded(&[0xff, 0xd8, 0xff, 0xe0, 0]), Err(TextureError::Jpeg(_))));
        let whole = png_of(4, 4, png::ColorType::Rgb, &[9; 48]);
        assert!(decoded(&whole[..whole.len() / 2]).is_err());
    }
}
