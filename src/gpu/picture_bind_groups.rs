//! Bind groups of passes that read the picture.

use bevy::render::{
    render_resource::{BindGroup, BindingResource, Texture, TextureId, TextureView},
    renderer::RenderDevice,
    view::ViewTarget,
};

use super::bind_group_cache::{CachedBindGroup, ResolvedLayout};

/// A bind group per main texture: Bevy has two for a view and may use either.
#[derive(Default)]
pub(crate) struct PictureBindGroups([(Option<TextureId>, CachedBindGroup); 2]);

impl PictureBindGroups {
    /// Updates both groups. `resource` gets each binding of the layout, and each picture in turn.
    pub(crate) fn bind<'r>(
        &mut self,
        device: &RenderDevice,
        layout: &ResolvedLayout,
        target: &'r ViewTarget,
        resource: impl Fn(u32, &'r TextureView) -> Option<BindingResource<'r>>,
    ) {
        // A stable order, although the textures swap roles.
        let mut pictures = [
            (target.main_texture(), target.main_texture_view()),
            (
                target.main_texture_other(),
                target.main_texture_other_view(),
            ),
        ];
        pictures.sort_by_key(|(texture, _)| texture.id());
        for ((picture, view), (id, group)) in pictures.into_iter().zip(&mut self.0) {
            *id = Some(picture.id());
            group.bind(device, layout, |binding| resource(binding, view));
        }
    }

    /// The group that reads `picture`.
    pub(crate) fn of(&self, picture: &Texture) -> Option<&BindGroup> {
        let (_, group) = self.0.iter().find(|(id, _)| *id == Some(picture.id()))?;
        group.get()
    }

    pub(crate) fn all(&self) -> impl Iterator<Item = &BindGroup> {
        self.0.iter().filter_map(|(_, group)| group.get())
    }
}
