//! What is drawn, as the GPU holds it: pieces of a tile, each drawn in one call.

use super::Gpu;
use bytemuck::{Pod, Zeroable};
use geom::{Vec2, Vec3};
use wgpu::util::DeviceExt;

/// A corner of a surface in space: metres around the corner of its tile, x east, y north, z up.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Solid {
    /// Place.
    pub position: [f32; 3],
    /// Unit normal, in 127ths.
    pub normal: [i8; 4],
    /// Red, green, blue (linear light), in 255ths.
    pub colour: [u8; 4],
}

/// A corner of an area on a map: metres around the corner of its tile.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Flat {
    /// Place; of a line with a width, of its middle.
    pub position: [f32; 2],
    /// From there to the rim, in metres, and the least of that in pixels: so that lines are seen from far off, too.
    pub reach: [f32; 3],
    /// Red, green, blue (linear light) and opacity, in 255ths.
    pub colour: [u8; 4],
}

/// Corners with the triangles between them, or lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing<V> {
    /// The corner of the tile, in metres.
    pub corner: Vec2,
    /// Corners.
    pub vertices: Vec<V>,
    /// Three a triangle, or two a line; what is not seen from far off comes last.
    pub indices: Vec<u32>,
    /// How many of them are drawn from far off; all when none.
    pub from_far: Option<usize>,
    /// Whether it throws shadows that one sees.
    pub casts: bool,
}

impl<V> Drawing<V> {
    /// Nothing yet.
    pub fn at(corner: Vec2) -> Self {
        Self { corner, vertices: Vec::new(), indices: Vec::new(), from_far: None, casts: true }
    }
}

/// A drawing on the GPU.
#[derive(Debug)]
pub struct Chunk {
    /// The corner of its tile, in metres.
    pub corner: Vec2,
    /// Least and greatest place, in metres.
    pub bounds: (Vec3, Vec3),
    /// Indices to draw.
    pub count: u32,
    /// Those of them that are drawn from far off.
    pub from_far: u32,
    /// Whether it throws shadows.
    pub casts: bool,
    /// Bytes that were uploaded for it.
    pub bytes: u64,
    pub(super) vertices: wgpu::Buffer,
    pub(super) indices: wgpu::Buffer,
}

impl Chunk {
    /// Uploads a drawing; `None` where there is nothing to draw. Works on any thread.
    pub fn of<V: Pod + Placed>(gpu: &Gpu, drawing: &Drawing<V>) -> Option<Self> {
        if drawing.indices.is_empty() {
            return None;
        }
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for vertex in &drawing.vertices {
            let (place, reach) = (vertex.place(), Vec3::splat(vertex.reach()));
            (low, high) = (low.min(place - reach), high.max(place + reach));
        }
        let corner = drawing.corner.extend(0.0);
        let buffer = |contents: &[u8], usage| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("chunk"), contents, usage })
        };
        let (vertices, indices) = (bytemuck::cast_slice(&drawing.vertices), bytemuck::cast_slice(&drawing.indices));
        Some(Self {
            corner: drawing.corner,
            bounds: (corner + low, corner + high),
            count: u32::try_from(drawing.indices.len()).ok()?,
            from_far: u32::try_from(drawing.from_far.unwrap_or(drawing.indices.len())).ok()?,
            casts: drawing.casts,
            bytes: (vertices.len() + indices.len()) as u64,
            vertices: buffer(vertices, wgpu::BufferUsages::VERTEX),
            indices: buffer(indices, wgpu::BufferUsages::INDEX),
        })
    }
}

/// What lies at a place around the corner of its tile.
pub trait Placed {
    /// The place in metres.
    fn place(&self) -> Vec3;

    /// How far from there it is drawn, in metres.
    fn reach(&self) -> f64 {
        0.0
    }
}

impl Placed for Solid {
    fn place(&self) -> Vec3 {
        Vec3::from_array(self.position.map(f64::from))
    }
}

impl Placed for Flat {
    fn place(&self) -> Vec3 {
        Vec3::new(f64::from(self.position[0]), f64::from(self.position[1]), 0.0)
    }

    fn reach(&self) -> f64 {
        f64::from(self.reach[0].hypot(self.reach[1]))
    }
}

/// A colour of the screen (sRGB) as linear light.
pub fn linear(colour: [u8; 3]) -> [u8; 3] {
    colour.map(|byte| (city::export::glb::linear(f64::from(byte) / 255.0) * 255.0).round() as u8)
}
