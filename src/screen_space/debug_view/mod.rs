//! Shows textures of diffuse GI and of reflections in place of the picture: before post-processing, and after the history is kept,
//! which must not contain them.

#[doc(hidden)]
pub mod binding_numbers;

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    core_pipeline::{
        FullscreenShader,
        schedule::{Core3d, Core3dSystems},
    },
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        render_resource::{
            BindGroupLayoutDescriptor, IntoBinding, PipelineCache, ShaderStages, TextureSampleType,
            TextureView, binding_types::texture_2d,
        },
        renderer::RenderDevice,
        view::ExtractedView,
    },
    shader::ShaderDefVal,
};

use binding_numbers::SOURCE_TEXTURE;

use super::{diffuse_gi::ViewGi, reflections::ViewReflections};
use crate::{
    gpu::bindings::layout,
    view::{
        DebugView, DebugViewPasses, EffectSystems, HistoryPasses, LeanDebugView,
        debug_draw::{DebugDraw, DebugDrawn, DebugPipelines, draw_debug_view},
        removal,
    },
};

/// Channels of a texture to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Shows {
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

impl DebugDraw for Shows {
    const LABEL: &'static str = "lean_deferred/screen_space/debug_view";

    fn layout(self) -> BindGroupLayoutDescriptor {
        let sample_type = match self {
            Self::Hit => TextureSampleType::Uint,
            _ => TextureSampleType::Float { filterable: false },
        };
        let source = [(SOURCE_TEXTURE, texture_2d(sample_type))];
        layout(Self::LABEL, ShaderStages::FRAGMENT, source)
    }

    fn shader_defs(self) -> Vec<ShaderDefVal> {
        let name = match self {
            Self::Light => "SHOWS_LIGHT",
            Self::BareLight => "SHOWS_BARE_LIGHT",
            Self::Alpha => "SHOWS_ALPHA",
            Self::OneMinusAlpha => "SHOWS_ONE_MINUS_ALPHA",
            Self::Hit => "SHOWS_HIT",
        };
        vec![name.into()]
    }
}

/// The channels and the texture that `view` is of, if it is of one of these effects. The texture covers the viewport.
fn source_of<'a>(
    view: DebugView,
    gi: Option<&'a ViewGi>,
    reflections: Option<&'a ViewReflections>,
) -> Option<(Shows, &'a TextureView)> {
    let shows = match view {
        DebugView::GiLight => Shows::BareLight,
        DebugView::GiVisibility => Shows::OneMinusAlpha,
        DebugView::ReflectionLight => Shows::Light,
        DebugView::ReflectionConfidence => Shows::Alpha,
        DebugView::ReflectionHit => Shows::Hit,
        _ => return None,
    };
    let texture = match shows {
        Shows::BareLight | Shows::OneMinusAlpha => gi?.output(),
        Shows::Light | Shows::Alpha => reflections?.output(),
        Shows::Hit => reflections?.hits(),
    };
    Some((shows, texture))
}

/// Shows the debug views of diffuse GI and of reflections. Added by the first of the two.
pub(super) struct DebugViewPlugin;

impl DebugViewPlugin {
    pub(super) fn add_to(app: &mut App) {
        if !app.is_plugin_added::<Self>() {
            app.add_plugins(Self);
        }
    }
}

impl Plugin for DebugViewPlugin {
    fn build(&self, app: &mut App) {
        embedded_asset!(app, "debug_view.wgsl");
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<LeanDebugView, DebugDrawn<Shows>>(render_app);
        // What is drawn keeps their textures alive.
        removal::remove_with::<ViewGi, DebugDrawn<Shows>>(render_app);
        removal::remove_with::<ViewReflections, DebugDrawn<Shows>>(render_app);
        render_app
            .add_systems(RenderStartup, init_pipelines)
            .add_systems(
                Render,
                prepare_debug_views
                    .in_set(RenderSystems::PrepareBindGroups)
                    .in_set(EffectSystems::DebugViews),
            )
            .add_systems(
                Core3d,
                draw_debug_view::<Shows>
                    .in_set(EffectSystems::DebugViews)
                    .in_set(Core3dSystems::MainPass)
                    .in_set(DebugViewPasses)
                    .after(HistoryPasses),
            );
    }
}

fn init_pipelines(
    mut commands: Commands,
    asset_server: Res<AssetServer>,
    fullscreen: Res<FullscreenShader>,
) {
    let shader = load_embedded_asset!(asset_server.as_ref(), "debug_view.wgsl");
    commands.insert_resource(DebugPipelines::<Shows>::new(shader, &fullscreen));
}

fn prepare_debug_views(
    mut commands: Commands,
    (device, cache): (Res<RenderDevice>, Res<PipelineCache>),
    pipelines: Option<ResMut<DebugPipelines<Shows>>>,
    mut views: Query<(
        Entity,
        (&ExtractedView, &LeanDebugView),
        (Option<&ViewGi>, Option<&ViewReflections>),
        Option<&mut DebugDrawn<Shows>>,
    )>,
) {
    let Some(mut pipelines) = pipelines else {
        return;
    };
    for (entity, (view, debug_view), (gi, reflections), drawn) in &mut views {
        let Some((shows, texture)) = source_of(debug_view.shows, gi, reflections) else {
            if drawn.is_some() {
                commands.entity(entity).remove::<DebugDrawn<Shows>>();
            }
            continue;
        };
        pipelines.set(
            &mut commands,
            &device,
            &cache,
            (entity, view),
            drawn,
            (shows, None),
            |entries| entries.push(SOURCE_TEXTURE, texture.into_binding()),
        );
    }
}
