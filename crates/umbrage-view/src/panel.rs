//! The panel beside the view: all that can be set, and all that is told.

use eframe::egui::{
    Button, CollapsingHeader, Color32, ComboBox, DragValue, Grid, Label, RichText, ScrollArea, Slider, Ui,
};
use umbrage::bake::BakeSettings;
use umbrage_cli::look::Unit;
use umbrage_formats::BakedCamera;
use umbrage_picture::Tone;
use umbrage_picture::color::DEGREES;

use crate::controls::Controls;
use crate::draw::Show;
use crate::facts::{Fact, NOT_IN_FILE, Picked, about};
use crate::load::Loaded;
use crate::marks::{POINTS, TRIANGLE, deepest};
use crate::progress::progress;
use crate::session::Session;

/// Reach of the exposure.
const EXPOSURES: std::ops::RangeInclusive<f32> = 0.016..=64.0;

const KEYS: [[&str; 2]; 8] = [
    ["drag", "turn"],
    ["right drag, Shift+drag", "move sideways"],
    ["wheel, pinch, + -", "nearer, farther"],
    ["W A S D, Q E", "walk, down and up; Shift: faster"],
    ["arrow keys", "turn by 5 degrees"],
    ["click", "tell of the point"],
    ["double click", "turn to it, and around it"],
    ["F, Home, P", "fit; first view; this panel"],
];

/// What a click in the panel asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Wish {
    /// See the whole scene.
    Fit,
    /// See it from where the view began.
    Begin,
    /// See it as a camera of the file does.
    Camera(usize),
    /// Bake with these settings.
    Bake(BakeSettings),
    /// Stop the bake.
    Cancel,
    /// Hide the panel.
    Hide,
    /// Save what is seen.
    SaveView,
    /// Save the baked file.
    SaveBaked,
}

/// What the panel shows, and what of it can be changed.
pub(crate) struct Panel<'a> {
    pub(crate) session: &'a Session,
    pub(crate) controls: &'a mut Controls,
    /// Settings for the next bake.
    pub(crate) settings: &'a mut BakeSettings,
    pub(crate) picked: Option<&'a Picked>,
    /// What was done last.
    pub(crate) status: &'a str,
}

impl Panel<'_> {
    pub(crate) fn show(mut self, ui: &mut Ui) -> Option<Wish> {
        let mut wish = None;
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                if ui.button("Hide (P)").on_hover_text("Hide this panel").clicked() {
                    wish = Some(Wish::Hide);
                }
                ui.add(Label::new(RichText::new(self.session.name()).heading()).truncate());
            });
            if let Some(loading) = &self.session.loading
                && progress(ui, loading)
            {
                wish = Some(Wish::Cancel);
            }
            if let Some(failure) = &self.session.failure {
                ui.add(Label::new(RichText::new(failure).color(Color32::LIGHT_RED)).wrap());
            }
            if let Some(loaded) = &self.session.loaded {
                let asked = self.sections(ui, loaded);
                wish = wish.or(asked);
            }
            CollapsingHeader::new("Mouse and keys").show(ui, |ui| {
                table(ui, "keys", KEYS.iter().map(|[key, what]| [*key, *what]));
            });
            ui.add_space(6.0);
        });
        wish
    }

    fn sections(&mut self, ui: &mut Ui, loaded: &Loaded) -> Option<Wish> {
        for warning in &loaded.warnings {
            ui.add(Label::new(RichText::new(warning).color(Color32::KHAKI)).wrap());
        }
        let wishes = [
            section(ui, "View", |ui| self.view(ui, &loaded.shown.file.cameras)),
            section(ui, "Light", |ui| self.light(ui, loaded)),
            section(ui, "Lines", |ui| self.lines(ui, loaded)),
            section(ui, "Point", |ui| self.point(ui)),
            section(ui, "Bake", |ui| self.bake(ui, loaded)),
        ];
        wishes.into_iter().flatten().next()
    }

    fn view(&mut self, ui: &mut Ui, cameras: &[BakedCamera]) -> Option<Wish> {
        let mut wish = None;
        ui.horizontal(|ui| {
            ui.label("Drag turns");
            ui.radio_value(&mut self.controls.around, true, "the scene");
            ui.radio_value(&mut self.controls.around, false, "the head");
        });
        ui.horizontal_wrapped(|ui| {
            for (text, what, asked) in [
                ("Fit", "See the whole scene (F)", Wish::Fit),
                ("First view", "Go back to where the view began (Home)", Wish::Begin),
                ("Save picture", "Write what is seen as a PNG beside the file", Wish::SaveView),
            ] {
                if ui.button(text).on_hover_text(what).clicked() {
                    wish = Some(asked);
                }
            }
        });
        if !cameras.is_empty() {
            ComboBox::from_id_salt("camera").selected_text("Camera of the file").show_ui(ui, |ui| {
                for (number, camera) in cameras.iter().enumerate() {
                    let name =
                        if camera.name.is_empty() { format!("camera {}", number + 1) } else { camera.name.clone() };
                    if ui.selectable_label(false, name).clicked() {
                        wish = Some(Wish::Camera(number));
                    }
                }
            });
        }
        if !self.status.is_empty() {
            ui.add(Label::new(RichText::new(self.status).weak()).wrap());
        }
        wish
    }

    fn light(&mut self, ui: &mut Ui, loaded: &Loaded) -> Option<Wish> {
        let look = &mut self.controls.look;
        let shows = [
            (Show::Surfaces, "Surfaces"),
            (Show::Light, "Light alone"),
            (Show::Irradiance, "Irradiance in false colours"),
        ];
        for (show, text) in shows {
            ui.radio_value(&mut look.show, show, text);
        }
        if look.show == Show::Irradiance {
            self.scale(ui, loaded);
            return None;
        }
        ui.horizontal(|ui| {
            ui.label("Exposure");
            ui.add(Slider::new(&mut look.exposure, EXPOSURES).logarithmic(true).max_decimals(3).prefix("x "));
            if ui.button("1").on_hover_text("As the file is").clicked() {
                look.exposure = 1.0;
            }
        });
        let mut filmic = look.tone == Tone::Filmic;
        ui.checkbox(&mut filmic, "Film curve").on_hover_text("Softer in the bright, more contrast in the dark");
        look.tone = if filmic { Tone::Filmic } else { Tone::Off };
        None
    }

    fn scale(&mut self, ui: &mut Ui, loaded: &Loaded) {
        let controls = &mut *self.controls;
        ui.horizontal(|ui| {
            if loaded.shown.file.photometric {
                ui.label("lx");
                return;
            }
            for (unit, text, what) in [
                (Unit::W, "W/m²", "As in the file"),
                (Unit::Lx, "lx", "At 683 lm per W: for scenes whose light is in watts"),
                (Unit::Photometric, "lx, photometric", "As in the file, where its light is photometric, as in MGF"),
            ] {
                ui.radio_value(&mut controls.unit, unit, text).on_hover_text(what);
            }
        });
        ui.horizontal(|ui| {
            ui.label("Scale ends at");
            let mut end = controls.scale_end(&loaded.shown.file);
            let speed = 0.01 * end;
            let value = DragValue::new(&mut end).speed(speed).range(1e-6..=1e9).max_decimals(4);
            if ui.add(value).changed() {
                controls.scale_end = Some(end / controls.unit.per_file_unit());
            }
            let auto = ui.add_enabled(controls.scale_end.is_some(), Button::new("round"));
            if auto.on_hover_text("A round number above nearly all of the scene").clicked() {
                controls.scale_end = None;
            }
        });
    }

    fn lines(&mut self, ui: &mut Ui, loaded: &Loaded) -> Option<Wish> {
        let controls = &mut *self.controls;
        ui.checkbox(&mut controls.look.wire, "Triangles");
        let Some(baked) = &loaded.baked else {
            ui.add(Label::new(RichText::new(NOT_IN_FILE).weak()).wrap());
            return None;
        };
        ui.horizontal(|ui| {
            ui.label("Shadow edges");
            for (degree, shown) in controls.degrees.iter_mut().enumerate() {
                let count = baked.report.d_segments[degree];
                ui.checkbox(shown, colored(&format!("D{degree}"), DEGREES[degree]))
                    .on_hover_text(format!("{count} d-segments of degree {degree}"));
            }
        });
        ui.horizontal(|ui| {
            ui.checkbox(&mut controls.patches, "Patches to level");
            let deepest = deepest(&baked.meshed);
            ui.add_enabled(controls.patches, Slider::new(&mut controls.level, 0..=deepest));
        });
        if controls.patches {
            ui.horizontal_wrapped(|ui| {
                ui.label("cut by");
                for (degree, code) in DEGREES.into_iter().enumerate() {
                    ui.label(colored(&format!("D{degree}"), code));
                }
                ui.label(colored("point_split", POINTS));
                ui.label(colored("triangle_split", TRIANGLE));
            });
        }
        None
    }

    fn point(&mut self, ui: &mut Ui) -> Option<Wish> {
        match self.picked {
            Some(picked) => table(ui, "point", picked.facts.iter().map(as_text)),
            None => {
                ui.weak("Click a surface to read the light there.");
            }
        }
        None
    }

    fn bake(&mut self, ui: &mut Ui, loaded: &Loaded) -> Option<Wish> {
        let mut wish = None;
        if loaded.baked.is_some() {
            let settings = &mut *self.settings;
            Grid::new("settings").num_columns(2).show(ui, |ui| {
                ui.label("Tolerance")
                    .on_hover_text("Error of the light between vertices, as a share of the mean light");
                let mut percent = 100.0 * settings.shade.tolerance.min(1.0);
                let told = |percent: f64, _| if percent < 100.0 { format!("{percent:.2} %") } else { "none".into() };
                let field = DragValue::new(&mut percent).speed(0.01).range(0.05..=100.0).custom_formatter(told);
                if ui.add(field).changed() {
                    // 100 % is no refinement at all.
                    settings.shade.tolerance = if percent < 100.0 { 0.01 * percent } else { f64::INFINITY };
                }
                ui.end_row();
                ui.label("Form factor")
                    .on_hover_text("Patches are split until one's light that reaches another is less");
                let mut max_form_factor = settings.fmax();
                let field = DragValue::new(&mut max_form_factor).speed(0.001).range(0.001..=1.0).max_decimals(4);
                if ui.add(field).changed() {
                    settings.max_form_factor = Some(max_form_factor);
                }
                ui.end_row();
            });
            ui.horizontal(|ui| {
                if ui.button("Bake").on_hover_text("Bake again with these settings").clicked() {
                    wish = Some(Wish::Bake(*settings));
                }
                if ui.button("Save baked file").on_hover_text("Write the GLB beside the scene").clicked() {
                    wish = Some(Wish::SaveBaked);
                }
            });
        }
        let facts: Vec<Fact> = about(loaded);
        table(ui, "about", facts.iter().map(as_text));
        wish
    }
}

fn as_text([name, value]: &Fact) -> [&str; 2] {
    [name, value]
}

fn colored(text: &str, [r, g, b]: [u8; 3]) -> RichText {
    RichText::new(text).color(Color32::from_rgb(r, g, b)).strong()
}

fn section(ui: &mut Ui, title: &str, add: impl FnOnce(&mut Ui) -> Option<Wish>) -> Option<Wish> {
    CollapsingHeader::new(RichText::new(title).strong()).default_open(true).show(ui, add).body_returned.flatten()
}

/// Names and values in two columns; long values go on below.
fn table<'a>(ui: &mut Ui, id: &str, rows: impl Iterator<Item = [&'a str; 2]>) {
    let width = ui.available_width();
    Grid::new(id).num_columns(2).min_col_width(0.3 * width).max_col_width(0.66 * width).show(ui, |ui| {
        for [name, value] in rows {
            ui.add(Label::new(RichText::new(name).weak()).wrap());
            ui.add(Label::new(value).wrap());
            ui.end_row();
        }
    });
}
