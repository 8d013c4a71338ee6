//! A finished picture, and the PNG file that it becomes.
//!
//! Holds: pixels are linear and within 0..1; the same picture gives the same bytes: a PNG carries no time and no tool.

use crate::color::{LinearRgb, srgb8_from_linear};

/// A picture as it is displayed, in linear colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) pixels: Vec<LinearRgb>,
}

/// A picture that could not be encoded.
#[derive(Debug, thiserror::Error)]
#[error("cannot encode the picture as PNG")]
pub struct PngError(#[from] png::EncodingError);

impl Picture {
    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Pixels, row by row from the top, in linear colours within 0..1.
    pub fn pixels(&self) -> &[LinearRgb] {
        &self.pixels
    }

    /// The pixel `column` from the left and `row` from the top.
    pub fn pixel(&self, column: usize, row: usize) -> LinearRgb {
        self.pixels[row * self.width + column]
    }

    /// Pixels as 8-bit sRGB codes: red, green, blue, row by row from the top.
    pub fn srgb8(&self) -> Vec<u8> {
        self.pixels.iter().flatten().map(|&c| srgb8_from_linear(c)).collect()
    }

    /// The picture as a PNG file, marked as sRGB.
    ///
    /// # Errors
    /// [`PngError`] where the encoder refuses.
    pub fn png(&self) -> Result<Vec<u8>, PngError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::Balanced);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.srgb8())?;
        writer.finish()?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn picture() -> Picture {
        let pixels = vec![[0.0, 0.215_861, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [1.0; 3], [0.5; 3]];
        Picture { width: 3, height: 2, pixels }
    }

    #[test]
    fn a_png_reads_back_as_its_codes() {
        let bytes = picture().png().unwrap();
        let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
        let mut codes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut codes).unwrap();
        assert_eq!((info.width, info.height, info.color_type), (3, 2, png::ColorType::Rgb));
        assert_eq!(reader.info().srgb, Some(png::SrgbRenderingIntent::Perceptual));
        assert_eq!(codes, picture().srgb8());
        assert_eq!(codes[..6], [0, 128, 255, 255, 0, 0]);
    }
}
