//! The naive version, as a baseline: see `naive.wgsl`.

use bevy::{
    asset::uuid_handle,
    core_pipeline::{
        FullscreenShader,
        core_3d::{main_opaque_pass_3d, main_transparent_pass_3d},
        schedule::{Core3d, Core3dSystems},
    },
    image::ToExtents,
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        render_resource::*,
        renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery},
        texture::{CachedTexture, TextureCache},
        view::{ExtractedView, ViewDepthTexture, ViewTarget},
    },
    shader::ShaderDefVal,
};
use bevy_lean_deferred::{
    effects::ambient_occlusion::OcclusionUniform,
    prelude::*,
    shader_library::reconstruction::position::{ProjectionKind, projection_of},
};
use binding_types::{sampler, texture_2d, texture_depth_2d, texture_storage_2d, uniform_buffer};

const SHADER: Handle<Shader> = uuid_handle!("6c1f2a52-3d0c-4a5e-8a55-0f3a1f6d7b01");

/// Adds the naive version to a camera.
#[derive(Component, ExtractComponent, Clone, Copy)]
pub struct NaiveOcclusion {
    /// Shows the occlusion alone.
    pub shows: bool,
}

#[derive(Component)]
struct NaiveView {
    texture: CachedTexture,
    uniform: UniformBuffer<OcclusionUniform>,
}

#[derive(Resource)]
struct NaivePipelines {
    sampler: Sampler,
    gather_layout: BindGroupLayoutDescriptor,
    merge_layout: BindGroupLayoutDescriptor,
    gather: CachedComputePipelineId,
    merges: [CachedRenderPipelineId; 2],
}

pub fn plugin(app: &mut App) {
    app.world_mut()
        .resource_mut::<Assets<Shader>>()
        .insert(
            SHADER.id(),
            Shader::from_wgsl(include_str!("naive.wgsl"), "naive.wgsl"),
        )
        .expect("a place for a constant handle");
    app.add_plugins(ExtractComponentPlugin::<NaiveOcclusion>::default());
    app.sub_app_mut(RenderApp)
        .add_systems(RenderStartup, init)
        .add_systems(
            Render,
            (
                make_depth_readable.in_set(RenderSystems::PrepareAssets),
                prepare.in_set(RenderSystems::PrepareResources),
            ),
        )
        .add_systems(
            Core3d,
            draw.in_set(Core3dSystems::MainPass)
                .after(main_opaque_pass_3d)
                .before(main_transparent_pass_3d),
        );
}

fn make_depth_readable(mut cameras: Query<&mut Camera3d, With<NaiveOcclusion>>) {
    for mut camera in &mut cameras {
        let usages = TextureUsages::from(camera.depth_texture_usages);
        camera.depth_texture_usages = (usages | TextureUsages::TEXTURE_BINDING).into();
    }
}

fn init(
    mut commands: Commands,
    device: Res<RenderDevice>,
    pipelines: Res<PipelineCache>,
    fullscreen: Res<FullscreenShader>,
) {
    let layout = |stage| {
        vec![
            uniform_buffer::<OcclusionUniform>(false).build(0, stage),
            texture_depth_2d().build(1, stage),
            sampler(SamplerBindingType::NonFiltering).build(2, stage),
        ]
    };
    let mut gather_entries = layout(ShaderStages::COMPUTE);
    gather_entries.push(
        texture_storage_2d(TextureFormat::Rgba16Float, StorageTextureAccess::WriteOnly)
            .build(4, ShaderStages::COMPUTE),
    );
    let mut merge_entries = layout(ShaderStages::FRAGMENT);
    for binding in [4, 5] {
        merge_entries.push(
            texture_2d(TextureSampleType::Float { filterable: false })
                .build(binding, ShaderStages::FRAGMENT),
        );
    }
    let gather_layout = BindGroupLayoutDescriptor::new("naive gather", &gather_entries);
    let merge_layout = BindGroupLayoutDescriptor::new("naive merge", &merge_entries);
    let (slices, steps) = LeanScreenSpaceAmbientOcclusion::default().samples();
    let defs: Vec<ShaderDefVal> = vec![
        ShaderDefVal::UInt("SLICES".into(), slices),
        ShaderDefVal::UInt("STEPS".into(), steps),
        "PROJECTION_PERSPECTIVE".into(),
    ];
    let with = |names: &[&'static str]| {
        let more = names.iter().map(|name| (*name).into());
        defs.iter().cloned().chain(more).collect::<Vec<_>>()
    };
    let merge = |names: &[&'static str]| {
        pipelines.queue_render_pipeline(RenderPipelineDescriptor {
            label: Some("naive merge".into()),
            layout: vec![merge_layout.clone()],
            vertex: fullscreen.to_vertex_state(),
            fragment: Some(FragmentState {
                shader: SHADER,
                shader_defs: with(names),
                entry_point: Some("merge".into()),
                targets: vec![Some(TextureFormat::Rgba16Float.into())],
            }),
            ..default()
        })
    };
    let merges = [merge(&[]), merge(&["SHOWS"])];
    let gather = pipelines.queue_compute_pipeline(ComputePipelineDescriptor {
        label: Some("naive gather".into()),
        layout: vec![gather_layout.clone()],
        shader: SHADER,
        shader_defs: with(&["GATHER"]),
        entry_point: Some("gather".into()),
        ..default()
    });
    commands.insert_resource(NaivePipelines {
        sampler: device.create_sampler(&SamplerDescriptor::default()),
        gather_layout,
        merge_layout,
        gather,
        merges,
    });
}

fn prepare(
    mut commands: Commands,
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    mut textures: ResMut<TextureCache>,
    views: Query<(Entity, &ExtractedCamera, &ExtractedView), With<NaiveOcclusion>>,
) {
    for (entity, camera, view) in &views {
        let size = camera.physical_target_size.unwrap_or(UVec2::ONE);
        assert!(projection_of(view.clip_from_view) == ProjectionKind::Perspective);
        let settings = LeanScreenSpaceAmbientOcclusion::default();
        let mut uniform =
            UniformBuffer::from(OcclusionUniform::new(&settings, view.clip_from_view, size));
        uniform.write_buffer(&device, &queue);
        let texture = textures.get(
            &device,
            TextureDescriptor {
                label: Some("naive occlusion"),
                size: size.to_extents(),
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format: TextureFormat::Rgba16Float,
                usage: TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            },
        );
        commands
            .entity(entity)
            .insert(NaiveView { texture, uniform });
    }
}

fn draw(
    view: ViewQuery<(&NaiveOcclusion, &NaiveView, &ViewTarget, &ViewDepthTexture)>,
    pipelines: Res<NaivePipelines>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (naive, view, target, depth) = view.into_inner();
    let (Some(gather), Some(merge), Some(uniform)) = (
        cache.get_compute_pipeline(pipelines.gather),
        cache.get_render_pipeline(pipelines.merges[usize::from(naive.shows)]),
        view.uniform.binding(),
    ) else {
        return;
    };
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let device = ctx.render_device().clone();
    let common = [
        (0, uniform),
        (1, depth.view().into_binding()),
        (2, pipelines.sampler.into_binding()),
    ];
    let group = |layout: &BindGroupLayoutDescriptor, own: &[(u32, &TextureView)]| {
        let own = own
            .iter()
            .map(|(binding, view)| (*binding, view.into_binding()));
        let entries: Vec<BindGroupEntry> = common
            .iter()
            .cloned()
            .chain(own)
            .map(|(binding, resource)| BindGroupEntry { binding, resource })
            .collect();
        device.create_bind_group("naive", &cache.get_bind_group_layout(layout), &entries)
    };

    let texture = &view.texture.default_view;
    let gather_group = group(&pipelines.gather_layout, &[(4, texture)]);
    let span = diagnostics.time_span(ctx.command_encoder(), "bench/naive/gather");
    let mut pass = ctx
        .command_encoder()
        .begin_compute_pass(&ComputePassDescriptor::default());
    pass.set_pipeline(gather);
    pass.set_bind_group(0, &gather_group, &[]);
    let size = view.texture.texture.size();
    pass.dispatch_workgroups(size.width.div_ceil(8), size.height.div_ceil(8), 1);
    drop(pass);
    span.end(ctx.command_encoder());

    let write = target.post_process_write();
    let merge_group = group(&pipelines.merge_layout, &[(4, texture), (5, write.source)]);
    let span = diagnostics.time_span(ctx.command_encoder(), "bench/naive/merge");
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        color_attachments: &[Some(RenderPassColorAttachment {
            view: write.destination,
            depth_slice: None,
            resolve_target: None,
            ops: Operations::default(),
        })],
        ..default()
    });
    pass.set_render_pipeline(merge);
    pass.set_bind_group(0, &merge_group, &[]);
    pass.draw(0..3, 0..1);
    drop(pass);
    span.end(ctx.command_encoder());
}
