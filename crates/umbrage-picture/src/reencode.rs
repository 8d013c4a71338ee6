//! Images made fit for viewers: glTF knows PNG and JPEG alone, and has opacity in the alpha of the colour's image.

use crate::decode::{Codes, TextureError, decode};
use crate::mean_color::MOST_TEXELS;

/// The same image as every viewer of glTF takes it: a PNG or a JPEG as it is, another as a PNG.
///
/// # Errors
/// [`TextureError`] where it cannot be decoded.
pub fn for_viewers(file: Vec<u8>) -> Result<Vec<u8>, TextureError> {
    match file.as_slice() {
        [0x89, b'P', b'N', b'G', ..] | [0xff, 0xd8, 0xff, ..] => Ok(file),
        _ => png_of(&decode(&file, MOST_TEXELS)?),
    }
}

/// An image of colours with the opacity of another, as a PNG; white without `colours`. The opacity is the other's alpha
/// where it has any, else its brightness. It is stretched over the colours.
///
/// # Errors
/// [`TextureError`] where one of them cannot be decoded.
pub fn with_opacity(colours: Option<&[u8]>, opacity: &[u8]) -> Result<Vec<u8>, TextureError> {
    let ([columns, rows], mask) = decode(opacity, MOST_TEXELS)?;
    let by_alpha = mask.iter().any(|texel| texel[3] < u8::MAX);
    let seen = |[r, g, b, a]: [u8; 4]| {
        if by_alpha { a } else { ((u16::from(r) + u16::from(g) + u16::from(b)) / 3) as u8 }
    };
    let (size, mut codes) = match colours {
        Some(colours) => decode(colours, MOST_TEXELS)?,
        None => ([columns, rows], vec![[u8::MAX; 4]; mask.len()]),
    };
    for (y, row) in codes.chunks_exact_mut(size[0]).enumerate() {
        for (x, texel) in row.iter_mut().enumerate() {
            texel[3] = seen(mask[(y * rows / size[1]) * columns + x * columns / size[0]]);
        }
    }
    png_of(&(size, codes))
}

fn png_of(([width, height], codes): &Codes) -> Result<Vec<u8>, TextureError> {
    let mut file = Vec::new();
    // Sizes were checked when it was decoded.
    let mut encoder = png::Encoder::new(&mut file, *width as u32, *height as u32);
    encoder.set_color(png::ColorType::Rgba);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(codes.as_flattened())?;
        writer.finish()
    });
    written.map_err(|_| TextureError::BadSize { width: *width, height: *height })?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::tests::png_of as grey_png;

    #[test]
    fn opacity_is_stretched_over_the_colours() {
        let colours = grey_png(4, 1, png::ColorType::Grayscale, &[10, 20, 30, 40]);
        let mask = grey_png(2, 1, png::ColorType::Grayscale, &[0, 255]);
        let alphas = |file: &[u8]| decode(file, 99).unwrap().1.iter().map(|texel| texel[3]).collect::<Vec<_>>();
        let both = with_opacity(Some(&colours), &mask).unwrap();
        assert_eq!(alphas(&both), [0, 0, 255, 255]);
        assert_eq!(decode(&both, 99).unwrap().1[3], [40, 40, 40, 255]);
        assert_eq!(decode(&with_opacity(None, &mask).unwrap(), 99).unwrap().1, [[255, 255, 255, 0], [255; 4]]);
        // Where there is alpha, it is what counts.
        let by_alpha = grey_png(2, 1, png::ColorType::GrayscaleAlpha, &[255, 7, 255, 255]);
        assert_eq!(alphas(&with_opacity(Some(&colours), &by_alpha).unwrap()), [7, 7, 255, 255]);
    }

    #[test]
    fn a_png_stays_what_it_is_and_a_tga_becomes_one() {
        let file = grey_png(1, 1, png::ColorType::Grayscale, &[10]);
        assert_eq!(for_viewers(file.clone()).unwrap(), file);
        let tga = [0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 8, 0x20, 77].to_vec();
        assert_eq!(decode(&for_viewers(tga).unwrap(), 1).unwrap().1, [[77, 77, 77, 255]]);
        assert!(for_viewers(b"GIF89a".to_vec()).is_err());
    }
}
