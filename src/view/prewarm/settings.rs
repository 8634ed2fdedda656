//! The component with which an app prewarms a camera, and the features of a level.

use bevy::{
    ecs::{lifecycle::HookContext, world::DeferredWorld},
    prelude::*,
};
use bitflags::bitflags;

use crate::view::support::SupportChecks;

/// Compiles the pipelines that a [`LeanDeferred`](crate::LeanDeferred) camera will need, during a loading screen.
///
/// Insert it on the camera once the level is spawned: for a glTF file, in an observer of Bevy's `WorldInstanceReady`. Nothing of it has to be
/// visible. It compiles
///
/// - lighting: the general pipelines, and those that fit the lights, decals and light probes of the world, hidden and distant ones
///   too, with the settings of the camera (fog, shadow filter, …) and with [`features`](Self::features);
/// - the effects of the camera, with their settings;
/// - the pipelines that draw the meshes of the world into the G-buffer: for all combinations of optional targets that these meshes
///   may bring about, and on cameras with motion vectors also for meshes in motion. To prewarm a material that appears later, spawn
///   a mesh with it and `Visibility::Hidden`.
///
/// Bevy's own pipelines are compiled when Bevy first needs them: shadow maps, sky, post-processing, and meshes that go forward.
///
/// [`progress`](Self::progress) counts the pipelines for a progress bar, and tells when all are compiled. Where Bevy compiles within
/// the frame (macOS, the web, apps without its feature `multi_threaded`), no more than two are compiled per frame, so that the
/// loading screen keeps moving. Insert the component again for the next level, which ends the last one. It may be removed at any
/// time.
///
/// If the camera cannot be lean (no `LeanDeferred`, a device without support, a setting that [`LeanStatus`](crate::LeanStatus)
/// names), or is not rendered for 120 frames, a warning says so, and the prewarm is done at once.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// use bevy_lean_deferred::{LeanPrewarm, PrewarmFeatures};
///
/// fn prewarm(mut commands: Commands, camera: Single<Entity, With<LeanDeferred>>) {
///     commands.entity(*camera).insert(LeanPrewarm {
///         // A torch that the player may light, and fog in one of the rooms.
///         features: vec![
///             PrewarmFeatures::SPOT_LIGHTS | PrewarmFeatures::SPOT_SHADOWS,
///             PrewarmFeatures::FOG,
///         ],
///         ..default()
///     });
/// }
///
/// fn show_progress(prewarm: Single<&LeanPrewarm>, mut bar: Single<&mut Node, With<Button>>) {
///     bar.width = percent(100.0 * prewarm.progress.fraction());
///     if prewarm.progress.is_done {
///         // Leave the loading screen.
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(on_insert = end_without_plugins)]
pub struct LeanPrewarm {
    /// Sets of features that the level will show in addition to what is in the world, and that are not there yet. Lighting is
    /// compiled to fit the world alone, and the world with each of these sets. Default: none.
    pub features: Vec<PrewarmFeatures>,
    /// Written by the crate.
    pub progress: PrewarmProgress,
}

/// Progress of a [`LeanPrewarm`].
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Default, Clone, PartialEq)]
pub struct PrewarmProgress {
    /// Pipelines that were compiled since it began. Those that cannot be compiled count too.
    pub done: usize,
    /// These, and those that are still to be compiled. Grows when effects begin to run and when assets are loaded: a mesh whose
    /// assets are still loading counts as one pipeline.
    pub total: usize,
    /// True once all are compiled, or if there is nothing to compile. It stays true until the component is inserted again.
    pub is_done: bool,
}

impl PrewarmProgress {
    /// From 0 to 1. 1 only once it is done.
    pub fn fraction(self) -> f32 {
        if self.is_done {
            return 1.0;
        }
        // The total is not known before the first frame.
        let fraction = self.done as f32 / self.total.max(1) as f32;
        fraction.min(0.99)
    }
}

bitflags! {
    /// Features of a level, for [`LeanPrewarm::features`].
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
    #[reflect(opaque, Default, Clone, PartialEq, Hash)]
    pub struct PrewarmFeatures: u32 {
        /// Point lights.
        const POINT_LIGHTS = 1 << 0;
        /// Spot lights.
        const SPOT_LIGHTS = 1 << 1;
        /// Point or spot lights with a radius.
        const SPHERE_LIGHTS = 1 << 2;
        /// At least 2,048 point and spot lights at a time.
        const MANY_LIGHTS = 1 << 3;
        /// Rectangular lights.
        const RECT_LIGHTS = 1 << 4;
        /// Shadow maps of a directional light; of several, if several in the world have them.
        const DIRECTIONAL_SHADOWS = 1 << 5;
        /// Shadow maps of point lights.
        const POINT_SHADOWS = 1 << 6;
        /// Shadow maps of spot lights.
        const SPOT_SHADOWS = 1 << 7;
        /// Soft shadows of any of these (Bevy's feature `experimental_pbr_pcss`). They are not found in the world: name them.
        const SOFT_SHADOWS = 1 << 8;
        /// Contact shadows of the camera.
        const CONTACT_SHADOWS = 1 << 9;
        /// Clustered decals, or lights with textures.
        const DECALS = 1 << 10;
        /// Reflection probes, or an environment map of the camera.
        const ENVIRONMENT_MAPS = 1 << 11;
        /// Irradiance volumes.
        const IRRADIANCE_VOLUMES = 1 << 12;
        /// Fog of the camera.
        const FOG = 1 << 13;
        /// An atmosphere.
        const ATMOSPHERE = 1 << 14;
        /// Lights, decals or light probes whose layers exclude some meshes.
        const LIGHT_LAYERS = 1 << 15;
        /// Motion vectors (`MotionVectorPrepass`), as with TAA and motion blur.
        const MOTION_VECTORS = 1 << 16;
    }
}

/// Ends the prewarm in an app without plugins of this crate, whose systems would do it otherwise.
fn end_without_plugins(mut world: DeferredWorld, context: HookContext) {
    if world.contains_resource::<SupportChecks>() {
        return;
    }
    warn!(
        "LeanPrewarm on camera {} compiles nothing and is done: the app has no plugins of this crate. Add `LeanDeferredPlugins` \
         after `DefaultPlugins`.",
        context.entity
    );
    if let Some(mut prewarm) = world.get_mut::<LeanPrewarm>(context.entity) {
        prewarm.progress.is_done = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_is_full_only_when_it_is_done() {
        let mut progress = PrewarmProgress::default();
        assert_eq!(progress.fraction(), 0.0);
        (progress.done, progress.total) = (3, 4);
        assert_eq!(progress.fraction(), 0.75);
        progress.done = 4;
        assert!(progress.fraction() < 1.0);
        progress.is_done = true;
        assert_eq!(progress.fraction(), 1.0);
    }

    #[test]
    fn without_plugins_it_is_done_at_once() {
        let mut world = World::new();
        let camera = world.spawn(LeanPrewarm::default());
        let prewarm = camera.get::<LeanPrewarm>().expect("it is there");
        assert!(prewarm.progress.is_done);
        world.init_resource::<SupportChecks>();
        let camera = world.spawn(LeanPrewarm::default());
        let prewarm = camera.get::<LeanPrewarm>().expect("it is there");
        assert!(!prewarm.progress.is_done);
    }
}
