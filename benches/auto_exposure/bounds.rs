//! Upper bounds of the memory's speed: copies, a read, and an idle dispatch.

use crate::{
    Args,
    kernel::{Kernel, compile},
    picture::TEXEL,
    ring::Ring,
    timing::time,
};
use figures::benches::auto_exposure::{Group, Measurement};
use kit::{exposure_gpu::ExposureGpu, gpu_time::Time};

/// Times the bounds over `ring`.
pub fn measure(gpu: &ExposureGpu, ring: &Ring, args: &Args) -> Vec<Measurement> {
    let size = ring.0[0].size();
    let bytes = f64::from(size.width) * f64::from(size.height) * TEXEL as f64;
    let of = |name: &str, group, passes: Vec<Time>, bytes| Measurement {
        group,
        contender: name.into(),
        whole: passes.first().copied(),
        passes,
        bytes,
        luminance: None,
        error: None,
    };
    vec![
        of(
            "copy, by a compute shader",
            Group::Copy,
            by_shader(gpu, ring, args),
            2.0 * bytes,
        ),
        of(
            "copy, `copy_texture_to_texture`",
            Group::Copy,
            by_command(gpu, ring, args),
            2.0 * bytes,
        ),
        of(
            "read, nothing else",
            Group::Bound,
            of_buffer(gpu, ring, args, "read"),
            bytes,
        ),
        of(
            "dispatch of one idle workgroup",
            Group::Bound,
            of_buffer(gpu, ring, args, "nothing"),
            0.0,
        ),
    ]
}

fn targets(gpu: &ExposureGpu, ring: &Ring, usage: wgpu::TextureUsages) -> Ring {
    let size = ring.0[0].size();
    let size = bevy::math::UVec2::new(size.width, size.height);
    Ring::empty(gpu, size, ring.0.len(), usage)
}

fn by_shader(gpu: &ExposureGpu, ring: &Ring, args: &Args) -> Vec<Time> {
    let targets = targets(gpu, ring, wgpu::TextureUsages::STORAGE_BINDING);
    let pipeline = compile(gpu, include_str!("copy.wgsl"), "copy");
    let size = ring.0[0].size();
    let kernels = ring.0.iter().zip(&targets.0).map(|(picture, target)| {
        let [picture, target] =
            [picture, target].map(|texture| texture.create_view(&Default::default()));
        let resources = [
            (0, wgpu::BindingResource::TextureView(&picture)),
            (1, wgpu::BindingResource::TextureView(&target)),
        ];
        let groups = [size.width.div_ceil(16), size.height.div_ceil(16)];
        vec![Kernel {
            pipeline: pipeline.clone(),
            group: gpu.bind_group(&pipeline.get_bind_group_layout(0), &resources),
            groups,
        }]
    });
    Kernel::time(gpu, &kernels.collect::<Vec<_>>(), args)
}

fn by_command(gpu: &ExposureGpu, ring: &Ring, args: &Args) -> Vec<Time> {
    if !gpu.has(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS) {
        return Vec::new();
    }
    let targets = targets(gpu, ring, wgpu::TextureUsages::COPY_DST);
    time(gpu, 1, args, |frame, _, encoder, timestamps| {
        let turn = frame % ring.0.len();
        timestamps.around(encoder, |encoder| {
            encoder.copy_texture_to_texture(
                ring.0[turn].as_image_copy(),
                targets.0[turn].as_image_copy(),
                ring.0[turn].size(),
            );
        });
    })
}

/// Times an entry point whose only output is a buffer.
fn of_buffer(gpu: &ExposureGpu, ring: &Ring, args: &Args, entry_point: &str) -> Vec<Time> {
    let pipeline = compile(gpu, include_str!("copy.wgsl"), entry_point);
    let total = gpu.buffer(4, wgpu::BufferUsages::STORAGE);
    let kernels = ring.0.iter().map(|picture| {
        let size = picture.size();
        let picture = picture.create_view(&Default::default());
        let mut resources = vec![(2, total.as_entire_binding())];
        let mut groups = [1, 1];
        if entry_point == "read" {
            resources.push((0, wgpu::BindingResource::TextureView(&picture)));
            groups = [size.width.div_ceil(64), size.height.div_ceil(128)];
        }
        vec![Kernel {
            pipeline: pipeline.clone(),
            group: gpu.bind_group(&pipeline.get_bind_group_layout(0), &resources),
            groups,
        }]
    });
    Kernel::time(gpu, &kernels.collect::<Vec<_>>(), args)
}
