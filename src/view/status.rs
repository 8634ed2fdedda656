//! The status of a camera, for the main world.

use core::fmt;

use bevy::{
    camera::Viewport,
    core_pipeline::schedule::Core3d,
    ecs::schedule::ScheduleLabel,
    prelude::*,
    render::{camera::ExtractedCamera, render_resource::TextureFormat},
};

/// On a camera with [`LeanDeferred`](super::LeanDeferred): tells if the last frame was rendered lean, or the reason
/// that it was not. Added and removed with it.
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
    /// The camera was rendered through the G-buffer.
    Lean,
    /// Bevy renders the camera until its lighting shaders are compiled.
    Compiling,
    /// Bevy renders the camera, or nothing does.
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

/// The reason that a camera with [`LeanDeferred`](super::LeanDeferred) is not rendered lean. Its text completes the
/// sentence "It is off: …". `docs/reliability.md` lists the requirements for camera and device.
#[derive(Reflect, Clone, Debug, PartialEq, Eq)]
#[reflect(Clone, PartialEq)]
#[non_exhaustive]
pub enum LeanOffReason {
    /// The camera was not rendered: it is not active, its target does not exist, no frame has been rendered yet, or the
    /// app has no [`LeanDeferredPlugin`](crate::LeanDeferredPlugin).
    NotRendered,
    /// [`LeanDeferred::enabled`](super::LeanDeferred::enabled) is false.
    Disabled,
    /// Its `Msaa` is not `Off`.
    Msaa,
    /// Its `CameraRenderGraph` is not `Core3d`, in which the passes of this crate run.
    Schedule,
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
    /// The device lacks these capabilities.
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
            Self::NotRendered => write!(f, "it was not rendered"),
            Self::Disabled => write!(f, "`LeanDeferred::enabled` is false"),
            Self::Msaa => write!(f, "its `Msaa` is not `Off`: insert `Msaa::Off`"),
            Self::Schedule => write!(
                f,
                "its `CameraRenderGraph` is not `Core3d`: set it to `Core3d`"
            ),
            Self::NotCamera3d => write!(f, "it has no `Camera3d`: insert one"),
            Self::ViewportDepth => write!(
                f,
                "its `Viewport::depth` is not 0 to 1: set it to `0.0..1.0`"
            ),
            Self::NotHdr => write!(f, "it has no `Hdr`: insert it"),
            Self::Format(format) => {
                write!(f, "its main texture is {format:?} instead of Rgba16Float")
            }
            Self::DeferredPrepass => {
                write!(
                    f,
                    "it has `DeferredPrepass`, Bevy's own deferred renderer: remove it"
                )
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
    pub(crate) fn text(&self) -> Option<&str> {
        match self {
            Self::Device(text) | Self::Shader(text) | Self::OutOfMemory(text) => Some(text),
            _ => None,
        }
    }

    /// True if each camera gets a warning. Other reasons are logged elsewhere, or the app knows them.
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
