//! The status of each effect on a camera, for the main world.

use core::fmt;

use bevy::{
    camera::Viewport,
    core_pipeline::schedule::Core3d,
    ecs::{lifecycle::HookContext, schedule::ScheduleLabel, world::DeferredWorld},
    prelude::*,
    render::{camera::ExtractedCamera, render_resource::TextureFormat},
};

use super::support::SupportChecks;

/// On a camera with the component of an effect: tells for each effect if the last frame had it, or the reason that it did
/// not. Inserted with the first of these components and removed with the last one.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn show(cameras: Query<&LeanStatus, Changed<LeanStatus>>, mut texts: Query<&mut Text>) {
///     for status in &cameras {
///         let lines = status.each().map(|(component, status)| format!("{component}: {status}\n"));
///         // "LeanDeferred: off: its `Msaa` is not `Off`: insert `Msaa::Off`"
///         let lines: String = lines.collect();
///         for mut text in &mut texts {
///             text.0.clone_from(&lines);
///         }
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(on_add = warn_without_plugins)]
pub struct LeanStatus {
    /// Of [`LeanDeferred`](crate::LeanDeferred): on if the camera was rendered through the G-buffer. Bevy renders it otherwise.
    pub deferred: EffectStatus,
    /// Of [`LeanScreenSpaceAmbientOcclusion`](crate::LeanScreenSpaceAmbientOcclusion).
    pub ambient_occlusion: EffectStatus,
    /// Of [`LeanScreenSpaceGi`](crate::LeanScreenSpaceGi).
    pub diffuse_gi: EffectStatus,
    /// Of [`LeanScreenSpaceReflections`](crate::LeanScreenSpaceReflections).
    pub reflections: EffectStatus,
    /// Of [`LeanSubsurfaceScattering`](crate::LeanSubsurfaceScattering).
    pub subsurface: EffectStatus,
    /// Of [`LeanAutoExposure`](crate::LeanAutoExposure).
    pub auto_exposure: EffectStatus,
}

impl LeanStatus {
    /// Name of the component and status of each effect that the camera has.
    pub fn each(&self) -> impl Iterator<Item = (&'static str, &EffectStatus)> {
        (Effect::ALL.into_iter())
            .map(move |effect| (effect.component(), self.of(effect)))
            .filter(|(_, status)| **status != EffectStatus::Absent)
    }

    fn begin(&mut self, effect: Effect) {
        *self.of_mut(effect) = EffectStatus::Off(LeanOffReason::NotRendered);
    }

    /// The status of `effect`.
    pub(super) fn of(&self, effect: Effect) -> &EffectStatus {
        match effect {
            Effect::Deferred => &self.deferred,
            Effect::AmbientOcclusion => &self.ambient_occlusion,
            Effect::DiffuseGi => &self.diffuse_gi,
            Effect::Reflections => &self.reflections,
            Effect::Subsurface => &self.subsurface,
            Effect::AutoExposure => &self.auto_exposure,
        }
    }

    /// The status of `effect`, to change it.
    pub(super) fn of_mut(&mut self, effect: Effect) -> &mut EffectStatus {
        match effect {
            Effect::Deferred => &mut self.deferred,
            Effect::AmbientOcclusion => &mut self.ambient_occlusion,
            Effect::DiffuseGi => &mut self.diffuse_gi,
            Effect::Reflections => &mut self.reflections,
            Effect::Subsurface => &mut self.subsurface,
            Effect::AutoExposure => &mut self.auto_exposure,
        }
    }
}

/// The status of an effect on a camera in the last frame.
#[derive(Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Default, Clone, PartialEq)]
pub enum EffectStatus {
    /// The camera does not have the effect's component, or the app does not have its plugin.
    #[default]
    Absent,
    /// The frame had the effect. While shaders for changed settings compile, it goes on with the former settings.
    On,
    /// The frame did not have the effect: its shaders compile.
    Compiling,
    /// The frame did not have the effect, for this reason.
    Off(LeanOffReason),
}

impl EffectStatus {
    /// True if the frame had the effect.
    pub fn is_on(&self) -> bool {
        *self == Self::On
    }
}

impl fmt::Display for EffectStatus {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Absent => write!(f, "absent"),
            Self::On => write!(f, "on"),
            Self::Compiling => write!(f, "compiling"),
            Self::Off(reason) => write!(f, "off: {reason}"),
        }
    }
}

/// An effect with a component on cameras.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    Deferred,
    AmbientOcclusion,
    DiffuseGi,
    Reflections,
    Subsurface,
    AutoExposure,
}

impl Effect {
    /// All effects, in the order of their values.
    pub(super) const ALL: [Self; 6] = [
        Self::Deferred,
        Self::AmbientOcclusion,
        Self::DiffuseGi,
        Self::Reflections,
        Self::Subsurface,
        Self::AutoExposure,
    ];

    /// The name of its component.
    pub(super) fn component(self) -> &'static str {
        match self {
            Self::Deferred => "LeanDeferred",
            Self::AmbientOcclusion => "LeanScreenSpaceAmbientOcclusion",
            Self::DiffuseGi => "LeanScreenSpaceGi",
            Self::Reflections => "LeanScreenSpaceReflections",
            Self::Subsurface => "LeanSubsurfaceScattering",
            Self::AutoExposure => "LeanAutoExposure",
        }
    }
}

/// Keeps the field of `effect`, whose component is `E`, in the [`LeanStatus`] of cameras: absent without the component,
/// and off from its insertion until the first frame.
pub(crate) fn add_to<E: Component>(app: &mut App, effect: Effect) {
    let world = app.world_mut();
    let mut cameras = world.query_filtered::<&mut LeanStatus, With<E>>();
    for mut status in cameras.iter_mut(world) {
        status.begin(effect);
    }
    let begin = move |added: On<Add, E>, mut cameras: Query<&mut LeanStatus>| {
        if let Ok(mut status) = cameras.get_mut(added.entity) {
            status.begin(effect);
        }
    };
    let end = move |removed: On<Remove, E>,
                    mut cameras: Query<&mut LeanStatus>,
                    mut commands: Commands| {
        let Ok(mut status) = cameras.get_mut(removed.entity) else {
            return;
        };
        *status.of_mut(effect) = EffectStatus::Absent;
        if *status == LeanStatus::default() {
            commands
                .entity(removed.entity)
                .queue_silenced(remove_empty_status);
        }
    };
    app.add_observer(begin).add_observer(end);
}

/// Removes the status of a camera that has lost its last effect and got no other since.
fn remove_empty_status(mut camera: EntityWorldMut) {
    if camera.get() == Some(&LeanStatus::default()) {
        camera.remove::<LeanStatus>();
    }
}

/// Warns once in an app without plugins of this crate, where components do nothing. All of them come with a status.
fn warn_without_plugins(world: DeferredWorld, context: HookContext) {
    if !world.contains_resource::<SupportChecks>() {
        warn_once!(
            "Components of bevy_lean_deferred on camera {} do nothing: the app has no plugins of this crate. Add \
             `LeanDeferredPlugins` after `DefaultPlugins`.",
            context.entity
        );
    }
}

/// The reason that a camera does not have an effect. Its text completes the sentence "It is off: …", and names what to
/// change. `docs/reliability.md` lists the requirements for camera and device.
#[derive(Reflect, Clone, Debug, PartialEq, Eq)]
#[reflect(Clone, PartialEq)]
#[non_exhaustive]
pub enum LeanOffReason {
    /// The camera was not rendered: it is not active, its target does not exist, or no frame has been rendered yet.
    NotRendered,
    /// [`LeanDeferred::enabled`](crate::LeanDeferred::enabled) is false.
    Disabled,
    /// It has lost the [`LeanDeferred`](crate::LeanDeferred) that the effect needs and came with, or the app does not have its plugin.
    NoLeanDeferred,
    /// It has [`LeanDeferred`](crate::LeanDeferred), which the effect needs, but is not rendered lean.
    /// [`LeanStatus::deferred`] has the reason.
    NotLean,
    /// [`LeanScreenSpaceGi`](crate::LeanScreenSpaceGi) is on, which finds the occlusion of ambient light too.
    ReplacedByGi,
    /// No surface in view scatters light.
    NothingScatters,
    /// Its `Msaa` is not `Off`.
    Msaa,
    /// Its `CameraRenderGraph` is not `Core3d`, in which the passes of this effect run.
    Schedule,
    /// Its `CameraRenderGraph` is neither `Core3d` nor `Core2d`, in which auto exposure runs.
    ExposureSchedule,
    /// It has no `Camera3d`.
    NotCamera3d,
    /// Its `Viewport::depth` is not `0.0..1.0`, so positions cannot be reconstructed from depth.
    ViewportDepth,
    /// It has no `Hdr`.
    NotHdr,
    /// Its main texture has this format instead of `Rgba16Float`.
    Format(TextureFormat),
    /// It has `DeferredPrepass`, that is, Bevy's own deferred renderer.
    DeferredPrepass,
    /// Its `Tonemapping` is `None`, the default of `Camera2d`, with which Bevy applies no exposure. It is metered all the
    /// same: [`MeteredExposure`](crate::effects::auto_exposure::MeteredExposure) has the values.
    NoTonemapping,
    /// The device lacks these capabilities. [`LeanSupport`](crate::LeanSupport) has them before any camera is spawned.
    Device(String),
    /// A shader cannot be compiled, for this reason.
    Shader(String),
    /// The texture with this label does not fit into the GPU's memory. It is tried again once the size of the camera's
    /// target or the camera's effects have changed, or the camera was switched off.
    OutOfMemory(String),
}

impl fmt::Display for LeanOffReason {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::NotRendered => f.write_str(
                "it was not rendered yet: if this stays, let its `Camera` be active, with a target that exists",
            ),
            Self::Disabled => f.write_str("`LeanDeferred::enabled` is false: set it to true"),
            Self::NoLeanDeferred => f.write_str(
                "it has no `LeanDeferred`: insert one, with `LeanDeferredPlugin` in the app",
            ),
            Self::NotLean => {
                f.write_str("it is not rendered lean: change what `LeanStatus::deferred` names")
            }
            Self::ReplacedByGi => f.write_str(
                "`LeanScreenSpaceGi` darkens ambient light in its place: remove one of the two",
            ),
            Self::NothingScatters => {
                f.write_str("no surface in view scatters light: use `ShadingExtension::Subsurface`")
            }
            Self::Msaa => f.write_str("its `Msaa` is not `Off`: insert `Msaa::Off`"),
            Self::Schedule => {
                f.write_str("its `CameraRenderGraph` is not `Core3d`: set it to `Core3d`")
            }
            Self::ExposureSchedule => f.write_str(
                "its `CameraRenderGraph` is neither `Core3d` nor `Core2d`: set it to one of them",
            ),
            Self::NotCamera3d => f.write_str("it has no `Camera3d`: insert one"),
            Self::ViewportDepth => {
                f.write_str("its `Viewport::depth` is not 0 to 1: set it to `0.0..1.0`")
            }
            Self::NotHdr => f.write_str("it has no `Hdr`: insert it"),
            Self::Format(format) => write!(
                f,
                "its main texture is {format:?} instead of Rgba16Float: insert `Hdr`"
            ),
            Self::DeferredPrepass => {
                f.write_str("it has `DeferredPrepass`, Bevy's own deferred renderer: remove it")
            }
            Self::NoTonemapping => f.write_str(
                "its `Tonemapping` is `None`, with which Bevy applies no exposure: insert another",
            ),
            Self::Device(missing) => write!(
                f,
                "the device lacks {missing}: update its driver or choose another adapter"
            ),
            Self::Shader(cause) => write!(
                f,
                "a shader cannot be compiled: correct it, or add the plugin that loads it: {cause}"
            ),
            Self::OutOfMemory(label) => write!(
                f,
                "{label} does not fit into the GPU's memory: make the target smaller, or remove \
                 effects"
            ),
        }
    }
}

impl LeanOffReason {
    /// The reason that effects cannot reconstruct surfaces from the depth of `camera`, if any.
    pub(crate) fn against_reading_depth(
        camera: &ExtractedCamera,
        is_3d: bool,
        msaa: &Msaa,
    ) -> Option<Self> {
        let is_whole = |viewport: &Viewport| viewport.depth == (0.0..1.0);
        if !is_3d {
            Some(Self::NotCamera3d)
        } else if msaa.samples() > 1 {
            Some(Self::Msaa)
        } else if camera.schedule != Core3d.intern() {
            Some(Self::Schedule)
        } else if !camera.viewport.as_ref().is_none_or(is_whole) {
            Some(Self::ViewportDepth)
        } else {
            None
        }
    }

    /// The text of reasons that have one.
    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Self::Device(text) | Self::Shader(text) | Self::OutOfMemory(text) => Some(text),
            _ => None,
        }
    }

    /// True if each camera gets a warning. Other reasons are logged elsewhere, or the app knows them.
    pub(super) fn is_of_camera(&self) -> bool {
        match self {
            Self::NotRendered
            | Self::Disabled
            | Self::NoLeanDeferred
            | Self::NotLean
            | Self::ReplacedByGi
            | Self::NothingScatters
            | Self::Device(_)
            | Self::Shader(_)
            | Self::OutOfMemory(_) => false,
            Self::Msaa
            | Self::Schedule
            | Self::ExposureSchedule
            | Self::NotCamera3d
            | Self::ViewportDepth
            | Self::NotHdr
            | Self::Format(_)
            | Self::DeferredPrepass
            | Self::NoTonemapping => true,
        }
    }
}
