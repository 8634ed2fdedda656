//! GPU times of passes, outside of any app.

use crate::{Args, common::exposure_gpu::ExposureGpu, gpu_time::Time};

/// Where a frame of [`time`] notes its timestamps.
pub struct Timestamps<'a>(pub &'a wgpu::QuerySet);

impl Timestamps<'_> {
    /// For compute pass `index`: at its begin, when all earlier commands have ended, and at its end. Between them lie the
    /// barriers that its bindings need, the start of the dispatch and its last write.
    pub fn of_pass(&self, index: usize) -> wgpu::ComputePassDescriptor<'_> {
        let first = 2 * index as u32;
        wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                query_set: self.0,
                beginning_of_pass_write_index: Some(first),
                end_of_pass_write_index: Some(first + 1),
            }),
        }
    }
}

/// Times of `passes` passes over some frames after others to warm up. `encode` gets the number of the frame and writes all
/// timestamps of it: to resolve one that was not written may hang the device.
pub fn time(
    gpu: &ExposureGpu,
    passes: usize,
    args: &Args,
    mut encode: impl FnMut(usize, &mut wgpu::CommandEncoder, Timestamps),
) -> Vec<Time> {
    use wgpu::BufferUsages as Usage;
    let count = 2 * passes as u32;
    let size = u64::from(count) * 8;
    let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
        label: None,
        ty: wgpu::QueryType::Timestamp,
        count,
    });
    let resolved = gpu.buffer(size, Usage::QUERY_RESOLVE | Usage::COPY_SRC);
    let all = gpu.buffer(size * args.frames as u64, Usage::COPY_DST | Usage::COPY_SRC);
    for frame in 0..args.warm_up + args.frames {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encode(frame, &mut encoder, Timestamps(&queries));
        encoder.resolve_query_set(&queries, 0..count, &resolved, 0);
        if let Some(measured) = frame.checked_sub(args.warm_up) {
            encoder.copy_buffer_to_buffer(&resolved, 0, &all, size * measured as u64, size);
        }
        gpu.queue.submit([encoder.finish()]);
    }
    let milliseconds = f64::from(gpu.queue.get_timestamp_period()) * 1e-6;
    let ticks: Vec<u64> = gpu
        .read(&all)
        .chunks_exact(8)
        .map(|bytes| u64::from_le_bytes(*bytes.first_chunk().expect("chunks of 8")))
        .collect();
    (0..passes)
        .map(|pass| {
            let of_frame = |frame: &[u64]| {
                frame[2 * pass + 1].saturating_sub(frame[2 * pass]) as f64 * milliseconds
            };
            Time::of(ticks.chunks_exact(count as usize).map(of_frame).collect())
        })
        .collect()
}
