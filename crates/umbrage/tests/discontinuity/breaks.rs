//! Where a function of one variable is not smooth: intervals on which no polynomial fits it however short they are.
//!
//! A function that is analytic but for breaks is divided until a polynomial of degree 8 agrees with it to rounding.
//! Around a break none does, and the division goes on to the resolution. At a break, polynomials on both sides tell
//! what jumps.

/// Degree + 1 of the polynomials.
const NODES: usize = 9;
/// How far from the polynomial counts as off, as a share of the greatest value: some hundred roundings.
const ROUNDING: f64 = 1e-13;
/// Darkness is rounded like a value of this size: what makes it dark is.
const LEAST: f64 = 0.3;
/// Intervals are divided down to this length, in metres.
pub const RESOLUTION_M: f64 = 1e-4;
/// One look at an interval longer than this, in metres, is not trusted.
const LONGEST_M: f64 = 0.05;
/// One-sided polynomials are at most so long, in metres, and use this share of the way to the next break.
const SIDE_M: f64 = 0.01;
const SIDE_SHARE: f64 = 0.45;

/// A place where the function is not smooth.
#[derive(Clone, Copy, Debug)]
pub struct Break {
    pub from: f64,
    pub to: f64,
}

impl Break {
    pub fn middle(&self) -> f64 {
        0.5 * (self.from + self.to)
    }
}

/// Values at Chebyshev points, and the polynomial through them.
struct Polynomial {
    middle: f64,
    half: f64,
    /// Coefficients of Chebyshev's polynomials.
    coefficients: [f64; NODES],
}

impl Polynomial {
    fn through(f: &impl Fn(f64) -> f64, from: f64, to: f64) -> Self {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let angle = |j: usize| std::f64::consts::PI * (j as f64 + 0.5) / NODES as f64;
        let values: Vec<f64> = (0..NODES).map(|j| f(middle + half * angle(j).cos())).collect();
        let coefficients = std::array::from_fn(|k| {
            let sum: f64 = (0..NODES).map(|j| values[j] * (k as f64 * angle(j)).cos()).sum();
            sum * if k == 0 { 1.0 } else { 2.0 } / NODES as f64
        });
        Self { middle, half, coefficients }
    }

    /// Value, first and second derivative.
    fn at(&self, t: f64) -> [f64; 3] {
        let x = (t - self.middle) / self.half;
        let (mut t0, mut t1) = ([1.0, 0.0, 0.0], [x, 1.0, 0.0]);
        let mut sum = [0.0; 3];
        for &c in &self.coefficients {
            sum.iter_mut().zip(t0).for_each(|(s, d)| *s += c * d);
            let t2 =
                [2.0 * x * t1[0] - t0[0], 2.0 * t1[0] + 2.0 * x * t1[1] - t0[1], 4.0 * t1[1] + 2.0 * x * t1[2] - t0[2]];
            (t0, t1) = (t1, t2);
        }
        [sum[0], sum[1] / self.half, sum[2] / (self.half * self.half)]
    }
}

fn is_smooth(f: &impl Fn(f64) -> f64, from: f64, to: f64, most_error: f64) -> bool {
    let polynomial = Polynomial::through(f, from, to);
    // Off the nodes, and next to the ends: a break between an end and the first node is seen from its far side alone.
    [2e-4, 0.21, 0.47, 0.76, 1.0 - 2e-4].iter().all(|share| {
        let t = from + share * (to - from);
        (polynomial.at(t)[0] - f(t)).abs() <= most_error
    })
}

/// The breaks of `f` between 0 and `length`, and the least jumps of value, slope and curvature that are found for sure.
pub fn breaks(f: &impl Fn(f64) -> f64, length: f64) -> (Vec<Break>, [f64; 3]) {
    let error = ROUNDING * (0..64).map(|i| f(length * (i as f64 + 0.5) / 64.0).abs()).fold(LEAST, f64::max);
    let mut found = Vec::new();
    divide(f, 0.0, length, error, &mut found);
    found.sort_by(|p: &Break, q| p.from.total_cmp(&q.from));
    let mut merged: Vec<Break> = Vec::new();
    for next in found {
        match merged.last_mut().filter(|last| next.from <= last.to + 0.1 * RESOLUTION_M) {
            Some(last) => last.to = last.to.max(next.to),
            None => merged.push(next),
        }
    }
    // A kink in the middle of an interval is off its best polynomial by about a sixtieth of jump times length; a break
    // of curvature by a tenth of that. Both with a margin, for breaks near an end.
    let sure = [20.0, 2e3 / RESOLUTION_M, 4e4 / (RESOLUTION_M * RESOLUTION_M)].map(|factor| factor * error);
    (merged, sure)
}

fn divide(f: &impl Fn(f64) -> f64, from: f64, to: f64, error: f64, found: &mut Vec<Break>) {
    let length = to - from;
    // Short features may lie between the points of a long interval.
    if length < LONGEST_M && is_smooth(f, from, to, error) {
        return;
    }
    if length <= RESOLUTION_M {
        found.push(Break { from, to });
        return;
    }
    let middle = from + 0.5 * length;
    divide(f, from, middle, error, found);
    divide(f, middle, to, error, found);
    // A break next to the middle is seen from neither half.
    let (before, after) = (middle - 0.4 * RESOLUTION_M, middle + 0.6 * RESOLUTION_M);
    if !is_smooth(f, before, after, error) {
        found.push(Break { from: before, to: after });
    }
}

/// What jumps at a break between two others (or ends): value, slope and curvature.
pub fn jumps(f: &impl Fn(f64) -> f64, at: &Break, before: f64, after: f64) -> [f64; 3] {
    let left = (SIDE_SHARE * (at.from - before)).min(SIDE_M);
    let right = (SIDE_SHARE * (after - at.to)).min(SIDE_M);
    let left = Polynomial::through(f, at.from - left, at.from).at(at.middle());
    let right = Polynomial::through(f, at.to, at.to + right).at(at.middle());
    std::array::from_fn(|i| right[i] - left[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn breaks_of_every_degree_are_found_and_measured() {
        // A jump of 0.01 at 0.5, of slope 2 at 1.0 (a middle of every division), of curvature 3 at 1.7.
        let f = |t: f64| {
            (1.3 * t).sin()
                + if t > 0.5 { 0.01 } else { 0.0 }
                + 2.0 * (t - 1.0).max(0.0)
                + 1.5 * (t - 1.7).max(0.0).powi(2)
        };
        let (found, _) = breaks(&f, 2.0);
        assert_eq!(found.len(), 3, "{found:?}");
        for (i, (at, degree, jump)) in [(0.5, 0, 0.01), (1.0, 1, 2.0), (1.7, 2, 3.0)].into_iter().enumerate() {
            assert!(found[i].from - 1e-6 <= at && at <= found[i].to + 1e-6, "{found:?}");
            let measured = jumps(&f, &found[i], 0.0, 2.0);
            assert!((measured[degree] - jump).abs() < 1e-3 * jump + 1e-4, "{measured:?}");
        }
    }

    #[test]
    fn a_smooth_function_has_no_breaks() {
        assert!(breaks(&|t: f64| (1.0 / (0.01 + t * t)).sqrt(), 1.0).0.is_empty());
    }
}
