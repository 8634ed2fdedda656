//! Shaders that only the bench has.

use crate::{Args, timing::time};
use kit::{exposure_gpu::ExposureGpu, gpu::compute_pipeline, gpu_time::Time};

/// A dispatch.
pub struct Kernel {
    pub pipeline: wgpu::ComputePipeline,
    pub group: wgpu::BindGroup,
    pub groups: [u32; 2],
}

impl Kernel {
    /// Times each dispatch of frames that take turns.
    pub fn time(gpu: &ExposureGpu, turns: &[Vec<Self>], args: &Args) -> Vec<Time> {
        time(
            gpu,
            turns[0].len(),
            args,
            |frame, index, encoder, timestamps| {
                let kernel = &turns[frame % turns.len()][index];
                kernel.dispatch(&mut encoder.begin_compute_pass(&timestamps.of_pass(index)));
            },
        )
    }

    /// Times frames that take turns, with all dispatches of a frame in one pass.
    pub fn time_whole(gpu: &ExposureGpu, turns: &[Vec<Self>], args: &Args) -> Time {
        time(gpu, 1, args, |frame, index, encoder, timestamps| {
            let mut pass = encoder.begin_compute_pass(&timestamps.of_pass(index));
            for kernel in &turns[frame % turns.len()] {
                kernel.dispatch(&mut pass);
            }
        })[0]
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(self.groups[0], self.groups[1], 1);
    }
}

/// Compiles an entry point, with the layout that the shader asks for.
pub fn compile(gpu: &ExposureGpu, source: &str, entry_point: &str) -> wgpu::ComputePipeline {
    compute_pipeline(&gpu.device, source, Some(entry_point))
}
