//! The options that say how a bake is done, and the settings that they mean.

use clap::Args;
use umbrage::bake::BakeSettings;
use umbrage::mesh::SplitScore;

/// How the mesh is refined.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct MethodArgs {
    /// Split patches until the light that one sends to another is less than this share of it [default: 0.05]; a smaller F
    /// makes a finer mesh
    #[arg(long, value_name = "F", value_parser = share)]
    max_form_factor: Option<f64>,
    /// Never split patches smaller than this, in square metres [default: from the size of the scene]
    #[arg(long, value_name = "A", value_parser = positive)]
    min_area: Option<f64>,
    /// What makes a good cut of a patch: `eq1` is Eq. (1) of the paper as printed, `well-shaped` also shuns slivers
    #[arg(long, value_name = "SCORE", default_value_t)]
    score: SplitScore,
    /// Do not cut along the edges of shadows: for comparison only
    #[arg(long)]
    no_discontinuities: bool,
}

impl MethodArgs {
    /// The settings that these options mean.
    pub(crate) fn settings(&self) -> BakeSettings {
        let default = BakeSettings::default();
        BakeSettings {
            max_form_factor: self.max_form_factor.unwrap_or(default.max_form_factor),
            min_area_m2: self.min_area.or(default.min_area_m2),
            score: self.score,
            discontinuities: !self.no_discontinuities,
            ..default
        }
    }
}

/// A number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    number(text).and_then(|x| if x > 0.0 { Ok(x) } else { Err("must be more than 0".into()) })
}

/// A number above 0 and at most 1.
pub(crate) fn share(text: &str) -> Result<f64, String> {
    positive(text).and_then(|x| if x <= 1.0 { Ok(x) } else { Err("must be at most 1".into()) })
}

/// A finite number.
pub(crate) fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err("is not a number".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_checked() {
        assert_eq!(positive("0.25"), Ok(0.25));
        assert_eq!(share("1"), Ok(1.0));
        assert!(positive("0").is_err() && positive("-1").is_err() && positive("nan").is_err() && share("1.5").is_err());
    }

    #[test]
    fn no_option_means_the_default() {
        assert_eq!(format!("{:?}", MethodArgs::default().settings()), format!("{:?}", BakeSettings::default()));
    }
}
