//! What is opened, and how it is shown first.

use clap::Args;
use umbrage_cli::camera::{CameraArgs, SizeArgs};
use umbrage_cli::look::{LookArgs, Unit};
use umbrage_cli::shown::Colors;
use umbrage_formats::BakedFile;

use crate::draw::{FrameLook, Show};
use crate::load::Job;

/// Which lines are drawn over the surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Args)]
#[command(next_help_heading = "Lines")]
pub struct LineArgs {
    /// Draw the edges of the triangles
    #[arg(long)]
    pub wireframe: bool,
    /// Draw the d-segments (shadow edges) of a scene that is baked here: contacts and hard edges red, D1 orange, D2
    /// blue
    #[arg(long)]
    pub segments: bool,
    /// Draw the patches of a scene that is baked here, after so many splits of each face: 0 draws the faces
    #[arg(long, value_name = "LEVEL")]
    pub patches: Option<usize>,
}

impl LineArgs {
    /// Whether there are lines that only a bake knows.
    pub(crate) fn needs_bake(&self) -> bool {
        self.segments || self.patches.is_some()
    }
}

/// What is opened, and how it is shown first.
#[derive(Clone, Debug)]
pub struct ViewOptions {
    /// The file.
    pub job: Job,
    /// Size of the picture, or of the window.
    pub size: SizeArgs,
    /// From where.
    pub camera: CameraArgs,
    /// What becomes of light.
    pub look: LookArgs,
    /// Lines over it.
    pub lines: LineArgs,
}

/// The scale of false colours: its unit, and where it ends in it.
pub(crate) fn first_scale(look: &LookArgs, file: &BakedFile) -> (Unit, f64) {
    let unit = look.false_color.unwrap_or(Unit::W).in_file(file);
    (unit, look.scale_end.unwrap_or_else(|| unit.scale_end(file)))
}

/// What is shown of a file first.
pub(crate) fn first_look(look: &LookArgs, lines: LineArgs, file: &BakedFile) -> FrameLook {
    let (unit, end) = first_scale(look, file);
    FrameLook {
        show: match look.colors() {
            Colors::Seen => Show::Surfaces,
            Colors::Light => Show::Light,
            Colors::Irradiance => Show::Irradiance,
        },
        exposure: look.brighter(file) as f32,
        tone: look.tone(),
        scale_end: (end / unit.per_file_unit()) as f32,
        wire: lines.wireframe,
    }
}
