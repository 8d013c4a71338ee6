//! The options that say how a bake is done, and the settings that they mean.

use std::fmt;
use std::str::FromStr;

use clap::Args;
use serde_json::Map;
use umbrage::bake::{BakeSettings, GatherKind, Report};
use umbrage::mesh::SplitScore;
use umbrage::prepare::PrepareSettings;
use umbrage::shade::ShadeSettings;
use umbrage::transport::OracleKind;
use umbrage_formats::BakeFacts;

/// How the mesh is refined.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Method")]
pub struct MethodArgs {
    /// `umbrage` refines what is shown until the light is as exact as --tolerance asks; `paper` is the algorithm as the paper
    /// prints it: patches split by Fmax alone, cuts by Eq. (1), D0 hints removed at the end, and the triangles of that shown
    #[arg(long, value_name = "METHOD", default_value_t)]
    method: Method,
    /// Refine triangles until the light between vertices errs by this share of the mean light; `none`: not at all [default:
    /// 0.01; in scenes of more than 5,000 polygons more, in proportion, up to 0.05]
    #[arg(long, value_name = "T", value_parser = tolerance, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Make no more triangles than N, where they lessen the error most; refused where the shapes alone need more [default: as
    /// many as the tolerance needs]
    #[arg(long, value_name = "N", value_parser = at_least_one, allow_negative_numbers = true)]
    max_triangles: Option<usize>,
    /// Split patches until the share of one's light that reaches another is less than this: a smaller F makes reflected
    /// light more exact [default: 0.04 at the default tolerance, less for a smaller one]
    #[arg(long, value_name = "F", value_parser = share, allow_negative_numbers = true)]
    max_form_factor: Option<f64>,
    /// Never split patches smaller than this, in square metres [default: from the size of the scene and the tolerance]
    #[arg(long, value_name = "A", value_parser = positive, allow_negative_numbers = true)]
    min_area: Option<f64>,
    /// What decides that: `brightness` weighs the share by how bright, reflecting, large and hidden the patches are;
    /// `form-factor` is the share alone, as in the paper: patches are then linked in scenes of thousands of faces, too, which
    /// takes long [default: brightness]
    #[arg(long, value_name = "ORACLE")]
    oracle: Option<OracleKind>,
    /// How reflected light is gathered: `faces` looks at every face from every point, exactly, `regression` fits it to samples
    /// along rays, `fastest` takes what is expected to be faster [default: fastest]
    #[arg(long, value_name = "GATHER")]
    gather: Option<GatherKind>,
    /// What makes a good cut of a patch: `eq1` is Eq. (1) of the paper as printed, `well-shaped` also shuns slivers
    /// [default: well-shaped]
    #[arg(long, value_name = "SCORE")]
    score: Option<SplitScore>,
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
        self.tolerance.is_some() || self.method == Method::Paper
    }

    /// The settings that these options mean for a scene of so many polygons.
    ///
    /// # Errors
    /// [`Conflict`] where the paper's method is asked for, and what is not in it.
    pub fn settings(&self, polygons: usize) -> Result<BakeSettings, Conflict> {
        match self.method {
            Method::Umbrage => Ok(self.refined(polygons)),
            Method::Paper => self.as_in_paper(),
        }
    }

    fn as_in_paper(&self) -> Result<BakeSettings, Conflict> {
        let refines = self.tolerance.is_some_and(f64::is_finite);
        let not_in_it = [
            (refines, "--tolerance", "it refines nothing after the patches are linked"),
            (
                self.max_triangles.is_some(),
                "--max-triangles",
                "Fmax alone says how many triangles there are: use --max-form-factor",
            ),
            (self.oracle == Some(OracleKind::Brightness), "--oracle brightness", "it looks at form factors alone"),
            (self.score == Some(SplitScore::WellShaped), "--score well-shaped", "it cuts by Eq. (1)"),
            (self.no_discontinuities, "--no-discontinuities", "it cuts along the edges of shadows"),
        ];
        if let Some(&(_, option, because)) = not_in_it.iter().find(|(is_asked, ..)| *is_asked) {
            return Err(Conflict { option, because });
        }
        let paper = BakeSettings::as_in_paper();
        Ok(BakeSettings {
            max_form_factor: self.max_form_factor,
            min_area_m2: self.min_area,
            prepare: PrepareSettings {
                cut_contacts: !self.no_intersect,
                smooth: !self.flat_shading,
                keep_hidden: self.keep_hidden,
            },
            ..paper
        })
    }

    fn refined(&self, polygons: usize) -> BakeSettings {
        let default = BakeSettings::default();
        let max_triangles = self.max_triangles.unwrap_or(default.shade.max_triangles);
        BakeSettings {
            max_form_factor: self.max_form_factor,
            min_area_m2: self.min_area.or(default.min_area_m2),
            oracle: self.oracle.unwrap_or_default(),
            score: self.score.unwrap_or_default(),
            gather: self.gather.unwrap_or_default(),
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

/// Which algorithm bakes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Refined until light is shown as exactly as is asked.
    #[default]
    Umbrage,
    /// As the paper prints it.
    Paper,
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Umbrage => "umbrage",
            Self::Paper => "paper",
        })
    }
}

impl FromStr for Method {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let all = [Self::Umbrage, Self::Paper];
        all.into_iter().find(|method| method.to_string() == name).ok_or_else(|| "is umbrage or paper".into())
    }
}

/// An option was given that the paper's method has no use for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("--method paper and {option} do not go together: {because}. Leave one of them out")]
pub struct Conflict {
    option: &'static str,
    because: &'static str,
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

/// A whole number above 0.
fn at_least_one(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) => Err("must be at least 1".into()),
        Ok(n) => Ok(n),
        Err(_) => Err("is not a whole number".into()),
    }
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

/// No light errs by more than so many times the mean between vertices, and none can be resolved better than rounding allows.
const TOLERANCES: [f64; 2] = [1e-9, 100.0];

/// A share of the mean light, or `none` for infinity.
fn tolerance(text: &str) -> Result<f64, String> {
    if text == "none" {
        return Ok(f64::INFINITY);
    }
    let [least, most] = TOLERANCES;
    let tolerance =
        number(text).map_err(|what| format!("{what}: give a share of the mean light such as 0.01, or none"))?;
    if (least..=most).contains(&tolerance) {
        Ok(tolerance)
    } else {
        Err(format!("must be between {least:e} and {most}, as a share of the mean light, or none"))
    }
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
        assert_eq!(format!("{:?}", method.settings(5_000).unwrap()), format!("{:?}", BakeSettings::default()));
        let tolerances = [10_497, 35_458, 99_407].map(|polygons| method.settings(polygons).unwrap().shade.tolerance);
        assert_eq!(tolerances, [0.021, 0.05, 0.05]);
        let asked = Command::parse_from(["bake", "--tolerance", "0.02"]).method.settings(99_407).unwrap();
        assert_eq!(asked.shade.tolerance, 0.02);
    }

    #[test]
    fn tolerances_that_mean_nothing_are_refused_in_words() {
        let parse =
            |t: &str| Command::try_parse_from(["bake", "--tolerance", t]).map(|_| ()).map_err(|e| e.to_string());
        for t in ["0.01", "none", "1e-9", "16"] {
            assert_eq!(parse(t), Ok(()), "{t}");
        }
        for t in ["-1", "0", "1e308", "101", "1e-12", "nan", "inf"] {
            let told = parse(t).unwrap_err();
            assert!(told.contains("share of the mean light") && told.contains("none"), "{t}: {told}");
        }
    }

    #[test]
    fn no_triangles_are_refused() {
        let parse = |n: &str| Command::try_parse_from(["bake", "--max-triangles", n]);
        assert!(parse("1").is_ok());
        let refused = parse("0").unwrap_err().to_string();
        assert!(refused.contains("must be at least 1"), "{refused}");
    }

    #[test]
    fn the_paper_alone_is_the_paper_and_what_is_not_in_it_is_refused() {
        let settings = |line: &str| {
            Command::parse_from(format!("bake --method paper {line}").trim().split(' ')).method.settings(1)
        };
        assert_eq!(settings(""), Ok(BakeSettings::as_in_paper()));
        assert_eq!(settings("--tolerance none --oracle form-factor --score eq1"), Ok(BakeSettings::as_in_paper()));
        assert_eq!(settings("--max-form-factor 0.1").map(|settings| settings.fmax()), Ok(0.1));
        for option in [
            "--tolerance 0.1",
            "--max-triangles 9",
            "--oracle brightness",
            "--score well-shaped",
            "--no-discontinuities",
        ] {
            let told = settings(option).unwrap_err().to_string();
            let named = option.trim_end_matches(|c: char| !c.is_ascii_alphabetic()).trim();
            assert!(told.starts_with(&format!("--method paper and {named}")), "{told}");
        }
    }

    #[test]
    fn options_become_settings() {
        let coarse =
            Command::parse_from(["bake", "--tolerance", "none", "--max-triangles", "900"]).method.settings(1).unwrap();
        assert_eq!(coarse.shade, ShadeSettings { tolerance: f64::INFINITY, max_triangles: 900 });
        let line = "bake --max-form-factor 0.5 --min-area 2 --oracle form-factor --score eq1 --no-discontinuities --keep-bad-shapes";
        let settings = Command::parse_from(line.split(' ')).method.settings(1).unwrap();
        assert_eq!(
            (settings.max_form_factor, settings.min_area_m2, settings.oracle, settings.score),
            (Some(0.5), Some(2.0), OracleKind::FormFactor, SplitScore::Eq1)
        );
        assert!(!settings.discontinuities && !settings.prepare.cut_contacts && !settings.mend_bad_shapes);
        let settings = Command::parse_from(["bake", "--no-intersect", "--flat-shading"]).method.settings(1).unwrap();
        assert_eq!(settings.oracle, OracleKind::default());
        assert!(settings.discontinuities && !settings.prepare.cut_contacts && !settings.prepare.smooth);
        assert!(!settings.prepare.keep_hidden);
        let settings = Command::parse_from(["bake", "--keep-hidden"]).method.settings(1).unwrap();
        assert!(settings.prepare.keep_hidden);
    }
}
