//! The scene on the window's screen: what is uploaded, and a frame that is drawn when it differs from the last one.

use eframe::egui::TextureId;
use eframe::egui_wgpu::RenderState;
use umbrage_picture::{Picture, Scale};
use wgpu::FilterMode;

use crate::draw::{Frame, Renderer};
use crate::layout::Tables;
use crate::marks::Mark;
use crate::targets::{ReadBackError, Targets};
use crate::upload::{TooLarge, Uploaded, UploadedMarks};

/// Sets of lines, in the order in which they are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lines {
    Patches,
    Segments,
    Picked,
}

/// What is drawn, and what it is drawn with.
pub(crate) struct Screen {
    state: RenderState,
    renderer: Renderer,
    scene: Option<Uploaded>,
    lines: [Option<UploadedMarks>; 3],
    targets: Option<(Targets, TextureId)>,
    /// The frame that the targets hold.
    drawn: Option<Frame>,
}

impl Screen {
    pub(crate) fn new(state: &RenderState) -> Self {
        let renderer = Renderer::new(state.device.clone(), state.queue.clone(), state.adapter.get_info().device_type);
        let (scene, lines, targets, drawn) = (None, [const { None }; 3], None, None);
        Self { state: state.clone(), renderer, scene, lines, targets, drawn }
    }

    /// Shows another scene from now on, without lines; one that cannot be held leaves the screen empty.
    pub(crate) fn show(&mut self, tables: &Tables) -> Result<(), TooLarge> {
        (self.scene, self.lines, self.drawn) = (None, [const { None }; 3], None);
        self.scene = Some(self.renderer.upload(tables)?);
        Ok(())
    }

    /// Sets the lines of one set.
    pub(crate) fn set_lines(&mut self, which: Lines, marks: &[Mark]) {
        let uploaded = (!marks.is_empty()).then(|| UploadedMarks::new(&self.renderer.device, marks));
        self.lines[which as usize] = uploaded;
        self.drawn = None;
    }

    /// The texture of a frame of `size_px`, which is drawn unless it is the last one.
    pub(crate) fn texture(&mut self, frame: &Frame, tables: &Tables, size_px: [u32; 2]) -> Option<TextureId> {
        let scene = self.scene.as_ref()?;
        if self.targets.as_ref().is_none_or(|(targets, _)| targets.size_px != size_px) {
            let targets = Targets::new(&self.renderer, size_px);
            let mut shown = self.state.renderer.write();
            let (device, view) = (&self.renderer.device, &targets.finished_view);
            let id = match self.targets.take() {
                Some((_, id)) => {
                    shown.update_egui_texture_from_wgpu_texture(device, view, FilterMode::Nearest, id);
                    id
                }
                None => shown.register_native_texture(device, view, FilterMode::Nearest),
            };
            self.targets = Some((targets, id));
            self.drawn = None;
        }
        let (targets, id) = self.targets.as_ref()?;
        if self.drawn.as_ref() != Some(frame) {
            let lines: Vec<_> = self.lines.iter().flatten().collect();
            self.renderer.draw(frame, targets, tables, scene, &lines);
            self.drawn = Some(*frame);
        }
        Some(*id)
    }

    /// What is on the screen as a picture to be saved, with a legend if there is a scale.
    pub(crate) fn picture(&mut self, tables: &Tables, scale: Option<&Scale>) -> Option<Result<Picture, ReadBackError>> {
        let frame = Frame { dither: false, ..self.drawn.take()? };
        let ((targets, _), scene) = (self.targets.as_ref()?, self.scene.as_ref()?);
        let lines: Vec<_> = self.lines.iter().flatten().collect();
        self.renderer.draw(&frame, targets, tables, scene, &lines);
        Some(targets.picture(&self.renderer).map(|mut picture| {
            scale.into_iter().for_each(|scale| scale.draw(&mut picture));
            picture
        }))
    }
}
