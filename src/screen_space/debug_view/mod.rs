//! Shows the output of an effect in place of the picture: before post-processing, and after the history is kept, which must not
//! contain it.

#[doc(hidden)]
pub mod binding_numbers;

use core::marker::PhantomData;

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    core_pipeline::{
        FullscreenShader,
        schedule::{Core3d, Core3dSystems},
    },
    platform::collections::HashMap,
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        camera::ExtractedCamera,
        render_resource::{
            CachedRenderPipelineId, ColorTargetState, ColorWrites, FragmentState, IntoBinding,
            PipelineCache, RenderPassDescriptor, RenderPipelineDescriptor, ShaderStages,
            TextureFormat, TextureSampleType, TextureView, binding_types::texture_2d,
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        view::{ExtractedView, ViewTarget},
    },
};

use binding_numbers::SOURCE_TEXTURE;

use crate::{
    gpu::{
        bind_group_cache::{CachedBindGroup, ResolvedLayout},
        bindings::layout,
        timed::timed,
    },
    view::{DebugViewPasses, HistoryPasses, removal},
};

const LABEL: &str = "lean_deferred/screen_space/debug_view";

/// Channels of a texture to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Shows {
    /// RGB times alpha.
    Light,
    /// RGB alone.
    BareLight,
    /// Alpha as grey.
    Alpha,
    /// 1 - alpha, as grey.
    OneMinusAlpha,
    /// Hit words of reflections: 1 / (1 + metres) as grey, black without a hit.
    Hit,
}

impl Shows {
    fn shader_def(self) -> &'static str {
        match self {
            Self::Light => "SHOWS_LIGHT",
            Self::BareLight => "SHOWS_BARE_LIGHT",
            Self::Alpha => "SHOWS_ALPHA",
            Self::OneMinusAlpha => "SHOWS_ONE_MINUS_ALPHA",
            Self::Hit => "SHOWS_HIT",
        }
    }

    fn sample_type(self) -> TextureSampleType {
        match self {
            Self::Hit => TextureSampleType::Uint,
            _ => TextureSampleType::Float { filterable: false },
        }
    }
}

/// On a view of the render world: the state of an effect with a debug view.
pub(super) trait DebugShown: Component {
    /// Channels and texture that the settings select; the texture covers the viewport. `None` without a debug view.
    fn shown(&self) -> Option<(Shows, &TextureView)>;
}

/// Shows the debug view of a `V`.
pub(super) struct DebugViewPlugin<V>(PhantomData<V>);

impl<V> Default for DebugViewPlugin<V> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<V: DebugShown> Plugin for DebugViewPlugin<V> {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<DebugViewPipelinesPlugin>() {
            app.add_plugins(DebugViewPipelinesPlugin);
        }
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<V, DebugView<V>>(render_app);
        render_app
            .add_systems(
                Render,
                prepare_debug_views::<V>
                    .run_if(any_with_component::<V>)
                    .in_set(RenderSystems::PrepareBindGroups),
            )
            .add_systems(
                Core3d,
                show::<V>
                    .run_if(any_with_component::<DebugView<V>>)
                    .in_set(Core3dSystems::MainPass)
                    .in_set(DebugViewPasses)
                    .after(HistoryPasses),
            );
    }
}

struct DebugViewPipelinesPlugin;

impl Plugin for DebugViewPipelinesPlugin {
    fn build(&self, app: &mut App) {
        embedded_asset!(app, "debug_view.wgsl");
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app
                .allow_ambiguous_resource::<DebugViewPipelines>()
                .add_systems(RenderStartup, init_pipelines);
        }
    }
}

type Key = (TextureFormat, Shows);

/// Created on first use.
#[derive(Resource)]
struct DebugViewPipelines {
    shader: Handle<Shader>,
    fullscreen: FullscreenShader,
    by_key: HashMap<Key, (CachedRenderPipelineId, ResolvedLayout)>,
}

fn init_pipelines(
    mut commands: Commands,
    asset_server: Res<AssetServer>,
    fullscreen: Res<FullscreenShader>,
) {
    commands.insert_resource(DebugViewPipelines {
        shader: load_embedded_asset!(asset_server.as_ref(), "debug_view.wgsl"),
        fullscreen: fullscreen.clone(),
        by_key: HashMap::default(),
    });
}

impl DebugViewPipelines {
    fn get(
        &mut self,
        cache: &PipelineCache,
        key: Key,
    ) -> (CachedRenderPipelineId, &ResolvedLayout) {
        let (format, shows) = key;
        let (pipeline, layout) = self.by_key.entry(key).or_insert_with(|| {
            let found = [(SOURCE_TEXTURE, texture_2d(shows.sample_type()))];
            let layout = ResolvedLayout::new(cache, layout(LABEL, ShaderStages::FRAGMENT, found));
            let pipeline = cache.queue_render_pipeline(RenderPipelineDescriptor {
                label: Some(LABEL.into()),
                layout: vec![layout.descriptor().clone()],
                vertex: self.fullscreen.to_vertex_state(),
                fragment: Some(FragmentState {
                    shader: self.shader.clone(),
                    shader_defs: vec![shows.shader_def().into()],
                    entry_point: Some("fragment".into()),
                    targets: vec![Some(ColorTargetState {
                        format,
                        blend: None,
                        write_mask: ColorWrites::ALL,
                    })],
                }),
                ..default()
            });
            (pipeline, layout)
        });
        (*pipeline, layout)
    }
}

/// On a view that shows the output of a `V`. The pipeline may still be compiling.
#[derive(Component)]
struct DebugView<V> {
    pipeline: CachedRenderPipelineId,
    group: CachedBindGroup,
    of: PhantomData<V>,
}

fn prepare_debug_views<V: DebugShown>(
    mut commands: Commands,
    device: Res<RenderDevice>,
    cache: Res<PipelineCache>,
    pipelines: Option<ResMut<DebugViewPipelines>>,
    mut views: Query<(Entity, &V, &ExtractedView, Option<&mut DebugView<V>>)>,
) {
    let Some(mut pipelines) = pipelines else {
        return;
    };
    for (entity, held, view, shown) in &mut views {
        let Some((shows, texture)) = held.shown() else {
            if shown.is_some() {
                commands.entity(entity).remove::<DebugView<V>>();
            }
            continue;
        };
        let (pipeline, layout) = pipelines.get(&cache, (view.target_format, shows));
        let mut made = None;
        let shown = match shown {
            Some(shown) => shown.into_inner(),
            None => made.insert(DebugView {
                pipeline,
                group: CachedBindGroup::default(),
                of: PhantomData,
            }),
        };
        shown.pipeline = pipeline;
        (shown.group).update(&device, layout, |entries| {
            entries.push(SOURCE_TEXTURE, texture.into_binding())
        });
        if let Some(made) = made {
            commands.entity(entity).insert(made);
        }
    }
}

fn show<V: DebugShown>(
    view: ViewQuery<(&DebugView<V>, &ViewTarget, &ExtractedCamera)>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (shown, target, camera) = view.into_inner();
    let (Some(pipeline), Some(group)) =
        (cache.get_render_pipeline(shown.pipeline), shown.group.get())
    else {
        return;
    };
    timed(&mut ctx, LABEL, &mut |ctx| {
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some(LABEL),
            color_attachments: &[Some(target.get_color_attachment())],
            ..default()
        });
        if let Some(viewport) = &camera.viewport {
            pass.set_camera_viewport(viewport);
        }
        pass.set_render_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.draw(0..3, 0..1);
    });
}
