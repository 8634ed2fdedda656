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

use crate::{
    gpu::bindings::layout,
    view::{
        DebugView, DebugViewPasses, EffectSystems, HistoryPasses, IndirectDiffuse,
        IndirectSpecular, LeanDebugView,
        debug_draw::{DebugDraw, DebugDrawn, DebugPipelines, draw_debug_view},
        removal,
    },
};

/// On a view with reflections, while their hits are shown: the texture of hit words, one per ray.
#[derive(Component)]
pub(super) struct RayHits(pub(super) TextureView);

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
    const LABEL: &'static str = "lean_deferred/effects/debug_view";

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
    diffuse: Option<&'a IndirectDiffuse>,
    specular: Option<&'a IndirectSpecular>,
    hits: Option<&'a RayHits>,
) -> Option<(Shows, &'a TextureView)> {
    let diffuse = diffuse.and_then(|light| light.texture.as_ref());
    let specular = specular.and_then(|light| light.0.as_ref());
    Some(match view {
        DebugView::GiLight => (Shows::BareLight, diffuse?),
        DebugView::GiVisibility => (Shows::OneMinusAlpha, diffuse?),
        DebugView::ReflectionLight => (Shows::Light, specular?),
        DebugView::ReflectionConfidence => (Shows::Alpha, specular?),
        DebugView::ReflectionHit => (Shows::Hit, &hits?.0),
        _ => return None,
    })
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
        // Bind groups of the draw keep these textures alive.
        removal::remove_with::<IndirectDiffuse, DebugDrawn<Shows>>(render_app);
        removal::remove_with::<IndirectSpecular, DebugDrawn<Shows>>(render_app);
        removal::remove_with::<RayHits, DebugDrawn<Shows>>(render_app);
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
        (Option<&IndirectDiffuse>, Option<&IndirectSpecular>),
        Option<&RayHits>,
        Option<&mut DebugDrawn<Shows>>,
    )>,
) {
    let Some(mut pipelines) = pipelines else {
        return;
    };
    for (entity, (view, debug_view), (diffuse, specular), hits, drawn) in &mut views {
        let source = source_of(debug_view.shows, diffuse, specular, hits);
        let Some((shows, texture)) = source else {
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
