//! What an app wants from a camera.

use bevy::{prelude::*, render::extract_component::ExtractComponent};

use super::{
    active::ActiveLeanView,
    overrides::{CameraEffect, Need},
    status::LeanStatus,
};

/// Renders this `Camera3d` through a packed 64-bit G-buffer and one compute lighting pass.
///
/// The picture is that of Bevy's forward renderer. Opaque and alpha-masked meshes whose material the G-buffer can
/// carry go through it; every other mesh is drawn by Bevy's forward passes on the same camera, against the same depth.
/// Adding or removing the component at run time switches the camera over and frees what it held. [`enabled`](Self::enabled) does so too,
/// and leaves the camera's settings alone.
/// What the camera is doing is in [`LeanStatus`], what its targets cost in [`GBufferUsage`](crate::gbuffer::GBufferUsage).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn_camera(mut commands: Commands) {
///     commands.spawn((
///         Camera3d::default(),
///         LeanDeferred::default(),
///         Transform::from_xyz(0.0, 2.0, 5.0).looking_at(Vec3::ZERO, Vec3::Y),
///     ));
/// }
///
/// /// Back to Bevy's renderer, and to this one again.
/// fn toggle(mut cameras: Query<&mut LeanDeferred>) {
///     for mut lean in &mut cameras {
///         lean.enabled = !lean.enabled;
///     }
/// }
///
/// /// Shows a channel of the G-buffer in place of the picture.
/// fn show_normals(mut cameras: Query<&mut LeanDeferred>) {
///     for mut lean in &mut cameras {
///         lean.debug_view = Some(DebugChannel::Normal);
///     }
/// }
/// ```
///
/// Needs HDR (`Hdr` is added with the component) and no MSAA (switched off then). Removing the component gives back what
/// the camera had, unless another effect needs it or the app has set it since. Other cameras of its target that had the
/// same get the same, so that they go on sharing a picture. On devices that cannot run it
/// ([`LeanDeferredSupport`](crate::LeanDeferredSupport)) nothing is changed. A camera that
/// breaks these later, or whose device lacks something, is rendered as Bevy has it, with one warning that names the
/// reason. `docs/reliability.md` lists all that is needed.
///
/// # On a camera that is rendered already
///
/// Give a camera that is to become lean later `Hdr` and `Msaa::Off` when it is spawned, or `LeanDeferred` with `enabled: false`. Added to a
/// rendered camera that has Bevy's defaults, the component changes its sample count and the format of its main texture. Bevy makes its
/// own pipelines anew then. Those that other crates keep for each camera may not follow: with `bevy_mod_outline` 0.13 a validation error
/// ends the app. A message warns of it, once for each camera.
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(LeanStatus)]
#[extract_component_sync_target((Self, ActiveLeanView))]
pub struct LeanDeferred {
    /// Renders the camera lean. While it is false, Bevy renders the camera, without MSAA and with `Hdr`, and nothing is kept for it.
    /// Default: true.
    pub enabled: bool,
    /// How the normal of the surface itself is found from depth. Shadow bias uses it where a normal map turns the shading normal; elsewhere
    /// that is exact. Default: the most exact.
    pub geometric_normal: GeometricNormal,
    /// Lights, decals and light probes that have a [`RenderLayers`](bevy::camera::visibility::RenderLayers) component
    /// affect only meshes that share a layer with them. Default: true.
    ///
    /// Bevy's forward pass asks only whether the camera shares one. The two differ on cameras that see several layers,
    /// where a light has some of these but not all; elsewhere, and where no such light exists, this costs nothing.
    /// Lights without the component affect all meshes. Layers from 31 on count as one. Meshes that Bevy's forward pass
    /// draws, such as transparent ones, are lit as Bevy has it.
    pub light_layers: bool,
    /// How lights that do not reach a pixel are passed by. Default: [`LightCulling::Auto`].
    pub light_culling: LightCulling,
    /// Shows one channel of the G-buffer, or one part of the light, in place of the picture. Default: none.
    pub debug_view: Option<DebugChannel>,
}

impl Default for LeanDeferred {
    fn default() -> Self {
        Self {
            enabled: true,
            geometric_normal: GeometricNormal::default(),
            light_layers: true,
            light_culling: LightCulling::default(),
            debug_view: None,
        }
    }
}

impl LeanDeferred {
    /// Whether surfaces are not lit.
    pub(crate) fn shows_channel(&self) -> bool {
        self.debug_view.is_some_and(|channel| !channel.is_light())
    }
}

impl CameraEffect for LeanDeferred {
    const NAME: &'static str = "LeanDeferred";
    const NEEDS: &'static [Need] = &[Need::WithoutMsaa, Need::Hdr];
}

/// Ways to reconstruct the geometric normal of a pixel from the depth buffer.
///
/// All find two tangents from neighbouring depths and cross them; they differ in how they keep neighbours from
/// across an edge out. Parts a pixel high have no neighbour of their own surface: where the result is more than 75° from the shading normal,
/// shadows are biased by a normal between the two, 75° from that. `docs/accuracy.md` and `docs/frame_times.md` have their errors and times.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum GeometricNormal {
    /// Right and lower neighbour, as a screen-space derivative takes them: 3 taps, wrong along every edge.
    ThreeTap,
    /// On each axis the neighbour with the nearer depth: 5 taps (Turánszki 2019, "Improved normal reconstruction
    /// from depth", Wicked Engine).
    FiveTap,
    /// On each axis the side whose two depths extrapolate best to the centre: 9 taps (atyuwen 2021, "Accurate Normal
    /// Reconstruction from Depth Buffer"). Also right beside edges; on parts a few pixels thin it equals the five taps.
    #[default]
    NineTap,
}

impl GeometricNormal {
    /// All of them, cheapest first.
    pub const ALL: [Self; 3] = [Self::ThreeTap, Self::FiveTap, Self::NineTap];
}

/// How point and spot lights that do not reach a pixel are passed by. The picture is the same.
///
/// Bevy sorts lights into clusters (Olsson, Billeter and Assarsson 2012, "Clustered Deferred and Forward Shading"). Within one the
/// pixels of a tile may find the lights that reach it together (Olsson and Assarsson 2011, "Tiled Shading"; spot lights by Wronski
/// 2017, "Cull that cone!").
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum LightCulling {
    /// The faster one, as measured so far: [`PerPixel`](Self::PerPixel), and from 2,048 point and spot lights on
    /// [`SharedMemory`](Self::SharedMemory).
    #[default]
    Auto,
    /// Each pixel looks at all lights of its cluster.
    PerPixel,
    /// The subgroups of an 8×8 tile first find those that reach it, by ballots. Where the device has no subgroups:
    /// [`SharedMemory`](Self::SharedMemory).
    Subgroup,
    /// The workgroup of an 8×8 tile first finds those that reach it, in shared memory.
    SharedMemory,
}

/// One channel of the G-buffer, or one part of the light, for [`LeanDeferred::debug_view`].
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[reflect(Clone, PartialEq)]
pub enum DebugChannel {
    /// Linear albedo.
    Albedo,
    /// Metallic, grey.
    Metallic,
    /// Baked material occlusion, grey: white is open.
    Occlusion,
    /// World-space shading normal, `n / 2 + 1/2`.
    Normal,
    /// Perceptual roughness, grey.
    Roughness,
    /// World-space normal reconstructed from depth, `n / 2 + 1/2`.
    GeometricNormal,
    /// Distance along the view axis, grey: `1 / (1 + metres)`.
    Depth,
    /// Emitted light and that of lightmaps, as exposed. Black while no visible mesh has any.
    Emissive,
    /// A colour for each shading model: subsurface pink, anisotropy yellow, rim cyan, clearcoat blue, backlight green,
    /// unlit magenta; plain surfaces grey by their specular constant (white at 2).
    ShadingModel,
    /// Motion of meshes that move or deform: grey at rest, red and green with the motion across the picture (full at a
    /// tenth of it), black where it follows from the cameras. Black without `MotionVectorPrepass`.
    Motion,
    /// Render layers: a colour for each set, grey for layer 0 alone. All grey while no light's layers tell meshes apart.
    VisibilityMask,
    /// Light that surfaces reflect diffusely or transmit, exposed; without fog and without what they emit.
    DiffuseLight,
    /// Light that the boundaries of surfaces reflect, exposed; without fog and without what they emit.
    SpecularLight,
}

impl DebugChannel {
    /// All channels, in the order of the bit table, and the parts of the light.
    pub const ALL: [Self; 13] = [
        Self::Albedo,
        Self::Metallic,
        Self::Occlusion,
        Self::Normal,
        Self::Roughness,
        Self::GeometricNormal,
        Self::Depth,
        Self::Emissive,
        Self::ShadingModel,
        Self::Motion,
        Self::VisibilityMask,
        Self::DiffuseLight,
        Self::SpecularLight,
    ];

    /// Whether it shows light, for which surfaces are lit.
    pub(crate) fn is_light(self) -> bool {
        matches!(self, Self::DiffuseLight | Self::SpecularLight)
    }

    /// The name of the shader definition that selects it.
    pub(crate) fn shader_def(self) -> &'static str {
        match self {
            Self::Albedo => "DEBUG_ALBEDO",
            Self::Metallic => "DEBUG_METALLIC",
            Self::Occlusion => "DEBUG_OCCLUSION",
            Self::Normal => "DEBUG_NORMAL",
            Self::Roughness => "DEBUG_ROUGHNESS",
            Self::GeometricNormal => "DEBUG_GEOMETRIC_NORMAL",
            Self::Depth => "DEBUG_DEPTH",
            Self::Emissive => "DEBUG_EMISSIVE",
            Self::ShadingModel => "DEBUG_SHADING_MODEL",
            Self::Motion => "DEBUG_MOTION",
            Self::VisibilityMask => "DEBUG_VISIBILITY_MASK",
            Self::DiffuseLight => "DEBUG_DIFFUSE_LIGHT",
            Self::SpecularLight => "DEBUG_SPECULAR_LIGHT",
        }
    }
}
