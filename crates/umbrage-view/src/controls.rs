//! What can be set in the panel.

use umbrage_cli::look::{LookArgs, Unit};
use umbrage_formats::BakedFile;
use umbrage_picture::Tone;

use crate::draw::{FrameLook, Show};
use crate::options::{LineArgs, first_look};

/// The state of the panel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Controls {
    /// What becomes of light, but for where the scale ends.
    pub(crate) look: FrameLook,
    /// Unit of irradiance.
    pub(crate) unit: Unit,
    /// Where the scale of false colours ends, in the file's unit; nothing: a round number above nearly all of the
    /// scene.
    pub(crate) scale_end: Option<f64>,
    /// Degrees of the d-segments that are drawn.
    pub(crate) degrees: [bool; 3],
    /// Whether patches are drawn.
    pub(crate) patches: bool,
    /// After how many splits.
    pub(crate) level: usize,
    /// Whether a drag turns around the scene, or the head.
    pub(crate) around: bool,
    /// Whether the panel is seen.
    pub(crate) open: bool,
}

impl Controls {
    /// As the options say.
    pub(crate) fn new(look: &LookArgs, lines: LineArgs) -> Self {
        let unit = look.false_color.unwrap_or(Unit::W);
        Self {
            look: FrameLook { show: Show::Surfaces, exposure: 1.0, tone: Tone::Off, scale_end: 1.0, wire: false },
            unit,
            scale_end: look.scale_end.map(|end| end / unit.per_file_unit()),
            degrees: [lines.segments; 3],
            patches: lines.patches.is_some(),
            level: lines.patches.unwrap_or(1),
            around: true,
            open: true,
        }
    }

    /// Takes over what the options say of a file that is opened for the first time.
    pub(crate) fn show_first(&mut self, look: &LookArgs, lines: LineArgs, file: &BakedFile) {
        self.unit = self.unit.in_file(file);
        self.look = first_look(look, lines, file);
    }

    /// Where the scale of false colours ends, in the unit that is chosen.
    pub(crate) fn scale_end(&self, file: &BakedFile) -> f64 {
        match self.scale_end {
            Some(end) => end * self.unit.per_file_unit(),
            None => self.unit.scale_end(file),
        }
    }

    /// What a frame of a file looks like.
    pub(crate) fn frame_look(&self, file: &BakedFile) -> FrameLook {
        FrameLook { scale_end: (self.scale_end(file) / self.unit.per_file_unit()) as f32, ..self.look }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::layout::tests::{shown, square};

    #[derive(Debug, Parser)]
    struct Args {
        #[command(flatten)]
        look: LookArgs,
        #[command(flatten)]
        lines: LineArgs,
    }

    fn controls(line: &str) -> (Controls, FrameLook) {
        let args = Args::parse_from(line.split(' '));
        let shown = shown(vec![square(0.0, 3.0)]);
        let mut controls = Controls::new(&args.look, args.lines);
        controls.show_first(&args.look, args.lines, &shown.file);
        let look = controls.frame_look(&shown.file);
        (controls, look)
    }

    #[test]
    fn options_become_what_is_shown_first() {
        let (plain, look) = controls("view");
        assert_eq!((look.show, look.exposure, look.tone, look.wire), (Show::Surfaces, 1.0, Tone::Off, false));
        assert!(plain.degrees == [false; 3] && !plain.patches);
        let (lines, look) = controls("view --wireframe --segments --patches 4 --tone filmic --brighter 2");
        assert_eq!((lines.degrees, lines.patches, lines.level), ([true; 3], true, 4));
        assert_eq!((look.tone, look.exposure, look.wire), (Tone::Filmic, 2.0, true));
    }

    #[test]
    fn a_scale_ends_at_a_round_number_of_its_unit_or_where_it_is_told() {
        // All of the square has 3 W/m2, which are 2049 lx.
        let (mut controls, look) = controls("view --false-color");
        assert_eq!((look.show, look.scale_end), (Show::Irradiance, 5.0));
        let shown = shown(vec![square(0.0, 3.0)]);
        controls.unit = Unit::Lx;
        assert_eq!(controls.scale_end(&shown.file), 5000.0);
        controls.scale_end = Some(2.0);
        assert_eq!(controls.scale_end(&shown.file), 1366.0);
        assert_eq!(controls.frame_look(&shown.file).scale_end, 2.0);
    }
}
