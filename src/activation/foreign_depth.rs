//! Detects renderers other than those of meshes that may draw depth before the G-buffer.

use core::any::TypeId;

use bevy::{
    light::cluster::ClusterVisibilityClass,
    mesh::{Mesh2d, Mesh3d},
    render::view::RenderExtractedVisibleEntities,
};

/// True if the view sees entities of a visibility class that is neither meshes nor lights. Bevy's meshlets are such a
/// class: they are in the depth buffer before any mesh is drawn. Their type cannot be named here because it exists only
/// with Bevy's feature `meshlet`, and other crates may have similar renderers.
pub(super) fn others_may_draw_depth(visible: Option<&RenderExtractedVisibleEntities>) -> bool {
    let harmless = [
        TypeId::of::<Mesh3d>(),
        TypeId::of::<Mesh2d>(),
        TypeId::of::<ClusterVisibilityClass>(),
    ];
    // Bevy lists every class that any camera of the app has seen, so the list of entities decides.
    visible.is_some_and(|visible| {
        let mut classes = visible.classes.iter();
        classes.any(|(class, seen)| !harmless.contains(class) && !seen.entities.is_empty())
    })
}
