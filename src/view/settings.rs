//! The component with which an app makes a camera lean, and its settings.

use bevy::{prelude::*, render::extract_component::ExtractComponent};

use super::{
    active::ActiveLeanView,
    overrides::{CameraEffect, Need},
    status::LeanStatus,
};

/// Renders this `Camera3d` through a packed 64-bit G-buffer and one compute lighting pass.
///
/// The picture is that of Bevy's forward renderer. Opaque and alpha-masked meshes whose material the G-buffer can carry
/// are drawn into it. Bevy's forward passes draw all other meshes on the same camera, against the same depth. Adding or
/// removing the component at run time switches the renderer and frees its resources. [`enabled`](Self::enabled) does so
/// too, without changing the camera's settings. [`LeanStatus`] reports the active renderer,
/// [`GBufferUsage`](crate::gbuffer::GBufferUsage) the memory cost of the targets, and
/// [`LeanForwardMeshes`](crate::gbuffer::LeanForwardMeshes), if added, the meshes that forward draws.
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
/// /// Switches to Bevy's renderer and back.
/// fn toggle(mut cameras: Query<&mut LeanDeferred>) {
///     for mut lean in &mut cameras {
///         lean.enabled = !lean.enabled;
///     }
/// }
///
/// /// Shows a channel of the G-buffer in place of the picture.
/// fn show_normals(mut commands: Commands, cameras: Query<Entity, With<LeanDeferred>>) {
///     for camera in &cameras {
///         commands.entity(camera).insert(LeanDebugView::from(DebugView::Normal));
///     }
/// }
/// ```
///
/// Needs HDR (`Hdr` is added with the component) and no MSAA (`Msaa` is set to `Off`). Removing the component restores
/// the former settings, unless another effect needs the changed ones or the app has changed them since. Nothing is
/// changed on devices that cannot run it ([`LeanSupport`](crate::LeanSupport)). Bevy renders a camera
/// that later violates these needs or whose device lacks a capability, and one warning names the reason.
/// `docs/reliability.md` lists all needs.
///
/// # Other cameras of the same target
///
/// Other cameras are not changed. Insert `Hdr` and `Msaa::Off` on those that draw over this one or under it, such as that
/// of a HUD: Bevy draws cameras of a target into one picture only if both are equal. Otherwise the later picture
/// replaces the other or is blended over it. One warning per pair of cameras tells of it.
///
/// # On a camera that is rendered already
///
/// If a camera is to become lean later, spawn it with `Hdr` and `Msaa::Off`, or with `LeanDeferred` and
/// `enabled: false`. Added to a rendered camera with Bevy's defaults, the component changes its sample count and the
/// format of its main texture. Bevy then recreates its own pipelines. Those that other crates keep per camera may not follow:
/// with `bevy_mod_outline` 0.13 a validation error ends the app. A message warns of this once per camera.
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(LeanStatus)]
#[extract_component_sync_target((Self, ActiveLeanView))]
pub struct LeanDeferred {
    /// Renders the camera lean. While false, Bevy renders the camera, without MSAA and with `Hdr`, and no resources are
    /// kept for it. Default: true.
    pub enabled: bool,
    /// Lights, decals and light probes that have a [`RenderLayers`](bevy::camera::visibility::RenderLayers) component
    /// affect only meshes that share a layer with them. Default: true.
    ///
    /// Bevy's forward pass tests only if the camera shares a layer with a light. The two differ on cameras that see
    /// several layers when a light has some but not all of these. In other cases, and without such lights, this costs
    /// nothing. Lights without the component affect all meshes. Layers from 31 on count as one. Meshes that Bevy's fragment shader
    /// lights (`docs/limits.md`) are lit as in Bevy.
    pub light_layers: bool,
    /// Settings that few games change.
    pub advanced: LeanDeferredAdvanced,
}

impl Default for LeanDeferred {
    fn default() -> Self {
        Self {
            enabled: true,
            light_layers: true,
            advanced: default(),
        }
    }
}

impl CameraEffect for LeanDeferred {
    const NAME: &'static str = "LeanDeferred";
    const NEEDS: &'static [Need] = &[Need::WithoutMsaa, Need::Hdr];
}

/// Settings of [`LeanDeferred`] that few games change.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Default, Clone, PartialEq)]
pub struct LeanDeferredAdvanced {
    /// Culling of point and spot lights that do not reach a pixel. Default: [`LightCulling::Auto`].
    pub light_culling: LightCulling,
    /// Lights blended meshes, and others of `StandardMaterial` that Bevy's passes draw, by this crate's light functions: those skip
    /// lights that do not reach a pixel, and respect light layers. If false, Bevy's fragment shader lights them. The picture is
    /// the same but for layers. Default: true.
    pub lights_forward_meshes: bool,
}

impl Default for LeanDeferredAdvanced {
    fn default() -> Self {
        Self {
            light_culling: default(),
            lights_forward_meshes: true,
        }
    }
}

/// Culling of point and spot lights that do not reach a pixel. All variants give the same picture.
///
/// Bevy bins lights into clusters (Olsson, Billeter and Assarsson 2012, "Clustered Deferred and Forward Shading").
/// Within a cluster, the pixels of a tile may cull lights together (Olsson and Assarsson 2011, "Tiled Shading"; spot
/// lights by Wronski 2017, "Cull that cone!").
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum LightCulling {
    /// The faster variant, as measured so far: [`PerPixel`](Self::PerPixel), and from 2,048 point and spot lights on
    /// [`SharedMemory`](Self::SharedMemory).
    #[default]
    Auto,
    /// Each pixel tests all lights of its cluster.
    PerPixel,
    /// The subgroups of an 8×8 tile first cull lights that do not reach it, by ballots. Falls back to
    /// [`SharedMemory`](Self::SharedMemory) on devices without subgroups.
    Subgroup,
    /// The workgroup of an 8×8 tile first culls lights that do not reach it, in shared memory.
    SharedMemory,
}

/// Adds [`LeanDeferred`] to entities that `C` is added to. `#[require]` would hold in the render world too: there each extraction of `C`
/// would add it again after an app has removed it.
pub(crate) fn require_lean<C: Component>(app: &mut App) {
    // Refused if entities with `C` exist already; these have to add it themselves.
    let _ = app.try_register_required_components::<C, LeanDeferred>();
}
