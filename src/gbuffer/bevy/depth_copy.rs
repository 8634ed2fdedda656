//! Provides the depth copy of the depth prepass to its readers.
//!
//! Bevy's prepass copies depth right after drawing, when the lean meshes are still missing, and again in the second
//! phase of occlusion culling. On lean views these systems withhold the copy's texture from it and copy once, when
//! depth is complete.

use bevy::{
    core_pipeline::prepass::ViewPrepassTextures,
    prelude::*,
    render::{
        renderer::{RenderContext, ViewQuery},
        texture::ColorAttachment,
        view::ViewDepthTexture,
    },
};

use crate::view::ActiveLeanView;

/// The systems of this file. They change nothing that shadow passes read.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(in crate::gbuffer) struct DepthCopySystems;

/// The texture, while it is withheld from Bevy's prepass. One slot suffices: the views of a frame are drawn in
/// sequence.
#[derive(Resource, Default)]
pub(in crate::gbuffer) struct WithheldDepthCopy(Option<ColorAttachment>);

/// Withholds the texture before Bevy's early prepass.
pub(in crate::gbuffer) fn withhold_depth_copy(
    view: ViewQuery<&mut ViewPrepassTextures, With<ActiveLeanView>>,
    mut withheld: ResMut<WithheldDepthCopy>,
) {
    withheld.0 = view.into_inner().depth.take();
}

/// Returns the texture before Bevy's late prepass on views that resolve motion: the late resolve compares depth with
/// the copy which that prepass makes.
pub(in crate::gbuffer) fn allow_late_depth_copy(
    view: ViewQuery<(&mut ViewPrepassTextures, &ActiveLeanView)>,
    mut withheld: ResMut<WithheldDepthCopy>,
) {
    let (mut textures, active) = view.into_inner();
    if active.culls_in_two_phases && active.resolves_motion {
        give_back(&mut textures, &mut withheld);
    }
}

/// Copies depth after the last pass that draws in place of the prepass.
pub(in crate::gbuffer) fn copy_depth(
    view: ViewQuery<(&mut ViewPrepassTextures, &ViewDepthTexture), With<ActiveLeanView>>,
    mut withheld: ResMut<WithheldDepthCopy>,
    mut ctx: RenderContext,
) {
    let (mut textures, depth) = view.into_inner();
    give_back(&mut textures, &mut withheld);
    // Cameras that share a target may report different sizes. Bevy's two textures may then differ in size from each
    // other and from the view, and depth can only be copied whole.
    if let Some(copy) = &textures.depth
        && copy.texture.texture.size() == depth.texture.size()
    {
        ctx.command_encoder().copy_texture_to_texture(
            depth.texture.as_image_copy(),
            copy.texture.texture.as_image_copy(),
            depth.texture.size(),
        );
    }
}

fn give_back(textures: &mut ViewPrepassTextures, withheld: &mut WithheldDepthCopy) {
    if let Some(copy) = withheld.0.take() {
        textures.depth = Some(copy);
    }
}
