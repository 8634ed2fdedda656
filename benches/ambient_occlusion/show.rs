//! Shows Bevy's occlusion texture, and reads back a camera's picture before tonemapping.

use bevy::{
    asset::uuid_handle,
    core_pipeline::{
        FullscreenShader,
        core_3d::{main_opaque_pass_3d, main_transparent_pass_3d},
        schedule::{Core3d, Core3dSystems},
    },
    pbr::ScreenSpaceAmbientOcclusionResources,
    prelude::*,
    render::{
        RenderApp, RenderStartup,
        render_resource::{binding_types::texture_2d, *},
        renderer::{RenderContext, ViewQuery},
        view::ViewTarget,
    },
};
use kit::{hdr::read_light, headless::Headless};

const SHADER: Handle<Shader> = uuid_handle!("6c1f2a52-3d0c-4a5e-8a55-0f3a1f6d7b02");

const SOURCE: &str = r"
@group(0) @binding(0) var visibility: texture_2d<f32>;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return vec4(textureLoad(visibility, vec2<i32>(position.xy), 0).rrr, 1.0);
}
";

#[derive(Resource)]
struct ShowPipeline {
    layout: BindGroupLayoutDescriptor,
    pipeline: CachedRenderPipelineId,
}

/// Makes Bevy's occlusion the picture of each camera that has it.
pub fn plugin(app: &mut App) {
    app.world_mut()
        .resource_mut::<Assets<Shader>>()
        .insert(SHADER.id(), Shader::from_wgsl(SOURCE, "show.wgsl"))
        .expect("a place for a constant handle");
    app.sub_app_mut(RenderApp)
        .add_systems(RenderStartup, init)
        .add_systems(
            Core3d,
            show.in_set(Core3dSystems::MainPass)
                .after(main_opaque_pass_3d)
                .before(main_transparent_pass_3d),
        );
}

fn init(mut commands: Commands, cache: Res<PipelineCache>, fullscreen: Res<FullscreenShader>) {
    let layout = BindGroupLayoutDescriptor::new(
        "show",
        &[texture_2d(TextureSampleType::Float { filterable: false })
            .build(0, ShaderStages::FRAGMENT)],
    );
    let pipeline = cache.queue_render_pipeline(RenderPipelineDescriptor {
        label: Some("show".into()),
        layout: vec![layout.clone()],
        vertex: fullscreen.to_vertex_state(),
        fragment: Some(FragmentState {
            shader: SHADER,
            shader_defs: Vec::new(),
            entry_point: Some("fragment".into()),
            targets: vec![Some(TextureFormat::Rgba16Float.into())],
        }),
        ..default()
    });
    commands.insert_resource(ShowPipeline { layout, pipeline });
}

fn show(
    view: ViewQuery<(&ScreenSpaceAmbientOcclusionResources, &ViewTarget)>,
    show: Res<ShowPipeline>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (ssao, target) = view.into_inner();
    let Some(pipeline) = cache.get_render_pipeline(show.pipeline) else {
        return;
    };
    let view = &ssao.screen_space_ambient_occlusion_texture.default_view;
    let group = ctx.render_device().create_bind_group(
        "show",
        &cache.get_bind_group_layout(&show.layout),
        &BindGroupEntries::single(view),
    );
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        color_attachments: &[Some(target.get_color_attachment())],
        ..default()
    });
    pass.set_render_pipeline(pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..3, 0..1);
}

/// The red channel of the only camera's main texture after the last frame.
pub fn read_main_texture(headless: &mut Headless) -> Vec<f32> {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut targets = world.query::<&ViewTarget>();
    let target = targets.single(world).expect("one camera");
    let texture = target.main_texture().clone();
    let texels = read_light(headless, &texture).texels;
    texels.into_iter().map(|[red, ..]| red).collect()
}
