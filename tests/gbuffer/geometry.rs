//! Pixels covered by a lean mesh: the normal target marks them for passes of apps, and depth marks them for lighting where it can.

use bevy::{
    camera::{RenderTarget, Viewport, visibility::RenderLayers},
    core_pipeline::schedule::{Core3d, Core3dSystems},
    material::OpaqueRendererMethod,
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        camera::ExtractedCamera,
        render_resource::{PipelineCache, PipelineDescriptor},
        renderer::{RenderContext, RenderDevice, ViewQuery},
    },
};
use bevy_lean_deferred::{
    LeanDeferred,
    gbuffer::{GBufferTextures, ReadsGBuffer, layout::NO_GEOMETRY},
    view::{ActiveLeanView, LeanViewSystems},
};
use kit::{
    gpu::compute_pipeline,
    headless::{Headless, target_image},
    lean::{active_lean_views, build},
    log_watch,
    own_process::in_own_process,
};

const SIZE: UVec2 = UVec2::new(64, 48);
const CAMERAS: usize = 2;

/// The targets cannot be copied, so a compute pass moves one to a buffer.
const SHADER: &str = "
@group(0) @binding(0) var normal_texture: texture_2d<u32>;
@group(0) @binding(1) var<storage, read_write> words: array<u32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(normal_texture);
    if all(id.xy < size) {
        words[id.y * size.x + id.x] = textureLoad(normal_texture, id.xy, 0).r;
    }
}";

/// Words of the normal target by the order of cameras, in the render world.
#[derive(Resource)]
struct NormalProbe {
    pipeline: wgpu::ComputePipeline,
    words: [[wgpu::Buffer; 2]; CAMERAS],
}

fn install_probe(headless: &mut Headless) {
    let render_app = headless.app.sub_app_mut(RenderApp);
    let device = render_app.world().resource::<RenderDevice>().wgpu_device();
    let pipeline = compute_pipeline(device, SHADER, None);
    use wgpu::BufferUsages as Usage;
    let usages = [
        Usage::STORAGE | Usage::COPY_SRC,
        Usage::MAP_READ | Usage::COPY_DST,
    ];
    let words = [(); CAMERAS].map(|()| {
        usages.map(|usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: 4 * u64::from(SIZE.element_product()),
                usage,
                mapped_at_creation: false,
            })
        })
    });
    render_app
        .insert_resource(NormalProbe { pipeline, words })
        .add_systems(
            Render,
            announce
                .in_set(RenderSystems::PrepareAssets)
                .before(LeanViewSystems),
        )
        .add_systems(Core3d, probe.in_set(Core3dSystems::PostProcess));
}

fn announce(mut commands: Commands, views: Query<Entity, With<LeanDeferred>>) {
    for view in &views {
        commands.entity(view).insert(ReadsGBuffer);
    }
}

/// Runs where the documentation of `GBufferTextures` allows it.
fn probe(
    view: ViewQuery<(&ExtractedCamera, &GBufferTextures)>,
    probe: Res<NormalProbe>,
    device: Res<RenderDevice>,
    mut ctx: RenderContext,
) {
    let (camera, textures) = view.into_inner();
    let [words, readback] = &probe.words[camera.order as usize];
    let group = device
        .wgpu_device()
        .create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &probe.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&textures.normal.default_view),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: words.as_entire_binding(),
                },
            ],
        });
    let encoder = ctx.command_encoder();
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&probe.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(SIZE.x.div_ceil(8), SIZE.y.div_ceil(8), 1);
    }
    encoder.copy_buffer_to_buffer(words, 0, readback, 0, words.size());
}

/// Words of the last frame, row by row.
fn words_of(headless: &mut Headless, camera: usize) -> Vec<u32> {
    let world = headless.app.sub_app(RenderApp).world();
    let [_, readback] = &world.resource::<NormalProbe>().words[camera];
    readback.map_async(wgpu::MapMode::Read, .., |mapped| {
        mapped.unwrap_or_else(|error| panic!("the words cannot be read: {error}"));
    });
    let device = world.resource::<RenderDevice>().wgpu_device();
    (device.poll(wgpu::PollType::wait_indefinitely())).expect("the GPU answers");
    let words = (readback.get_mapped_range(..).as_chunks::<4>().0)
        .iter()
        .map(|bytes| u32::from_le_bytes(*bytes))
        .collect();
    readback.unmap();
    words
}

fn word(words: &[u32], x: u32, y: u32) -> u32 {
    words[(y * SIZE.x + x) as usize]
}

/// The normal target marks pixels without a lean mesh, on two cameras of one size, which share their textures. The first sees a floor
/// everywhere; the second sees a lean ball, a forward ball and sky, in the left half of its target.
#[test]
fn where_no_lean_mesh_is_the_normal_target_says_so() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            s.floor();
            s.sun(false);
            let ball = Sphere::new(0.5);
            for (x, method) in [
                (-0.6, OpaqueRendererMethod::Auto),
                (0.6, OpaqueRendererMethod::Forward),
            ] {
                s.mesh(
                    ball,
                    StandardMaterial {
                        opaque_render_method: method,
                        ..default()
                    },
                    Transform::from_xyz(x, 20.0, 0.0),
                );
            }
            let onto_floor = Transform::from_xyz(0.0, 2.0, 0.0).looking_to(Vec3::NEG_Y, Vec3::X);
            s.camera(onto_floor, LeanDeferred::default());
            let image = s.add::<Image>(target_image(SIZE));
            let at_balls = Transform::from_xyz(0.0, 20.0, 4.0);
            let second = s.camera(at_balls, LeanDeferred::default());
            s.world().entity_mut(second).insert((
                RenderTarget::from(image),
                Camera {
                    order: 1,
                    viewport: Some(Viewport {
                        physical_size: UVec2::new(SIZE.x / 2, SIZE.y),
                        ..default()
                    }),
                    ..default()
                },
            ));
        });
        install_probe(&mut headless);
        headless.settle();
        assert_eq!(active_lean_views(&mut headless), CAMERAS);

        let floor = words_of(&mut headless, 0);
        assert!(floor.iter().all(|&word| word != NO_GEOMETRY));
        let balls = words_of(&mut headless, 1);
        let middle = SIZE.y / 2;
        assert_ne!(word(&balls, 10, middle), NO_GEOMETRY, "the lean ball");
        let wrong = |what: &str, xs: core::ops::Range<u32>, ys: core::ops::Range<u32>| {
            let words = ys.flat_map(|y| xs.clone().map(move |x| (x, y)));
            let wrong = words.filter(|&(x, y)| word(&balls, x, y) != NO_GEOMETRY);
            let wrong = wrong.count();
            println!("{what}: {wrong} pixels have words of another camera or frame");
            wrong
        };
        let wrong = wrong("sky", 0..SIZE.x / 2, 0..4)
            + wrong("the forward ball", 19..24, middle - 1..middle + 1)
            + wrong("outside of the viewport", SIZE.x / 2..SIZE.x, 0..SIZE.y);
        assert_eq!(wrong, 0);
        log_watch::assert_validation_layer_silent();
    });
}

/// Number of lighting pipelines requested so far.
fn lighting_pipelines(headless: &Headless) -> usize {
    let world = headless.app.sub_app(RenderApp).world();
    let pipelines = world.resource::<PipelineCache>().pipelines();
    let labels = pipelines.filter_map(|pipeline| match &pipeline.descriptor {
        PipelineDescriptor::ComputePipelineDescriptor(descriptor) => descriptor.label.clone(),
        PipelineDescriptor::RenderPipelineDescriptor(_) => None,
    });
    labels
        .filter(|label| label == "lean_deferred/lighting")
        .count()
}

/// Sprites of another camera change nothing of a lean one, though Bevy lists the kinds of entities that any camera sees for all cameras.
#[test]
fn sprites_of_other_cameras_change_nothing_of_a_lean_one() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            s.solids();
            s.sun(true);
            s.default_camera(LeanDeferred::default());
        });
        headless.settle();
        let state = |headless: &mut Headless| {
            let pipelines = lighting_pipelines(headless);
            let world = headless.app.sub_app_mut(RenderApp).world_mut();
            let mut views = world.query::<&ActiveLeanView>();
            (*views.single(world).expect("one is lean"), pipelines)
        };
        let before = state(&mut headless);
        assert!(before.0.depth_tells_geometry);
        let layer = RenderLayers::layer(3);
        let image = headless
            .world()
            .resource_mut::<Assets<Image>>()
            .add(target_image(SIZE));
        let target = RenderTarget::from(image);
        let world = headless.world();
        world.spawn((Camera2d, target, layer.clone()));
        world.spawn((
            Sprite::from_color(Color::WHITE, Vec2::splat(8.0)),
            layer.clone(),
        ));
        world.spawn((Text2d::new("a"), layer));
        headless.settle();
        assert_eq!(state(&mut headless), before);
    });
}
