//! Roots of short polynomials between 0 and 1.
//!
//! The roots of the derivative divide the interval into parts on which the polynomial is monotone; each part whose ends
//! differ in sign holds one root, which bisection finds to the last bit. Roots without a change of sign are none:
//! nothing begins or ends there.

use smallvec::SmallVec;

/// Halvings that take an interval of length 1 to rounding.
const HALVINGS: usize = 54;

/// The roots between 0 and 1 at which a polynomial with these coefficients, of ascending powers, changes sign;
/// ascending.
pub(super) fn roots(coefficients: &[f64]) -> SmallVec<[f64; 4]> {
    let value = |t: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * t + c);
    let mut ends: SmallVec<[f64; 6]> = SmallVec::from_slice(&[0.0]);
    if coefficients.len() > 2 {
        let derivative: SmallVec<[f64; 4]> =
            coefficients.iter().enumerate().skip(1).map(|(power, c)| power as f64 * c).collect();
        ends.extend(roots(&derivative));
    }
    ends.push(1.0);
    let root = |pair: &[f64]| {
        let (mut from, mut to) = (pair[0], pair[1]);
        let rises = value(to) > 0.0;
        if value(from) * value(to) >= 0.0 {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (from + to);
            if (value(middle) > 0.0) == rises { to = middle } else { from = middle }
        }
        Some(0.5 * (from + to))
    };
    ends.windows(2).filter_map(root).collect()
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

    #[test]
    fn roots_outside_and_roots_without_a_change_of_sign_are_none() {
        assert!(roots(&[2.0, -1.0]).is_empty());
        assert!(roots(&[0.25, -1.0, 1.0]).is_empty());
        assert!(roots(&[1.0]).is_empty());
    }
}
