//! Runs functions of the crate's WGSL modules on the device, over arrays of words.

use crate::wgsl::{WgslModule, compile, numbers};
use bevy::tasks::block_on;

/// Invocations per workgroup.
const WORKGROUP: usize = 64;
/// Workgroups per row of the dispatch: the limit that every device supports.
const WORKGROUPS_IN_ROW: usize = 65_535;

/// A wgpu device separate from Bevy's.
pub struct Compute {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
}

/// A WGSL function from `INPUT` words to `OUTPUT` words, compiled to run over many inputs.
pub struct Kernel<'a, const INPUT: usize, const OUTPUT: usize> {
    compute: &'a Compute,
    pipeline: wgpu::ComputePipeline,
}

impl Compute {
    pub fn new() -> Self {
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
            .unwrap_or_else(|error| panic!("no graphics adapter: {error}"));
        let (device, queue) = block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))
            .unwrap_or_else(|error| panic!("no device: {error}"));
        Self { device, queue }
    }

    /// Compiles `source`, which imports from `modules` and defines
    /// `fn kernel(input: array<u32, INPUT>) -> array<u32, OUTPUT>`.
    pub fn kernel<const INPUT: usize, const OUTPUT: usize>(
        &self,
        modules: &[WgslModule],
        source: &str,
    ) -> Kernel<'_, INPUT, OUTPUT> {
        self.kernel_with(modules, source, &[])
    }

    /// As [`kernel`](Self::kernel), with shader definitions.
    pub fn kernel_with<const INPUT: usize, const OUTPUT: usize>(
        &self,
        modules: &[WgslModule],
        source: &str,
        definitions: &[(&str, u32)],
    ) -> Kernel<'_, INPUT, OUTPUT> {
        let source = format!("{source}\n{}", entry_point(INPUT, OUTPUT));
        let shader = compile(&self.device, modules, &source, numbers(definitions));
        let pipeline = self
            .device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("kernel"),
                layout: None,
                module: &shader,
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
        Kernel {
            compute: self,
            pipeline,
        }
    }

    fn buffer(&self, bytes: usize, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes as u64,
            usage,
            mapped_at_creation: false,
        })
    }
}

impl<const INPUT: usize, const OUTPUT: usize> Kernel<'_, INPUT, OUTPUT> {
    /// Returns the kernel's result for each of `inputs`.
    pub fn run(&self, inputs: &[[u32; INPUT]]) -> Vec<[u32; OUTPUT]> {
        if inputs.is_empty() {
            return Vec::new();
        }
        let Compute { device, queue } = self.compute;
        let input_bytes: Vec<u8> = inputs
            .as_flattened()
            .iter()
            .flat_map(|word| word.to_le_bytes())
            .collect();
        let output_size = inputs.len() * OUTPUT * size_of::<u32>();

        use wgpu::BufferUsages as Usage;
        let input = self
            .compute
            .buffer(input_bytes.len(), Usage::STORAGE | Usage::COPY_DST);
        let output = self
            .compute
            .buffer(output_size, Usage::STORAGE | Usage::COPY_SRC);
        let readback = self
            .compute
            .buffer(output_size, Usage::MAP_READ | Usage::COPY_DST);
        queue.write_buffer(&input, 0, &input_bytes);

        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: input.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: output.as_entire_binding(),
                },
            ],
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &bind_group, &[]);
            let groups = inputs.len().div_ceil(WORKGROUP);
            let row = groups.min(WORKGROUPS_IN_ROW);
            pass.dispatch_workgroups(row as u32, groups.div_ceil(row) as u32, 1);
        }
        encoder.copy_buffer_to_buffer(&output, 0, &readback, 0, output_size as u64);
        queue.submit([encoder.finish()]);

        readback.map_async(wgpu::MapMode::Read, .., |mapped| {
            mapped.unwrap_or_else(|error| panic!("the results cannot be read: {error}"));
        });
        device
            .poll(wgpu::PollType::wait_indefinitely())
            .unwrap_or_else(|error| panic!("the device did not finish: {error}"));
        let words: Vec<u32> = readback
            .get_mapped_range(..)
            .as_chunks()
            .0
            .iter()
            .map(|bytes| u32::from_le_bytes(*bytes))
            .collect();
        words.as_chunks::<OUTPUT>().0.to_vec()
    }
}

/// The compute entry point, which calls `kernel` once per input.
fn entry_point(input: usize, output: usize) -> String {
    format!(
        "
@group(0) @binding(0) var<storage, read> kernel_inputs: array<array<u32, {input}>>;
@group(0) @binding(1) var<storage, read_write> kernel_outputs: array<array<u32, {output}>>;

@compute @workgroup_size({WORKGROUP})
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {{
    let index = id.x + id.y * groups.x * {WORKGROUP}u;
    if index < arrayLength(&kernel_inputs) {{
        kernel_outputs[index] = kernel(kernel_inputs[index]);
    }}
}}
"
    )
}
