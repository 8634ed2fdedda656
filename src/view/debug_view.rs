//! The component that shows data of a camera's effects in place of its picture.

use bevy::{prelude::*, render::extract_component::ExtractComponent};

/// Insert on a camera to see data of its effects in place of its picture: on the whole viewport, or on a part from the left.
///
/// [`DebugView`] lists the views, and the effect that each is of. Without that effect, and while the shaders of a view compile, the
/// camera shows its picture. The effects go on behind the view, and the part of the picture beside it stays the same. Without the
/// component, nothing is compiled, allocated or drawn for it.
///
/// Values are shown as linear colours, before tonemapping, apart from [`DebugView::ExposureWeights`]: insert `Tonemapping::None` to see
/// them unchanged.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// /// Shows the light of diffuse GI in the left half of the picture.
/// fn compare(mut commands: Commands, camera: Single<Entity, With<LeanScreenSpaceGi>>) {
///     commands.entity(*camera).insert(LeanDebugView {
///         shows: DebugView::GiLight,
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

/// Data that a [`LeanDebugView`] shows. "Exposed" light is in the units of the HDR picture, before tonemapping.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq, Hash)]
pub enum DebugView {
    /// Of [`LeanScreenSpaceAmbientOcclusion`](crate::LeanScreenSpaceAmbientOcclusion): the visibility that filtered occlusion
    /// leaves, grey: 1 (white) where unoccluded, and without a surface. Where forward meshes cover lean ones that receive the
    /// occlusion, it is that of the hidden surface.
    #[default]
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
    /// All views.
    pub const ALL: [Self; 7] = [
        Self::AmbientOcclusion,
        Self::GiLight,
        Self::GiVisibility,
        Self::ReflectionLight,
        Self::ReflectionConfidence,
        Self::ReflectionHit,
        Self::ExposureWeights,
    ];
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
