//! Bind groups of what reads the picture.

use bevy::render::{
    render_resource::{BindGroup, Texture, TextureId, TextureView},
    renderer::RenderDevice,
    view::ViewTarget,
};

use super::bind_group_cache::{CachedBindGroup, Entries, FoundLayout};

/// One for each of the two main textures that Bevy has for a view, and may use one or the other of.
#[derive(Default)]
pub(crate) struct PictureBindGroups([(Option<TextureId>, CachedBindGroup); 2]);

impl PictureBindGroups {
    /// `push` gets each picture in turn.
    pub(crate) fn update(
        &mut self,
        device: &RenderDevice,
        layout: &FoundLayout,
        target: &ViewTarget,
        push: impl Fn(&mut Entries, &TextureView) -> Option<()>,
    ) {
        // In an order that stays.
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
            group.update(device, layout, |entries| push(entries, view));
        }
    }

    /// The one that reads `picture`.
    pub(crate) fn of(&self, picture: &Texture) -> Option<&BindGroup> {
        let (_, group) = self.0.iter().find(|(id, _)| *id == Some(picture.id()))?;
        group.get()
    }

    pub(crate) fn all(&self) -> impl Iterator<Item = &BindGroup> {
        self.0.iter().filter_map(|(_, group)| group.get())
    }
}
