//! The samples of a band of pixel rows: depth test, lines, and the average of each pixel's samples.
//!
//! Idea: a picture is made band by band, so that its samples need little memory and bands can be made in parallel. A
//! band has a margin of rows above and below, because a line asks for the depth of samples beside it.
//!
//! Holds: a band's pixels depend on nothing but the scene and the picture's size, never on the other bands.

use crate::color::LinearRgb;
use crate::fill::Fill;
use crate::line::{LineColor, LineSample, cover, rows};
use crate::project::{ScreenLine, ScreenTriangle};
use crate::render::Look;
use crate::texture::Texture;

/// Samples per pixel along x and along y: 4 x 4 on a regular grid, averaged with equal weights.
pub(crate) const SUPERSAMPLING: usize = 4;

/// How much nearer than it is a line counts, as a share of its distance: more than rounding, less than any gap.
const LINE_BIAS: f64 = 1e-4;

/// Lines of one look, ready to be drawn.
pub(crate) struct ScreenLines {
    /// Half their width, in samples.
    pub(crate) radius: f64,
    pub(crate) color: LineColor,
    pub(crate) opacity: f32,
    pub(crate) lines: Vec<ScreenLine>,
}

/// The samples of some rows of a picture.
pub(crate) struct Band {
    /// Columns, in samples.
    width: i64,
    /// First row and row after the last, in samples, margins included.
    rows: [i64; 2],
    /// 1/z of each sample, 0 where there is nothing.
    inverse_depth: Vec<f64>,
    color: Vec<LinearRgb>,
    /// 1 + the number of the lines that cover the sample, or 0.
    overlay: Vec<u8>,
}

/// What is on a triangle.
#[derive(Clone, Copy, Default)]
pub(crate) struct Paint<'a> {
    /// Its colours are multiplied with those of this texture.
    pub(crate) texture: Option<&'a Texture>,
    /// Where the alpha of this one is less than the number, it is not drawn.
    pub(crate) mask: Option<(&'a Texture, f32)>,
}

impl Band {
    /// An empty band of `rows` (first, and after the last) of `width` samples.
    pub(crate) fn new(width: usize, rows: [i64; 2]) -> Self {
        let count = width * (rows[1] - rows[0]) as usize;
        Self {
            width: width as i64,
            rows,
            inverse_depth: vec![0.0; count],
            color: vec![[0.0; 3]; count],
            overlay: vec![0; count],
        }
    }

    /// Where a sample of this band is in its tables.
    fn index(&self, column: i64, row: i64) -> usize {
        ((row - self.rows[0]) * self.width + column) as usize
    }

    /// Draws the front of a triangle where it is the nearest.
    pub(crate) fn draw_triangle(&mut self, triangle: &ScreenTriangle, paint: Paint<'_>) {
        let Some(fill) = Fill::new(triangle) else { return };
        let mix = |weights: [f64; 3], of: [f64; 3]| weights[0] * of[0] + weights[1] * of[1] + weights[2] * of[2];
        let inverse_depths = [0, 1, 2].map(|i| triangle[i].inverse_depth);
        let colors = [0, 1, 2].map(|channel| [0, 1, 2].map(|i| triangle[i].color_over_depth[channel]));
        let uvs = [0, 1].map(|axis| [0, 1, 2].map(|i| triangle[i].uv_over_depth[axis]));
        let weight_steps = fill.weight_steps();
        let [first, end] = fill.rows();
        for row in first.max(self.rows[0])..end.min(self.rows[1]) {
            let Some([first, end]) = fill.span(row, self.width) else { continue };
            for column in first..end {
                let weights = fill.weights(column, row);
                let inverse_depth = mix(weights, inverse_depths);
                let at = self.index(column, row);
                if inverse_depth <= self.inverse_depth[at] {
                    continue;
                }
                let texel = |texture: &Texture| {
                    let uv = uvs.map(|of| mix(weights, of) / inverse_depth);
                    // The derivative of (uv/z) / (1/z).
                    let steps = weight_steps.map(|step| {
                        let deeper = mix(step, inverse_depths);
                        [0, 1].map(|axis| (mix(step, uvs[axis]) - uv[axis] * deeper) / inverse_depth)
                    });
                    texture.sample(uv, steps)
                };
                if paint.mask.is_some_and(|(texture, cutoff)| texel(texture)[3] < cutoff) {
                    continue;
                }
                self.inverse_depth[at] = inverse_depth;
                let mut color = colors.map(|of| (mix(weights, of) / inverse_depth) as f32);
                if let Some(texture) = paint.texture {
                    let texel = texel(texture);
                    color = [0, 1, 2].map(|channel| color[channel] * texel[channel]);
                }
                self.color[at] = color;
            }
        }
    }

    /// Marks the samples of line set number `set` that can be seen.
    pub(crate) fn draw_lines(&mut self, set: u8, lines: &ScreenLines) {
        for line in &lines.lines {
            let [first, end] = rows(line, lines.radius);
            for row in first.max(self.rows[0])..end.min(self.rows[1]) {
                cover(line, lines.radius, row, self.width, |sample| {
                    if self.line_is_seen(&sample) {
                        let at = self.index(sample.column, sample.row);
                        self.overlay[at] = set + 1;
                    }
                });
            }
        }
    }

    /// Whether the middle of a line is not behind all samples around it.
    fn line_is_seen(&self, sample: &LineSample) -> bool {
        let clamp = |at: f64, first: i64, end: i64| (at.floor() as i64).clamp(first, end - 1);
        let column = clamp(sample.middle.x, 0, self.width);
        let row = clamp(sample.middle.y, self.rows[0], self.rows[1]);
        let nearer = sample.inverse_depth * (1.0 + LINE_BIAS);
        let columns = (column - 1).max(0)..(column + 2).min(self.width);
        ((row - 1).max(self.rows[0])..(row + 2).min(self.rows[1]))
            .any(|row| columns.clone().any(|column| nearer >= self.inverse_depth[self.index(column, row)]))
    }

    /// A pixel: the mean of its samples, each as `look` shows it, with lines over them.
    pub(crate) fn pixel(
        &self,
        column: usize,
        row: usize,
        look: Look,
        background: LinearRgb,
        lines: &[ScreenLines],
    ) -> LinearRgb {
        let mut sum = [0.0f32; 3];
        for y in 0..SUPERSAMPLING {
            for x in 0..SUPERSAMPLING {
                let at = self.index((column * SUPERSAMPLING + x) as i64, (row * SUPERSAMPLING + y) as i64);
                let empty = self.inverse_depth[at] == 0.0;
                let under = if empty { background } else { look.of(self.color[at]) };
                let over = match self.overlay[at] {
                    0 => under,
                    set => {
                        let set = &lines[usize::from(set) - 1];
                        let color = set.color.over(under);
                        std::array::from_fn(|i| under[i] + set.opacity * (color[i] - under[i]))
                    }
                };
                sum = std::array::from_fn(|i| sum[i] + over[i]);
            }
        }
        sum.map(|s| s / (SUPERSAMPLING * SUPERSAMPLING) as f32)
    }
}
