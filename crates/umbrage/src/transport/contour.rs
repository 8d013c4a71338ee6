//! The form factor between two polygons in clear sight of one another, by Stokes' theorem twice (Sparrow, *A new and
//! simpler formulation for radiative angle factors*, 1963):
//!
//! ```text
//! A1 F12 = 1 / (2 pi) * sum over edge pairs of  (d1 . d2) * double integral of ln r ds dt
//! ```
//!
//! The inner integral has a closed form, also on a common edge, where `ln r` is not bounded; the outer one is Gauss's, on
//! pieces that end where the inner one has a kink (at the feet of the other edge's ends) and with nodes that crowd there.
//! It is good to 5e-5 for polygons that touch, where sampling is worst; it loses digits where they are far apart,
//! since large terms cancel: use samples there.

use std::f64::consts::PI;

use glam::DVec3;

/// Nodes and weights of Gauss's rule on -1 to 1, ten points: the positive half.
const GAUSS: [(f64, f64); 5] = [
    (0.148_874_338_981_631_2, 0.295_524_224_714_752_9),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_3),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_1),
];

/// The factor from `receiver_m` to `source_m`, times the receiver's area, in square metres. Both are convex, run
/// counter-clockwise seen from their fronts, and lie in front of one another.
pub(super) fn exchange_area_m2(receiver_m: &[DVec3], source_m: &[DVec3]) -> f64 {
    let edges = |corners: &[DVec3]| -> Vec<(DVec3, DVec3)> {
        (0..corners.len())
            .map(|i| (corners[i], corners[(i + 1) % corners.len()]))
            .filter(|(from, to)| from != to)
            .collect()
    };
    let (receiver_edges, source_edges) = (edges(receiver_m), edges(source_m));
    let mut sum = 0.0;
    for &(from, to) in &receiver_edges {
        for &source_edge in &source_edges {
            sum += edge_pair(from, to, source_edge);
        }
    }
    (sum / (2.0 * PI)).max(0.0)
}

/// `(d1 . d2)` times the double integral of `ln r` over two edges.
fn edge_pair(from: DVec3, to: DVec3, source: (DVec3, DVec3)) -> f64 {
    let (along, source_along) = (to - from, source.1 - source.0);
    let (length, source_length) = (along.length(), source_along.length());
    let direction = source_along / source_length;
    let cosine = along.dot(direction) / length;
    if cosine == 0.0 {
        return 0.0;
    }
    let foot = |end: DVec3| ((end - from).dot(along) / (length * length)).clamp(0.0, 1.0);
    let (near, far) = (foot(source.0), foot(source.1));
    let stops = [0.0, near.min(far), near.max(far), 1.0];
    let mut integral = 0.0;
    for piece in stops.windows(2).filter(|piece| piece[1] > piece[0]) {
        for (node, weight) in GAUSS.iter().flat_map(|&(node, weight)| [(-node, weight), (node, weight)]) {
            // s = u^3 (10 - 15 u + 6 u^2): nodes crowd at both ends, where the inner integral behaves like t ln t.
            let u = 0.5 * (1.0 + node);
            let (s, density) = (u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u), 30.0 * (u * (1.0 - u)).powi(2));
            let point = from + along * (piece[0] + s * (piece[1] - piece[0]));
            let value = log_distance(point, source.0, direction, source_length);
            integral += 0.5 * weight * density * (piece[1] - piece[0]) * value;
        }
    }
    cosine * length * integral
}

/// The integral of `ln` of the distance from `point` over the segment from `start` along `direction`.
fn log_distance(point: DVec3, start: DVec3, direction: DVec3, length: f64) -> f64 {
    let t0 = (start - point).dot(direction);
    let h = (start - point - t0 * direction).length();
    let antiderivative = |t: f64| {
        let r_squared = t * t + h * h;
        let logarithm = if r_squared > 0.0 { 0.5 * t * r_squared.ln() } else { 0.0 };
        logarithm - t + h * t.atan2(h)
    };
    antiderivative(t0 + length) - antiderivative(t0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(origin: DVec3, u: DVec3, v: DVec3) -> [DVec3; 4] {
        [origin, origin + u, origin + u + v, origin + v]
    }

    fn assert_close(value: f64, truth: f64, tolerance: f64) {
        assert!((value - truth).abs() <= tolerance, "{value} is not {truth} within {tolerance}");
    }

    #[test]
    fn parallel_unit_squares() {
        let floor = rectangle(DVec3::ZERO, DVec3::X, DVec3::Y);
        for (distance, truth) in [(1.0, 0.1998248957), (0.1, 0.8269945224), (2.0, 0.0685895888)] {
            let above = rectangle(DVec3::Z * distance, DVec3::Y, DVec3::X);
            assert_close(exchange_area_m2(&floor, &above), truth, 5e-5);
        }
    }

    #[test]
    fn perpendicular_rectangles_with_a_common_edge() {
        let floor = rectangle(DVec3::ZERO, DVec3::X, DVec3::Y);
        for (height, truth) in [(1.0, 0.2000437761), (2.0, 0.2328526028)] {
            let wall = rectangle(DVec3::ZERO, DVec3::Y, DVec3::Z * height);
            assert_close(exchange_area_m2(&floor, &wall), truth, 5e-5);
        }
    }

    #[test]
    fn parts_that_touch_in_part_sum_to_the_whole() {
        let wall = |y: f64, width: f64| rectangle(DVec3::Y * y, DVec3::Y * width, DVec3::Z);
        let floor = |y: f64, width: f64| rectangle(DVec3::Y * y, DVec3::X, DVec3::Y * width);
        let mut sum = 0.0;
        for (y, width) in [(0.0, 0.3), (0.3, 0.7)] {
            for (z, height) in [(0.0, 0.6), (0.6, 0.4)] {
                sum += exchange_area_m2(&floor(y, width), &wall(z, height));
            }
        }
        assert_close(sum, 0.2000437761, 1e-5);
    }
}
