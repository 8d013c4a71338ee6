//! The lengths below which things count as one, all derived from the scene's extent.
//!
//! Coordinates come as `f32` and leave as `f32`, with 24 bits of mantissa: their rounding is 6e-8 of the extent. Every
//! tolerance here is a distance in metres, never an angle.

/// Vertices nearer than this share of the extent are one: 50 roundings of `f32`.
const WELD_OF_EXTENT: f64 = 3e-6;
/// A point nearer to a plane than this share of the extent lies in it: 16 roundings of `f32`.
const COPLANAR_OF_EXTENT: f64 = 1e-6;
/// A gap between two faces that is narrower than this share of the extent is closed: 1 mm in a hall of 5 m, a fifth of a pixel where
/// the scene fills a picture of a thousand. Light that gets into it is gone within a few of its widths, which no mesh can show.
const CLOSED_OF_EXTENT: f64 = 2e-4;

/// Tolerances of one scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Largest side of the scene's bounding box, in metres.
    pub extent_m: f64,
}

impl Tolerance {
    /// Tolerances of a scene of this extent.
    pub fn new(extent_m: f64) -> Self {
        Self { extent_m }
    }

    /// Vertices nearer than this are one vertex.
    pub fn weld_m(&self) -> f64 {
        WELD_OF_EXTENT * self.extent_m
    }

    /// A face that is nearer than this over a point, along the point's own face, covers it.
    pub fn closed_m(&self) -> f64 {
        CLOSED_OF_EXTENT * self.extent_m
    }

    /// A point nearer than this to a plane lies in the plane.
    pub fn coplanar_m(&self) -> f64 {
        COPLANAR_OF_EXTENT * self.extent_m
    }
}
