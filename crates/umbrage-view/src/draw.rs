//! Drawing a frame: surfaces, lines over them, then what the screen takes of it.

use umbrage_picture::Tone;
use umbrage_picture::color::{BACKGROUND, linear_from_srgb8, srgb8_from_linear};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, Buffer, BufferDescriptor, BufferUsages, Color, CommandEncoder,
    Device, DeviceType, IndexFormat, LoadOp, Operations, Queue, RenderPass, RenderPassColorAttachment,
    RenderPassDepthStencilAttachment, RenderPassDescriptor, StoreOp,
};

use crate::layout::Tables;
use crate::lens::Lens;
use crate::pipelines::Pipelines;
use crate::targets::Targets;
use crate::upload::{TooLarge, Uploaded, UploadedMarks};

/// Bytes of the struct in `view.wgsl`.
const VIEW_BYTES: u64 = 160;

/// What is shown of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Show {
    /// Base colour times light.
    Surfaces,
    /// The light alone.
    Light,
    /// Irradiance in false colours.
    Irradiance,
}

/// What becomes of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameLook {
    /// What is shown.
    pub(crate) show: Show,
    /// What light is multiplied with.
    pub(crate) exposure: f32,
    /// The curve that it then goes through.
    pub(crate) tone: Tone,
    /// Where the scale of false colours ends, in the file's unit.
    pub(crate) scale_end: f32,
    /// Whether triangles are drawn, where the driver can hold them apart.
    pub(crate) wire: bool,
}

/// All that a frame depends on, but for the scene and the lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub(crate) lens: Lens,
    pub(crate) look: FrameLook,
    /// Whether it is dithered, as for a screen; a picture that is saved is rounded, as all pictures are.
    pub(crate) dither: bool,
}

/// Draws frames.
pub(crate) struct Renderer {
    pub(crate) device: Device,
    pub(crate) queue: Queue,
    pub(crate) pipelines: Pipelines,
    view: Buffer,
    view_group: BindGroup,
    /// Whether the main processor does the work: textures are then looked at in a plainer way, see `upload`.
    pub(crate) on_processor: bool,
}

impl Renderer {
    /// A renderer with a device; `kind` is what works for it.
    pub(crate) fn new(device: Device, queue: Queue, kind: DeviceType) -> Self {
        let pipelines = Pipelines::new(&device);
        let view = device.create_buffer(&BufferDescriptor {
            label: Some("view"),
            size: VIEW_BYTES,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let view_group = device.create_bind_group(&BindGroupDescriptor {
            label: Some("view"),
            layout: &pipelines.view_layout,
            entries: &[BindGroupEntry { binding: 0, resource: view.as_entire_binding() }],
        });
        Self { device, queue, pipelines, view, view_group, on_processor: kind == DeviceType::Cpu }
    }

    /// A scene in the memory of the graphics processor.
    pub(crate) fn upload(&self, tables: &Tables) -> Result<Uploaded, TooLarge> {
        Uploaded::new(self, tables)
    }

    /// Draws a frame into `targets`.
    pub(crate) fn draw(
        &self,
        frame: &Frame,
        targets: &Targets,
        tables: &Tables,
        scene: &Uploaded,
        marks: &[&UploadedMarks],
    ) {
        self.queue.write_buffer(&self.view, 0, &view_bytes(frame, targets.size_px));
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut pass = begin(&mut encoder, targets);
        pass.set_bind_group(0, &self.view_group, &[]);
        self.draw_surfaces(&mut pass, frame.look.wire && scene.wires.is_ok(), tables, scene);
        pass.set_pipeline(&self.pipelines.lines);
        for marks in marks.iter().filter(|marks| marks.count > 0) {
            pass.set_vertex_buffer(0, marks.lines.slice(..));
            pass.draw(0..4, 0..marks.count);
        }
        drop(pass);
        self.finish(&mut encoder, targets, frame.dither);
        self.queue.submit([encoder.finish()]);
    }

    fn draw_surfaces(&self, pass: &mut RenderPass<'_>, wire: bool, tables: &Tables, scene: &Uploaded) {
        if wire {
            pass.set_vertex_buffer(0, scene.unshared(&self.device, tables).slice(..));
        } else {
            pass.set_vertex_buffer(0, scene.vertices.slice(..));
            pass.set_index_buffer(scene.indices.slice(..), IndexFormat::Uint32);
        }
        for dark in [false, true] {
            pass.set_pipeline(self.pipelines.surfaces(dark, wire));
            for group in &scene.groups {
                let begin = if dark { group.first + group.lit } else { group.first };
                let count = if dark { group.dark } else { group.lit };
                if count == 0 {
                    continue;
                }
                pass.set_bind_group(1, scene.texture(group), &[]);
                if wire {
                    pass.draw(begin..begin + count, 0..1);
                } else {
                    pass.draw_indexed(begin..begin + count, 0, 0..1);
                }
            }
        }
    }

    fn finish(&self, encoder: &mut CommandEncoder, targets: &Targets, dither: bool) {
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("finish"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: &targets.finished_view,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(Color::BLACK), store: StoreOp::Store },
            })],
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(self.pipelines.finish(dither));
        pass.set_bind_group(0, &targets.drawn_group, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// The colour behind the scene: as a picture shows it, so that it is one code.
fn background() -> Color {
    let [r, g, b] = linear_from_srgb8(BACKGROUND.map(srgb8_from_linear)).map(f64::from);
    Color { r, g, b, a: 1.0 }
}

fn begin<'a>(encoder: &'a mut CommandEncoder, targets: &Targets) -> RenderPass<'a> {
    encoder.begin_render_pass(&RenderPassDescriptor {
        label: Some("scene"),
        color_attachments: &[Some(RenderPassColorAttachment {
            view: &targets.samples_view,
            depth_slice: None,
            resolve_target: Some(&targets.drawn_view),
            ops: Operations { load: LoadOp::Clear(background()), store: StoreOp::Discard },
        })],
        depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
            view: &targets.depth_view,
            depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
            stencil_ops: None,
        }),
        ..RenderPassDescriptor::default()
    })
}

/// The struct in `view.wgsl`.
fn view_bytes(frame: &Frame, [width, height]: [u32; 2]) -> Vec<u8> {
    let FrameLook { show, exposure, tone, scale_end, .. } = frame.look;
    let mut words = frame.lens.uniforms();
    words.extend([exposure, width as f32, height as f32, scale_end]);
    let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes.extend((show as u32).to_le_bytes());
    bytes.extend(u32::from(tone == Tone::Filmic).to_le_bytes());
    bytes.resize(VIEW_BYTES as usize, 0);
    bytes
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use umbrage_picture::Camera;

    use super::*;

    #[test]
    fn words_of_the_view_lie_where_the_shader_reads_them() {
        let camera = Camera::looking(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 90.0);
        let lens = Lens::new(&camera, 1.0, DVec3::ZERO, [DVec3::NEG_ONE, DVec3::ONE]).unwrap();
        let look = FrameLook { show: Show::Irradiance, exposure: 3.0, tone: Tone::Filmic, scale_end: 7.0, wire: false };
        let bytes = view_bytes(&Frame { lens, look, dither: true }, [640, 480]);
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let float = |at| f32::from_bits(word(at));
        assert_eq!([64, 68, 72].map(float), [0.0, 0.0, 5.0]);
        assert_eq!([112, 116, 120].map(float), [0.0, 0.0, -1.0]);
        assert_eq!([124, 128, 132, 136].map(float), [3.0, 640.0, 480.0, 7.0]);
        assert_eq!((word(140), word(144), bytes.len()), (2, 1, 160));
    }

    #[test]
    fn the_background_is_one_code() {
        let Color { r, .. } = background();
        let code = 255.0 * umbrage_picture::color::srgb_from_linear(r);
        assert!((code - code.round()).abs() < 1e-4, "{code}");
    }
}
