//! Lighting by a fragment shader in place of the dispatch, with the same functions, for benches: it tells what a compute shader gains on a
//! GPU. For views of plain surfaces alone, without effects that read the diffuse light, and with lights culled per pixel.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    core_pipeline::{
        FullscreenShader,
        core_3d::main_opaque_pass_3d,
        schedule::{Core3d, Core3dSystems},
    },
    platform::collections::HashMap,
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        render_resource::{
            CachedRenderPipelineId, ColorTargetState, ColorWrites, FragmentState, PipelineCache,
            RenderPassDescriptor, RenderPipelineDescriptor, ShaderStages, TextureFormat,
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        view::ViewTarget,
    },
};

use super::{
    bindings::update_bind_groups,
    features::LightingKey,
    forward::prepare_forward_groups,
    inputs::{LightingResources, LitView, LitViewItem},
    layouts::{LightingLayouts, descriptors},
    pipeline::LightingPipelines,
    state::{ViewLighting, ViewLightingBindings},
};
use crate::{
    gpu::timed::timed,
    view::{ActiveLeanView, EffectSystems, LightCulling, LightingIo, LightingPasses},
};

/// Adds the pass, which runs only with [`LightsByFragments`].
pub(super) fn add_to(app: &mut App) {
    embedded_asset!(app, "fragment.wgsl");
    app.sub_app_mut(RenderApp)
        .add_systems(
            Render,
            prepare_fragment_lighting
                .run_if(resource_exists::<LightsByFragments>)
                .in_set(RenderSystems::PrepareBindGroups)
                .after(prepare_forward_groups),
        )
        .add_systems(
            Core3d,
            fragment_lighting_pass
                .in_set(EffectSystems::Lean)
                .in_set(LightingPasses)
                .in_set(Core3dSystems::MainPass)
                .before(main_opaque_pass_3d),
        );
}

/// In the render world: views that can be are lit by a fragment shader.
#[derive(Resource, Default)]
pub struct LightsByFragments {
    shader: Option<Handle<Shader>>,
    by_key: HashMap<LightingKey, (CachedRenderPipelineId, LightingLayouts)>,
}

/// On a view that a fragment shader lights.
#[derive(Component)]
pub(crate) struct FragmentLighting {
    pipeline: CachedRenderPipelineId,
    bindings: ViewLightingBindings,
}

impl LightsByFragments {
    fn specialize(
        &mut self,
        cache: &PipelineCache,
        pipelines: &LightingPipelines,
        fullscreen: &FullscreenShader,
        key: LightingKey,
    ) -> (CachedRenderPipelineId, &LightingLayouts) {
        let shader = self.shader.clone().unwrap_or_default();
        let (id, layouts) = self.by_key.entry(key).or_insert_with(|| {
            let mut groups = descriptors(&pipelines.mesh_pipeline, key);
            for entry in groups.iter_mut().flat_map(|group| &mut group.entries) {
                entry.visibility = ShaderStages::FRAGMENT;
            }
            let layouts = LightingLayouts::new(cache, groups, key, None);
            let fragment = FragmentState {
                shader,
                shader_defs: pipelines.shader_defs(key, &layouts),
                entry_point: Some("fragment".into()),
                targets: vec![Some(ColorTargetState {
                    format: TextureFormat::Rgba16Float,
                    blend: None,
                    write_mask: ColorWrites::ALL,
                })],
            };
            let groups = [&layouts.view, &layouts.arrays, &layouts.targets];
            let id = cache.queue_render_pipeline(RenderPipelineDescriptor {
                label: Some("lean_deferred/lighting/fragment".into()),
                layout: groups.map(|group| group.descriptor().clone()).to_vec(),
                vertex: fullscreen.to_vertex_state(),
                fragment: Some(fragment),
                ..default()
            });
            (id, layouts)
        });
        (*id, layouts)
    }
}

/// The key of a view that a fragment shader can light.
fn key_of(lighting: &ViewLighting) -> Option<LightingKey> {
    let [(key, _)] = lighting.pipelines[..] else {
        return None;
    };
    let is_plain = key.light_culling == LightCulling::PerPixel
        && !key.scatters
        && !key.lists
        && !key.io.contains(LightingIo::DIFFUSE_LIGHT);
    is_plain.then_some(key)
}

/// Queues the pipelines of views, and creates their bind groups.
pub(super) fn prepare_fragment_lighting(
    mut commands: Commands,
    mut own: ResMut<LightsByFragments>,
    asset_server: Res<AssetServer>,
    fullscreen: Res<FullscreenShader>,
    (cache, pipelines): (Res<PipelineCache>, Res<LightingPipelines>),
    device: Res<RenderDevice>,
    resources: LightingResources,
    mut views: Query<(Entity, LitView), With<ActiveLeanView>>,
) {
    let shader = || load_embedded_asset!(asset_server.as_ref(), "fragment.wgsl");
    own.shader.get_or_insert_with(shader);
    for (entity, view) in &mut views {
        let view = LitViewItem::of(view);
        let mut fragment = None;
        if let Some(key) = key_of(&view.lighting) {
            let (pipeline, layouts) = own.specialize(&cache, &pipelines, &fullscreen, key);
            let mut bindings = ViewLightingBindings::default();
            let complete = update_bind_groups(
                &mut bindings,
                layouts,
                &pipelines,
                &view,
                &resources,
                &device,
            );
            fragment = complete
                .filter(|()| cache.get_render_pipeline(pipeline).is_some())
                .map(|()| FragmentLighting { pipeline, bindings });
        }
        let mut entity = commands.entity(entity);
        match fragment {
            Some(fragment) => entity.insert(fragment),
            None => entity.remove::<FragmentLighting>(),
        };
    }
}

/// Lights the G-buffer of a view into its main texture.
pub(super) fn fragment_lighting_pass(
    view: ViewQuery<(&FragmentLighting, &ViewLighting, &ViewTarget)>,
    pipeline_cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (FragmentLighting { pipeline, bindings }, lighting, target) = view.into_inner();
    let (Some(pipeline), Some(view), Some(arrays), Some(targets)) = (
        pipeline_cache.get_render_pipeline(*pipeline),
        bindings.view.get(),
        bindings.arrays.get(),
        // The texture that the dispatch writes is bound too, so it must not be the one that is drawn into.
        bindings.targets_for(target.main_texture_other_view()),
    ) else {
        return;
    };
    timed(&mut ctx, "lean_deferred/lighting", &mut |ctx| {
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some("lean_deferred/lighting/fragment"),
            color_attachments: &[Some(target.get_color_attachment())],
            ..default()
        });
        pass.set_render_pipeline(pipeline);
        pass.set_bind_group(0, view, &bindings.view_offsets);
        pass.set_bind_group(1, arrays, &[]);
        pass.set_bind_group(2, targets, &[lighting.bindings.uniform_offsets[0]]);
        pass.draw(0..3, 0..1);
    });
}
