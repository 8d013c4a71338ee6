//! The window: the view of the scene, the panel beside it, and what one asks of the other.

mod deeds;

use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context as _, anyhow};
use eframe::egui::{
    self, CentralPanel, Color32, Context, Frame as EguiFrame, Margin, Rect, Sense, SidePanel, Ui, pos2, vec2,
};
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use eframe::emath::GuiRounding;
use umbrage::bake::BakeSettings;
use umbrage_cli::camera::SizeArgs;
use umbrage_picture::Camera;

use crate::controls::Controls;
use crate::draw::{Frame, Show};
use crate::dress::{background, dress};
use crate::facts::Picked;
use crate::gpu::device_descriptor;
use crate::legend;
use crate::lens::Lens;
use crate::marks::Marker;
use crate::navigate::navigate;
use crate::options::ViewOptions;
use crate::panel::Panel;
use crate::pick::Hit;
use crate::progress::progress;
use crate::screen::{Lines, Screen};
use crate::session::{Session, WATCH_EVERY};
use crate::viewpoint::Viewpoint;

/// What desktops know the program as.
const PROGRAM: &str = "umbrage-view";
/// Size of the window at first, and the least, in points.
const SIZE: [f32; 2] = [1280.0, 800.0];
const LEAST_SIZE: [f32; 2] = [360.0, 300.0];
/// Width of the panel at first, and the least.
const PANEL: [f32; 2] = [300.0, 240.0];
/// Below this width of the window the panel would hide the scene, and is closed at first.
const ROOM_FOR_PANEL: f32 = 700.0;
/// Time between looks at how far a bake is.
const PROGRESS_EVERY: Duration = Duration::from_millis(100);

/// Opens a window and stays until it is closed.
///
/// # Errors
/// Where there is no screen or no graphics driver.
pub fn open(options: ViewOptions) -> anyhow::Result<()> {
    let setup = WgpuSetupCreateNew { device_descriptor: Arc::new(device_descriptor), ..WgpuSetupCreateNew::default() };
    let native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title(format!("{} - Umbrage", options.job.path.display()))
            .with_app_id(PROGRAM)
            .with_inner_size(SIZE)
            .with_min_inner_size(LEAST_SIZE),
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: WgpuConfiguration { wgpu_setup: WgpuSetup::CreateNew(setup), ..WgpuConfiguration::default() },
        ..eframe::NativeOptions::default()
    };
    let begin = move |context: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, _> {
        Ok(Box::new(Window::new(context, options)?))
    };
    eframe::run_native(PROGRAM, native, Box::new(begin))
        .map_err(|error| anyhow!("no window can be opened: {error}; --screenshot OUT.png needs none"))
}

/// Lines as they were asked for last.
type LinesAsked = ([bool; 3], Option<usize>);

struct Window {
    options: ViewOptions,
    session: Session,
    screen: Screen,
    controls: Controls,
    /// Settings for the next bake.
    settings: BakeSettings,
    view: Option<Viewpoint>,
    begin: Option<Viewpoint>,
    hit: Option<Hit>,
    picked: Option<Picked>,
    lines: LinesAsked,
    status: String,
}

impl Window {
    fn new(context: &eframe::CreationContext<'_>, options: ViewOptions) -> anyhow::Result<Self> {
        let state = context.wgpu_render_state.as_ref().context("the window has no graphics driver")?;
        dress(&context.egui_ctx);
        Ok(Self {
            session: Session::new(options.job.clone(), &context.egui_ctx),
            screen: Screen::new(state),
            controls: Controls::new(&options.look, options.lines),
            settings: options.job.settings,
            view: None,
            begin: None,
            hit: None,
            picked: None,
            lines: ([false; 3], None),
            status: String::new(),
            options,
        })
    }

    /// Shows what was loaded; the first time also from where, and how, the options say.
    fn take_over(&mut self, size_px: [u32; 2]) {
        let Some(loaded) = &self.session.loaded else { return };
        if let Err(error) = self.screen.show(&loaded.tables) {
            self.session.failure = Some(error.to_string());
        }
        if let Some(baked) = loaded.baked.as_ref().filter(|_| self.session.job.tolerance_by_size) {
            self.settings.shade.tolerance = baked.settings.shade.tolerance;
        }
        (self.hit, self.picked, self.lines) = (None, None, ([false; 3], None));
        if self.view.is_some() {
            return;
        }
        self.controls.show_first(&self.options.look, self.options.lines, &loaded.shown.file);
        let [width, height] = size_px.map(|side| side as usize);
        let camera = self.options.camera.choose(&loaded.shown, SizeArgs { width, height });
        let camera = camera.unwrap_or_else(|error| {
            self.status = format!("{error:#}");
            let [low, high] = loaded.tables.world_bounds_m();
            Camera::looking(high + (high - low), 0.5 * (low + high), Camera::DEFAULT_FOV_DEG)
        });
        let mut view = Viewpoint::new(&camera);
        // A camera of the file does not say what it turns around: what is in the middle of its picture, well in the
        // scene.
        let known = self.options.camera.gives_target() || loaded.shown.file.cameras.is_empty();
        view.turn_around(0.5 * loaded.tables.size_m(), known);
        (self.view, self.begin) = (Some(view), Some(view));
    }

    /// The view, the scene in it, and what hands on it ask for.
    fn central(&mut self, ui: &mut Ui) {
        let rect = ui.max_rect().round_to_pixels(ui.pixels_per_point());
        let size_px = (rect.size() * ui.pixels_per_point()).round();
        let size_px = [size_px.x, size_px.y].map(|side| (side as u32).max(1));
        if self.session.look(ui.ctx()) {
            self.take_over(size_px);
        }
        let Some(mut view) = self.view else {
            self.waiting(ui, rect);
            return;
        };
        let Some(loaded) = &self.session.loaded else { return };
        let size_m = loaded.tables.size_m();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let asked = navigate(&response, &mut view, size_m, self.controls.around);
        self.view = Some(view);
        self.draw_lines();
        let Some(loaded) = &self.session.loaded else { return };
        let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
        let Ok(lens) = Lens::new(&view.camera(), aspect, loaded.tables.origin_m, loaded.tables.bounds_m) else {
            return;
        };
        let frame = Frame { lens, look: self.controls.frame_look(&loaded.shown.file), dither: true };
        if let Some(texture) = self.screen.texture(&frame, &loaded.tables, size_px) {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture, rect, whole, Color32::WHITE);
        }
        if self.controls.look.show == Show::Irradiance {
            let scale = self.controls.unit.scale(self.controls.scale_end(&loaded.shown.file));
            legend::draw(ui.painter(), rect, self.controls.unit, &scale);
        }
        if let Some(asked) = asked {
            self.answer(asked, &lens, rect, aspect);
        }
        if !self.controls.open {
            self.corner(ui, rect);
        }
    }

    /// Uploads the lines that are asked for, where they are others than before.
    fn draw_lines(&mut self) {
        let asked = (self.controls.degrees, self.controls.patches.then_some(self.controls.level));
        let Some(loaded) = &self.session.loaded else { return };
        let Some(baked) = loaded.baked.as_ref().filter(|_| asked != self.lines) else { return };
        let marker = Marker { meshed: &baked.meshed, origin_m: loaded.tables.origin_m };
        let patches = asked.1.map(|level| marker.patches(level)).unwrap_or_default();
        self.screen.set_lines(Lines::Patches, &patches);
        self.screen.set_lines(Lines::Segments, &marker.d_segments(asked.0));
        self.lines = asked;
    }

    /// What is seen while the file is opened for the first time.
    fn waiting(&mut self, ui: &mut Ui, rect: Rect) {
        let size = vec2(rect.width().min(420.0), 120.0);
        let place = Rect::from_center_size(rect.center(), size).shrink(10.0);
        ui.scope_builder(egui::UiBuilder::new().max_rect(place), |ui| {
            if let Some(loading) = &self.session.loading {
                ui.heading(format!("Opening {}", self.session.name()));
                if progress(ui, loading) {
                    self.session.cancel();
                }
            } else if let Some(failure) = &self.session.failure {
                ui.heading(format!("{} cannot be shown", self.session.name()));
                ui.label(failure);
                ui.weak("It is opened again when it changes.");
                if ui.button("Open again").clicked() {
                    self.session.open(&ui.ctx().clone());
                }
            }
        });
    }

    /// The way back to the panel, and how far a bake is, where the panel is closed.
    fn corner(&mut self, ui: &mut Ui, rect: Rect) {
        let place = Rect::from_min_size(rect.right_top() + vec2(-88.0, 8.0), vec2(80.0, 24.0));
        let text = if self.session.loading.is_some() { "Baking..." } else { "Panel (P)" };
        if ui.put(place, egui::Button::new(text)).clicked() {
            self.controls.open = true;
        }
    }
}

impl eframe::App for Window {
    fn update(&mut self, ctx: &Context, _: &mut eframe::Frame) {
        let width = ctx.content_rect().width();
        if self.view.is_none() {
            self.controls.open = width >= ROOM_FOR_PANEL;
        }
        let unit = self.controls.unit;
        let mut wish = None;
        if self.controls.open && self.view.is_some() {
            let margin =
                EguiFrame::side_top_panel(&ctx.style()).inner_margin(Margin { left: 8, right: 14, top: 2, bottom: 2 });
            let panel = SidePanel::right("panel")
                .default_width(PANEL[0])
                .min_width(PANEL[1])
                .max_width(0.8 * width)
                .frame(margin);
            panel.show(ctx, |ui| {
                let panel = Panel {
                    session: &self.session,
                    controls: &mut self.controls,
                    settings: &mut self.settings,
                    picked: self.picked.as_ref(),
                    status: &self.status,
                };
                wish = panel.show(ui);
            });
        }
        if unit != self.controls.unit {
            self.tell();
        }
        CentralPanel::default().frame(EguiFrame::NONE.fill(background())).show(ctx, |ui| {
            let size = ui.max_rect().size();
            if let Some(wish) = wish {
                self.grant(wish, ctx, f64::from(size.x / size.y.max(1.0)));
            }
            self.central(ui);
        });
        ctx.request_repaint_after(if self.session.loading.is_some() { PROGRESS_EVERY } else { WATCH_EVERY });
    }
}
