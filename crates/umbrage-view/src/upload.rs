//! The tables of a scene in the memory of the graphics processor.

use std::cell::OnceCell;

use umbrage_picture::color::srgb8_from_linear;
use umbrage_picture::{LinearRgb, Wrap};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{
    AddressMode, BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferUsages, Device,
    Extent3d, FilterMode, SamplerDescriptor, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureDescriptor,
    TextureDimension, TextureFormat, TextureUsages, TextureViewDescriptor,
};

use crate::draw::Renderer;
use crate::layout::{Group, Tables};
use crate::marks::Mark;

/// Texels looked at along a surface that is seen at a grazing angle. Not where the main processor draws: it takes long
/// there, and Mesa blurs with it even what is near.
const ANISOTROPY: u16 = 8;

/// A scene that is ready to be drawn.
pub(crate) struct Uploaded {
    pub(crate) vertices: Buffer,
    pub(crate) indices: Buffer,
    pub(crate) groups: Vec<Group>,
    /// One for each texture, and a white one.
    textures: Vec<BindGroup>,
    /// Vertices of triangles that share none: made when triangles are first drawn.
    unshared: OnceCell<Buffer>,
}

impl Uploaded {
    pub(crate) fn new(renderer: &Renderer, tables: &Tables) -> Self {
        let device = &renderer.device;
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
        textures.push(bind(renderer, &[([1, 1], &[[1.0; 3]])], [Wrap::Repeat; 2]));
        Self {
            vertices: buffer(device, bytemuck::cast_slice(&tables.vertices), BufferUsages::VERTEX),
            indices: buffer(device, bytemuck::cast_slice(&tables.indices), BufferUsages::INDEX),
            groups: tables.groups.clone(),
            textures,
            unshared: OnceCell::new(),
        }
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
type Level<'a> = ([usize; 2], &'a [LinearRgb]);

/// The bytes of texels: sRGB codes, or half floats where a driver on the main processor would compute with eight bits
/// between the codes.
fn bytes(texels: &[LinearRgb], float: bool) -> Vec<u8> {
    if float {
        texels.iter().flat_map(|&[r, g, b]| [r, g, b, 1.0].map(half).map(u16::to_le_bytes)).flatten().collect()
    } else {
        let codes = |&[r, g, b]: &LinearRgb| [r, g, b, 1.0].map(srgb8_from_linear);
        texels.iter().flat_map(codes).collect()
    }
}

/// The bits of the half float nearest to a number from 0 to 1; a tie goes to the even one.
fn half(x: f32) -> u16 {
    /// The least number that a half float holds with all its bits.
    const LEAST: f32 = 6.103_515_6e-5;
    if x < LEAST {
        // Steps of 2^-24.
        return (x * 16_777_216.0).round_ties_even() as u16;
    }
    let bits = x.to_bits();
    // Exponents of halves begin 112 later.
    (((bits + 0xfff + (bits >> 13 & 1)) >> 13) - (112 << 10)) as u16
}

fn bind(renderer: &Renderer, levels: &[Level<'_>], wrap: [Wrap; 2]) -> BindGroup {
    let Renderer { device, queue, on_processor, .. } = renderer;
    let (format, texel_bytes) =
        if *on_processor { (TextureFormat::Rgba16Float, 8) } else { (TextureFormat::Rgba8UnormSrgb, 4) };
    let extent =
        |[width, height]: [usize; 2]| Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: 1 };
    let texture = device.create_texture(&TextureDescriptor {
        label: None,
        size: extent(levels[0].0),
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for ((size, texels), mip_level) in levels.iter().zip(0..) {
        let layout = TexelCopyBufferLayout { bytes_per_row: Some(texel_bytes * size[0] as u32), ..Default::default() };
        let to = TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() };
        queue.write_texture(to, &bytes(texels, *on_processor), layout, extent(*size));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_the_nearest() {
        // By hand: 1 is 15 << 10, 0.5 is 14 << 10, 2^-14 is 1 << 10, 2^-24 is 1.
        assert_eq!([0.0, 1.0, 0.5, 0.75, 2f32.powi(-14), 2f32.powi(-24)].map(half), [0, 15360, 14336, 14848, 1024, 1]);
        // The next after 0.5 is 2^-11 away; a tie goes to the even one.
        let next = |steps: f32| half(0.5 + steps * 2f32.powi(-11)) - half(0.5);
        assert_eq!([0.4, 0.5, 0.6, 1.5, 1.6].map(next), [0, 0, 1, 2, 2]);
        assert_eq!(half(1.0 - 1e-6), 15360);
    }

    #[test]
    fn a_texel_is_four_codes_or_four_halves() {
        let texels = [[0.0, 0.215_861, 1.0]];
        assert_eq!(bytes(&texels, false), [0, 128, 255, 255]);
        let halves = bytes(&texels, true);
        assert_eq!((halves.len(), &halves[4..]), (8, &[0x00, 0x3c, 0x00, 0x3c][..]));
    }
}
