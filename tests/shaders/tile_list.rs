//! Exactly the tiles with special surfaces are listed.

use std::collections::BTreeSet;

use kit::{
    compute::Compute,
    random::Random,
    shipped_wgsl,
    wgsl::{WgslModule, compile, numbers},
};
use wgpu::BufferUsages;

const MODULES: [WgslModule; 3] = [
    shipped_wgsl!("shader_library/layout.wgsl"),
    shipped_wgsl!("shader_library/layout/specialization.wgsl"),
    shipped_wgsl!("lighting/tile_list.wgsl"),
];

const TILE: usize = 64;
/// Number of tested tiles, for which the list has room.
const TILES: usize = 512;
/// Plain surfaces, clearcoat, diffuse transmission, and rim.
const KINDS: [u32; 4] = [0, 4, 5, 3];

const LIST_TILES: &str = "
#import bevy_lean_deferred::lighting::tile_list::list_tile

@group(0) @binding(0) var<storage, read> kinds: array<u32>;
@group(0) @binding(1) var<storage, read_write> answers: array<atomic<u32>>;

@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let is_listed = list_tile(vec2(8u * tile.x, 0u), kinds[64u * tile.x + invocation], invocation);
    // Each invocation says so.
    if is_listed {
        atomicAdd(&answers[tile.x], 1u);
    }
}";

/// Fills a workgroup's shared memory with ones.
const MAKE_DIRTY: &str = "
@group(0) @binding(0) var<storage, read> kinds: array<u32>;
@group(3) @binding(0) var<storage, read_write> dispatch: array<atomic<u32>>;
@group(3) @binding(1) var<storage, read_write> list: array<atomic<u32>>;

var<workgroup> memory: array<atomic<u32>, 4096>;

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(local_invocation_index) invocation: u32) {
    for (var i = invocation; i < 4096u; i += 64u) {
        atomicStore(&memory[i], 0xffffffffu);
    }
    workgroupBarrier();
    // Never so; but without a use of it compilers would drop the memory.
    if atomicLoad(&memory[4095u - invocation]) == kinds[0] + 12345u {
        atomicStore(&list[0], atomicLoad(&dispatch[0]));
    }
}";

/// A pipeline that does not clear shared memory, like Bevy's compute pipelines.
fn pipeline(
    compute: &Compute,
    layout: &wgpu::PipelineLayout,
    source: &str,
) -> wgpu::ComputePipeline {
    let definitions = numbers(&[("LISTED_VARIANTS", 1)]);
    let shader = compile(&compute.device, &MODULES, source, definitions);
    (compute.device).create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: Some(layout),
        module: &shader,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions {
            zero_initialize_workgroup_memory: false,
            ..Default::default()
        },
        cache: None,
    })
}

fn storage_layout(device: &wgpu::Device, read_only: &[bool]) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0u32..)
        .zip(read_only)
        .map(|(binding, &read_only)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    })
}

fn storage_group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0u32..)
        .zip(buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &entries,
    })
}

fn buffer(device: &wgpu::Device, words: usize, usage: BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 4 * words as u64,
        usage,
        mapped_at_creation: false,
    })
}

/// Kind of each pixel: most tiles have one or two.
fn random_kinds() -> Vec<u32> {
    let mut random = Random::new(5);
    (0..TILES)
        .flat_map(|_| {
            let of_tile: Vec<u32> = (0..1 + random.below(3))
                .map(|_| KINDS[random.below(KINDS.len())])
                .collect();
            (0..TILE)
                .map(|_| of_tile[random.below(of_tile.len())])
                .collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn tiles_with_special_surfaces_are_listed() {
    let compute = Compute::new();
    let Compute { device, queue } = &compute;
    let [read, empty, written] =
        [&[true, false][..], &[], &[false, false]].map(|bindings| storage_layout(device, bindings));
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(&read), Some(&empty), Some(&empty), Some(&written)],
        ..Default::default()
    });
    let [make_dirty, list_tiles] =
        [MAKE_DIRTY, LIST_TILES].map(|source| pipeline(&compute, &layout, source));

    let kinds = random_kinds();
    let input = buffer(
        device,
        kinds.len(),
        BufferUsages::STORAGE | BufferUsages::COPY_DST,
    );
    queue.write_buffer(&input, 0, bytemuck::cast_slice(&kinds));
    let read_back = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let answers = buffer(device, TILES, read_back);
    let list = buffer(device, 1 + TILES, read_back);
    let dispatch = buffer(device, 3, read_back);

    let groups = [
        storage_group(device, &read, &[&input, &answers]),
        storage_group(device, &empty, &[]),
        storage_group(device, &empty, &[]),
        storage_group(device, &written, &[&dispatch, &list]),
    ];
    let mut encoder = device.create_command_encoder(&Default::default());
    for pipeline in [&make_dirty, &list_tiles] {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        for (index, group) in (0..).zip(&groups) {
            pass.set_bind_group(index, group, &[]);
        }
        pass.dispatch_workgroups(TILES as u32, 1, 1);
    }
    queue.submit([encoder.finish()]);
    let words = |buffer| read_buffer(&compute, buffer);
    let (answers, list, dispatch) = (words(&answers), words(&list), words(&dispatch));

    let expected: BTreeSet<u32> = (0..TILES)
        .filter(|tile| kinds[TILE * tile..][..TILE].iter().any(|kind| *kind != 0))
        .map(|tile| 8 * tile as u32)
        .collect();
    let count = list[0] as usize;
    let listed: BTreeSet<u32> = list[1..][..count].iter().copied().collect();
    assert_eq!(listed.len(), count, "a tile is listed twice");
    assert_eq!(listed, expected);
    assert_eq!(dispatch[..2], [count as u32, 1]);
    for (tile, answer) in (0u32..).zip(answers) {
        let expected = if listed.contains(&(8 * tile)) {
            TILE
        } else {
            0
        };
        assert_eq!(answer, expected as u32, "invocations of tile {tile}");
    }
}

fn read_buffer(compute: &Compute, source: &wgpu::Buffer) -> Vec<u32> {
    let Compute { device, queue } = compute;
    let words = source.size() as usize / 4;
    let readback = buffer(
        device,
        words,
        BufferUsages::MAP_READ | BufferUsages::COPY_DST,
    );
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(source, 0, &readback, 0, source.size());
    queue.submit([encoder.finish()]);
    readback.map_async(wgpu::MapMode::Read, .., |mapped| {
        mapped.unwrap_or_else(|error| panic!("a buffer cannot be read: {error}"));
    });
    device
        .poll(wgpu::PollType::wait_indefinitely())
        .unwrap_or_else(|error| panic!("the device did not finish: {error}"));
    bytemuck::cast_slice(&readback.get_mapped_range(..)).to_vec()
}
