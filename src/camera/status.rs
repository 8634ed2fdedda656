//! What a camera is doing, for the main world.

use core::fmt;

use alloc::sync::Arc;

use bevy::{
    prelude::*,
    render::{
        MainWorld,
        render_resource::TextureFormat,
        sync_world::{MainEntity, MainEntityHashMap},
    },
};

use super::LeanDeferred;
use crate::warn_once::WarnOnce;

/// On a camera with [`LeanDeferred`]: whether the last frame was rendered lean, or why it was not. Added and removed with
/// it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn show(cameras: Query<&LeanStatus, Changed<LeanStatus>>, mut texts: Query<&mut Text>) {
///     for status in &cameras {
///         for mut text in &mut texts {
///             text.0 = format!("Renderer: {status}"); // "Renderer: off: its Msaa is not Off"
///         }
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub enum LeanStatus {
    /// It was rendered through the G-buffer.
    Lean,
    /// Bevy's forward passes render it until its lighting shaders are compiled.
    Compiling,
    /// Bevy's forward passes render it, or nothing does.
    Off(LeanOffReason),
}

impl Default for LeanStatus {
    fn default() -> Self {
        Self::Off(LeanOffReason::NotRendered)
    }
}

impl fmt::Display for LeanStatus {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Lean => write!(f, "lean"),
            Self::Compiling => write!(f, "compiling"),
            Self::Off(reason) => write!(f, "off: {reason}"),
        }
    }
}

/// Why a camera with [`LeanDeferred`] is not rendered lean. Shown, it completes the sentence "It is off: …".
#[derive(Reflect, Clone, Debug, PartialEq, Eq)]
#[reflect(Clone, PartialEq)]
#[non_exhaustive]
pub enum LeanOffReason {
    /// It was not rendered: it is not active, its target is not there, no frame has been rendered yet, or the app has no
    /// [`LeanDeferredPlugin`](crate::LeanDeferredPlugin).
    NotRendered,
    /// Its `Msaa` is not `Off`.
    Msaa,
    /// It has no `Hdr`.
    NotHdr,
    /// Its main texture has this format.
    Format(TextureFormat),
    /// It has `DeferredPrepass`, so Bevy's own deferred renderer.
    DeferredPrepass,
    /// A light has soft shadows (`experimental_pbr_pcss`).
    SoftShadows,
    /// The device lacks this.
    Device(String),
    /// A shader cannot be compiled, for this cause.
    Shader(String),
}

impl fmt::Display for LeanOffReason {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::NotRendered => write!(f, "it was not rendered"),
            Self::Msaa => write!(f, "its Msaa is not Off"),
            Self::NotHdr => write!(f, "it has no Hdr component"),
            Self::Format(format) => write!(
                f,
                "its main texture is {format:?}, and Rgba16Float is needed"
            ),
            Self::DeferredPrepass => {
                write!(f, "it has DeferredPrepass (Bevy's own deferred renderer)")
            }
            Self::SoftShadows => write!(
                f,
                "a light has soft shadows (experimental_pbr_pcss), which only fragment shaders can filter"
            ),
            Self::Device(missing) => write!(f, "the device lacks {missing}"),
            Self::Shader(cause) => write!(f, "a shader cannot be compiled: {cause}"),
        }
    }
}

impl LeanOffReason {
    /// Whether cameras are warned of it one by one. Of the others there is one message for all.
    fn is_of_camera(&self) -> bool {
        !matches!(self, Self::NotRendered | Self::Device(_) | Self::Shader(_))
    }
}

/// In the render world: what was decided for each camera in this frame.
#[derive(Resource)]
pub(super) struct LeanStatuses {
    statuses: MainEntityHashMap<LeanStatus>,
    warnings: WarnOnce<LeanOffReason>,
}

impl Default for LeanStatuses {
    fn default() -> Self {
        Self {
            statuses: default(),
            warnings: WarnOnce::new("LeanDeferred"),
        }
    }
}

impl LeanStatuses {
    pub(super) fn off(&mut self, camera: MainEntity, reason: LeanOffReason) {
        let warning = reason.is_of_camera().then(|| reason.clone());
        self.warnings.tell(camera, warning);
        self.statuses.insert(camera, LeanStatus::Off(reason));
    }

    /// A camera that nothing speaks against; `failure` is the cause why a pipeline that it waits for does not compile.
    pub(super) fn on(&mut self, camera: MainEntity, is_active: bool, failure: Option<Arc<str>>) {
        self.warnings.tell(camera, None);
        let status = match (is_active, failure) {
            (true, _) => LeanStatus::Lean,
            (false, None) => LeanStatus::Compiling,
            (false, Some(cause)) => LeanStatus::Off(LeanOffReason::Shader(cause.to_string())),
        };
        self.statuses.insert(camera, status);
    }
}

/// Hands what was decided for the last frame to the cameras in the main world.
pub(super) fn report_statuses(
    mut main_world: ResMut<MainWorld>,
    mut statuses: ResMut<LeanStatuses>,
    cameras: Query<&MainEntity, With<LeanDeferred>>,
) {
    for camera in &cameras {
        let status = statuses.statuses.remove(camera).unwrap_or_default();
        if let Some(mut reported) = main_world.get_mut::<LeanStatus>(camera.id()) {
            reported.set_if_neq(status);
        }
    }
    statuses.statuses.clear();
    statuses.warnings.keep_only(cameras.iter());
}

pub(super) fn remove_status(removed: On<Remove, LeanDeferred>, mut commands: Commands) {
    commands
        .entity(removed.entity)
        .queue_silenced(|mut camera: EntityWorldMut| {
            camera.remove::<LeanStatus>();
        });
}
