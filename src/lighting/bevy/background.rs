//! The pixels of a target that Bevy draws for a camera, and their colour where nothing is drawn.

use bevy::{
    camera::{ClearColorConfig, CompositingSpace, MainPassResolutionOverride, Viewport},
    prelude::*,
    render::{camera::ExtractedCamera, view::ViewTarget},
};

/// The actual size; the one that the camera reports may lag behind a target that is resized or replaced.
pub(in crate::lighting) fn target_size(target: &ViewTarget) -> UVec2 {
    let texture = target.main_texture();
    UVec2::new(texture.width(), texture.height())
}

/// Origin and size of the lit part of a target, in pixels.
pub(in crate::lighting) fn lit_pixels(
    camera: &ExtractedCamera,
    target: &ViewTarget,
    resolution_override: Option<&MainPassResolutionOverride>,
) -> (UVec2, UVec2) {
    let viewport =
        Viewport::from_viewport_and_override(camera.viewport.as_ref(), resolution_override);
    match &viewport {
        Some(viewport) => (viewport.physical_position, viewport.physical_size),
        None => (UVec2::ZERO, target_size(target)),
    }
}

/// The clear colour of `camera` as its main texture stores it; as in Bevy's `prepare_view_targets`.
pub(in crate::lighting) fn background(camera: &ExtractedCamera, clear_color: &ClearColor) -> Vec4 {
    let color = match camera.clear_color {
        ClearColorConfig::Custom(color) => color,
        ClearColorConfig::None => return Vec4::ZERO,
        ClearColorConfig::Default => clear_color.0,
    };
    match camera.compositing_space {
        Some(CompositingSpace::Oklab) => Oklaba::from(color).to_vec4(),
        Some(CompositingSpace::Srgb) => Srgba::from(color).to_vec4(),
        Some(CompositingSpace::Linear) | None => color.to_linear().to_vec4(),
    }
}
