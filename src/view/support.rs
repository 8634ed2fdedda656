//! Checks which effects the device can run.

use bevy::prelude::*;

/// Tells which effects the device can run. Available from before `Startup` on, and replaced with each new device. An error
/// names what is missing: capabilities of the device, or the plugin of the effect.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn_camera(mut commands: Commands, support: Res<LeanSupport>) {
///     let mut camera = commands.spawn(Camera3d::default());
///     match &support.deferred {
///         Ok(()) => {
///             camera.insert(LeanDeferred::default());
///         }
///         // Bevy renders the camera, with its own settings.
///         Err(missing) => info!("no lean cameras: the device lacks {missing}"),
///     }
///     if support.screen_space.is_ok() {
///         camera.insert(LeanScreenSpaceReflections::default());
///     }
/// }
/// ```
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct LeanSupport {
    /// [`LeanDeferred`](crate::LeanDeferred).
    pub deferred: Result<(), String>,
    /// [`LeanScreenSpaceAmbientOcclusion`](crate::LeanScreenSpaceAmbientOcclusion) by compute shaders.
    /// Without them a raster pass computes it, on any device.
    pub ambient_occlusion_by_compute: Result<(), String>,
    /// [`LeanScreenSpaceGi`](crate::LeanScreenSpaceGi) and
    /// [`LeanScreenSpaceReflections`](crate::LeanScreenSpaceReflections).
    pub screen_space: Result<(), String>,
    /// [`LeanSubsurfaceScattering`](crate::LeanSubsurfaceScattering).
    pub subsurface: Result<(), String>,
    /// [`LeanAutoExposure`](crate::LeanAutoExposure).
    pub auto_exposure: Result<(), String>,
}

impl LeanSupport {
    /// In an app without plugins of this crate.
    fn without_plugins() -> Self {
        let lacks = |plugin: &str| Err(format!("a plugin: add `{plugin}`"));
        Self {
            deferred: lacks("LeanDeferredPlugin"),
            ambient_occlusion_by_compute: lacks("LeanScreenSpaceAmbientOcclusionPlugin"),
            screen_space: lacks("LeanScreenSpaceGiPlugin` or `LeanScreenSpaceReflectionsPlugin"),
            subsurface: lacks("LeanSubsurfaceScatteringPlugin"),
            auto_exposure: lacks("LeanAutoExposurePlugin"),
        }
    }
}

/// The checks of the effects whose plugins the app has, in both worlds.
#[derive(Resource, Clone, Default)]
pub(crate) struct SupportChecks(Vec<SupportCheck>);

#[derive(Clone, Copy)]
struct SupportCheck {
    field: fn(&mut LeanSupport) -> &mut Result<(), String>,
    check: fn(&World) -> Result<(), String>,
}

/// Has a field of [`LeanSupport`] set by `check`, which looks at the device of a world.
pub(crate) fn add_check(
    app: &mut App,
    field: fn(&mut LeanSupport) -> &mut Result<(), String>,
    check: fn(&World) -> Result<(), String>,
) {
    let mut checks = app.world_mut().resource_mut::<SupportChecks>();
    checks.0.push(SupportCheck { field, check });
}

/// Inserts [`LeanSupport`] for the device of `world`, by its [`SupportChecks`].
pub(super) fn check_device(world: &mut World) {
    let unchecked = LeanSupport::without_plugins();
    let mut support = unchecked.clone();
    for check in &world.resource::<SupportChecks>().0 {
        *(check.field)(&mut support) = (check.check)(world);
    }
    // These effects run on lean cameras only.
    for effect in [&mut support.screen_space, &mut support.subsurface] {
        if effect.is_ok() && support.deferred != unchecked.deferred {
            effect.clone_from(&support.deferred);
        }
    }
    world.insert_resource(support);
}
