//! The double integral of `ln r` over two edges: what the contour form of the form factor is made of.
//!
//! The inner integral, over the source's edge, has a closed form. As a function of the place `s` on the receiver's edge it
//! is analytic but for three places: the feet of the source edge's ends, and where the lines of both come nearest. There
//! it behaves like `t ln t` or `|t|` where the edges touch, and nearly so where they nearly touch. So the outer integral
//! is cut there, and each piece taken by a rule that allows for singular ends.

use glam::DVec3;

use super::quadrature::unit_interval;

/// An edge of a polygon; it has a length.
#[derive(Clone, Copy, Debug)]
pub(super) struct PolygonEdge {
    start: DVec3,
    along: DVec3,
    length: f64,
}

/// An integral over two edges.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Part {
    pub(super) value: f64,
    /// What the last refinement changed, and the rounding.
    pub(super) error: f64,
}

/// Directions whose cosine is below this are taken to be perpendicular: their contribution is rounding.
const PERPENDICULAR: f64 = 1e-16;
/// A singular place of the inner integral spoils the rule where it is nearer to the outer edge than this share of its
/// length; the integral is then cut there.
const NEAR_OF_LENGTH: f64 = 0.5;
/// A refinement that changes the integral by less than this share of the lengths is the last.
const ENOUGH: f64 = 1e-14;
/// Roundings of one part in 2^53, of terms of the size of the edges, in the sum over all nodes.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The edges of a polygon that have a length.
pub(super) fn edges(corners: &[DVec3]) -> Vec<PolygonEdge> {
    (0..corners.len())
        .map(|i| (corners[i], corners[(i + 1) % corners.len()]))
        .map(|(start, end)| PolygonEdge { start, along: end - start, length: start.distance(end) })
        .filter(|edge| edge.length > 0.0)
        .collect()
}

/// `(d1 . d2)` times the double integral of `ln r`. Coordinates are of the order of 1.
pub(super) fn edge_pair(receiver: &PolygonEdge, source: &PolygonEdge) -> Part {
    let product = receiver.along.dot(source.along);
    let lengths = receiver.length * source.length;
    if product.abs() <= PERPENDICULAR * lengths {
        return Part { value: 0.0, error: PERPENDICULAR * lengths };
    }
    let cosine = product / lengths;
    let stops = stops(receiver, source);
    let (mut value, mut change) = (0.0, 0.0);
    for piece in stops.windows(2) {
        let length = (piece[1] - piece[0]) * receiver.length;
        let inner = |from_start: f64, from_end: f64| {
            // From the nearer end, so that nodes close to a singular one keep their distance from it.
            let s = if from_start < from_end {
                piece[0] + from_start * (piece[1] - piece[0])
            } else {
                piece[1] - from_end * (piece[1] - piece[0])
            };
            log_distance(receiver.start + s * receiver.along, source)
        };
        let integral = unit_interval(inner, ENOUGH * source.length);
        value += length * integral.value;
        change += length * integral.change;
    }
    Part { value: cosine * value, error: cosine.abs() * (change + ROUNDING * lengths) }
}

/// Where the outer integral is cut: 0, 1, and the singular places between.
fn stops(receiver: &PolygonEdge, source: &PolygonEdge) -> Vec<f64> {
    let place = |point: DVec3| {
        let s = (point - receiver.start).dot(receiver.along) / receiver.length.powi(2);
        (s, point.distance(receiver.start + s * receiver.along))
    };
    let ends = [source.start, source.start + source.along].map(place);
    let singular = ends.into_iter().chain(nearest(receiver, source));
    let mut stops: Vec<f64> = singular
        .filter(|&(s, away)| s > 0.0 && s < 1.0 && away < NEAR_OF_LENGTH * receiver.length)
        .map(|(s, _)| s)
        .chain([0.0, 1.0])
        .collect();
    stops.sort_by(f64::total_cmp);
    stops.dedup();
    stops
}

/// Where the line of the receiver's edge comes nearest to that of the source's, and how near; `None` for parallels.
fn nearest(receiver: &PolygonEdge, source: &PolygonEdge) -> Option<(f64, f64)> {
    let across = receiver.along.cross(source.along);
    let squared = across.length_squared();
    let lengths = receiver.length * source.length;
    if squared <= (f64::EPSILON * lengths).powi(2) {
        return None;
    }
    let between = source.start - receiver.start;
    let s = between.cross(source.along).dot(across) / squared;
    Some((s, between.dot(across).abs() / squared.sqrt()))
}

/// The integral of `ln` of the distance from `point` over the source's edge.
fn log_distance(point: DVec3, source: &PolygonEdge) -> f64 {
    let direction = source.along / source.length;
    let t0 = (source.start - point).dot(direction);
    let h = (source.start - point - t0 * direction).length();
    let antiderivative = |t: f64| {
        let r_squared = t * t + h * h;
        let logarithm = if r_squared > 0.0 { 0.5 * t * r_squared.ln() } else { 0.0 };
        logarithm - t + h * t.atan2(h)
    };
    antiderivative(t0 + source.length) - antiderivative(t0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(start: DVec3, along: DVec3) -> PolygonEdge {
        PolygonEdge { start, along, length: along.length() }
    }

    #[test]
    fn an_edge_with_itself_has_a_closed_form() {
        // The double integral of ln |s - t| over the unit square is -3/2.
        let unit = edge(DVec3::new(0.3, -0.2, 0.1), DVec3::X);
        let part = edge_pair(&unit, &unit);
        assert!((part.value + 1.5).abs() < 1e-14 && part.error < 1e-12, "{part:?}");
    }

    #[test]
    fn collinear_edges_that_overlap_in_part_have_a_closed_form() {
        // With f(x) = x^2 ln(x^2) / 4 - 3 x^2 / 4: f(b - a') - f(a - a') - f(b - b') + f(a - b'), signs apart.
        let f = |x: f64| if x == 0.0 { 0.0 } else { 0.25 * x * x * (x * x).ln() - 0.75 * x * x };
        for (start, length) in [(0.3, 1.1), (-0.2, 0.5), (1.0, 2.0), (0.2, 0.3)] {
            let truth = f(1.0 - start) - f(-start) - f(1.0 - start - length) + f(-start - length);
            let part = edge_pair(&edge(DVec3::ZERO, DVec3::X), &edge(DVec3::X * start, DVec3::X * length));
            assert!((part.value - truth).abs() < 1e-13, "{part:?} is not {truth}");
        }
    }

    #[test]
    fn edges_that_cross_are_the_same_from_both() {
        for gap in [0.0, 1e-9, 1e-4, 0.1] {
            let first = edge(DVec3::new(-0.4, 0.0, 0.0), DVec3::X);
            let second = edge(DVec3::new(-0.1, -0.5, gap), DVec3::new(0.3, 1.0, 0.0));
            let parts = [edge_pair(&first, &second), edge_pair(&second, &first)];
            assert!((parts[0].value - parts[1].value).abs() < 1e-12, "{parts:?} at {gap}");
            assert!(parts.iter().all(|part| part.error < 1e-10), "{parts:?} at {gap}");
        }
    }
}
