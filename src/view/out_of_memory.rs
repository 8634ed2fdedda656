//! Handles textures that do not fit into the GPU's memory.
//!
//! Bevy quits the app on an uncaught error. Textures of this crate are therefore created within an error scope: if one
//! does not fit, its camera is left to Bevy, which needs less.

use bevy::{
    ecs::entity::EntityHashMap,
    prelude::*,
    render::{camera::ExtractedCamera, renderer::RenderDevice},
    tasks::futures::now_or_never,
};
use wgpu::ErrorFilter;

use super::lighting_io::{LightingIo, LightingIoQuery};
use crate::gpu::growing_size::GrowingSize;

/// In the render world: the cameras whose textures do not fit.
#[derive(Resource, Default)]
pub struct OutOfMemory {
    lacking: EntityHashMap<Lack>,
    #[cfg(feature = "test_hooks")]
    hooks: test_hooks::Hooks,
}

struct Lack {
    label: &'static str,
    /// Size of the camera's target, and what its effects exchange with lighting. If these change, it is tried again.
    tried_with: Option<(Option<UVec2>, LightingIo)>,
}

impl OutOfMemory {
    /// Returns the texture or textures that `make` creates for the camera `view`; `None` if they do not fit, or if
    /// other textures of this camera did not.
    ///
    /// In a browser, which reports errors only later, everything fits.
    pub(crate) fn fit<T>(
        &mut self,
        device: &RenderDevice,
        view: Entity,
        label: &'static str,
        make: impl FnOnce() -> T,
    ) -> Option<T> {
        if self.lacking.contains_key(&view) {
            return None;
        }
        let made = self.create(device, label, false, make);
        made.map_err(|error| self.leave(view, label, &error)).ok()
    }

    /// As [`fit`](Self::fit), for textures of this `size`. Headroom that does not fit is left away.
    pub(crate) fn fit_growing<T>(
        &mut self,
        device: &RenderDevice,
        view: Entity,
        label: &'static str,
        size: &mut GrowingSize,
        mut make: impl FnMut(UVec2) -> T,
    ) -> Option<T> {
        if self.lacking.contains_key(&view) {
            return None;
        }
        let has_headroom = size.has_headroom();
        let mut made = self.create(device, label, has_headroom, || make(size.allocated()));
        if made.is_err() && has_headroom {
            size.drop_headroom();
            made = self.create(device, label, false, || make(size.allocated()));
        }
        made.map_err(|error| self.leave(view, label, &error)).ok()
    }

    /// Calls `make` within an error scope. `has_headroom` matters to tests alone.
    fn create<T>(
        &mut self,
        device: &RenderDevice,
        label: &str,
        has_headroom: bool,
        make: impl FnOnce() -> T,
    ) -> Result<T, wgpu::Error> {
        let scope = (device.wgpu_device()).push_error_scope(ErrorFilter::OutOfMemory);
        let made = make();
        #[cfg(feature = "test_hooks")]
        self.hooks.create(device, label, has_headroom);
        #[cfg(not(feature = "test_hooks"))]
        let _ = (label, has_headroom);
        let error = now_or_never(scope.pop()).flatten();
        error.map_or(Ok(made), Err)
    }

    /// Leaves the camera `view` to Bevy.
    fn leave(&mut self, view: Entity, label: &'static str, error: &wgpu::Error) {
        error!(
            "{label} does not fit into the GPU's memory: {error}. Bevy renders the camera. Make its target smaller or remove effects."
        );
        let lack = Lack {
            label,
            tried_with: None,
        };
        self.lacking.insert(view, lack);
    }

    /// The label of the texture that did not fit.
    pub(crate) fn label(&self, view: Entity) -> Option<&'static str> {
        self.lacking.get(&view).map(|lack| lack.label)
    }
}

/// Lets cameras try again if their target's size or their effects changed, or if they are switched off or despawned.
pub(super) fn forget_cameras(
    mut memory: ResMut<OutOfMemory>,
    cameras: Query<(&ExtractedCamera, LightingIoQuery)>,
) {
    if memory.lacking.is_empty() {
        return;
    }
    memory.lacking.retain(|view, lack| {
        cameras.get(*view).is_ok_and(|(camera, io)| {
            // Ignored because scattering meshes enter and leave the view.
            let io = LightingIo::asked(io) - LightingIo::SUBSURFACE_LIGHT;
            let now = (camera.physical_target_size, io);
            *lack.tried_with.get_or_insert(now) == now
        })
    });
}

/// Counts creations for tests, and makes them fail.
#[cfg(feature = "test_hooks")]
mod test_hooks {
    use bevy::render::{
        render_resource::{TextureDescriptor, TextureDimension, TextureFormat, TextureUsages},
        renderer::RenderDevice,
    };
    use wgpu::Extent3d;

    use super::OutOfMemory;

    #[derive(Default)]
    pub(super) struct Hooks {
        /// Textures whose labels have this prefix do not fit.
        scarce: Option<&'static str>,
        /// Only those with headroom do not fit.
        fits_without_headroom: bool,
        /// Number of creations within an error scope.
        attempts: usize,
    }

    impl Hooks {
        /// Called within the error scope of each creation.
        pub(super) fn create(&mut self, device: &RenderDevice, label: &str, has_headroom: bool) {
            self.attempts += 1;
            let is_scarce = self.scarce.is_some_and(|scarce| label.starts_with(scarce));
            if is_scarce && (has_headroom || !self.fits_without_headroom) {
                make_huge(device);
            }
        }
    }

    impl OutOfMemory {
        /// Number of creations. It does not grow in frames in which nothing changed.
        pub fn attempts(&self) -> usize {
            self.hooks.attempts
        }

        /// Pretends that textures whose labels have this prefix do not fit.
        pub fn make_scarce(&mut self, labels: Option<&'static str>) {
            self.hooks.scarce = labels;
            self.hooks.fits_without_headroom = false;
        }

        /// As [`make_scarce`](Self::make_scarce), but only headroom does not fit.
        pub fn make_headroom_scarce(&mut self, labels: &'static str) {
            self.hooks.scarce = Some(labels);
            self.hooks.fits_without_headroom = true;
        }
    }

    /// Creates a texture that exceeds the memory of any GPU.
    fn make_huge(device: &RenderDevice) {
        let limits = device.limits();
        device.create_texture(&TextureDescriptor {
            label: Some("lean_deferred/view/huge"),
            size: Extent3d {
                width: limits.max_texture_dimension_2d,
                height: limits.max_texture_dimension_2d,
                depth_or_array_layers: limits.max_texture_array_layers,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: TextureFormat::Rgba32Uint,
            usage: TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
    }
}
