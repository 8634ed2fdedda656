//! Times of passes, outside any app.

use std::time::Instant;

use crate::Args;
use kit::{exposure_gpu::ExposureGpu, gpu_time::Time};

/// Measurements of one contender.
pub struct Measured {
    /// Times of the dispatches, each in its own pass.
    pub passes: Vec<Time>,
    /// Time of all dispatches in one pass.
    pub whole: Option<Time>,
    pub luminance: f64,
}

/// Writes the timestamps of a pass, on devices that have them.
pub struct Timestamps<'a>(Option<&'a wgpu::QuerySet>);

impl Timestamps<'_> {
    /// Timestamps at the begin of compute pass `index`, after all earlier commands, and at its end. They enclose the
    /// start of the dispatch and its last write, but not the barriers before it.
    pub fn of_pass(&self, index: usize) -> wgpu::ComputePassDescriptor<'_> {
        let first = 2 * index as u32;
        wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: self.0.map(|query_set| wgpu::ComputePassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(first),
                end_of_pass_write_index: Some(first + 1),
            }),
        }
    }

    /// Writes the first two timestamps around commands other than a compute pass. They enclose the barriers, too.
    pub fn around(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        encode: impl FnOnce(&mut wgpu::CommandEncoder),
    ) {
        if let Some(queries) = self.0 {
            encoder.write_timestamp(queries, 0);
        }
        encode(encoder);
        if let Some(queries) = self.0 {
            encoder.write_timestamp(queries, 1);
        }
    }
}

/// Times `passes` passes over the measured frames, after the warm-up. `encode` gets the index of the frame and that of
/// the pass to encode. It must write both timestamps: resolving an unwritten one may hang the device.
pub fn time(
    gpu: &ExposureGpu,
    passes: usize,
    args: &Args,
    encode: impl FnMut(usize, usize, &mut wgpu::CommandEncoder, Timestamps),
) -> Vec<Time> {
    if gpu.adapter.device_type == wgpu::DeviceType::Cpu {
        by_clock(gpu, passes, args, encode)
    } else {
        by_timestamps(gpu, passes, args, encode)
    }
}

fn by_timestamps(
    gpu: &ExposureGpu,
    passes: usize,
    args: &Args,
    mut encode: impl FnMut(usize, usize, &mut wgpu::CommandEncoder, Timestamps),
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
        for pass in 0..passes {
            encode(frame, pass, &mut encoder, Timestamps(Some(&queries)));
        }
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

/// Times passes on software renderers, from submission until they have finished: their timestamps need not enclose the
/// dispatch.
fn by_clock(
    gpu: &ExposureGpu,
    passes: usize,
    args: &Args,
    mut encode: impl FnMut(usize, usize, &mut wgpu::CommandEncoder, Timestamps),
) -> Vec<Time> {
    let mut samples = vec![Vec::new(); passes];
    for frame in 0..args.warm_up + args.frames {
        for (pass, samples) in samples.iter_mut().enumerate() {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            encode(frame, pass, &mut encoder, Timestamps(None));
            let commands = encoder.finish();
            let start = Instant::now();
            gpu.queue.submit([commands]);
            gpu.device
                .poll(wgpu::PollType::wait_indefinitely())
                .unwrap_or_else(|error| panic!("the device did not finish: {error}"));
            if frame >= args.warm_up {
                samples.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    samples.into_iter().map(Time::of).collect()
}
