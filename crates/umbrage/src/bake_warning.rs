//! Warnings about the result of a bake: it is written, and something in it is not as good as it should be.
//!
//! They come from the figures of the report alone. Each says the figure, its meaning, and a way out.

use std::fmt;

use crate::shade::ShadeSettings;
use crate::solve::EnergyAccount;

/// An account of energy that is off by more than this share of the emitted light cannot be true. Sound bakes are within 0.002.
pub const MAX_ENERGY_ERROR: f64 = 0.05;
/// An estimated error of interpolation above this share of the mean irradiance says no more than that the light was not resolved.
pub const MAX_ERROR_ESTIMATE: f64 = 1.0;
/// A solution with a greater residual has not converged: with surfaces that reflect 0.9 up to 9 times as much light is missing, which is
/// as much as the default tolerance.
pub const MAX_RESIDUAL: f64 = 1e-3;

/// A defect of the result of a bake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BakeWarning {
    /// The account of energy does not balance ([`MAX_ENERGY_ERROR`]).
    EnergyOutOfBalance {
        /// [`EnergyAccount::error`]: below 0 light is lost.
        error: f64,
    },
    /// The light between vertices is unknown ([`MAX_ERROR_ESTIMATE`]).
    LightNotResolved {
        /// Estimated root mean square error of interpolation over the mean irradiance.
        error: f64,
    },
    /// The tolerance was not reached, though no limit of triangles was given.
    ToleranceNotReached {
        /// Estimated root mean square error of interpolation over the mean irradiance.
        error: f64,
        /// The one that was asked for.
        tolerance: f64,
    },
    /// Reflected light has not converged ([`MAX_RESIDUAL`]).
    NotConverged {
        /// Relative residual of the solution.
        residual: f64,
        /// Iterations that it took.
        iterations: usize,
    },
}

/// The figures of a bake that warnings are about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Figures<'a> {
    pub(crate) energy: &'a EnergyAccount,
    /// Estimated root mean square error of interpolation over the mean irradiance.
    pub(crate) error: f64,
    /// Relative residual of the solution.
    pub(crate) residual: f64,
    /// Iterations that it took.
    pub(crate) iterations: usize,
}

impl BakeWarning {
    /// All warnings about a bake, the gravest first.
    pub(crate) fn about(figures: Figures<'_>, asked: ShadeSettings) -> Vec<Self> {
        let Figures { energy, error, residual, iterations } = figures;
        let mut warnings = Vec::new();
        let imbalance = energy.error();
        // What is no number is no good either.
        let exceeds = |figure: f64, most: f64| figure > most || figure.is_nan();
        if exceeds(imbalance.abs(), MAX_ENERGY_ERROR) {
            warnings.push(Self::EnergyOutOfBalance { error: imbalance });
        }
        let is_limited = asked.max_triangles != ShadeSettings::default().max_triangles;
        if exceeds(error, MAX_ERROR_ESTIMATE) {
            warnings.push(Self::LightNotResolved { error });
        } else if error > asked.tolerance && !is_limited {
            warnings.push(Self::ToleranceNotReached { error, tolerance: asked.tolerance });
        }
        if exceeds(residual, MAX_RESIDUAL) {
            warnings.push(Self::NotConverged { residual, iterations });
        }
        warnings
    }

    /// A short name that stays the same, for programs that read reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::EnergyOutOfBalance { .. } => "energy-out-of-balance",
            Self::LightNotResolved { .. } => "light-not-resolved",
            Self::ToleranceNotReached { .. } => "tolerance-not-reached",
            Self::NotConverged { .. } => "not-converged",
        }
    }
}

impl fmt::Display for BakeWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::EnergyOutOfBalance { error } => {
                let (amount, fate) = (100.0 * error.abs(), if error < 0.0 { "lost" } else { "too much" });
                write!(
                    f,
                    "the account of energy does not balance: {amount:.1} % of the emitted light is {fate}. Do not trust the \
                     light of this bake before `umbrage verify` has checked it; look for lamps that touch surfaces or nearly do"
                )
            }
            Self::LightNotResolved { .. } => write!(
                f,
                "the triangles do not resolve the light: the estimated error between vertices is above the mean irradiance. \
                 Look for lamps that touch surfaces or nearly do"
            ),
            Self::ToleranceNotReached { error, tolerance } => write!(
                f,
                "the tolerance was not reached: the estimated error between vertices is {:.2} % of the mean irradiance, \
                 and {:.2} % was asked for",
                100.0 * error,
                100.0 * tolerance
            ),
            Self::NotConverged { residual, iterations } => write!(
                f,
                "reflected light has not converged: after {iterations} iterations it still changes by {:.2} %. \
                 A lower --max-reflectance makes it converge",
                100.0 * residual
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Rgb;

    fn account(absorbed_w: f64) -> EnergyAccount {
        EnergyAccount { emitted_w: Rgb::ONE, absorbed_w: Rgb::splat(absorbed_w), ..EnergyAccount::default() }
    }

    fn names(absorbed_w: f64, error: f64, residual: f64, asked: ShadeSettings) -> Vec<&'static str> {
        let energy = account(absorbed_w);
        let figures = Figures { energy: &energy, error, residual, iterations: 7 };
        BakeWarning::about(figures, asked).iter().map(BakeWarning::name).collect()
    }

    #[test]
    fn a_sound_bake_has_none() {
        assert!(names(0.96, 0.009, 1e-5, ShadeSettings::default()).is_empty());
        let none = ShadeSettings { tolerance: f64::INFINITY, ..ShadeSettings::default() };
        assert!(names(1.0, 0.9, 0.0, none).is_empty(), "without refinement there is no tolerance to reach");
        let few = ShadeSettings { max_triangles: 9, ..ShadeSettings::default() };
        assert!(names(1.0, 0.5, 0.0, few).is_empty(), "whoever limits triangles knows");
    }

    #[test]
    fn figures_that_cannot_be_true_are_told() {
        let asked = ShadeSettings::default();
        assert_eq!(names(6.0884, 0.0, 0.0, asked), ["energy-out-of-balance"]);
        assert_eq!(names(0.754, 1.9, 0.0, asked), ["energy-out-of-balance", "light-not-resolved"]);
        assert_eq!(names(1.0, 0.07, 2e-3, asked), ["tolerance-not-reached", "not-converged"]);
        assert_eq!(names(1.0, f64::NAN, f64::NAN, asked), ["light-not-resolved", "not-converged"]);
    }

    #[test]
    fn words_have_the_figures() {
        let lost = BakeWarning::EnergyOutOfBalance { error: -0.246 }.to_string();
        assert!(lost.contains("24.6 % of the emitted light is lost"), "{lost}");
        let made = BakeWarning::EnergyOutOfBalance { error: 5.0884 }.to_string();
        assert!(made.contains("508.8 % of the emitted light is too much"), "{made}");
        let coarse = BakeWarning::ToleranceNotReached { error: 0.07, tolerance: 0.01 }.to_string();
        assert!(coarse.contains("is 7.00 %") && coarse.contains("1.00 % was asked for"), "{coarse}");
    }
}
