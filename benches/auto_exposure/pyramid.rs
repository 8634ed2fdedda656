//! The classic reduction in three passes, as a baseline: see `pyramid.wgsl`.

use crate::{
    Args,
    kernel::{Kernel, compile},
    ring::Ring,
    timing::Measured,
};
use kit::exposure_gpu::ExposureGpu;
use wgpu::BindingResource::TextureView;

const PYRAMID: &str = include_str!("pyramid.wgsl");
const SUM_SHARED: &str = include_str!("sum_shared.wgsl");
const SUM_SUBGROUPS: &str = include_str!("sum_subgroups.wgsl");

/// Times the passes over `ring`, and returns the metered luminance with them.
pub fn measure(gpu: &ExposureGpu, ring: &Ring, subgroups: bool, args: &Args) -> Measured {
    use wgpu::BufferUsages as Usage;
    let sum = if subgroups { SUM_SUBGROUPS } else { SUM_SHARED };
    let source = format!("{sum}{PYRAMID}");
    let pipelines =
        ["reduce_picture", "reduce_sums", "reduce_rest"].map(|entry| compile(gpu, &source, entry));
    let size = ring.0[0].size();
    let metered = gpu.buffer(8, Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC);
    let pixels = size.width as f32 * size.height as f32;
    gpu.queue.write_buffer(&metered, 0, &pixels.to_le_bytes());

    let turns: Vec<Vec<Kernel>> = ring
        .0
        .iter()
        .map(|picture| {
            let levels: Vec<_> = core::iter::once(picture.clone())
                .chain([8, 64].map(|scale| level(gpu, size, scale)))
                .collect();
            let views: Vec<_> = levels
                .iter()
                .map(|level| level.create_view(&Default::default()))
                .collect();
            (0..3)
                .map(|i| {
                    let source = (0, TextureView(&views[i]));
                    let (result, groups) = match levels.get(i + 1) {
                        Some(level) => (
                            (1, TextureView(&views[i + 1])),
                            [level.width(), level.height()],
                        ),
                        None => ((2, metered.as_entire_binding()), [1, 1]),
                    };
                    Kernel {
                        pipeline: pipelines[i].clone(),
                        group: gpu
                            .bind_group(&pipelines[i].get_bind_group_layout(0), &[source, result]),
                        groups,
                    }
                })
                .collect()
        })
        .collect();
    let passes = Kernel::time(gpu, &turns, args);
    let whole = Some(Kernel::time_whole(gpu, &turns, args));
    let metered = gpu.read(&metered);
    let luminance = f32::from_le_bytes(*metered[4..].first_chunk().expect("it has 8 bytes"));
    Measured {
        passes,
        whole,
        luminance: luminance.into(),
    }
}

/// A texture with one texel per `scale`×`scale` pixels of the picture.
fn level(gpu: &ExposureGpu, picture: wgpu::Extent3d, scale: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: picture.width.div_ceil(scale),
            height: picture.height.div_ceil(scale),
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Float,
        usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}
