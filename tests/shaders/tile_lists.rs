//! Tiles are listed for the kinds of surfaces that they have, and for no others.

use std::{borrow::Cow, collections::BTreeSet};

use kit::{
    compute::{Compute, WgslModule, compose},
    random::Random,
};
use wgpu::BufferUsages;

const MODULES: [WgslModule; 4] = [
    WgslModule {
        path: "src/shader_library/layout.wgsl",
        source: include_str!("../../src/shader_library/layout.wgsl"),
    },
    WgslModule {
        path: "src/shader_library/layout/specialization.wgsl",
        source: include_str!("../../src/shader_library/layout/specialization.wgsl"),
    },
    // In the place of the lighting pass's uniform.
    WgslModule {
        path: "bindings.wgsl",
        source: "
#define_import_path bevy_lean_deferred::lighting::bindings

struct Uniforms {
    list_capacity: u32,
}

const uniforms: Uniforms = Uniforms(512u);
",
    },
    WgslModule {
        path: "src/lighting/tile_lists.wgsl",
        source: include_str!("../../src/lighting/tile_lists.wgsl"),
    },
];

/// Twins of constants of `tile_lists.wgsl`.
const VARIANTS: usize = 16;
const TILE: usize = 64;
/// Tiles that are looked at, and that a list has room for.
const TILES: usize = 512;
/// Clearcoat, backlight, and rim with a lightmap, beside plain surfaces.
const KINDS: [u32; 4] = [0, 4, 5, 3 + 8];
const LISTED: u32 = 1 << 4 | 1 << 5 | 1 << 11;

const LIST_TILES: &str = "
#import bevy_lean_deferred::lighting::tile_lists::list_tile

@group(0) @binding(0) var<storage, read> kinds: array<u32>;

@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    list_tile(vec2(8u * tile.x, 0u), kinds[64u * tile.x + invocation], invocation);
}";

/// Leaves ones in all the memory that workgroups share.
const MAKE_DIRTY: &str = "
@group(0) @binding(0) var<storage, read> kinds: array<u32>;
@group(3) @binding(0) var<storage, read_write> dispatches: array<atomic<u32>>;
@group(3) @binding(1) var<storage, read_write> lists: array<atomic<u32>>;

var<workgroup> memory: array<atomic<u32>, 4096>;

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(local_invocation_index) invocation: u32) {
    for (var i = invocation; i < 4096u; i += 64u) {
        atomicStore(&memory[i], 0xffffffffu);
    }
    workgroupBarrier();
    // Never so; but without a use of it compilers would drop the memory.
    if atomicLoad(&memory[4095u - invocation]) == kinds[0] + 12345u {
        atomicStore(&lists[0], atomicLoad(&dispatches[0]));
    }
}";

/// A pipeline that takes shared memory as it finds it, as Bevy's compute pipelines do.
fn pipeline(
    compute: &Compute,
    layout: &wgpu::PipelineLayout,
    source: &str,
) -> wgpu::ComputePipeline {
    let module = compose(&MODULES, source, &[("LISTED_VARIANTS", LISTED)]);
    let shader = (compute.device).create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
    });
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

/// The kind of each pixel: few tiles have more than one or two.
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
fn tiles_are_listed_for_the_kinds_that_they_have() {
    let compute = Compute::new();
    let Compute { device, queue } = &compute;
    let [read, empty, written] =
        [&[true][..], &[], &[false, false]].map(|bindings| storage_layout(device, bindings));
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(&read), Some(&empty), Some(&empty), Some(&written)],
        ..Default::default()
    });
    let [make_dirty, list_tiles] =
        [MAKE_DIRTY, LIST_TILES].map(|source| pipeline(&compute, &layout, source));

    let kinds = random_kinds();
    let bytes: Vec<u8> = kinds.iter().flat_map(|kind| kind.to_le_bytes()).collect();
    let input = buffer(
        device,
        kinds.len(),
        BufferUsages::STORAGE | BufferUsages::COPY_DST,
    );
    queue.write_buffer(&input, 0, &bytes);
    let list_words = VARIANTS + LISTED.count_ones() as usize * TILES;
    let lists = buffer(
        device,
        list_words,
        BufferUsages::STORAGE | BufferUsages::COPY_SRC,
    );
    let dispatches = buffer(device, 3 * VARIANTS, BufferUsages::STORAGE);
    let readback = buffer(
        device,
        list_words,
        BufferUsages::MAP_READ | BufferUsages::COPY_DST,
    );

    let groups = [
        storage_group(device, &read, &[&input]),
        storage_group(device, &empty, &[]),
        storage_group(device, &empty, &[]),
        storage_group(device, &written, &[&dispatches, &lists]),
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
    encoder.copy_buffer_to_buffer(&lists, 0, &readback, 0, lists.size());
    queue.submit([encoder.finish()]);
    readback.map_async(wgpu::MapMode::Read, .., |mapped| {
        mapped.unwrap_or_else(|error| panic!("the lists cannot be read: {error}"));
    });
    device
        .poll(wgpu::PollType::wait_indefinitely())
        .unwrap_or_else(|error| panic!("the device did not finish: {error}"));
    let words: Vec<u32> = (readback.get_mapped_range(..).as_chunks().0.iter())
        .map(|bytes| u32::from_le_bytes(*bytes))
        .collect();

    for (rank, kind) in KINDS[1..].iter().enumerate() {
        let expected: BTreeSet<u32> = (0..TILES)
            .filter(|tile| kinds[TILE * tile..][..TILE].contains(kind))
            .map(|tile| 8 * tile as u32)
            .collect();
        let count = words[*kind as usize] as usize;
        let start = VARIANTS + rank * TILES;
        let listed: BTreeSet<u32> = words[start..][..count].iter().copied().collect();
        assert_eq!(listed.len(), count, "kind {kind}: a tile is listed twice");
        let extra = listed.difference(&expected).count();
        let missing = expected.difference(&listed).count();
        assert_eq!(
            (extra, missing),
            (0, 0),
            "kind {kind}: {extra} tiles too many and {missing} too few of {}",
            expected.len()
        );
    }
}
