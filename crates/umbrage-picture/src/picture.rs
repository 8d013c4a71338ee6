//! A finished picture, and the PNG or EXR file that it becomes.
//!
//! Holds: pixels are linear, and within 0..1 unless they are [`crate::Look::Raw`]; the same picture gives the same
//! bytes: neither file carries time or tool.

use crate::color::{LinearRgb, linear_from_srgb8, srgb8_from_linear};

/// A picture in linear colours.
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

/// A picture that could not be encoded as OpenEXR.
#[cfg(feature = "exr")]
#[derive(Debug, thiserror::Error)]
#[error("cannot encode the picture as EXR")]
pub struct ExrError(#[from] exr::error::Error);

impl Picture {
    /// A picture of `width` columns from sRGB codes, row by row from the top; what does not fill a row is left out.
    pub fn from_srgb8(width: usize, codes: &[[u8; 3]]) -> Self {
        let height = codes.len().checked_div(width).unwrap_or(0);
        Self { width, height, pixels: codes[..width * height].iter().map(|&code| linear_from_srgb8(code)).collect() }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Pixels, row by row from the top, in linear colours.
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

    /// The picture as an OpenEXR file: linear Rec. 709 colours as 32-bit floats, nothing cut off.
    ///
    /// # Errors
    /// [`ExrError`] where the encoder refuses.
    #[cfg(feature = "exr")]
    pub fn exr(&self) -> Result<Vec<u8>, ExrError> {
        use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, WritableImage};
        let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| {
            let [red, green, blue] = self.pixel(at.x(), at.y());
            (red, green, blue)
        });
        let size = (self.width, self.height);
        let layer = Layer::new(size, LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
        let mut bytes = std::io::Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes)?;
        Ok(bytes.into_inner())
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

    #[test]
    fn codes_come_back_as_they_were() {
        let codes: Vec<[u8; 3]> = (0..=255).map(|c| [c, 255 - c, c / 2]).collect();
        let picture = Picture::from_srgb8(16, &codes);
        assert_eq!((picture.width(), picture.height(), picture.srgb8()), (16, 16, codes.concat()));
        assert_eq!(Picture::from_srgb8(100, &codes).height(), 2);
        assert_eq!(Picture::from_srgb8(0, &codes).height(), 0);
    }

    #[cfg(feature = "exr")]
    #[test]
    fn an_exr_reads_back_with_the_bits_that_were_written() {
        use exr::prelude::{ReadChannels, ReadLayers};
        let mut written = picture();
        written.pixels[4] = [65.5, 1e-9, 1e9];
        let bytes = written.exr().unwrap();
        assert_eq!(bytes, written.exr().unwrap());
        let read = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .rgb_channels(
                |size, _| vec![vec![[0.0f32; 3]; size.width()]; size.height()],
                |rows, at, (r, g, b): (f32, f32, f32)| rows[at.y()][at.x()] = [r, g, b],
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .unwrap();
        assert_eq!(read.layer_data.channel_data.pixels.concat(), written.pixels);
    }
}
