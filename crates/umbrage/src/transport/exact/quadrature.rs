//! Rules for integrals over an interval and over a triangle.
//!
//! Gauss's rule serves smooth functions. Where a function has a singularity at, or next to, an end of the interval, the
//! double exponential rule does (Takahasi and Mori, *Double exponential formulas for numerical integration*, 1974): with
//! `u = 1 / (1 + exp(-pi sinh t))` the trapezoidal rule in `t` converges nearly as fast as for a smooth function, and
//! halving its step keeps all earlier nodes.

use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::DVec3;

/// Step of the coarsest level of the double exponential rule.
const FIRST_STEP: f64 = 0.8;
/// Steps to each side at the coarsest level: beyond them weights are below 1e-15.
const FIRST_STEPS: usize = 4;
/// Levels of the double exponential rule; the last one has 513 nodes.
const LEVELS: usize = 7;

/// A node at a distance from one end of the unit interval, and its weight; both ends have it.
#[derive(Clone, Copy, Debug)]
struct EndNode {
    from_end: f64,
    weight: f64,
}

/// The nodes that each level adds, without the middle, which is the first level's alone.
static DOUBLE_EXPONENTIAL: LazyLock<Vec<Vec<EndNode>>> = LazyLock::new(|| {
    let node = |t: f64| {
        let from_end = 1.0 / (1.0 + (PI * t.sinh()).exp());
        EndNode { from_end, weight: PI * t.cosh() * from_end * (1.0 - from_end) }
    };
    (0..LEVELS)
        .map(|level| {
            let step = FIRST_STEP / f64::from(1 << level);
            let steps = FIRST_STEPS << level;
            (1..=steps).filter(|i| level == 0 || i % 2 == 1).map(|i| node(step * i as f64)).collect()
        })
        .collect()
});

/// An integral, and how much the last refinement changed it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Integral {
    pub(super) value: f64,
    pub(super) change: f64,
}

/// The integral over 0 to 1 of a function of the distances from both ends, refined until a refinement changes it by at
/// most `tolerance`. The function may be singular at the ends if it stays bounded.
pub(super) fn unit_interval(f: impl Fn(f64, f64) -> f64, tolerance: f64) -> Integral {
    let mut sum = 0.25 * PI * f(0.5, 0.5);
    let mut integral = Integral { value: 0.0, change: f64::INFINITY };
    for (level, nodes) in DOUBLE_EXPONENTIAL.iter().enumerate() {
        sum += nodes
            .iter()
            .map(|n| n.weight * (f(n.from_end, 1.0 - n.from_end) + f(1.0 - n.from_end, n.from_end)))
            .sum::<f64>();
        let value = sum * FIRST_STEP / f64::from(1 << level);
        integral = Integral { value, change: if level == 0 { f64::INFINITY } else { (value - integral.value).abs() } };
        if integral.change <= tolerance {
            break;
        }
    }
    integral
}

/// Nodes and weights of Gauss's rule with `n` points on 0 to 1: Newton's method on the Legendre polynomial, from
/// Tricomi's first guess.
pub(super) fn gauss(n: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut before, mut here) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (before, here) = (here, ((2.0 * k - 1.0) * x * here - (k - 1.0) * before) / k);
        }
        (here, n as f64 * (before - x * here) / (1.0 - x * x))
    };
    (0..n)
        .map(|i| {
            let mut x = -(PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            for _ in 0..NEWTON_STEPS {
                let (value, slope) = legendre(x);
                x -= value / slope;
            }
            let slope = legendre(x).1;
            (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Newton's method doubles its digits with each step; the first guess has three.
const NEWTON_STEPS: usize = 5;

/// A rule over triangles: the product of Gauss's with itself on a square of which one side is drawn together to a point.
/// With `n` by `n` points it is exact to degree `2 n - 2`.
#[derive(Clone, Debug)]
pub(super) struct TriangleRule(Vec<([f64; 2], f64)>);

impl TriangleRule {
    pub(super) fn new(n: usize) -> Self {
        let line = gauss(n);
        let product = line
            .iter()
            .flat_map(|&(u, wu)| line.iter().map(move |&(v, wv)| ([u, v * (1.0 - u)], 2.0 * wu * wv * (1.0 - u))));
        Self(product.collect())
    }

    /// Points over a convex polygon, by a fan of triangles, each with its share of the area in square metres.
    pub(super) fn over(&self, corners: &[DVec3]) -> Vec<(DVec3, f64)> {
        let mut points = Vec::with_capacity(corners.len().saturating_sub(2) * self.0.len());
        let Some((&apex, rest)) = corners.split_first() else { return points };
        for pair in rest.windows(2) {
            let (first, second) = (pair[0] - apex, pair[1] - apex);
            let area_m2 = 0.5 * first.cross(second).length();
            points.extend(self.0.iter().map(|&([s, t], weight)| (apex + s * first + t * second, weight * area_m2)));
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_is_exact_to_its_degree() {
        for n in 1..=12 {
            for degree in 0..2 * n {
                let sum: f64 = gauss(n).iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!((sum * (degree + 1) as f64 - 1.0).abs() < 1e-13, "{n} points, degree {degree}: {sum}");
            }
        }
    }

    #[test]
    fn triangle_rules_are_exact_to_their_degree() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        for n in [3, 4, 6] {
            let points = TriangleRule::new(n).over(&square);
            for (i, j) in (0..2 * n - 1).flat_map(|i| (0..2 * n - 1 - i).map(move |j| (i, j))) {
                let sum: f64 = points.iter().map(|(p, w)| w * p.x.powi(i as i32) * p.y.powi(j as i32)).sum();
                assert!((sum * ((i + 1) * (j + 1)) as f64 - 1.0).abs() < 1e-12, "{n}: x^{i} y^{j} {sum}");
            }
        }
    }

    #[test]
    fn singular_ends_do_no_harm() {
        for (f, truth) in [
            (Box::new(|u: f64, _: f64| u * u.ln()) as Box<dyn Fn(f64, f64) -> f64>, -0.25),
            (Box::new(|u: f64, v: f64| (u * v).sqrt()), PI / 8.0),
            (Box::new(|u: f64, _: f64| (-u).exp()), 1.0 - (-1.0_f64).exp()),
            (Box::new(|u: f64, _: f64| (u * u + 1e-12).ln()), -2.0 + PI * 1e-6 - 1e-12),
        ] {
            let integral = unit_interval(f, 1e-13);
            assert!((integral.value - truth).abs() < 1e-12 + integral.change, "{integral:?} is not {truth}");
            assert!(integral.change < 1e-11, "{integral:?}");
        }
    }
}
