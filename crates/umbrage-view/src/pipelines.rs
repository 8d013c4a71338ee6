//! How things are drawn: a pipeline for each kind.

use wgpu::{
    BindGroupLayout, BindGroupLayoutEntry, BindingType, BlendState, BufferBindingType, ColorTargetState, ColorWrites,
    CompareFunction, DepthBiasState, DepthStencilState, Device, Face, FragmentState, MultisampleState,
    PipelineCompilationOptions, PipelineLayoutDescriptor, PrimitiveState, PrimitiveTopology, RenderPipeline,
    RenderPipelineDescriptor, SamplerBindingType, ShaderModule, ShaderModuleDescriptor, ShaderSource, ShaderStages,
    StencilState, TextureFormat, TextureSampleType, TextureViewDimension, VertexBufferLayout, VertexState,
    VertexStepMode, vertex_attr_array,
};

use crate::layout::Vertex;
use crate::marks::Mark;
use crate::shader;

/// Samples per pixel.
pub(crate) const SAMPLES: u32 = 4;
/// What is drawn first: displayed light, linear.
pub(crate) const DRAWN: TextureFormat = TextureFormat::Rgba16Float;
/// What becomes of it: sRGB codes.
pub(crate) const FINISHED: TextureFormat = TextureFormat::Rgba8Unorm;
/// Depth, reversed.
pub(crate) const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// Triangles without any light are drawn as if they were farther away by what their depth changes over so many pixels,
/// besides what `shader` says. Drivers round corners to a sixteenth of a pixel at worst, so that two lines that are one
/// are 0.09 pixels apart at most; with more than this, what stands behind a black wall comes through where it meets the
/// wall.
const DARK_FARTHER_PX: f32 = 0.125;

/// The pipelines, and what their shaders take.
pub(crate) struct Pipelines {
    /// Surfaces by whether they are dark, then by whether triangles are drawn.
    surfaces: [[RenderPipeline; 2]; 2],
    pub(crate) lines: RenderPipeline,
    /// What the screen takes, by whether it is dithered.
    finish: [RenderPipeline; 2],
    pub(crate) view_layout: BindGroupLayout,
    pub(crate) texture_layout: BindGroupLayout,
    pub(crate) drawn_layout: BindGroupLayout,
}

impl Pipelines {
    pub(crate) fn new(device: &Device) -> Self {
        let view_layout = layout(
            device,
            &[entry(
                0,
                ShaderStages::VERTEX_FRAGMENT,
                BindingType::Buffer {
                    ty: BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
            )],
        );
        let image = |filterable| BindingType::Texture {
            sample_type: TextureSampleType::Float { filterable },
            view_dimension: TextureViewDimension::D2,
            multisampled: false,
        };
        let sampler = BindingType::Sampler(SamplerBindingType::Filtering);
        let texture_layout =
            layout(device, &[entry(0, ShaderStages::FRAGMENT, image(true)), entry(1, ShaderStages::FRAGMENT, sampler)]);
        let drawn_layout = layout(device, &[entry(0, ShaderStages::FRAGMENT, image(false))]);
        let line = module(device, shader::line());
        let surfaces = [false, true].map(|dark| {
            [false, true].map(|wire| surface_pipeline(device, &[&view_layout, &texture_layout], dark, wire))
        });
        Self {
            surfaces,
            lines: line_pipeline(device, &line, &[&view_layout]),
            finish: [false, true].map(|dither| finish_pipeline(device, &[&drawn_layout], dither)),
            view_layout,
            texture_layout,
            drawn_layout,
        }
    }

    pub(crate) fn surfaces(&self, dark: bool, wire: bool) -> &RenderPipeline {
        &self.surfaces[usize::from(dark)][usize::from(wire)]
    }

    pub(crate) fn finish(&self, dither: bool) -> &RenderPipeline {
        &self.finish[usize::from(dither)]
    }
}

fn entry(binding: u32, visibility: ShaderStages, ty: BindingType) -> BindGroupLayoutEntry {
    BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

fn layout(device: &Device, entries: &[BindGroupLayoutEntry]) -> BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries })
}

fn module(device: &Device, text: String) -> ShaderModule {
    device.create_shader_module(ShaderModuleDescriptor { label: None, source: ShaderSource::Wgsl(text.into()) })
}

fn depth(write: bool, bias: DepthBiasState) -> DepthStencilState {
    DepthStencilState {
        format: DEPTH,
        depth_write_enabled: write,
        // Of two at the same depth the first stays, as in a picture.
        depth_compare: if write { CompareFunction::Greater } else { CompareFunction::GreaterEqual },
        stencil: StencilState::default(),
        bias,
    }
}

/// What makes a pipeline one of its kind.
struct Kind<'a> {
    label: &'static str,
    entries: [&'static str; 2],
    buffers: &'a [VertexBufferLayout<'a>],
    primitive: PrimitiveState,
    depth: Option<DepthStencilState>,
    target: ColorTargetState,
    samples: u32,
}

fn pipeline(device: &Device, module: &ShaderModule, layouts: &[&BindGroupLayout], kind: Kind<'_>) -> RenderPipeline {
    let layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: Some(kind.label),
        bind_group_layouts: layouts,
        push_constant_ranges: &[],
    });
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some(kind.label),
        layout: Some(&layout),
        vertex: VertexState {
            module,
            entry_point: Some(kind.entries[0]),
            compilation_options: PipelineCompilationOptions::default(),
            buffers: kind.buffers,
        },
        primitive: kind.primitive,
        depth_stencil: kind.depth,
        multisample: MultisampleState { count: kind.samples, ..MultisampleState::default() },
        fragment: Some(FragmentState {
            module,
            entry_point: Some(kind.entries[1]),
            compilation_options: PipelineCompilationOptions::default(),
            targets: &[Some(kind.target)],
        }),
        multiview: None,
        cache: None,
    })
}

fn surface_pipeline(device: &Device, layouts: &[&BindGroupLayout], dark: bool, wire: bool) -> RenderPipeline {
    let module = module(device, shader::surface(dark, wire));
    // Depth is reversed: farther is less.
    let slope_scale = if dark { -DARK_FARTHER_PX } else { 0.0 };
    let kind = Kind {
        label: "surfaces",
        entries: ["place", "shade"],
        buffers: &[VertexBufferLayout {
            array_stride: size_of::<Vertex>() as u64,
            step_mode: VertexStepMode::Vertex,
            attributes: &vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32, 4 => Float32x2, 5 => Float32],
        }],
        primitive: PrimitiveState { cull_mode: Some(Face::Back), ..PrimitiveState::default() },
        depth: Some(depth(true, DepthBiasState { slope_scale, ..DepthBiasState::default() })),
        target: DRAWN.into(),
        samples: SAMPLES,
    };
    pipeline(device, &module, layouts, kind)
}

fn line_pipeline(device: &Device, module: &ShaderModule, layouts: &[&BindGroupLayout]) -> RenderPipeline {
    let blend = Some(BlendState::ALPHA_BLENDING);
    let kind = Kind {
        label: "lines",
        entries: ["place", "shade"],
        buffers: &[VertexBufferLayout {
            array_stride: size_of::<Mark>() as u64,
            step_mode: VertexStepMode::Instance,
            attributes: &vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32x3, 4 => Float32],
        }],
        primitive: PrimitiveState { topology: PrimitiveTopology::TriangleStrip, ..PrimitiveState::default() },
        depth: Some(depth(false, DepthBiasState::default())),
        target: ColorTargetState { format: DRAWN, blend, write_mask: ColorWrites::ALL },
        samples: SAMPLES,
    };
    pipeline(device, module, layouts, kind)
}

fn finish_pipeline(device: &Device, layouts: &[&BindGroupLayout], dither: bool) -> RenderPipeline {
    let module = module(device, shader::finish(dither));
    let kind = Kind {
        label: "finish",
        entries: ["cover", "finish"],
        buffers: &[],
        primitive: PrimitiveState::default(),
        depth: None,
        target: FINISHED.into(),
        samples: 1,
    };
    pipeline(device, &module, layouts, kind)
}
