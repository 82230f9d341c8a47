//! Drawing with wgpu: one renderer for the window, for pictures without a window, and for tests.
//!
//! Everything is drawn around the view's own origin, so that 32-bit numbers keep centimetres anywhere on a site.

mod camera;
mod chunk;
mod pipelines;
mod target;

pub use camera::{MapCamera, OrbitCamera};
pub use chunk::{Chunk, Drawing, Flat, Placed, Solid, linear};
pub use target::Target;

use bytemuck::{Pod, Zeroable};
use geom::{Bounds, Raster, Vec2, Vec3};
use glam::{DVec3, Mat4, Vec4};
use pipelines::Pipelines;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What everything is painted in: linear light, packed as sRGB.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// Samples of a pixel.
const SAMPLES: u32 = 4;

/// Pixels along a side of the map of shadows.
const SHADOW_SIDE: u32 = 2048;

/// A device to draw with. Cheap to clone; works on any thread.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Its name and driver.
    pub about: String,
}

/// Why nothing can be drawn.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// There is no adapter.
    #[error(
        "no graphics adapter was found: {0}\n  hint: install a driver; in software, Debian's mesa-vulkan-drivers and libvulkan1 do"
    )]
    NoAdapter(#[from] wgpu::RequestAdapterError),
    /// The adapter gives no device.
    #[error("the graphics adapter refused: {0}")]
    NoDevice(#[from] wgpu::RequestDeviceError),
    /// A picture is larger than the device can hold, or has no pixels.
    #[error("no picture of {0} × {1} pixels can be drawn: between 1 and {2} each way")]
    Size(u32, u32, u32),
    /// A picture could not be read back.
    #[error("the picture could not be read back: {0}")]
    Read(String),
}

impl Gpu {
    /// A device without a window.
    ///
    /// # Errors
    /// When there is none.
    pub fn headless() -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
        let limits = adapter.limits();
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("plat"),
            required_limits: limits,
            ..wgpu::DeviceDescriptor::default()
        }))?;
        let info = adapter.get_info();
        Ok(Self { device, queue, about: format!("{} ({:?})", info.name, info.backend) })
    }
}

/// What a frame cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Calls to draw.
    pub draws: usize,
    /// Triangles and lines drawn.
    pub primitives: u64,
    /// Bytes uploaded for the frame.
    pub bytes: u64,
    /// Chunks that were in sight.
    pub seen: usize,
    /// Chunks that were out of sight.
    pub culled: usize,
    /// Chunks that were drawn without what is not seen from far off.
    pub simplified: usize,
    /// Time on the processor until the work was handed over.
    pub cpu: Duration,
}

/// How things are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Whether the sun throws shadows.
    pub shadows: bool,
    /// Strength of silhouettes, from 0 to 1.
    pub silhouettes: f32,
    /// Direction to the sun: degrees from north, and above the horizon.
    pub sun: (f64, f64),
    /// Metres up to which everything is drawn; farther off what would be smaller than a pixel is left out.
    pub detail: f64,
}

impl Default for Look {
    fn default() -> Self {
        Self { shadows: true, silhouettes: 0.55, sun: (225.0, 42.0), detail: 3000.0 }
    }
}

/// A map laid over everything.
#[derive(Clone, Debug)]
pub struct Overlay {
    texture: wgpu::Texture,
    /// From 0, unseen, to 1.
    pub opacity: f32,
}

/// Most pixels of an overlay along a side.
const MOST_OVERLAY: usize = 2048;

impl Overlay {
    /// Uploads a map.
    pub fn of(gpu: &Gpu, raster: &Raster, opacity: f32) -> Self {
        let (width, height, values) = thinned(raster, MOST_OVERLAY);
        let (low, high) = values.iter().fold((f32::MAX, f32::MIN), |(low, high), &v| (low.min(v), high.max(v)));
        // The colours tell no more than so many values apart.
        let share = |value: &f32| if high > low { (value - low) / (high - low) } else { 0.0 };
        let bytes: Vec<u8> = values.iter().map(|value| (share(value) * 255.0).round() as u8).collect();
        Self { texture: upload(gpu, [width, height], wgpu::TextureFormat::R8Unorm, &bytes, 1), opacity }
    }
}

/// A raster's values, every so many of them that at most so many pixels are left along a side; row 0 in the north.
fn thinned(raster: &Raster, most: usize) -> (u32, u32, Vec<f32>) {
    let (columns, rows) = raster.size();
    let step = columns.max(rows).div_ceil(most).max(1);
    let (width, height) = (columns.div_ceil(step), rows.div_ceil(step));
    let values = raster.values();
    let at = |i: usize, count: usize| (i * step + step / 2).min(count - 1);
    let thin = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    (width as u32, height as u32, thin.map(|(x, y)| values[at(y, rows) * columns + at(x, columns)]).collect())
}

fn upload(gpu: &Gpu, [width, height]: [u32; 2], format: wgpu::TextureFormat, bytes: &[u8], size: u32) -> wgpu::Texture {
    let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("map"),
        size: extent,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * size), rows_per_image: None };
    gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, extent);
    texture
}

/// Land, parks and hills below a map.
#[derive(Clone, Debug)]
pub struct Ground {
    texture: wgpu::Texture,
}

impl Ground {
    /// Uploads a picture: land and parks from 0 to 1, the light on hills around one half.
    pub fn of(gpu: &Gpu, size: [u32; 2], pixels: &[[u8; 4]]) -> Self {
        Self { texture: upload(gpu, size, wgpu::TextureFormat::Rgba8Unorm, bytemuck::cast_slice(pixels), 4) }
    }
}

/// What a view shows, from below.
#[derive(Debug)]
pub struct Shown<'a> {
    /// The site.
    pub site: Bounds,
    /// Chunks in the order they are painted, with whether they are lines.
    pub chunks: Vec<(&'a Chunk, Kind)>,
    /// The map laid over.
    pub overlay: Option<&'a Overlay>,
    /// What lies below a map, and whether water and parks are told from land.
    pub ground: Option<(&'a Ground, [bool; 2])>,
    /// How it is shown.
    pub look: Look,
    /// What is behind everything (sRGB).
    pub background: [u8; 3],
}

/// What a chunk is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Surfaces in space.
    Solid,
    /// Areas of a map.
    Area,
    /// Lines of a map, one pixel wide.
    Line,
}

/// Where one looks from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Camera {
    /// From above.
    Map(MapCamera),
    /// From around a place.
    Orbit(OrbitCamera),
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct ViewNumbers {
    to_clip: [f32; 16],
    to_sun: [f32; 16],
    sun: [f32; 4],
    screen: [f32; 4],
    site: [f32; 4],
    strengths: [f32; 4],
}

/// Draws.
#[derive(Debug)]
pub struct Renderer {
    gpu: Gpu,
    pipelines: Pipelines,
    view: wgpu::Buffer,
    corners: wgpu::Buffer,
    room: usize,
    shadows: wgpu::TextureView,
    nothing: wgpu::Texture,
}

impl Renderer {
    /// A renderer on a device.
    pub fn new(gpu: Gpu) -> Self {
        let pipelines = Pipelines::new(&gpu);
        let view = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("view"),
            size: size_of::<ViewNumbers>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let shadows = target::depth(&gpu, [SHADOW_SIDE; 2], 1, "shadows");
        let nothing = upload(&gpu, [1, 1], wgpu::TextureFormat::R8Unorm, &[0], 1);
        let room = 256;
        let corners = corner_buffer(&gpu, room);
        Self { gpu, pipelines, view, corners, room, shadows, nothing }
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Draws on a target. Returns as soon as the work is handed over.
    pub fn draw(&mut self, target: &Target, camera: &Camera, shown: &Shown) -> Cost {
        let begin = Instant::now();
        let pixels = target.pixels();
        let origin = origin(camera);
        let (to_clip, range, height) = match camera {
            Camera::Map(map) => (map.to_clip(pixels), (map.scale, 1.0), 0.0),
            Camera::Orbit(orbit) => (orbit.to_clip(pixels), orbit.range(), orbit.target.z),
        };
        let down = Mat4::from_translation(glam::Vec3::new(0.0, 0.0, -height as f32));
        let to_clip = to_clip * down;
        let sun = towards(shown.look.sun);
        let has_shadows = shown.look.shadows && matches!(camera, Camera::Orbit(_));
        let to_sun = sun_view(camera, sun) * down;
        let corner = shown.site.min.metres() - origin.truncate();
        let size = shown.site.size();
        let [water, parks] = shown.ground.map_or([0.0; 2], |(_, parts)| parts.map(|is_on| f32::from(u8::from(is_on))));
        let numbers = ViewNumbers {
            to_clip: to_clip.to_cols_array(),
            to_sun: to_sun.to_cols_array(),
            sun: sun.as_vec3().extend(if has_shadows { 1.0 } else { 0.0 }).to_array(),
            screen: [pixels[0], pixels[1], range.0 as f32, range.1 as f32],
            site: [corner.x as f32, corner.y as f32, size.x as f32, size.y as f32],
            strengths: [shown.overlay.map_or(0.0, |overlay| overlay.opacity), shown.look.silhouettes, water, parks],
        };
        self.gpu.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&numbers));
        let mut cost = Cost::default();
        let seen: Vec<Seen> = shown
            .chunks
            .iter()
            .filter(|(chunk, _)| is_seen(chunk, origin, &to_clip))
            .map(|&(chunk, kind)| Seen { chunk, kind, count: count(chunk, camera, shown.look.detail) })
            .collect();
        cost.seen = seen.len();
        cost.culled = shown.chunks.len() - seen.len();
        // In the shadows that fall into the picture, things outside it count.
        let casting: Vec<&Chunk> = if has_shadows {
            let solid = shown.chunks.iter().filter(|(chunk, kind)| *kind == Kind::Solid && chunk.casts);
            solid.map(|(chunk, _)| *chunk).filter(|chunk| is_seen(chunk, origin, &to_sun)).collect()
        } else {
            Vec::new()
        };
        cost.bytes = size_of::<ViewNumbers>() as u64 + self.place(shown, &seen, &casting, origin);
        self.encode(target, shown, (&seen, &casting), matches!(camera, Camera::Orbit(_)), &mut cost);
        cost.cpu = begin.elapsed();
        cost
    }

    /// Uploads the corners of all tiles that are drawn; returns how many bytes. The first is that of the site.
    fn place(&mut self, shown: &Shown, seen: &[Seen], casting: &[&Chunk], origin: Vec3) -> u64 {
        let off = |corner: Vec2| (corner - origin.truncate()).as_vec2().to_array();
        let chunks = seen.iter().map(|seen| seen.chunk).chain(casting.iter().copied());
        let corners: Vec<[f32; 2]> =
            std::iter::once(off(shown.site.min.metres())).chain(chunks.map(|chunk| off(chunk.corner))).collect();
        if corners.len() > self.room {
            self.room = corners.len().next_power_of_two();
            self.corners = corner_buffer(&self.gpu, self.room);
        }
        let bytes = bytemuck::cast_slice(&corners);
        self.gpu.queue.write_buffer(&self.corners, 0, bytes);
        bytes.len() as u64
    }

    fn encode(
        &self,
        target: &Target,
        shown: &Shown,
        (seen, casting): (&[Seen], &[&Chunk]),
        in_space: bool,
        cost: &mut Cost,
    ) {
        let device = &self.gpu.device;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("view") });
        let overlay = shown.overlay.map_or(&self.nothing, |overlay| &overlay.texture);
        if !casting.is_empty() {
            let bindings = self.pipelines.bind_view(device, &self.view, overlay, &self.pipelines.no_shadows);
            let mut pass = encoder.begin_render_pass(&target::depth_pass(&self.shadows));
            pass.set_pipeline(&self.pipelines.shadow);
            pass.set_bind_group(0, &bindings, &[]);
            pass.set_vertex_buffer(1, self.corners.slice(..));
            for (i, chunk) in casting.iter().enumerate() {
                self.draw_chunk(&mut pass, chunk, chunk.from_far, 1 + seen.len() + i, cost);
            }
        }
        let bindings = self.pipelines.bind_view(device, &self.view, overlay, &self.shadows);
        let paint = |pass: &mut wgpu::RenderPass| {
            pass.set_bind_group(0, &bindings, &[]);
            pass.set_vertex_buffer(1, self.corners.slice(..));
            if let Some((ground, _)) = shown.ground {
                pass.set_bind_group(1, &self.pipelines.bind_texture(device, &ground.texture), &[]);
                self.paint_site(pass, &self.pipelines.ground, shown, cost);
            }
            let mut kind = None;
            for (i, seen) in seen.iter().enumerate() {
                if kind.replace(seen.kind) != Some(seen.kind) {
                    pass.set_pipeline(self.pipelines.of(seen.kind));
                }
                self.draw_chunk(pass, seen.chunk, seen.count, 1 + i, cost);
            }
            // In space it lies on every surface.
            if shown.overlay.is_some() && !in_space {
                self.paint_site(pass, &self.pipelines.overlay, shown, cost);
            }
        };
        let over = (in_space && shown.look.silhouettes > 0.0).then_some(
            |pass: &mut wgpu::RenderPass, drawn: &wgpu::TextureView, depths: &wgpu::TextureView| {
                pass.set_pipeline(&self.pipelines.silhouettes);
                pass.set_bind_group(0, &bindings, &[]);
                pass.set_bind_group(1, &self.pipelines.bind_drawn(device, drawn, depths), &[]);
                pass.draw(0..3, 0..1);
            },
        );
        target.paint(&mut encoder, shown.background, paint, over);
        self.gpu.queue.submit([encoder.finish()]);
    }

    fn paint_site(&self, pass: &mut wgpu::RenderPass, pipeline: &wgpu::RenderPipeline, shown: &Shown, cost: &mut Cost) {
        pass.set_pipeline(pipeline);
        pass.set_vertex_buffer(0, self.site_quad(shown).slice(..));
        pass.draw(0..6, 0..1);
        cost.draws += 1;
        cost.primitives += 2;
    }

    fn draw_chunk(&self, pass: &mut wgpu::RenderPass, chunk: &Chunk, count: u32, place: usize, cost: &mut Cost) {
        let place = place as u32;
        pass.set_vertex_buffer(0, chunk.vertices.slice(..));
        pass.set_index_buffer(chunk.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..count, 0, place..place + 1);
        cost.draws += 1;
        cost.primitives += u64::from(count / 3);
        cost.simplified += usize::from(count < chunk.count);
    }

    /// The site as two triangles around its corner.
    fn site_quad(&self, shown: &Shown) -> wgpu::Buffer {
        use wgpu::util::DeviceExt;
        let size = shown.site.size().as_vec2();
        let corner = |x: f32, y: f32| Flat { position: [x * size.x, y * size.y], reach: [0.0; 3], colour: [255; 4] };
        let corners = [
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(1.0, 1.0),
            corner(0.0, 0.0),
            corner(1.0, 1.0),
            corner(0.0, 1.0),
        ];
        let contents = bytemuck::cast_slice(&corners);
        let usage = wgpu::BufferUsages::VERTEX;
        self.gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("site"), contents, usage })
    }
}

fn corner_buffer(gpu: &Gpu, room: usize) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("corners"),
        size: room as u64 * 8,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// What everything is drawn around: a place of the plane; heights stay as they are.
fn origin(camera: &Camera) -> Vec3 {
    match camera {
        Camera::Map(map) => map.centre.extend(0.0),
        Camera::Orbit(orbit) => orbit.target.truncate().extend(0.0),
    }
}

/// The way to the sun.
fn towards((heading, height): (f64, f64)) -> Vec3 {
    let (heading, height) = (heading.to_radians(), height.to_radians());
    Vec3::new(heading.sin() * height.cos(), heading.cos() * height.cos(), height.sin())
}

/// From metres around the view's origin to what the sun sees of what is looked at.
fn sun_view(camera: &Camera, sun: Vec3) -> Mat4 {
    let radius = match camera {
        Camera::Map(_) => 1000.0,
        Camera::Orbit(orbit) => orbit.distance * 0.9,
    };
    let depth = radius * 2.0 + 1500.0;
    (camera::orthographic(radius, depth) * camera::looking(DVec3::ZERO, -sun, DVec3::Z)).as_mat4()
}

/// A chunk that is in sight.
struct Seen<'a> {
    chunk: &'a Chunk,
    kind: Kind,
    /// Indices to draw.
    count: u32,
}

/// How many indices of a chunk are drawn.
fn count(chunk: &Chunk, camera: &Camera, detail: f64) -> u32 {
    let Camera::Orbit(orbit) = camera else { return chunk.count };
    let eye = orbit.eye();
    let nearest = eye.clamp(chunk.bounds.0, chunk.bounds.1);
    if nearest.distance(eye) > detail { chunk.from_far } else { chunk.count }
}

/// Whether a box may be in sight: not wholly behind one of the planes of the view.
fn is_seen(chunk: &Chunk, origin: Vec3, to_clip: &Mat4) -> bool {
    let (low, high) = chunk.bounds;
    let corners = (0..8).map(|i| {
        let pick = |bit: u32, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
        let place = Vec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z)) - origin;
        *to_clip * place.as_vec3().extend(1.0)
    });
    let corners: Vec<Vec4> = corners.collect();
    let planes: [fn(&Vec4) -> f32; 6] =
        [|c| c.w + c.x, |c| c.w - c.x, |c| c.w + c.y, |c| c.w - c.y, |c| c.z, |c| c.w - c.z];
    planes.iter().all(|inside| corners.iter().any(|corner| inside(corner) >= 0.0))
}

/// A shared reference to a chunk.
pub type ChunkRef = Arc<Chunk>;
