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
            TextureView,
            binding_types::{texture_2d, uniform_buffer},
        },
        renderer::RenderDevice,
        view::{ExtractedView, ViewUniform, ViewUniformOffset, ViewUniforms},
    },
    shader::ShaderDefVal,
};

use binding_numbers::{SOURCE_TEXTURE, VIEW};

use crate::{
    gpu::bindings::layout,
    view::{
        DebugView, DebugViewPasses, EffectSystems, HistoryPasses, IndirectDiffuse,
        IndirectSpecular, LeanDebugView,
        debug_draw::{DebugDraw, DebugDrawn, DebugPipelines, draw_debug_view},
        removal,
    },
};

/// On a view with reflections, while their hits are shown.
#[derive(Component)]
pub(super) struct RayHits {
    /// Hit words, one per ray.
    pub(super) texture: TextureView,
    /// Pixels per side of a texel.
    pub(super) divisor: u32,
}

/// Channels of a texture to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Channels {
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

/// The texture to show: its channels, and the pixels per side of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Shown {
    channels: Channels,
    divisor: u32,
}

impl DebugDraw for Shown {
    const LABEL: &'static str = "lean_deferred/effects/debug_view";

    fn layout(self) -> BindGroupLayoutDescriptor {
        let sample_type = match self.channels {
            Channels::Hit => TextureSampleType::Uint,
            _ => TextureSampleType::Float { filterable: false },
        };
        let entries = [
            (SOURCE_TEXTURE, texture_2d(sample_type)),
            (VIEW, uniform_buffer::<ViewUniform>(true)),
        ];
        layout(Self::LABEL, ShaderStages::FRAGMENT, entries)
    }

    fn shader_defs(self) -> Vec<ShaderDefVal> {
        let name = match self.channels {
            Channels::Light => "SHOWS_LIGHT",
            Channels::BareLight => "SHOWS_BARE_LIGHT",
            Channels::Alpha => "SHOWS_ALPHA",
            Channels::OneMinusAlpha => "SHOWS_ONE_MINUS_ALPHA",
            Channels::Hit => "SHOWS_HIT",
        };
        let divisor = ShaderDefVal::UInt("DIVISOR".into(), self.divisor);
        vec![name.into(), divisor]
    }
}

/// The texture that `view` is of, if it is of one of these effects.
fn source_of<'a>(
    view: DebugView,
    diffuse: Option<&'a IndirectDiffuse>,
    specular: Option<&'a IndirectSpecular>,
    hits: Option<&'a RayHits>,
) -> Option<(Shown, &'a TextureView)> {
    let (channels, divisor, texture) = match view {
        DebugView::GiLight | DebugView::GiVisibility => {
            let diffuse = diffuse?;
            let channels = match view {
                DebugView::GiLight => Channels::BareLight,
                _ => Channels::OneMinusAlpha,
            };
            let divisor = if diffuse.is_half { 2 } else { 1 };
            (channels, divisor, diffuse.texture.as_ref()?)
        }
        DebugView::ReflectionLight => (Channels::Light, 1, specular?.0.as_ref()?),
        DebugView::ReflectionConfidence => (Channels::Alpha, 1, specular?.0.as_ref()?),
        DebugView::ReflectionHit => {
            let hits = hits?;
            (Channels::Hit, hits.divisor, &hits.texture)
        }
        _ => return None,
    };
    Some((Shown { channels, divisor }, texture))
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
        removal::remove_with::<LeanDebugView, DebugDrawn<Shown>>(render_app);
        // Bind groups of the draw keep these textures alive.
        removal::remove_with::<IndirectDiffuse, DebugDrawn<Shown>>(render_app);
        removal::remove_with::<IndirectSpecular, DebugDrawn<Shown>>(render_app);
        removal::remove_with::<RayHits, DebugDrawn<Shown>>(render_app);
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
                draw_debug_view::<Shown>
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
    commands.insert_resource(DebugPipelines::<Shown>::new(shader, &fullscreen));
}

fn prepare_debug_views(
    mut commands: Commands,
    (device, cache): (Res<RenderDevice>, Res<PipelineCache>),
    pipelines: Option<ResMut<DebugPipelines<Shown>>>,
    view_uniforms: Res<ViewUniforms>,
    mut views: Query<(
        Entity,
        (&ExtractedView, &ViewUniformOffset, &LeanDebugView),
        (Option<&IndirectDiffuse>, Option<&IndirectSpecular>),
        Option<&RayHits>,
        Option<&mut DebugDrawn<Shown>>,
    )>,
) {
    let (Some(mut pipelines), Some(uniforms)) = (pipelines, view_uniforms.uniforms.binding())
    else {
        return;
    };
    for (entity, (view, offset, debug_view), (diffuse, specular), hits, drawn) in &mut views {
        let source = source_of(debug_view.shows, diffuse, specular, hits);
        let Some((shown, texture)) = source else {
            if drawn.is_some() {
                commands.entity(entity).remove::<DebugDrawn<Shown>>();
            }
            continue;
        };
        pipelines.set(
            &mut commands,
            &device,
            &cache,
            (entity, view),
            drawn,
            (shown, Some(offset.offset)),
            |entries| {
                entries.push(SOURCE_TEXTURE, texture.into_binding())?;
                entries.push(VIEW, uniforms.clone())
            },
        );
    }
}
