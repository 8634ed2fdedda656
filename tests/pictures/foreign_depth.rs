//! What another renderer draws into depth before the G-buffer is no geometry of the G-buffer. Bevy's meshlets do so.

use bevy::{
    camera::visibility::{VisibilityClass, add_visibility_class},
    core_pipeline::schedule::{Core3d, Core3dSystems},
    prelude::*,
    render::{
        RenderApp,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        render_resource::StoreOp,
        renderer::{RenderContext, RenderDevice, ViewQuery},
        view::ViewDepthTexture,
    },
};
use bevy_lean_deferred::view::ActiveLeanView;
use kit::{
    headless::{Headless, Picture},
    lean::{active_lean_views, set_lean},
    log_watch,
    metrics::difference,
    own_process::in_own_process,
    scenes::{SceneBuilder, build::ambient},
};

const SIZE: UVec2 = UVec2::new(320, 240);

/// Seen by a renderer of its own.
#[derive(Component, ExtractComponent, Clone)]
#[require(Transform, Visibility, VisibilityClass)]
#[component(on_add = add_visibility_class::<Curtain>)]
struct Curtain;

/// Draws depth alone.
#[derive(Resource)]
struct CurtainPipeline(wgpu::RenderPipeline);

const SHADER: &str = "
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2(f32(index & 1u), f32(index >> 1u));
    return vec4(4.0 * corner - 1.0, 0.9, 1.0);
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

fn make_pipeline(headless: &mut Headless) {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let device = world.resource::<RenderDevice>().wgpu_device();
    let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &shader,
            entry_point: None,
            compilation_options: Default::default(),
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
        fragment: None,
        multiview_mask: None,
        cache: None,
    });
    world.insert_resource(CurtainPipeline(pipeline));
}

/// Over the left half.
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

/// Pictures before the curtain, behind it, and after it.
fn pictures(lean: bool) -> [Picture; 3] {
    let mut headless = Headless::with(SIZE, install);
    make_pipeline(&mut headless);
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

/// Where only meshes and lights are seen, depth tells what is geometry: the G-buffer needs no clearing.
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
