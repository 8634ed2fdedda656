//! The last frame of a view, its light and its depth, as they were before post-processing: for effects that find in it what
//! this frame cannot know yet.
//!
//! An effect inserts [`ReadsHistory`] on its views, and finds [`ViewHistory`] there. It is valid while each frame follows the
//! one before: not after a cut, a pause, a change of size or format, or of the kind of projection.

use bevy::{
    camera::MainPassResolutionOverride,
    core_pipeline::{
        core_3d::prepare_core_3d_depth_textures,
        schedule::{Core3d, Core3dSystems},
    },
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        camera::ExtractedCamera,
        render_resource::{
            Extent3d, Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
            TextureView, TextureViewDescriptor,
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        view::{ExtractedView, ViewDepthTexture, ViewTarget},
    },
};

use super::succession::{FrameNumber, LastFrame, Succession, SuccessionPlugin};
use crate::{
    gpu::timed::timed,
    view::{CameraCuts, depth_usage::extend_depth_usage, removal},
};

/// On a view of the render world: something reads its last frame. To be inserted before `RenderSystems::PrepareResources`,
/// and removed when nothing does any more.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ReadsHistory;

/// On a view of the render world with [`ReadsHistory`]: its last frame. Both textures are as large as the view's target.
#[derive(Component)]
pub struct ViewHistory {
    color: Kept,
    depth: Kept,
    frames: Succession,
}

impl ViewHistory {
    /// What the last frame was seen with; `None` if what the textures hold says nothing of this frame.
    pub fn last(&self) -> Option<&LastFrame> {
        self.frames.last()
    }

    /// The lit picture, linear, exposed as the last frame was, in the format of the view's main texture.
    pub fn color(&self) -> &TextureView {
        &self.color.view
    }

    /// `Depth32Float`, reversed, as the opaque meshes left it.
    pub fn depth(&self) -> &TextureView {
        &self.depth.view
    }

    /// What [`color`](Self::color) and [`depth`](Self::depth) show.
    pub fn textures(&self) -> [&Texture; 2] {
        [&self.color.texture, &self.depth.texture]
    }
}

/// A texture that outlasts frames.
struct Kept {
    texture: Texture,
    view: TextureView,
}

impl Kept {
    fn like(device: &RenderDevice, label: &'static str, source: &Texture) -> Self {
        let texture = device.create_texture(&TextureDescriptor {
            label: Some(label),
            size: source.size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: source.format(),
            usage: TextureUsages::TEXTURE_BINDING
                | TextureUsages::COPY_DST
                | TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&TextureViewDescriptor::default());
        Self { texture, view }
    }

    fn is_like(&self, source: &Texture) -> bool {
        form(&self.texture) == form(source)
    }
}

fn form(texture: &Texture) -> (Extent3d, TextureFormat) {
    (texture.size(), texture.format())
}

/// Keeps the last frame of views that somebody reads.
pub(crate) struct HistoryPlugin;

impl Plugin for HistoryPlugin {
    fn build(&self, app: &mut App) {
        SuccessionPlugin::add_to(app);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<ReadsHistory, ViewHistory>(render_app);
        render_app
            .add_systems(RenderStartup, forget_histories)
            .add_systems(
                Render,
                (
                    extend_depth_usage::<ReadsHistory>(TextureUsages::COPY_SRC)
                        .before(prepare_core_3d_depth_textures),
                    prepare_histories.after(prepare_core_3d_depth_textures),
                )
                    .in_set(RenderSystems::PrepareResources),
            )
            .add_systems(
                Core3d,
                keep_frame
                    .after(Core3dSystems::MainPass)
                    .before(Core3dSystems::EarlyPostProcess),
            );
    }
}

/// On each new device.
fn forget_histories(mut commands: Commands, views: Query<Entity, With<ViewHistory>>) {
    for view in &views {
        commands.entity(view).remove::<ViewHistory>();
    }
}

/// Makes the textures of views that have none, and says whether those of others are valid.
fn prepare_histories(
    mut commands: Commands,
    device: Res<RenderDevice>,
    number: Res<FrameNumber>,
    mut views: Query<
        (
            Entity,
            (&ExtractedView, &ExtractedCamera),
            &ViewTarget,
            &ViewDepthTexture,
            Option<&MainPassResolutionOverride>,
            Option<&CameraCuts>,
            Option<&mut ViewHistory>,
        ),
        With<ReadsHistory>,
    >,
) {
    for (entity, (view, camera), target, depth, resolution, cuts, history) in &mut views {
        let (color, depth) = (target.main_texture(), &depth.texture);
        // Depth cannot be resolved.
        let can_be_kept = color.usage().contains(TextureUsages::COPY_SRC)
            && depth.usage().contains(TextureUsages::COPY_SRC)
            && depth.sample_count() == 1;
        if !can_be_kept {
            commands.entity(entity).remove::<ViewHistory>();
            continue;
        }
        let current = LastFrame::of(view, resolution, camera.exposure);
        match history {
            Some(mut history) if history.color.is_like(color) && history.depth.is_like(depth) => {
                history.frames.advance(current, cuts, &number);
            }
            _ => {
                commands.entity(entity).insert(ViewHistory {
                    color: Kept::like(&device, "lean_deferred/screen_space/color", color),
                    depth: Kept::like(&device, "lean_deferred/screen_space/depth", depth),
                    frames: Succession::new(current, cuts),
                });
            }
        }
    }
}

/// Copies what the main passes have left.
fn keep_frame(
    view: ViewQuery<(&ViewHistory, &ViewTarget, &ViewDepthTexture)>,
    number: Res<FrameNumber>,
    mut ctx: RenderContext,
) {
    let (history, target, depth) = view.into_inner();
    let pairs = [
        (target.main_texture(), &history.color),
        (&depth.texture, &history.depth),
    ];
    if !pairs.iter().all(|(source, kept)| kept.is_like(source)) {
        return;
    }
    timed(&mut ctx, "lean_deferred/screen_space/history", |ctx| {
        for (source, kept) in pairs {
            ctx.command_encoder().copy_texture_to_texture(
                source.as_image_copy(),
                kept.texture.as_image_copy(),
                source.size(),
            );
        }
    });
    history.frames.hold(&number);
}
