//! The tables of a scene in the memory of the graphics processor.

use std::cell::OnceCell;

use umbrage_picture::color::srgb8_from_linear;
use umbrage_picture::{Texel, Wrap};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{
    AddressMode, BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferUsages, Device,
    Extent3d, FilterMode, SamplerDescriptor, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureDescriptor,
    TextureDimension, TextureFormat, TextureUsages, TextureViewDescriptor,
};

use crate::draw::Renderer;
use crate::layout::{Group, Tables, Vertex};
use crate::marks::Mark;

/// Texels looked at along a surface that is seen at a grazing angle. Not where the main processor draws: it takes long
/// there, and Mesa blurs with it even what is near.
const ANISOTROPY: u16 = 8;

/// A scene that the graphics driver cannot hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the scene needs a table of {needed} bytes, and this graphics driver holds {largest} at most")]
pub(crate) struct TooLarge {
    needed: u64,
    largest: u64,
}

/// Whether a table of this many bytes can be held.
fn check(renderer: &Renderer, needed: usize) -> Result<(), TooLarge> {
    let (needed, largest) = (needed as u64, renderer.device.limits().max_buffer_size);
    if needed <= largest { Ok(()) } else { Err(TooLarge { needed, largest }) }
}

/// A scene that is ready to be drawn.
pub(crate) struct Uploaded {
    pub(crate) vertices: Buffer,
    pub(crate) indices: Buffer,
    pub(crate) groups: Vec<Group>,
    /// One for each texture, and a white one.
    textures: Vec<BindGroup>,
    /// Vertices of triangles that share none: made when triangles are first drawn.
    unshared: OnceCell<Buffer>,
    /// Whether these can be held.
    pub(crate) wires: Result<(), TooLarge>,
}

impl Uploaded {
    pub(crate) fn new(renderer: &Renderer, tables: &Tables) -> Result<Self, TooLarge> {
        let device = &renderer.device;
        check(renderer, size_of_val(tables.vertices.as_slice()))?;
        check(renderer, size_of_val(tables.indices.as_slice()))?;
        let largest = device.limits().max_texture_dimension_2d as usize;
        let mut textures: Vec<BindGroup> = tables
            .textures
            .iter()
            .map(|texture| {
                let fits = |size: [usize; 2]| size.iter().all(|&side| side <= largest);
                let levels: Vec<Level<'_>> = texture.levels().filter(|(size, _)| fits(*size)).collect();
                bind(renderer, &levels, texture.wrap())
            })
            .collect();
        textures.push(bind(renderer, &[([1, 1], &[[1.0; 4]])], [Wrap::Repeat; 2]));
        Ok(Self {
            vertices: buffer(device, bytemuck::cast_slice(&tables.vertices), BufferUsages::VERTEX),
            indices: buffer(device, bytemuck::cast_slice(&tables.indices), BufferUsages::INDEX),
            groups: tables.groups.clone(),
            textures,
            unshared: OnceCell::new(),
            wires: check(renderer, tables.indices.len() * size_of::<Vertex>()),
        })
    }

    /// The texture of a group.
    pub(crate) fn texture(&self, group: &Group) -> &BindGroup {
        &self.textures[group.texture.unwrap_or(self.textures.len() - 1)]
    }

    /// Vertices of triangles that share none.
    pub(crate) fn unshared(&self, device: &Device, tables: &Tables) -> &Buffer {
        self.unshared.get_or_init(|| buffer(device, bytemuck::cast_slice(&tables.unshared()), BufferUsages::VERTEX))
    }
}

/// Lines that are ready to be drawn.
pub(crate) struct UploadedMarks {
    pub(crate) lines: Buffer,
    pub(crate) count: u32,
}

impl UploadedMarks {
    pub(crate) fn new(device: &Device, marks: &[Mark]) -> Self {
        let lines = buffer(device, bytemuck::cast_slice(marks), BufferUsages::VERTEX);
        Self { lines, count: marks.len() as u32 }
    }
}

fn buffer(device: &Device, contents: &[u8], usage: BufferUsages) -> Buffer {
    device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
}

/// A mip level: columns and rows, and texels.
type Level<'a> = ([usize; 2], &'a [Texel]);

/// Texels as sRGB codes, and their alpha.
fn codes(texels: &[Texel]) -> Vec<u8> {
    let alpha_code = |alpha: f32| (255.0 * alpha).round() as u8;
    texels
        .iter()
        .flat_map(|&[r, g, b, a]| [r, g, b].map(srgb8_from_linear).into_iter().chain([alpha_code(a)]))
        .collect()
}

fn bind(renderer: &Renderer, levels: &[Level<'_>], wrap: [Wrap; 2]) -> BindGroup {
    let Renderer { device, queue, on_processor, .. } = renderer;
    let extent =
        |[width, height]: [usize; 2]| Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: 1 };
    let texture = device.create_texture(&TextureDescriptor {
        label: None,
        size: extent(levels[0].0),
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format: TextureFormat::Rgba8UnormSrgb,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for ((size, texels), mip_level) in levels.iter().zip(0..) {
        let layout = TexelCopyBufferLayout { bytes_per_row: Some(4 * size[0] as u32), ..Default::default() };
        let to = TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() };
        queue.write_texture(to, &codes(texels), layout, extent(*size));
    }
    let [address_mode_u, address_mode_v] = wrap.map(|wrap| match wrap {
        Wrap::Repeat => AddressMode::Repeat,
        Wrap::Mirror => AddressMode::MirrorRepeat,
        Wrap::Clamp => AddressMode::ClampToEdge,
    });
    let sampler = device.create_sampler(&SamplerDescriptor {
        address_mode_u,
        address_mode_v,
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        mipmap_filter: FilterMode::Linear,
        anisotropy_clamp: if *on_processor { 1 } else { ANISOTROPY },
        ..SamplerDescriptor::default()
    });
    let view = texture.create_view(&TextureViewDescriptor::default());
    device.create_bind_group(&BindGroupDescriptor {
        label: None,
        layout: &renderer.pipelines.texture_layout,
        entries: &[
            BindGroupEntry { binding: 0, resource: BindingResource::TextureView(&view) },
            BindGroupEntry { binding: 1, resource: BindingResource::Sampler(&sampler) },
        ],
    })
}
