//! Even directions: where rays go.

use std::f64::consts::TAU;

use glam::DVec3;

/// A direction of the hemisphere over a plane, in proportion to its cosine.
pub(crate) fn cosine_direction(normal: DVec3, u: f64, v: f64) -> DVec3 {
    let (across, along) = normal.any_orthonormal_pair();
    let (sine, cosine) = (TAU * v).sin_cos();
    (u.sqrt() * (cosine * across + sine * along) + (1.0 - u).sqrt() * normal).normalize()
}
