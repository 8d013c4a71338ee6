//! What is drawn into, and reading it back.

use std::sync::mpsc::channel;

use umbrage_picture::Picture;
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, BufferDescriptor, BufferUsages,
    COPY_BYTES_PER_ROW_ALIGNMENT, Device, Extent3d, MapMode, PollType, TexelCopyBufferInfo, TexelCopyBufferLayout,
    Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView, TextureViewDescriptor,
};

use crate::draw::Renderer;
use crate::pipelines::{DEPTH, DRAWN, FINISHED, SAMPLES};

/// The textures of a frame.
pub(crate) struct Targets {
    pub(crate) size_px: [u32; 2],
    pub(crate) samples_view: TextureView,
    pub(crate) depth_view: TextureView,
    /// The mean of the samples, linear.
    pub(crate) drawn_view: TextureView,
    pub(crate) drawn_group: BindGroup,
    finished: Texture,
    /// What the screen takes.
    pub(crate) finished_view: TextureView,
}

/// The picture could not be read back.
#[derive(Debug, thiserror::Error)]
#[error("the graphics driver does not give the picture back")]
pub(crate) struct ReadBackError;

impl Targets {
    /// Textures of a size, which is at least 1 and at most what the device can.
    pub(crate) fn new(renderer: &Renderer, [width, height]: [u32; 2]) -> Self {
        let device = &renderer.device;
        let largest = device.limits().max_texture_dimension_2d;
        let size_px = [width, height].map(|side| side.clamp(1, largest));
        let make = |format, sample_count, usage| texture(device, size_px, format, sample_count, usage);
        let attached = TextureUsages::RENDER_ATTACHMENT;
        let drawn = make(DRAWN, 1, attached | TextureUsages::TEXTURE_BINDING);
        let finished = make(FINISHED, 1, attached | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC);
        let drawn_view = view(&drawn);
        let drawn_group = device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &renderer.pipelines.drawn_layout,
            entries: &[BindGroupEntry { binding: 0, resource: BindingResource::TextureView(&drawn_view) }],
        });
        Self {
            size_px,
            samples_view: view(&make(DRAWN, SAMPLES, attached)),
            depth_view: view(&make(DEPTH, SAMPLES, attached)),
            drawn_view,
            drawn_group,
            finished_view: view(&finished),
            finished,
        }
    }

    /// How many times as wide as high.
    pub(crate) fn aspect(&self) -> f64 {
        f64::from(self.size_px[0]) / f64::from(self.size_px[1])
    }

    /// What was drawn, as a picture.
    pub(crate) fn picture(&self, renderer: &Renderer) -> Result<Picture, ReadBackError> {
        let [width, height] = self.size_px;
        let bytes_per_row = (4 * width).next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = renderer.device.create_buffer(&BufferDescriptor {
            label: Some("picture"),
            size: u64::from(bytes_per_row) * u64::from(height),
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = renderer.device.create_command_encoder(&Default::default());
        let layout = TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(bytes_per_row), rows_per_image: None };
        let to = TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(self.finished.as_image_copy(), to, self.finished.size());
        renderer.queue.submit([encoder.finish()]);

        let (sender, mapped) = channel();
        buffer.slice(..).map_async(MapMode::Read, move |result| {
            // Whoever asked waits below.
            let _ = sender.send(result);
        });
        renderer.device.poll(PollType::wait_indefinitely()).map_err(|_| ReadBackError)?;
        mapped.recv().map_err(|_| ReadBackError)?.map_err(|_| ReadBackError)?;
        let bytes = buffer.slice(..).get_mapped_range();
        let rows = bytes.chunks_exact(bytes_per_row as usize);
        let codes: Vec<[u8; 3]> = rows
            .flat_map(|row| row[..4 * width as usize].chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]))
            .collect();
        Ok(Picture::from_srgb8(width as usize, &codes))
    }
}

fn texture(
    device: &Device,
    [width, height]: [u32; 2],
    format: TextureFormat,
    sample_count: u32,
    usage: TextureUsages,
) -> Texture {
    device.create_texture(&TextureDescriptor {
        label: None,
        size: Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count,
        dimension: TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

fn view(texture: &Texture) -> TextureView {
    texture.create_view(&TextureViewDescriptor::default())
}
