//! What a camera is doing, for the main world.

use core::fmt;

use bevy::{
    camera::Viewport,
    core_pipeline::schedule::Core3d,
    ecs::schedule::ScheduleLabel,
    prelude::*,
    render::{camera::ExtractedCamera, render_resource::TextureFormat},
};

/// On a camera with [`LeanDeferred`](super::LeanDeferred): whether the last frame was rendered lean, or why it was not. Added and removed with
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
    /// Bevy renders it until its lighting shaders are compiled.
    Compiling,
    /// Bevy renders it, or nothing does.
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

/// Why a camera with [`LeanDeferred`](super::LeanDeferred) is not rendered lean. Shown, it completes the sentence "It is off: …".
/// `docs/reliability.md` lists what a camera and its device need.
#[derive(Reflect, Clone, Debug, PartialEq, Eq)]
#[reflect(Clone, PartialEq)]
#[non_exhaustive]
pub enum LeanOffReason {
    /// It was not rendered: it is not active, its target is not there, no frame has been rendered yet, or the app has no
    /// [`LeanDeferredPlugin`](crate::LeanDeferredPlugin).
    NotRendered,
    /// [`LeanDeferred::enabled`](super::LeanDeferred::enabled) is false.
    Disabled,
    /// Its `Msaa` is not `Off`.
    Msaa,
    /// Its `CameraRenderGraph` is not `Core3d`, where the passes of this crate are.
    Schedule,
    /// It has no `Camera3d`.
    NotCamera3d,
    /// Its `Viewport::depth` is not `0.0..1.0`: depth does not tell where surfaces are.
    ViewportDepth,
    /// It has no `Hdr`.
    NotHdr,
    /// Its main texture has this format.
    Format(TextureFormat),
    /// It has `DeferredPrepass`, so Bevy's own deferred renderer.
    DeferredPrepass,
    /// The device lacks this.
    Device(String),
    /// A shader cannot be compiled, for this cause.
    Shader(String),
    /// The texture with this label does not fit into the GPU's memory. It is tried again once the camera's target has another size, its
    /// effects change, or it was switched off.
    OutOfMemory(String),
}

impl fmt::Display for LeanOffReason {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::NotRendered => write!(f, "it was not rendered"),
            Self::Disabled => write!(f, "LeanDeferred::enabled is false"),
            Self::Msaa => write!(f, "its Msaa is not Off"),
            Self::Schedule => write!(f, "its CameraRenderGraph is not Core3d"),
            Self::NotCamera3d => write!(f, "it has no Camera3d component"),
            Self::ViewportDepth => write!(f, "its viewport's depth is not 0 to 1"),
            Self::NotHdr => write!(f, "it has no Hdr component"),
            Self::Format(format) => write!(
                f,
                "its main texture is {format:?}, and Rgba16Float is needed"
            ),
            Self::DeferredPrepass => {
                write!(f, "it has DeferredPrepass (Bevy's own deferred renderer)")
            }
            Self::Device(missing) => write!(f, "the device lacks {missing}"),
            Self::Shader(cause) => write!(f, "a shader cannot be compiled: {cause}"),
            Self::OutOfMemory(label) => {
                write!(f, "{label} does not fit into the GPU's memory")
            }
        }
    }
}

impl LeanOffReason {
    /// What speaks against effects that find surfaces by the depth of `camera`.
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

    /// The text that says more of it.
    pub(crate) fn text(&self) -> Option<&str> {
        match self {
            Self::Device(text) | Self::Shader(text) | Self::OutOfMemory(text) => Some(text),
            _ => None,
        }
    }

    /// Whether cameras are warned of it one by one. Of the others there is a message elsewhere, or the app knows.
    pub(crate) fn is_of_camera(&self) -> bool {
        !matches!(
            self,
            Self::NotRendered
                | Self::Disabled
                | Self::Device(_)
                | Self::Shader(_)
                | Self::OutOfMemory(_)
        )
    }
}
