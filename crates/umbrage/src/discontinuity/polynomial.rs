//! Roots of short polynomials between 0 and 1.
//!
//! The roots of the derivative divide the interval into parts on which the polynomial is monotone; each part whose ends
//! differ in sign holds one root, which Newton's method finds, or bisection where a step of it leaves the part. Roots without a
//! change of sign are none: nothing begins or ends there.

use smallvec::SmallVec;

/// Halvings that take an interval of length 1 to rounding, and a few for steps that do less.
const STEPS: usize = 64;
/// A step shorter than this changes nothing: a few times the last bit of numbers up to 1.
const LAST_BIT: f64 = 4e-16;
/// Rounding of sums of a few terms, as a share of the terms: a thousand times the last bit.
const ROUNDING: f64 = 2e-13;

/// The roots between 0 and 1 at which a polynomial with these coefficients, of ascending powers, changes sign;
/// ascending.
pub(super) fn roots(coefficients: &[f64]) -> SmallVec<[f64; 4]> {
    if keeps_sign(coefficients) {
        return SmallVec::new();
    }
    // Value and slope.
    let at = |t: f64| coefficients.iter().rev().fold((0.0, 0.0), |(v, slope), c| (v * t + c, slope * t + v));
    let mut ends: SmallVec<[f64; 6]> = SmallVec::from_slice(&[0.0]);
    if coefficients.len() > 2 {
        let derivative: SmallVec<[f64; 4]> =
            coefficients.iter().enumerate().skip(1).map(|(power, c)| power as f64 * c).collect();
        ends.extend(roots(&derivative));
    }
    ends.push(1.0);
    let root = |pair: &[f64]| {
        let (mut from, mut to) = (pair[0], pair[1]);
        let (value_from, value_to) = (at(from).0, at(to).0);
        let rises = value_to > 0.0;
        if value_from * value_to >= 0.0 {
            return None;
        }
        let mut t = from + (to - from) * value_from / (value_from - value_to);
        for _ in 0..STEPS {
            let (value, slope) = at(t);
            if (value > 0.0) == rises {
                to = t
            } else {
                from = t
            }
            let step = value / slope;
            let next = t - step;
            if step.abs() <= LAST_BIT || to - from <= LAST_BIT {
                return Some(next.clamp(from, to));
            }
            t = if from < next && next < to { next } else { 0.5 * (from + to) };
        }
        Some(t)
    };
    ends.windows(2).filter_map(root).collect()
}

/// Whether a polynomial is clearly above zero, or clearly below, from 0 to 1: it lies in the hull of its Bernstein coefficients. Most
/// are, and the search for roots of their derivatives is long.
fn keeps_sign(coefficients: &[f64]) -> bool {
    let degree = coefficients.len().saturating_sub(1);
    let rounding = ROUNDING * coefficients.iter().map(|c| c.abs()).sum::<f64>();
    let bernstein = |number: usize| {
        // The share of each power: binomial of the number over binomial of the degree.
        let mut share = 1.0;
        let term = |(power, c): (usize, &f64)| {
            let of_power = share * c;
            share *= (number - power.min(number)) as f64 / (degree - power).max(1) as f64;
            of_power
        };
        coefficients.iter().enumerate().map(term).sum::<f64>()
    };
    (0..=degree).all(|number| bernstein(number) > rounding) || (0..=degree).all(|number| bernstein(number) < -rounding)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_roots_of_a_cubic_are_found(
            a in 0.01..0.3_f64, b in 0.35..0.6_f64, c in 0.65..0.99_f64, scale in -5.0..5.0_f64,
        ) {
            prop_assume!(scale.abs() > 0.1);
            let cubic = [-a * b * c, a * b + b * c + c * a, -(a + b + c), 1.0].map(|x| scale * x);
            let found = roots(&cubic);
            prop_assert_eq!(found.len(), 3);
            for (root, expected) in found.iter().zip([a, b, c]) {
                prop_assert!((root - expected).abs() < 1e-12);
            }
        }
    }

    proptest! {
        #[test]
        fn what_keeps_its_sign_has_no_root(coefficients in prop::collection::vec(-1.0..1.0_f64, 1..5), raise in 0.0..3.0_f64) {
            let mut raised = coefficients.clone();
            raised[0] += raise;
            let value = |t: f64| raised.iter().rev().fold(0.0, |sum, c| sum * t + c);
            let values = (0..=1000).map(|i| value(f64::from(i) * 1e-3));
            let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [v.min(low), v.max(high)]);
            prop_assert!(!keeps_sign(&raised) || low > 0.0 || high < 0.0, "{raised:?}");
            // It is worth something: polynomials far above zero are told.
            prop_assert!(keeps_sign(&raised) || low < 8.0);
            prop_assert!(keeps_sign(&[4.0, -1.0, 1.0, -1.0]) && keeps_sign(&[-4.0, 3.0]) && !keeps_sign(&[-1.0, 3.0]));
        }
    }

    #[test]
    fn roots_outside_and_roots_without_a_change_of_sign_are_none() {
        assert!(roots(&[2.0, -1.0]).is_empty());
        assert!(roots(&[0.25, -1.0, 1.0]).is_empty());
        assert!(roots(&[1.0]).is_empty());
    }
}
