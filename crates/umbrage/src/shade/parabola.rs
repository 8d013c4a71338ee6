//! A function of degree 2 over a triangle: what a field is taken to be between its values at the corners and in the middles of the
//! sides.

use glam::DVec2;

use crate::scene::Rgb;

/// A triangle in the frame of its face, with the values that make the function.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parabola {
    pub(super) corners_m: [DVec2; 3],
    /// At the corners.
    pub(super) values: [Rgb; 3],
    /// In the middles of the sides, from each corner to the next.
    pub(super) middles: [Rgb; 3],
}

impl Parabola {
    /// Barycentric coordinates of a point.
    fn weights(&self, at_m: DVec2) -> [f64; 3] {
        let [a, b, c] = self.corners_m;
        let doubled = (b - a).perp_dot(c - a);
        [(b, c), (c, a), (a, b)].map(|(p, q)| (p - at_m).perp_dot(q - at_m) / doubled)
    }

    /// The value where the barycentric coordinates are these.
    fn value(&self, weights: [f64; 3]) -> Rgb {
        (0..3)
            .map(|i| {
                let (here, next) = (weights[i], weights[(i + 1) % 3]);
                here * (2.0 * here - 1.0) * self.values[i] + 4.0 * here * next * self.middles[i]
            })
            .sum()
    }
}

/// The value at a point of the one that holds it, or is nearest to it; `None` of none.
pub(super) fn value_at(parabolas: &[Parabola], at_m: DVec2) -> Option<Rgb> {
    let least = |weights: &[f64; 3]| weights.iter().copied().fold(f64::INFINITY, f64::min);
    let weighted = parabolas.iter().map(|parabola| (parabola.weights(at_m), parabola));
    let nearest = weighted.reduce(|best, next| if least(&next.0) > least(&best.0) { next } else { best });
    nearest.map(|(weights, parabola)| parabola.value(weights))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_function_is_itself_all_over_two_triangles() {
        let function = |p: DVec2| Rgb::new(1.0 + p.x - 2.0 * p.y, p.x * p.y, 3.0 * p.x * p.x - p.y * p.y);
        let [a, b, c, d] = [(0.0, 0.0), (2.0, 0.1), (1.8, 1.5), (-0.1, 1.0)].map(|(x, y)| DVec2::new(x, y));
        let parabolas = [[a, b, c], [a, c, d]].map(|corners_m| Parabola {
            corners_m,
            values: corners_m.map(function),
            middles: [0, 1, 2].map(|i| function(corners_m[i].midpoint(corners_m[(i + 1) % 3]))),
        });
        for at_m in [DVec2::new(1.3, 0.2), DVec2::new(0.2, 0.8), DVec2::new(1.79, 1.49), DVec2::new(2.1, 1.6)] {
            let value = value_at(&parabolas, at_m).unwrap();
            assert!((value - function(at_m)).abs().max_element() < 1e-12, "{value}");
        }
        assert_eq!(value_at(&[], a), None);
    }
}
