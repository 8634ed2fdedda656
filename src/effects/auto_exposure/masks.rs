//! Images of the metering masks.

use bevy::{
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{TextureDimension, TextureSampleType, TextureViewDimension},
        renderer::RenderDevice,
        texture::{FallbackImage, GpuImage},
    },
};

use crate::gpu::named::system_param;

system_param! {
    /// Images of the metering masks.
    pub(super) struct Masks<'w> {
        device: Res<'w, RenderDevice>,
        images: Res<'w, RenderAssets<GpuImage>>,
        fallback: Res<'w, FallbackImage>,
    }
}

impl Masks<'_> {
    /// The mask's image; `None` while it is loading. The error is the reason that the image cannot be a mask.
    pub(super) fn get(&self, mask: &Handle<Image>) -> Result<Option<&GpuImage>, &'static str> {
        let Some(image) = self.images.get(mask) else {
            return Ok(None);
        };
        let texture = &image.texture_descriptor;
        let viewed = image.texture_view_descriptor.as_ref();
        let is_picture = texture.dimension == TextureDimension::D2
            && texture.size.depth_or_array_layers == 1
            && texture.sample_count == 1
            && matches!(
                viewed.and_then(|view| view.dimension),
                None | Some(TextureViewDimension::D2)
            );
        let aspect = viewed.map(|view| view.aspect);
        let kind = (texture.format).sample_type(aspect, Some(self.device.features()));
        if !is_picture {
            Err("it is no plain picture: use an image with one layer and one sample")
        } else if kind != Some(TextureSampleType::Float { filterable: true }) {
            Err("this device cannot filter its format: use another one, such as R8Unorm")
        } else {
            Ok(Some(image))
        }
    }

    /// The image to bind for the mask. Without one, and if it was unloaded or replaced by an unsuitable image, all pixels count.
    pub(super) fn bound(&self, mask: Option<&Handle<Image>>) -> &GpuImage {
        let found = mask.and_then(|mask| self.get(mask).ok().flatten());
        found.unwrap_or(&self.fallback.d2)
    }
}
