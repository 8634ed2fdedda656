//! Reports the targets of a camera and their memory cost.

use bevy::{
    prelude::*,
    render::{MainWorld, render_resource::TextureFormat, sync_world::MainEntity},
};

use super::textures::GBufferTextures;
use crate::{
    shader_library::layout::{BASE_BYTES_PER_PIXEL, VALID_MASK_FORMAT},
    view::{GBufferTargets, LeanDeferred},
};

/// On a camera with [`LeanDeferred`]: the targets of its G-buffer in the last frame that was rendered.
///
/// ```
/// # use bevy::prelude::*;
/// use bevy_lean_deferred::gbuffer::GBufferUsage;
///
/// fn print_costs(cameras: Query<(Entity, &GBufferUsage)>) {
///     for (camera, usage) in &cameras {
///         for (target, bytes) in usage.each() {
///             info!("{camera}: {target} {bytes} bytes");
///         }
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct GBufferUsage {
    /// Size of the targets in pixels; zero while Bevy's forward passes render the camera.
    pub size: UVec2,
    /// The optional targets.
    pub targets: GBufferTargets,
}

impl GBufferUsage {
    pub(crate) fn of(textures: &GBufferTextures) -> Self {
        let surface = &textures.surface.texture;
        Self {
            size: UVec2::new(surface.width(), surface.height()),
            targets: textures.targets(),
        }
    }

    /// True if the camera was rendered through the G-buffer.
    pub fn is_active(&self) -> bool {
        self.size != UVec2::ZERO
    }

    /// Bytes per pixel of all targets, without depth.
    pub fn bytes_per_pixel(&self) -> u32 {
        if self.is_active() {
            BASE_BYTES_PER_PIXEL + self.targets.bytes_per_pixel()
        } else {
            0
        }
    }

    /// Bytes of all targets. Cameras of one size with the same targets share them.
    pub fn bytes(&self) -> u64 {
        self.pixels() * u64::from(self.bytes_per_pixel())
    }

    /// Name and bytes of each target.
    pub fn each(&self) -> impl Iterator<Item = (&'static str, u64)> {
        let base = self
            .is_active()
            .then_some(("base", u64::from(BASE_BYTES_PER_PIXEL)));
        let bytes_of = |format: TextureFormat| u64::from(format.block_copy_size(None).unwrap_or(0));
        let written =
            (!self.targets.is_empty()).then_some(("valid mask", bytes_of(VALID_MASK_FORMAT)));
        let optional = self
            .targets
            .iter()
            .map(move |target| (target.name(), bytes_of(target.format())));
        let pixels = self.pixels();
        base.into_iter()
            .chain(written)
            .chain(optional)
            .map(move |(name, bytes)| (name, bytes * pixels))
    }

    fn pixels(&self) -> u64 {
        u64::from(self.size.x) * u64::from(self.size.y)
    }
}

/// Copies the usage of the last frame's views to their cameras in the main world.
pub(super) fn report_usage(
    mut main_world: ResMut<MainWorld>,
    views: Query<(&MainEntity, Option<&GBufferTextures>), With<LeanDeferred>>,
) {
    for (camera, textures) in &views {
        let usage = textures.map_or(GBufferUsage::default(), GBufferUsage::of);
        if let Some(mut reported) = main_world.get_mut::<GBufferUsage>(camera.id()) {
            reported.set_if_neq(usage);
        }
    }
}

pub(super) fn remove_usage(removed: On<Remove, LeanDeferred>, mut commands: Commands) {
    commands
        .entity(removed.entity)
        .queue_silenced(|mut camera: EntityWorldMut| {
            camera.remove::<GBufferUsage>();
        });
}
