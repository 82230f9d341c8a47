//! What is painted on, and how it becomes a picture.

use super::{FORMAT, Gpu, GpuError, SAMPLES};

/// The format of depths.
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A picture being painted, of a size in pixels.
#[derive(Debug)]
pub struct Target {
    size: [u32; 2],
    samples: wgpu::TextureView,
    depths: wgpu::TextureView,
    /// Where silhouettes are not drawn yet.
    drawn: wgpu::Texture,
    picture: wgpu::Texture,
    /// The picture, to be painted.
    view: wgpu::TextureView,
    /// The same as windows show it: they take colours as they are packed.
    shown: wgpu::TextureView,
}

fn texture(
    gpu: &Gpu,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    samples: u32,
    label: &str,
) -> wgpu::Texture {
    let once = samples == 1 && format == FORMAT;
    let read = if once { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::empty() };
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING | read,
        view_formats: if once { &[wgpu::TextureFormat::Rgba8Unorm] } else { &[] },
    })
}

/// A texture of depths.
pub(super) fn depth(gpu: &Gpu, size: [u32; 2], samples: u32, label: &str) -> wgpu::TextureView {
    texture(gpu, size, DEPTH, samples, label).create_view(&wgpu::TextureViewDescriptor::default())
}

fn depth_attachment(view: &wgpu::TextureView) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    let depth_ops = Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store });
    wgpu::RenderPassDepthStencilAttachment { view, depth_ops, stencil_ops: None }
}

/// A pass that finds depths alone.
pub(super) fn depth_pass(view: &wgpu::TextureView) -> wgpu::RenderPassDescriptor<'_> {
    wgpu::RenderPassDescriptor {
        label: Some("shadows"),
        depth_stencil_attachment: Some(depth_attachment(view)),
        ..wgpu::RenderPassDescriptor::default()
    }
}

impl Target {
    /// A target of a size in pixels.
    ///
    /// # Errors
    /// When the device cannot hold it.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        let most = gpu.device.limits().max_texture_dimension_2d;
        if size.iter().any(|side| !(1..=most).contains(side)) {
            return Err(GpuError::Size(size[0], size[1], most));
        }
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let picture = texture(gpu, size, FORMAT, 1, "picture");
        Ok(Self {
            size,
            samples: view(&texture(gpu, size, FORMAT, SAMPLES, "samples")),
            depths: depth(gpu, size, SAMPLES, "depths"),
            drawn: texture(gpu, size, FORMAT, 1, "drawn"),
            view: view(&picture),
            shown: picture.create_view(&wgpu::TextureViewDescriptor {
                format: Some(wgpu::TextureFormat::Rgba8Unorm),
                usage: Some(wgpu::TextureUsages::TEXTURE_BINDING),
                ..wgpu::TextureViewDescriptor::default()
            }),
            picture,
        })
    }

    /// Its size in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    pub(super) fn pixels(&self) -> [f32; 2] {
        self.size.map(|side| side as f32)
    }

    /// The picture, to be shown in a window.
    pub fn shown(&self) -> &wgpu::TextureView {
        &self.shown
    }

    /// Paints on a background; with what is painted over the finished picture, where there is such a thing.
    pub(super) fn paint(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        background: [u8; 3],
        paint: impl FnOnce(&mut wgpu::RenderPass),
        over: Option<impl FnOnce(&mut wgpu::RenderPass, &wgpu::TextureView, &wgpu::TextureView)>,
    ) {
        let [r, g, b] = super::linear(background).map(|byte| f64::from(byte) / 255.0);
        let load = wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 });
        let drawn = self.drawn.create_view(&wgpu::TextureViewDescriptor::default());
        let resolved = if over.is_some() { &drawn } else { &self.view };
        {
            let attachment = wgpu::RenderPassColorAttachment {
                view: &self.samples,
                depth_slice: None,
                resolve_target: Some(resolved),
                ops: wgpu::Operations { load, store: wgpu::StoreOp::Discard },
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("view"),
                color_attachments: &[Some(attachment)],
                depth_stencil_attachment: Some(depth_attachment(&self.depths)),
                ..wgpu::RenderPassDescriptor::default()
            });
            paint(&mut pass);
        }
        let Some(over) = over else { return };
        let attachment = wgpu::RenderPassColorAttachment {
            view: &self.view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("silhouettes"),
            color_attachments: &[Some(attachment)],
            ..wgpu::RenderPassDescriptor::default()
        });
        over(&mut pass, &drawn, &self.depths);
    }

    /// Waits until the picture is painted and reads it.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn read(&self, gpu: &Gpu) -> Result<image::RgbaImage, GpuError> {
        let [width, height] = self.size;
        let row = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read"),
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read") });
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(self.picture.as_image_copy(), to, self.picture.size());
        gpu.queue.submit([encoder.finish()]);
        let read = |what: &dyn std::fmt::Display| GpuError::Read(what.to_string());
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // Nobody listens any more where the device was lost meanwhile.
            let _ = sender.send(result);
        });
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| read(&error))?;
        receiver.recv().map_err(|error| read(&error))?.map_err(|error| read(&error))?;
        let bytes = buffer.slice(..).get_mapped_range().map_err(|error| read(&error))?;
        let rows = bytes.chunks_exact(row as usize).flat_map(|line| line[..width as usize * 4].iter().copied());
        image::RgbaImage::from_raw(width, height, rows.collect()).ok_or(GpuError::Size(width, height, 0))
    }
}
