//! The copy of depth that whoever asked for a depth prepass reads.
//!
//! Bevy's prepass makes it right after it has drawn, when the lean meshes are still missing, and once more in the second
//! phase of occlusion culling. On lean views the copy's texture is kept from it, and one copy made when depth is complete.

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

/// The systems of this file. They change what shadow passes do not read.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct DepthCopySystems;

/// The texture, while it is kept from Bevy's prepass. The views of a frame are drawn one after the other.
#[derive(Resource, Default)]
pub(super) struct WithheldDepthCopy(Option<ColorAttachment>);

/// Before Bevy's early prepass.
pub(super) fn withhold_depth_copy(
    view: ViewQuery<&mut ViewPrepassTextures, With<ActiveLeanView>>,
    mut withheld: ResMut<WithheldDepthCopy>,
) {
    withheld.0 = view.into_inner().depth.take();
}

/// Before Bevy's late prepass: motion vectors are resolved by what that changes in depth, so its copy is needed.
pub(super) fn allow_late_depth_copy(
    view: ViewQuery<(&mut ViewPrepassTextures, &ActiveLeanView)>,
    mut withheld: ResMut<WithheldDepthCopy>,
) {
    let (mut textures, active) = view.into_inner();
    if active.culls_in_two_phases && active.resolves_motion {
        give_back(&mut textures, &mut withheld);
    }
}

/// After the last pass that draws in the place of the prepass.
pub(super) fn copy_depth(
    view: ViewQuery<(&mut ViewPrepassTextures, &ViewDepthTexture), With<ActiveLeanView>>,
    mut withheld: ResMut<WithheldDepthCopy>,
    mut ctx: RenderContext,
) {
    let (mut textures, depth) = view.into_inner();
    give_back(&mut textures, &mut withheld);
    // Where cameras of one target say different sizes, Bevy's two textures may differ, and from what the view says. Depth
    // can only be copied whole.
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
