//! Depth that another renderer draws before the G-buffer is no geometry of the G-buffer. Bevy's meshlets draw it so.

use bevy::{
    camera::visibility::{VisibilityClass, add_visibility_class},
    core_pipeline::{
        core_3d::main_opaque_pass_3d,
        schedule::{Core3d, Core3dSystems},
    },
    prelude::*,
    render::{
        RenderApp,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        render_resource::StoreOp,
        renderer::{RenderContext, RenderDevice, ViewQuery},
        view::{ViewDepthTexture, ViewTarget},
    },
};
use bevy_lean_deferred::{LeanDeferredPlugins, view::ActiveLeanView};
use kit::{
    headless::{Headless, Picture},
    lean::{active_lean_views, judge, report, set_lean, settled},
    log_watch,
    metrics::difference,
    own_process::in_own_process,
    scenes::{
        LEAST_PSNR, SceneBuilder,
        build::{ambient, default_camera_transform},
    },
};

const SIZE: UVec2 = UVec2::new(320, 240);

/// An entity that another renderer draws.
#[derive(Component, ExtractComponent, Clone)]
#[require(Transform, Visibility, VisibilityClass)]
#[component(on_add = add_visibility_class::<Curtain>)]
struct Curtain;

/// Draws only depth.
#[derive(Resource)]
struct CurtainPipeline(wgpu::RenderPipeline);

/// Draws colour and depth.
#[derive(Resource)]
pub(super) struct WallPipeline(wgpu::RenderPipeline);

/// The curtain is in front of everything, the wall among the solids.
const SHADER: &str = "
override depth: f32;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2(f32(index & 1u), f32(index >> 1u));
    return vec4(4.0 * corner - 1.0, depth, 1.0);
}

@fragment
fn fragment() -> @location(0) vec4<f32> {
    return vec4(0.1, 0.6, 0.2, 1.0);
}";

fn install(app: &mut App) {
    app.add_plugins(ExtractComponentPlugin::<Curtain>::default());
    let render_app = app.sub_app_mut(RenderApp);
    render_app.add_systems(
        Core3d,
        draw_curtain
            .before(Core3dSystems::Prepass)
            .run_if(any_with_component::<Curtain>),
    );
}

fn make_pipeline(
    headless: &mut Headless,
    depth: f64,
    targets: &[Option<wgpu::ColorTargetState>],
) -> wgpu::RenderPipeline {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let device = world.resource::<RenderDevice>().wgpu_device();
    let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &shader,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &[("depth", depth)],
                ..default()
            },
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: (!targets.is_empty()).then(|| wgpu::FragmentState {
            module: &shader,
            entry_point: None,
            compilation_options: Default::default(),
            targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn insert_pipeline<R: Resource>(headless: &mut Headless, pipeline: R) {
    let render_app = headless.app.sub_app_mut(RenderApp);
    render_app.insert_resource(pipeline);
}

/// Draws the curtain over the left half.
fn draw_curtain(
    view: ViewQuery<&ViewDepthTexture>,
    pipeline: Res<CurtainPipeline>,
    mut ctx: RenderContext,
) {
    let depth = view.into_inner();
    let attachment = depth.get_attachment(StoreOp::Store);
    let mut pass = ctx
        .command_encoder()
        .begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(attachment),
            ..default()
        });
    pass.set_pipeline(&pipeline.0);
    pass.set_scissor_rect(0, 0, SIZE.x / 2, SIZE.y);
    pass.draw(0..3, 0..1);
}

/// Draws the wall over the left half. It is no visible entity of any camera.
pub(super) fn draw_wall(
    view: ViewQuery<(&ViewDepthTexture, &ViewTarget)>,
    pipeline: Res<WallPipeline>,
    mut ctx: RenderContext,
) {
    let (depth, target) = view.into_inner();
    let half = UVec2::new(depth.texture.width() / 2, depth.texture.height());
    let color = target.get_color_attachment();
    let depth = depth.get_attachment(StoreOp::Store);
    let mut pass = ctx
        .command_encoder()
        .begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(color)],
            depth_stencil_attachment: Some(depth),
            ..default()
        });
    pass.set_pipeline(&pipeline.0);
    pass.set_scissor_rect(0, 0, half.x, half.y);
    pass.draw(0..3, 0..1);
}

/// Pictures before the curtain exists, behind it, and after its removal.
fn pictures(lean: bool) -> [Picture; 3] {
    let mut headless = Headless::with(SIZE, install);
    let pipeline = make_pipeline(&mut headless, 0.9, &[]);
    insert_pipeline(&mut headless, CurtainPipeline(pipeline));
    let mut scene = SceneBuilder {
        headless: &mut headless,
    };
    scene.solids();
    scene.sun(false);
    scene.default_camera(ambient());
    set_lean(&mut headless, lean);
    headless.settle();
    let before = headless.capture();
    let curtain = headless.world().spawn(Curtain).id();
    headless.settle();
    let behind = headless.capture();
    assert_eq!(active_lean_views(&mut headless), usize::from(lean));
    headless.world().despawn(curtain);
    headless.settle();
    let after = headless.capture();
    [before, behind, after]
}

#[test]
fn what_others_draw_into_depth_is_left_alone() {
    in_own_process(|| {
        let [forward, lean] = [false, true].map(pictures);
        assert!(forward[0].rgba != forward[1].rgba, "the curtain hides");
        for (moment, (forward, lean)) in ["before", "behind", "after"]
            .iter()
            .zip(forward.iter().zip(&lean))
        {
            let difference = difference(forward, lean);
            println!("{moment}: {difference}");
            assert!(difference.psnr >= 45.0, "{moment}: {difference}");
        }
        log_watch::assert_validation_layer_silent();
    });
}

fn before_prepass(app: &mut App) {
    let render_app = app.sub_app_mut(RenderApp);
    render_app.add_systems(Core3d, draw_wall.before(Core3dSystems::Prepass));
}

/// Draws the wall where Bevy's meshlet renderer draws too.
fn before_opaque(app: &mut App) {
    let render_app = app.sub_app_mut(RenderApp);
    render_app.add_systems(
        Core3d,
        draw_wall
            .in_set(Core3dSystems::MainPass)
            .before(main_opaque_pass_3d),
    );
}

pub(super) fn add_wall_pipeline(headless: &mut Headless) {
    let target = Some(wgpu::TextureFormat::Rgba16Float.into());
    let pipeline = make_pipeline(headless, 0.017, &[target]);
    insert_pipeline(headless, WallPipeline(pipeline));
}

/// Compares lean with forward pictures of a wall that systems draw, added `before` this crate's plugins and `after` them.
fn assert_wall_is_forwards(before: fn(&mut App), after: fn(&mut App)) {
    let mut app = App::new();
    app.add_plugins(Headless::default_plugins());
    before(&mut app);
    app.add_plugins(LeanDeferredPlugins);
    let mut headless = Headless::from_app(SIZE, app, after);
    add_wall_pipeline(&mut headless);
    let mut scene = SceneBuilder {
        headless: &mut headless,
    };
    scene.solids();
    scene.sun(false);
    // Sees only the floor at first, whose words then fill all pixels.
    let from_above = Transform::from_xyz(0.0, 1.0, 4.0).looking_to(Vec3::NEG_Y, Vec3::X);
    let camera = scene.camera(from_above, ambient());
    set_lean(&mut headless, true);
    headless.settle();
    headless
        .world()
        .entity_mut(camera)
        .insert(default_camera_transform());
    let lean = settled(&mut headless);
    assert_eq!(active_lean_views(&mut headless), 1);
    set_lean(&mut headless, false);
    let forward = settled(&mut headless);
    let [red, green, ..] = forward.rgba[..] else {
        unreachable!("there is a pixel")
    };
    assert!(green > red + 50, "the wall is in the corner");
    report([judge("wall", &forward, &lean, LEAST_PSNR)]);
}

fn nothing(_: &mut App) {}

#[test]
fn what_others_draw_before_all_else_stays() {
    in_own_process(|| assert_wall_is_forwards(nothing, before_prepass));
}

/// Systems that others run before the opaque pass come after lighting, in whatever order they were added.
#[test]
fn what_others_draw_before_the_opaque_pass_comes_after_lighting() {
    in_own_process(|| {
        assert_wall_is_forwards(before_opaque, nothing);
        assert_wall_is_forwards(nothing, before_opaque);
    });
}

/// If only meshes and lights are visible, depth identifies geometry: the G-buffer needs no clearing.
#[test]
fn meshes_and_lights_alone_need_no_clearing() {
    in_own_process(|| {
        let mut headless = kit::lean::build(SIZE, |s| {
            s.solids();
            s.sun(false);
            s.spawn((PointLight::default(), Transform::from_xyz(0.0, 2.0, 0.0)));
            s.default_camera(());
        });
        set_lean(&mut headless, true);
        headless.settle();
        let world = headless.app.sub_app_mut(RenderApp).world_mut();
        let mut views = world.query::<&ActiveLeanView>();
        assert!(views.single(world).expect("lean").depth_tells_geometry);
    });
}
