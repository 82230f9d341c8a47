//! How each kind of thing is drawn.

use super::chunk::{Flat, Solid};
use super::target::DEPTH;
use super::{FORMAT, Gpu, Kind, SAMPLES, target};
use wgpu::{VertexAttribute, VertexBufferLayout, VertexFormat, VertexStepMode};

/// The pipelines, with the layouts of what they are bound to.
#[derive(Debug)]
pub struct Pipelines {
    view: wgpu::BindGroupLayout,
    texture: wgpu::BindGroupLayout,
    drawn: wgpu::BindGroupLayout,
    smooth: wgpu::Sampler,
    compare: wgpu::Sampler,
    solid: wgpu::RenderPipeline,
    area: wgpu::RenderPipeline,
    line: wgpu::RenderPipeline,
    /// Land, water and parks.
    pub ground: wgpu::RenderPipeline,
    /// A map over all that is on a map.
    pub overlay: wgpu::RenderPipeline,
    /// Depths seen from the sun.
    pub shadow: wgpu::RenderPipeline,
    /// Over the finished picture.
    pub silhouettes: wgpu::RenderPipeline,
    /// Bound while shadows are found: a texture cannot be read and written at once.
    pub no_shadows: wgpu::TextureView,
}

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    let visibility = wgpu::ShaderStages::VERTEX_FRAGMENT;
    wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

fn texture_entry(binding: u32, sample_type: wgpu::TextureSampleType, multisampled: bool) -> wgpu::BindGroupLayoutEntry {
    let view_dimension = wgpu::TextureViewDimension::D2;
    entry(binding, wgpu::BindingType::Texture { sample_type, view_dimension, multisampled })
}

const SMOOTH: wgpu::TextureSampleType = wgpu::TextureSampleType::Float { filterable: true };

fn attribute(format: VertexFormat, offset: u64, shader_location: u32) -> VertexAttribute {
    VertexAttribute { format, offset, shader_location }
}

/// How a pipeline differs from others.
struct Recipe<'a> {
    label: &'a str,
    vertex: &'a str,
    fragment: Option<&'a str>,
    buffers: &'a [Option<VertexBufferLayout<'a>>],
    groups: &'a [Option<&'a wgpu::BindGroupLayout>],
    topology: wgpu::PrimitiveTopology,
    depth: Option<wgpu::CompareFunction>,
    samples: u32,
    blend: Option<wgpu::BlendState>,
}

impl Pipelines {
    /// Those of a device.
    pub fn new(gpu: &Gpu) -> Self {
        let device = &gpu.device;
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let view = layout(
            "view",
            &[
                entry(0, uniform),
                entry(1, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
                entry(2, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
                texture_entry(3, SMOOTH, false),
                texture_entry(4, wgpu::TextureSampleType::Depth, false),
            ],
        );
        let texture = layout("texture", &[texture_entry(0, SMOOTH, false)]);
        let drawn =
            layout("drawn", &[texture_entry(0, SMOOTH, false), texture_entry(1, wgpu::TextureSampleType::Depth, true)]);
        let sampler = |compare| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                compare,
                ..wgpu::SamplerDescriptor::default()
            })
        };
        let (smooth, compare) = (sampler(None), sampler(Some(wgpu::CompareFunction::LessEqual)));
        let solid_corners = [
            attribute(VertexFormat::Float32x3, 0, 0),
            attribute(VertexFormat::Snorm8x4, 12, 1),
            attribute(VertexFormat::Unorm8x4, 16, 2),
        ];
        let flat_corners = [
            attribute(VertexFormat::Float32x2, 0, 0),
            attribute(VertexFormat::Float32x3, 8, 3),
            attribute(VertexFormat::Unorm8x4, 20, 1),
        ];
        let buffer =
            |array_stride, step_mode, attributes| Some(VertexBufferLayout { array_stride, step_mode, attributes });
        let solid_place = [attribute(VertexFormat::Float32x2, 0, 3)];
        let flat_place = [attribute(VertexFormat::Float32x2, 0, 2)];
        let solids = [
            buffer(size_of::<Solid>() as u64, VertexStepMode::Vertex, &solid_corners[..]),
            buffer(8, VertexStepMode::Instance, &solid_place[..]),
        ];
        let flats = [
            buffer(size_of::<Flat>() as u64, VertexStepMode::Vertex, &flat_corners[..]),
            buffer(8, VertexStepMode::Instance, &flat_place[..]),
        ];
        let solid = Recipe {
            label: "solid",
            vertex: "solid_vertex",
            fragment: Some("solid_fragment"),
            buffers: &solids,
            groups: &[Some(&view)],
            topology: wgpu::PrimitiveTopology::TriangleList,
            depth: Some(wgpu::CompareFunction::Less),
            samples: SAMPLES,
            blend: None,
        };
        let area = Recipe {
            label: "area",
            vertex: "flat_vertex",
            fragment: Some("flat_fragment"),
            buffers: &flats,
            depth: Some(wgpu::CompareFunction::Always),
            blend: Some(wgpu::BlendState::ALPHA_BLENDING),
            ..solid
        };
        let line = Recipe { label: "line", topology: wgpu::PrimitiveTopology::LineList, ..area };
        let ground = Recipe {
            label: "ground",
            fragment: Some("ground_fragment"),
            groups: &[Some(&view), Some(&texture)],
            ..area
        };
        let overlay = Recipe { label: "overlay", fragment: Some("overlay_fragment"), ..area };
        let shadow = Recipe { label: "shadow", vertex: "shadow_vertex", fragment: None, samples: 1, ..solid };
        let silhouettes = Recipe {
            label: "silhouettes",
            vertex: "screen_vertex",
            fragment: Some("silhouette_fragment"),
            buffers: &[],
            groups: &[Some(&view), Some(&drawn)],
            depth: None,
            samples: 1,
            blend: None,
            ..solid
        };
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("plat"),
            source: wgpu::ShaderSource::Wgsl(include_str!("shaders.wgsl").into()),
        });
        let make = |recipe: &Recipe| pipeline(device, &shader, recipe);
        Self {
            solid: make(&solid),
            area: make(&area),
            line: make(&line),
            ground: make(&ground),
            overlay: make(&overlay),
            shadow: make(&shadow),
            silhouettes: make(&silhouettes),
            no_shadows: target::depth(gpu, [1, 1], 1, "no shadows"),
            view,
            texture,
            drawn,
            smooth,
            compare,
        }
    }

    /// The pipeline that draws a kind of chunk.
    pub fn of(&self, kind: Kind) -> &wgpu::RenderPipeline {
        match kind {
            Kind::Solid => &self.solid,
            Kind::Area => &self.area,
            Kind::Line => &self.line,
        }
    }

    /// What all passes read.
    pub fn bind_view(
        &self,
        device: &wgpu::Device,
        view: &wgpu::Buffer,
        overlay: &wgpu::Texture,
        shadows: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        let overlay = overlay.create_view(&wgpu::TextureViewDescriptor::default());
        let resources = [
            view.as_entire_binding(),
            wgpu::BindingResource::Sampler(&self.smooth),
            wgpu::BindingResource::Sampler(&self.compare),
            wgpu::BindingResource::TextureView(&overlay),
            wgpu::BindingResource::TextureView(shadows),
        ];
        bind(device, &self.view, resources)
    }

    /// A texture.
    pub fn bind_texture(&self, device: &wgpu::Device, texture: &wgpu::Texture) -> wgpu::BindGroup {
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        bind(device, &self.texture, [wgpu::BindingResource::TextureView(&view)])
    }

    /// What was drawn, with its depths.
    pub fn bind_drawn(
        &self,
        device: &wgpu::Device,
        drawn: &wgpu::TextureView,
        depths: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        let resources = [wgpu::BindingResource::TextureView(drawn), wgpu::BindingResource::TextureView(depths)];
        bind(device, &self.drawn, resources)
    }
}

fn bind<const N: usize>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: [wgpu::BindingResource; N],
) -> wgpu::BindGroup {
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

fn pipeline(device: &wgpu::Device, shader: &wgpu::ShaderModule, recipe: &Recipe) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(recipe.label),
        bind_group_layouts: recipe.groups,
        immediate_size: 0,
    });
    let targets =
        [Some(wgpu::ColorTargetState { format: FORMAT, blend: recipe.blend, write_mask: wgpu::ColorWrites::ALL })];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(recipe.label),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some(recipe.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: recipe.buffers,
        },
        primitive: wgpu::PrimitiveState { topology: recipe.topology, ..wgpu::PrimitiveState::default() },
        depth_stencil: recipe.depth.map(|compare| wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(compare == wgpu::CompareFunction::Less),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: recipe.samples, ..wgpu::MultisampleState::default() },
        fragment: recipe.fragment.map(|entry| wgpu::FragmentState {
            module: shader,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
