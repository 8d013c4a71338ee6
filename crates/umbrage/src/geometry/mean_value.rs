//! Mean value coordinates of a point in a polygon (Floater 2003; Hormann and Floater 2006): barycentric coordinates for any number
//! of corners.
//!
//! Holds: they sum to one, reproduce affine functions, and are linear along the edges.

use glam::DVec2;
use smallvec::SmallVec;

/// A point sees the two ends of an edge of its polygon under half a turn, and so lies on it, if the sine of the angle is
/// below this: rounding of `f32` vertices.
const ON_EDGE_SINE: f64 = 1e-6;

/// The weights of a polygon's corners at a point inside or on it.
pub fn coordinates(polygon: &[DVec2], at: DVec2) -> SmallVec<[f64; 4]> {
    let n = polygon.len();
    let to: SmallVec<[DVec2; 4]> = polygon.iter().map(|&p| p - at).collect();
    let mut weights: SmallVec<[f64; 4]> = SmallVec::from_elem(0.0, n);
    if let Some(corner) = to.iter().position(|d| *d == DVec2::ZERO) {
        weights[corner] = 1.0;
        return weights;
    }
    // The tangent of half the angle under which each edge is seen.
    let mut tangents: SmallVec<[f64; 4]> = SmallVec::new();
    for i in 0..n {
        let (one, other) = (to[i], to[(i + 1) % n]);
        let (r, s) = (one.length(), other.length());
        let (sine, cosine) = (one.perp_dot(other) / (r * s), one.dot(other) / (r * s));
        if sine.abs() < ON_EDGE_SINE && cosine < 0.0 {
            (weights[i], weights[(i + 1) % n]) = (s / (r + s), r / (r + s));
            return weights;
        }
        tangents.push(if sine == 0.0 { 0.0 } else { (1.0 - cosine) / sine });
    }
    for i in 0..n {
        weights[i] = (tangents[i] + tangents[(i + n - 1) % n]) / to[i].length();
    }
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: [(f64, f64); 4] = [(0.0, 0.0), (3.0, 0.0), (4.0, 2.0), (0.0, 1.0)];

    #[test]
    fn mean_value_coordinates_reproduce_affine_functions() {
        let polygon = QUAD.map(DVec2::from);
        let value = |p: DVec2| 2.0 * p.x - p.y + 0.5;
        for at in [(1.0, 0.5), (2.9, 0.3), (0.01, 0.01), (1.5, 0.0), (0.0, 0.25), (3.5, 1.0), (4.0, 2.0)] {
            let at = DVec2::from(at);
            let weights = coordinates(&polygon, at);
            let sum: f64 = weights.iter().zip(polygon).map(|(weight, p)| weight * value(p)).sum();
            assert!((sum - value(at)).abs() < 1e-12, "{at}: {weights:?}");
            assert!(weights.iter().all(|weight| *weight >= -1e-12));
        }
    }

    #[test]
    fn on_an_edge_only_its_ends_count() {
        let weights = coordinates(&QUAD.map(DVec2::from), DVec2::new(0.75, 0.0));
        assert_eq!(weights[..], [0.75, 0.25, 0.0, 0.0]);
    }
}
