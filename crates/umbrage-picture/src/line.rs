//! Lines drawn over a picture: the mesh's edges, and segments such as shadow boundaries.
//!
//! Idea: a line has a width in pixels and covers samples, so it is anti-aliased like everything else. Whether it can be
//! seen is decided on its middle: a sample of it is drawn where the point of the middle nearest to it is not behind
//! *all* samples around that point. So a line on a surface is whole however steeply the surface is seen, without an
//! offset that would let lines behind show through.
//!
//! Holds: where lines of several sets cover a sample, the last set wins; the order inside a set does not matter.

use glam::{DVec2, DVec3};

use crate::color::{CONTRAST_LUMINANCE, LinearRgb, luminance};
use crate::mesh::PictureMesh;
use crate::project::ScreenLine;

/// Width of the lines of a wireframe, in pixels.
pub const WIRE_WIDTH_PX: f64 = 0.8;
/// How much of the picture a wireframe hides, 0 to 1.
pub const WIRE_OPACITY: f32 = 0.45;
/// Width of a d-segment, in pixels.
pub const SEGMENT_WIDTH_PX: f64 = 1.6;

/// A straight line in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Its ends, in metres.
    pub ends_m: [[f64; 3]; 2],
    /// Normal of the surface on which it lies: where it looks away from the eye, the line is not drawn.
    pub normal: Option<[f64; 3]>,
}

/// Colour of lines on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LineColor {
    /// The same everywhere, linear.
    Plain(LinearRgb),
    /// Black over what is bright, white over what is dark.
    Contrast,
}

impl LineColor {
    /// The colour over `under`.
    pub(crate) fn over(self, under: LinearRgb) -> LinearRgb {
        match self {
            Self::Plain(color) => color,
            Self::Contrast if luminance(under) > CONTRAST_LUMINANCE => [0.0; 3],
            Self::Contrast => [1.0; 3],
        }
    }
}

/// Lines of one look.
#[derive(Clone, Debug, PartialEq)]
pub struct LineSet {
    /// Their colour.
    pub color: LineColor,
    /// How much of the picture they hide, 0 to 1.
    pub opacity: f32,
    /// Their width, in pixels of the picture.
    pub width_px: f64,
    /// The lines.
    pub lines: Vec<Line>,
}

/// The edges of all triangles that show their front to an eye at `eye_m`, each once, in an order that only their
/// coordinates decide.
pub fn wireframe(meshes: &[PictureMesh], eye_m: DVec3) -> Vec<Line> {
    let mut edges: Vec<[[u64; 3]; 2]> = Vec::new();
    for [a, b, c] in meshes.iter().flat_map(PictureMesh::corners_m) {
        if (b - a).cross(c - a).dot(eye_m - a) <= 0.0 {
            continue;
        }
        for (from, to) in [(a, b), (b, c), (c, a)] {
            // Adding 0 makes -0 to 0: the same point has the same bits.
            let [from, to] = [from, to].map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
            edges.push(if from <= to { [from, to] } else { [to, from] });
        }
    }
    edges.sort_unstable();
    edges.dedup();
    edges.into_iter().map(|ends| Line { ends_m: ends.map(|p| p.map(f64::from_bits)), normal: None }).collect()
}

impl Line {
    /// Whether its surface shows the front to an eye at `eye_m`.
    pub(crate) fn faces(&self, eye_m: DVec3) -> bool {
        let middle = (DVec3::from(self.ends_m[0]) + DVec3::from(self.ends_m[1])) / 2.0;
        self.normal.is_none_or(|normal| DVec3::from(normal).dot(eye_m - middle) > 0.0)
    }
}

/// A sample that a line covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LineSample {
    pub(crate) column: i64,
    pub(crate) row: i64,
    /// The nearest point of the line's middle, in samples.
    pub(crate) middle: DVec2,
    /// 1/z of that point, per metre.
    pub(crate) inverse_depth: f64,
}

/// First row and row after the last that a line of `radius` samples can cover.
pub(crate) fn rows(line: &ScreenLine, radius: f64) -> [i64; 2] {
    let low = line.ends[0].y.min(line.ends[1].y) - radius;
    let high = line.ends[0].y.max(line.ends[1].y) + radius;
    [(low - 0.5).floor() as i64, (high - 0.5).floor() as i64 + 1]
}

/// Calls `draw` for each sample of row `row` within `radius` samples of a line, among the first `width` columns.
pub(crate) fn cover(line: &ScreenLine, radius: f64, row: i64, width: i64, mut draw: impl FnMut(LineSample)) {
    let [from, to] = line.ends;
    let along = to - from;
    let y = row as f64 + 0.5;
    let (mut low, mut high) = (from.x.min(to.x) - radius, from.x.max(to.x) + radius);
    // The strip of the infinite line, which for a steep line is much narrower than the box.
    if along.y.abs() > 1e-9 {
        let (middle, half) = (from.x + (y - from.y) * along.x / along.y, radius * along.length() / along.y.abs());
        (low, high) = (low.max(middle - half), high.min(middle + half));
    }
    let (first, end) = (((low - 0.5).ceil() as i64).max(0), ((high - 0.5).floor() as i64 + 1).min(width));
    for column in first..end {
        let sample = DVec2::new(column as f64 + 0.5, y);
        let length_squared = along.length_squared();
        let t = if length_squared > 0.0 { ((sample - from).dot(along) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
        let middle = from + t * along;
        if middle.distance_squared(sample) <= radius * radius {
            let [a, b] = line.inverse_depth;
            draw(LineSample { column, row, middle, inverse_depth: a + t * (b - a) });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shared_edge_is_one_line_and_a_back_has_none() {
        let mesh = PictureMesh {
            positions_m: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, -0.0], [0.0, 1.0, 0.0]],
            colors: vec![[1.0; 3]; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..PictureMesh::default()
        };
        assert_eq!(wireframe(std::slice::from_ref(&mesh), DVec3::Z).len(), 5);
        assert_eq!(wireframe(&[mesh], DVec3::NEG_Z).len(), 0);
    }

    #[test]
    fn a_line_covers_its_width() {
        for (from, to) in [((10.0, 50.0), (90.0, 50.0)), ((50.0, 10.0), (50.0, 90.0)), ((10.0, 10.0), (70.0, 63.0))] {
            let line = ScreenLine { ends: [DVec2::from(from), DVec2::from(to)], inverse_depth: [1.0, 2.0] };
            let (mut count, mut deepest) = (0, 0.0f64);
            let [first, end] = rows(&line, 4.0);
            (first..end).for_each(|row| {
                cover(&line, 4.0, row, 100, |s| {
                    count += 1;
                    deepest = deepest.max(s.inverse_depth);
                });
            });
            // A strip and two half discs.
            let area = 8.0 * line.ends[0].distance(line.ends[1]) + std::f64::consts::PI * 16.0;
            assert!((f64::from(count) - area).abs() < 0.02 * area, "{count} {area}");
            assert_eq!(deepest, 2.0);
        }
    }

    #[test]
    fn a_line_on_a_surface_that_looks_away_is_hidden() {
        let line = Line { ends_m: [[0.0; 3], [1.0, 0.0, 0.0]], normal: Some([0.0, 1.0, 0.0]) };
        assert!(line.faces(DVec3::Y) && !line.faces(DVec3::NEG_Y));
        assert!(Line { normal: None, ..line }.faces(DVec3::NEG_Y));
    }

    #[test]
    fn a_contrasting_line_is_never_the_colour_below() {
        assert_eq!(LineColor::Contrast.over([0.9; 3]), [0.0; 3]);
        assert_eq!(LineColor::Contrast.over([0.01; 3]), [1.0; 3]);
        assert_eq!(LineColor::Plain([0.5; 3]).over([0.9; 3]), [0.5; 3]);
    }
}
