//! Whether something besides meshes may draw depth before the G-buffer.

use core::any::TypeId;

use bevy::{
    light::cluster::ClusterVisibilityClass,
    mesh::{Mesh2d, Mesh3d},
    render::view::RenderExtractedVisibleEntities,
};

/// Whether the view has seen entities of a kind (a visibility class) that is neither meshes nor lights. Bevy's meshlets
/// are such a kind: they are in the depth buffer before any mesh is drawn. Their type cannot be named here, since Bevy
/// has it only with the feature `meshlet`; and other renderers of that sort may come with other crates.
pub(super) fn others_may_draw_depth(visible: Option<&RenderExtractedVisibleEntities>) -> bool {
    let harmless = [
        TypeId::of::<Mesh3d>(),
        TypeId::of::<Mesh2d>(),
        TypeId::of::<ClusterVisibilityClass>(),
    ];
    // Bevy lists the classes that any camera of the app has seen.
    visible.is_some_and(|visible| {
        let mut classes = visible.classes.iter();
        classes.any(|(class, seen)| !harmless.contains(class) && !seen.entities.is_empty())
    })
}
