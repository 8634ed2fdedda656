//! Reads Bevy's motion vectors back. Their texture cannot be copied, so a compute pass moves them to a buffer.

use bevy::{
    core_pipeline::{
        prepass::ViewPrepassTextures,
        schedule::{Core3d, Core3dSystems},
    },
    prelude::*,
    render::{
        RenderApp,
        renderer::{RenderContext, RenderDevice, ViewQuery},
    },
};

use kit::{gpu::compute_pipeline, headless::Headless};

const SHADER: &str = "
@group(0) @binding(0) var motion_vectors: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> motions: array<vec2<f32>>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(motion_vectors);
    if all(id.xy < size) {
        motions[id.y * size.x + id.x] = textureLoad(motion_vectors, id.xy, 0).xy;
    }
}";

/// Pipeline and buffers in the render world.
#[derive(Resource)]
struct MotionProbe {
    pipeline: wgpu::ComputePipeline,
    motions: wgpu::Buffer,
    readback: wgpu::Buffer,
}

/// Records the motion vectors of each frame.
pub fn install(headless: &mut Headless) {
    let bytes = u64::from(headless.size.element_product()) * 8;
    let render_app = headless.app.sub_app_mut(RenderApp);
    let device = render_app.world().resource::<RenderDevice>().wgpu_device();
    let pipeline = compute_pipeline(device, SHADER, None);
    let buffer = |usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes,
            usage,
            mapped_at_creation: false,
        })
    };
    use wgpu::BufferUsages as Usage;
    let probe = MotionProbe {
        pipeline,
        motions: buffer(Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST),
        readback: buffer(Usage::MAP_READ | Usage::COPY_DST),
    };
    render_app
        .insert_resource(probe)
        .add_systems(Core3d, record.in_set(Core3dSystems::PostProcess));
}

fn record(
    view: ViewQuery<&ViewPrepassTextures>,
    probe: Res<MotionProbe>,
    device: Res<RenderDevice>,
    mut ctx: RenderContext,
) {
    let textures = view.into_inner();
    let Some(motion_vectors) = &textures.motion_vectors else {
        return;
    };
    let group = device
        .wgpu_device()
        .create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &probe.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(
                        &motion_vectors.texture.default_view,
                    ),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: probe.motions.as_entire_binding(),
                },
            ],
        });
    let encoder = ctx.command_encoder();
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&probe.pipeline);
        pass.set_bind_group(0, &group, &[]);
        let size = textures.size;
        pass.dispatch_workgroups(size.width.div_ceil(8), size.height.div_ceil(8), 1);
    }
    let size = probe.motions.size();
    encoder.copy_buffer_to_buffer(&probe.motions, 0, &probe.readback, 0, size);
}

/// The motion vectors of the last frame, in UV units, row by row.
pub fn read(headless: &mut Headless) -> Vec<Vec2> {
    let world = headless.app.sub_app(RenderApp).world();
    let probe = world.resource::<MotionProbe>();
    probe.readback.map_async(wgpu::MapMode::Read, .., |mapped| {
        mapped.unwrap_or_else(|error| panic!("the motion vectors cannot be read: {error}"));
    });
    world
        .resource::<RenderDevice>()
        .wgpu_device()
        .poll(wgpu::PollType::wait_indefinitely())
        .unwrap_or_else(|error| panic!("the device did not finish: {error}"));
    let motions = (probe.readback.get_mapped_range(..).as_chunks::<8>().0)
        .iter()
        .map(|bytes| {
            let [x, y] =
                [[0, 1, 2, 3], [4, 5, 6, 7]].map(|at| f32::from_le_bytes(at.map(|i| bytes[i])));
            Vec2::new(x, y)
        })
        .collect();
    probe.readback.unmap();
    motions
}
