//! The component that shows data of a camera's effects in place of its picture.

use bevy::{prelude::*, render::extract_component::ExtractComponent};

/// Insert on a camera to see data of its effects in place of its picture: on the whole viewport, or on a part from the left.
///
/// [`DebugView`] lists the views, and the effect that each is of. Without that effect, and while the shaders of a view compile, the
/// camera shows its picture. The effects go on behind the view, and the picture beside it stays the same, except that auto exposure
/// meters what is shown, and that reflections reflect it if lighting draws it. Without the component, nothing is compiled, allocated
/// or drawn for it.
///
/// Values are shown as linear colours, before tonemapping, apart from [`DebugView::ExposureWeights`]: insert `Tonemapping::None` to see
/// them unchanged.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// /// Shows the normals in the left half of the picture.
/// fn compare(mut commands: Commands, camera: Single<Entity, With<LeanDeferred>>) {
///     commands.entity(*camera).insert(LeanDebugView {
///         shows: DebugView::Normal,
///         split: 0.5,
///     });
/// }
///
/// fn stop(mut commands: Commands, camera: Single<Entity, With<LeanDebugView>>) {
///     commands.entity(*camera).remove::<LeanDebugView>();
/// }
/// ```
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct LeanDebugView {
    /// The data that are shown. Default: the first view of [`DebugView::ALL`].
    pub shows: DebugView,
    /// Share of the viewport's width, from the left, that shows them; the rest shows the picture. 0 to 1. Default 1: all of it.
    pub split: f32,
}

impl Default for LeanDebugView {
    fn default() -> Self {
        DebugView::default().into()
    }
}

impl From<DebugView> for LeanDebugView {
    /// Shows it on the whole viewport.
    fn from(shows: DebugView) -> Self {
        Self { shows, split: 1.0 }
    }
}

impl LeanDebugView {
    /// Columns of pixels that show it, in a viewport of `width` columns. None if the split is NaN.
    pub(crate) fn columns(&self, width: u32) -> u32 {
        (self.split.clamp(0.0, 1.0) * width as f32).round() as u32
    }
}

/// Data that a [`LeanDebugView`] shows.
///
/// Those up to [`Forward`](Self::Forward) are of [`LeanDeferred`](crate::LeanDeferred): channels of the G-buffer, and parts of the light.
/// Lighting draws them on lean meshes; what Bevy's forward passes draw appears over them, and the background as usual. The views of
/// other effects cover everything. "Exposed" light is in the units of the HDR picture before tonemapping; "grey" is the same value in
/// all channels.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq, Hash)]
pub enum DebugView {
    /// Linear albedo, without decals.
    #[default]
    Albedo,
    /// Metallic, grey, 0 to 1.
    Metallic,
    /// Occlusion baked into the material, grey: 1 (white) is unoccluded.
    MaterialOcclusion,
    /// World-space shading normal, `n / 2 + 1/2`.
    Normal,
    /// Perceptual roughness, grey, 0 to 1.
    Roughness,
    /// World-space normal reconstructed from depth, `n / 2 + 1/2`. Shadow bias uses it where a normal map turns the
    /// shading normal far from the mesh's, except on parts one or two pixels wide.
    GeometricNormal,
    /// Distance along the view axis, grey: `1 / (1 + metres)`.
    Depth,
    /// Emitted light and that of lightmaps, exposed. Black while no visible mesh has any.
    Emissive,
    /// A colour per shading model: subsurface pink, anisotropy yellow, rim cyan, clearcoat blue, diffuse transmission green, unlit
    /// magenta; plain surfaces grey by their specular constant (white at 2).
    ShadingModel,
    /// Motion of meshes that move or deform: grey at rest, red and green with the motion across the picture (full at a
    /// tenth of it), black for pixels whose motion follows from the cameras. Black without `MotionVectorPrepass`.
    Motion,
    /// Render layers: a colour per set, grey for layer 0 alone. All grey while no light has layers that exclude some
    /// meshes.
    VisibilityMask,
    /// Light that surfaces reflect diffusely or transmit, exposed; without fog and emission.
    DiffuseLight,
    /// Light that surfaces reflect specularly, exposed; without fog and emission.
    SpecularLight,
    /// Meshes of Bevy's forward passes, and the background, as in the picture. Lean meshes are magenta, darker where they are turned
    /// away from the camera. [`LeanForwardMeshes`](crate::gbuffer::LeanForwardMeshes) tells why meshes are drawn forward.
    Forward,
    /// Of [`LeanScreenSpaceAmbientOcclusion`](crate::LeanScreenSpaceAmbientOcclusion): the visibility that filtered occlusion
    /// leaves, grey: 1 (white) where unoccluded, and without a surface. Where forward meshes cover lean ones that receive the
    /// occlusion, it is that of the hidden surface.
    AmbientOcclusion,
    /// Of [`LeanScreenSpaceGi`](crate::LeanScreenSpaceGi): the light that surfaces receive from others, as a white surface reflects
    /// it, exposed.
    GiLight,
    /// Of [`LeanScreenSpaceGi`](crate::LeanScreenSpaceGi): visibility of the environment, grey: 1 (white) where unoccluded.
    GiVisibility,
    /// Of [`LeanScreenSpaceReflections`](crate::LeanScreenSpaceReflections): reflected light times confidence, exposed, before it is
    /// weighted by the surface's reflectance. Black where nothing is reflected.
    ReflectionLight,
    /// Of [`LeanScreenSpaceReflections`](crate::LeanScreenSpaceReflections): the confidence, grey: share of the environment that
    /// reflections replace, 0 to 1.
    ReflectionConfidence,
    /// Of [`LeanScreenSpaceReflections`](crate::LeanScreenSpaceReflections): distance of the mirror image at the hit of each ray,
    /// grey: `1 / (1 + metres)`. Black for misses. In the size of the texels, one per ray.
    ReflectionHit,
    /// Of [`LeanAutoExposure`](crate::LeanAutoExposure), on 3D and 2D cameras: the tonemapped picture, in which pixels are the darker
    /// the less they count: those without weight have 0.35 of their brightness. Over it is a scale with a line per stop, a longer one
    /// at 0, a white mark at the exposure and a green one at its target.
    ExposureWeights,
}

impl DebugView {
    /// All views: channels of the G-buffer, parts of the light, and other effects.
    pub const ALL: [Self; 21] = [
        Self::Albedo,
        Self::Metallic,
        Self::MaterialOcclusion,
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
        Self::Forward,
        Self::AmbientOcclusion,
        Self::GiLight,
        Self::GiVisibility,
        Self::ReflectionLight,
        Self::ReflectionConfidence,
        Self::ReflectionHit,
        Self::ExposureWeights,
    ];

    /// True if lighting draws it.
    pub(crate) fn is_of_lighting(self) -> bool {
        self.shader_def().is_some()
    }

    /// The name of the shader definition with which lighting draws it.
    #[doc(hidden)]
    pub fn shader_def(self) -> Option<&'static str> {
        match self {
            Self::Albedo => Some("DEBUG_ALBEDO"),
            Self::Metallic => Some("DEBUG_METALLIC"),
            Self::MaterialOcclusion => Some("DEBUG_MATERIAL_OCCLUSION"),
            Self::Normal => Some("DEBUG_NORMAL"),
            Self::Roughness => Some("DEBUG_ROUGHNESS"),
            Self::GeometricNormal => Some("DEBUG_GEOMETRIC_NORMAL"),
            Self::Depth => Some("DEBUG_DEPTH"),
            Self::Emissive => Some("DEBUG_EMISSIVE"),
            Self::ShadingModel => Some("DEBUG_SHADING_MODEL"),
            Self::Motion => Some("DEBUG_MOTION"),
            Self::VisibilityMask => Some("DEBUG_VISIBILITY_MASK"),
            Self::DiffuseLight => Some("DEBUG_DIFFUSE_LIGHT"),
            Self::SpecularLight => Some("DEBUG_SPECULAR_LIGHT"),
            Self::Forward => Some("DEBUG_FORWARD"),
            Self::AmbientOcclusion
            | Self::GiLight
            | Self::GiVisibility
            | Self::ReflectionLight
            | Self::ReflectionConfidence
            | Self::ReflectionHit
            | Self::ExposureWeights => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_select_whole_columns() {
        let columns = |split: f32| {
            let shows = DebugView::default();
            LeanDebugView { shows, split }.columns(101)
        };
        let splits = [-1.0, 0.0, 0.5, 0.999, 1.0, 7.0, f32::INFINITY];
        assert_eq!(splits.map(columns), [0, 0, 51, 101, 101, 101, 101]);
        assert_eq!(columns(f32::NAN), 0);
        assert_eq!(LeanDebugView::default().columns(3840), 3840);
    }
}
