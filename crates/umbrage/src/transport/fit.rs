//! The best linear function over a patch: what links carry, and what patches receive and send.
//!
//! A constant over a large patch is wrong in the same direction for all that lies on one side of it: near an edge of a
//! room the sum would err by a tenth, and light would get lost. A linear function errs by the curvature only.

use serde::{Deserialize, Serialize};
use std::ops::{Add, Mul, Sub};

use glam::{DMat2, DVec2};

/// A linear function over a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Linear<V> {
    /// At the centroid, which is the mean.
    pub mean: V,
    /// Change along the axes of the face's frame, per metre.
    pub gradient: [V; 2],
}

impl<V: Copy + Default + Add<Output = V> + Mul<f64, Output = V>> Linear<V> {
    /// The least squares fit to offsets from the centroid in metres, weights that sum to 1, and values.
    pub fn fit(values: impl Iterator<Item = (DVec2, f64, V)>) -> Self {
        let (mut mean, mut moment, mut spread) = (V::default(), [V::default(); 2], DMat2::ZERO);
        for (offset_m, weight, value) in values {
            mean = mean + value * weight;
            moment = [moment[0] + value * (weight * offset_m.x), moment[1] + value * (weight * offset_m.y)];
            spread += weight * DMat2::from_cols(offset_m * offset_m.x, offset_m * offset_m.y);
        }
        let inverse = spread.inverse();
        let gradient = if spread.determinant() > 0.0 && inverse.is_finite() {
            let row = |i: usize| moment[0] * inverse.col(0)[i] + moment[1] * inverse.col(1)[i];
            [row(0), row(1)]
        } else {
            [V::default(); 2]
        };
        Self { mean, gradient }
    }

    /// The value at an offset from the centroid.
    pub fn at(&self, offset_m: DVec2) -> V {
        self.mean + self.gradient[0] * offset_m.x + self.gradient[1] * offset_m.y
    }
}

impl<V: Add<Output = V>> Add for Linear<V> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let ([g, h], [other_g, other_h]) = (self.gradient, other.gradient);
        Self { mean: self.mean + other.mean, gradient: [g + other_g, h + other_h] }
    }
}

impl<V: Sub<Output = V>> Sub for Linear<V> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        let ([g, h], [other_g, other_h]) = (self.gradient, other.gradient);
        Self { mean: self.mean - other.mean, gradient: [g - other_g, h - other_h] }
    }
}

impl<V: Mul<f64, Output = V>> Mul<f64> for Linear<V> {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { mean: self.mean * factor, gradient: self.gradient.map(|slope| slope * factor) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_function_is_found_again() {
        let truth = Linear { mean: 3.0, gradient: [2.0, -1.0] };
        let corners = [(-1.0, -0.5), (1.0, -0.5), (1.0, 0.5), (-1.0, 0.5)].map(DVec2::from);
        let fit = Linear::fit(corners.into_iter().map(|offset| (offset, 0.25, truth.at(offset))));
        assert!((fit.mean - 3.0).abs() < 1e-14);
        assert!((fit.gradient[0] - 2.0).abs() < 1e-14 && (fit.gradient[1] + 1.0).abs() < 1e-14);
    }

    #[test]
    fn points_in_a_row_have_no_gradient() {
        let fit = Linear::fit([(DVec2::ZERO, 0.5, 1.0), (DVec2::X, 0.5, 2.0)].into_iter());
        assert_eq!(fit, Linear { mean: 1.5, gradient: [0.0; 2] });
    }
}
