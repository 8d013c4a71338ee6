//! The options that say what becomes of light in a picture.

use clap::{Args, ValueEnum};
use umbrage_formats::BakedFile;
use umbrage_picture::{Scale, Tone, color, nice_ceiling};

use crate::method::positive;
use crate::shown::Colors;

/// What becomes of the light.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Light")]
pub struct LookArgs {
    /// Colours are K times E/pi, as for `umbrage bake --exposure`: a greater K is brighter [default: that of the file, which its bake
    /// told]
    #[arg(long, value_name = "K", value_parser = positive, allow_negative_numbers = true)]
    exposure: Option<f64>,
    /// Make the picture this many times brighter than the file was baked to be
    #[arg(long, value_name = "TIMES", value_parser = positive, conflicts_with = "exposure", default_value_t = 1.0)]
    brighter: f64,
    /// What becomes of light that is too bright for a screen
    #[arg(long, value_name = "TONE", default_value = "off")]
    tone: ToneArg,
    /// Draw the light alone, as if all surfaces were white
    #[arg(long)]
    light_only: bool,
    /// Draw the irradiance in false colours, with a legend, in this unit [default without UNIT: w]
    #[arg(long, value_name = "UNIT", num_args = 0..=1, default_missing_value = "w",
        conflicts_with_all = ["light_only", "exposure", "brighter", "tone"])]
    pub false_color: Option<Unit>,
    /// Where the scale of --false-color ends, in its unit [default: a round number above nearly all of the scene]
    #[arg(long, value_name = "E", value_parser = positive, requires = "false_color")]
    pub scale_end: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ToneArg {
    /// It is cut off, as in every glTF viewer
    Off,
    /// It goes through the curve of a film: softer in the bright, more contrast in the dark
    Filmic,
}

/// Units of irradiance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Unit {
    /// W/m2, as in the file; lx where the file is photometric
    W,
    /// lx: at 683 lm per W where the file is in watts, as it is where the file is photometric
    Lx,
    /// lx, as in the file: for photometric files that do not say that they are
    Photometric,
}

impl LookArgs {
    /// How many times brighter a file is shown than it was baked to be.
    pub fn brighter(&self, file: &BakedFile) -> f64 {
        self.exposure.map_or(self.brighter, |k| k / file.exposure_k)
    }

    /// The tone curve.
    pub fn tone(&self) -> Tone {
        match self.tone {
            ToneArg::Off => Tone::Off,
            ToneArg::Filmic => Tone::Filmic,
        }
    }

    /// What the colours of the picture are.
    pub fn colors(&self) -> Colors {
        match (self.false_color, self.light_only) {
            (Some(_), _) => Colors::Irradiance,
            (None, true) => Colors::Light,
            (None, false) => Colors::Seen,
        }
    }
}

impl Unit {
    /// This unit where a file's irradiance is in watts; as the file has it where that is in lux.
    pub fn in_file(self, file: &BakedFile) -> Self {
        if file.photometric { Self::Photometric } else { self }
    }

    /// What it is called in a legend.
    pub fn name(self) -> &'static str {
        if self == Self::W { "W/m2" } else { "lx" }
    }

    /// How many of it are 1 in the file.
    pub fn per_file_unit(self) -> f64 {
        if self == Self::Lx { color::LUMENS_PER_WATT } else { 1.0 }
    }

    /// The scale of false colours that ends at `end`, in this unit.
    pub fn scale(self, end: f64) -> Scale {
        Scale { begin: 0.0, end, unit: self.name(), stops: &color::SEQUENTIAL }
    }

    /// A round number, in this unit, that nearly all of the irradiance in a file is below.
    pub fn scale_end(self, file: &BakedFile) -> f64 {
        nice_ceiling(
            self.per_file_unit() * file.irradiance_quantile(color::SHARE_WITHIN_SCALE, color::LUMINANCE_WEIGHTS),
        )
    }
}
