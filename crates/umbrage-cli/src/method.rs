//! The options that say how a bake is done, and the settings that they mean.

use clap::Args;
use serde_json::Map;
use umbrage::bake::{BakeSettings, Report};
use umbrage::mesh::SplitScore;
use umbrage::prepare::PrepareSettings;
use umbrage::shade::ShadeSettings;
use umbrage::transport::OracleKind;
use umbrage_formats::BakeFacts;

/// How the mesh is refined.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Method")]
pub struct MethodArgs {
    /// Refine triangles until the light between vertices errs by this share of the mean light; `none`: not at all [default:
    /// 0.01; in scenes of more than 5,000 polygons more, in proportion, up to 0.1]
    #[arg(long, value_name = "T", value_parser = tolerance)]
    tolerance: Option<f64>,
    /// Make about so many triangles at most [default: as many as the tolerance needs]
    #[arg(long, value_name = "N")]
    max_triangles: Option<usize>,
    /// Split patches until the share of one's light that reaches another is less than this: a smaller F makes reflected
    /// light more exact [default: 0.04 at the default tolerance, less for a smaller one]
    #[arg(long, value_name = "F", value_parser = share)]
    max_form_factor: Option<f64>,
    /// Never split patches smaller than this, in square metres [default: from the size of the scene and the tolerance]
    #[arg(long, value_name = "A", value_parser = positive)]
    min_area: Option<f64>,
    /// What decides that: `brightness` weighs the share by how bright, reflecting, large and hidden the patches are;
    /// `form-factor` is the share alone, as in the paper
    #[arg(long, value_name = "ORACLE", default_value_t)]
    oracle: OracleKind,
    /// What makes a good cut of a patch: `eq1` is Eq. (1) of the paper as printed, `well-shaped` also shuns slivers
    #[arg(long, value_name = "SCORE", default_value_t)]
    score: SplitScore,
    /// Cut neither along the edges of shadows nor where surfaces touch: for comparison only
    #[arg(long)]
    no_discontinuities: bool,
    /// Do not cut surfaces where others touch or cross them: faster for scenes of many parts that overlap, but light
    /// leaks along these lines
    #[arg(long)]
    no_intersect: bool,
    /// Show every face flat, also those that stand for a curved surface by the normals of their corners: the irradiance
    /// is then that of the facets
    #[arg(long)]
    flat_shading: bool,
    /// Do not put point split-hints into badly shaped patches: for comparison only
    #[arg(long)]
    keep_bad_shapes: bool,
    /// Keep hidden sides, which no light reaches and nobody can see: the inside of closed boxes, what lies face to face.
    /// They take triangles, and are black
    #[arg(long)]
    keep_hidden: bool,
}

impl MethodArgs {
    /// Whether they say a tolerance.
    pub fn has_tolerance(&self) -> bool {
        self.tolerance.is_some()
    }

    /// The settings that these options mean for a scene of so many polygons.
    pub fn settings(&self, polygons: usize) -> BakeSettings {
        let default = BakeSettings::default();
        let max_triangles = self.max_triangles.unwrap_or(default.shade.max_triangles);
        BakeSettings {
            max_form_factor: self.max_form_factor,
            min_area_m2: self.min_area.or(default.min_area_m2),
            oracle: self.oracle,
            score: self.score,
            mend_bad_shapes: !self.keep_bad_shapes,
            prepare: PrepareSettings {
                cut_contacts: !(self.no_intersect || self.no_discontinuities),
                smooth: !self.flat_shading,
                keep_hidden: self.keep_hidden,
            },
            discontinuities: !self.no_discontinuities,
            shade: ShadeSettings {
                tolerance: self.tolerance.unwrap_or_else(|| ShadeSettings::default_tolerance(polygons)),
                max_triangles,
            },
            ..default
        }
    }
}

/// What a baked file says of how it was made.
pub fn facts(settings: &BakeSettings, report: &Report, exposure: Option<f64>) -> BakeFacts {
    let mut extras = Map::new();
    extras.insert("max_form_factor".into(), settings.fmax().into());
    extras.insert("min_area_m2".into(), settings.min_area_m2.into());
    // JSON has no infinity: null is no refinement.
    let tolerance = Some(settings.shade.tolerance).filter(|tolerance| tolerance.is_finite());
    extras.insert("tolerance".into(), tolerance.into());
    extras.insert("oracle".into(), settings.oracle.to_string().into());
    extras.insert("score".into(), settings.score.to_string().into());
    extras.insert("mend_bad_shapes".into(), settings.mend_bad_shapes.into());
    extras.insert("discontinuities".into(), settings.discontinuities.into());
    extras.insert("error".into(), report.error.into());
    BakeFacts { exposure, residual: report.residual, extras }
}

/// A number above 0.
///
/// # Errors
/// What is wrong with the text.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text).and_then(|x| if x > 0.0 { Ok(x) } else { Err("must be more than 0".into()) })
}

/// A number above 0 and at most 1.
///
/// # Errors
/// What is wrong with the text.
pub fn share(text: &str) -> Result<f64, String> {
    positive(text).and_then(|x| if x <= 1.0 { Ok(x) } else { Err("must be at most 1".into()) })
}

/// A number above 0, or `none` for infinity.
fn tolerance(text: &str) -> Result<f64, String> {
    if text == "none" { Ok(f64::INFINITY) } else { positive(text) }
}

/// A finite number.
///
/// # Errors
/// What is wrong with the text.
pub fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err("is not a number".into()),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[test]
    fn numbers_are_checked() {
        assert_eq!(positive("0.25"), Ok(0.25));
        assert_eq!(share("1"), Ok(1.0));
        assert!(positive("0").is_err() && positive("-1").is_err() && positive("nan").is_err() && share("1.5").is_err());
    }

    #[derive(Debug, clap::Parser)]
    struct Command {
        #[command(flatten)]
        method: MethodArgs,
    }

    #[test]
    fn no_option_means_the_default() {
        let method = Command::parse_from(["bake"]).method;
        assert_eq!(format!("{:?}", method.settings(5_000)), format!("{:?}", BakeSettings::default()));
        let tolerances = [10_497, 35_458, 99_407].map(|polygons| method.settings(polygons).shade.tolerance);
        assert_eq!(tolerances, [0.021, 0.071, 0.1]);
        let asked = Command::parse_from(["bake", "--tolerance", "0.02"]).method.settings(99_407);
        assert_eq!(asked.shade.tolerance, 0.02);
    }

    #[test]
    fn options_become_settings() {
        let coarse = Command::parse_from(["bake", "--tolerance", "none", "--max-triangles", "900"]).method.settings(1);
        assert_eq!(coarse.shade, ShadeSettings { tolerance: f64::INFINITY, max_triangles: 900 });
        let line = "bake --max-form-factor 0.5 --min-area 2 --oracle form-factor --score eq1 --no-discontinuities --keep-bad-shapes";
        let settings = Command::parse_from(line.split(' ')).method.settings(1);
        assert_eq!(
            (settings.max_form_factor, settings.min_area_m2, settings.oracle, settings.score),
            (Some(0.5), Some(2.0), OracleKind::FormFactor, SplitScore::Eq1)
        );
        assert!(!settings.discontinuities && !settings.prepare.cut_contacts && !settings.mend_bad_shapes);
        let settings = Command::parse_from(["bake", "--no-intersect", "--flat-shading"]).method.settings(1);
        assert_eq!(settings.oracle, OracleKind::default());
        assert!(!settings.prepare.keep_hidden);
        let settings = Command::parse_from(["bake", "--keep-hidden"]).method.settings(1);
        assert!(settings.prepare.keep_hidden);
        assert!(settings.discontinuities && !settings.prepare.cut_contacts && !settings.prepare.smooth);
    }
}
