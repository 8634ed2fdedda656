use bevy::{prelude::*, render::extract_component::ExtractComponent};

use crate::view::{LeanQuality, LeanResolution, LeanStatus};

/// Screen-space reflections: traces rays through this frame's depth into the light of the last frame.
///
/// For cameras with [`LeanDeferred`](crate::LeanDeferred), which is added with it. Mirrors reflect a single direction, resolved per
/// pixel; wide lobes are the mean of rays in 64 directions of GGX, shared by neighbours and by four frames. Nothing flickers at rest. In
/// lighting, reflections replace environment maps, reflection probes and ambient light with the same Fresnel, roughness and energy
/// terms; they also work in scenes without these.
///
/// Surfaces that are off screen, hidden or turned away are not reflected; the environment shows there, as without the component.
/// Meshes in Bevy's forward passes are reflected only if the camera has `DepthPrepass`, and reflect only with
/// [`forward_meshes`](LeanScreenSpaceReflectionsAdvanced::forward_meshes). Light that
/// they and transparent meshes add to the image in front of a reflected surface is reflected with it. Distance fog applies to the whole
/// way of reflected light once. Without `MotionVectorPrepass`,
/// the light of moving surfaces lags one frame behind. Anisotropic surfaces reflect as isotropic ones.
///
/// Rays skip empty hi-z cells (Uludag 2014, "Hi-Z Screen-Space Cone-Traced Reflections"), in directions sampled from the visible
/// microfacet normals (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps"). Neighbours share rays after
/// Stachowiak 2015, "Stochastic Screen-Space Reflections".
///
/// Can be added and removed at run time; removing it frees its GPU resources.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn_camera(mut commands: Commands) {
///     commands.spawn((
///         Camera3d::default(),
///         LeanScreenSpaceReflections {
///             max_roughness: 0.5,
///             resolution: LeanResolution::Full,
///             ..default()
///         },
///     ));
/// }
///
/// fn spawn_wet_floor(
///     mut commands: Commands,
///     mut meshes: ResMut<Assets<Mesh>>,
///     mut materials: ResMut<Assets<StandardMaterial>>,
/// ) {
///     commands.spawn((
///         Mesh3d(meshes.add(Plane3d::default().mesh().size(10.0, 10.0))),
///         MeshMaterial3d(materials.add(StandardMaterial {
///             base_color: Color::srgb(0.05, 0.05, 0.06),
///             perceptual_roughness: 0.1,
///             ..default()
///         })),
///     ));
/// }
/// ```
///
/// A ray from a surface with a perceptual roughness up to 0.2 steps through the hi-z: over the largest cell that it can skip, of 4 to
/// 64 pixels per side, and from pixel to pixel inside others. Rays from rougher surfaces march in segments that grow with the distance,
/// as the lobe does; a segment in which the ray passes behind a surface is bisected down to a pixel. A smooth surface's ray that has
/// used up its steps continues in segments.
///
/// | quality | steps | segments | length of a segment: pixels, or share of the lobe's radius if that is longer |
/// |---|---|---|---|
/// | `Low` | 48 | 48 | 16, or 0.22; texels are twice as large per side |
/// | `Medium` | 64 | 48 | 8, or 0.22; in views of 1360 rows or more, texels and segments are as large as with `Low` |
/// | `High` | 128 | 96 | 4, or 0.075 |
/// | `Ultra` | 256 | 192 | 2, or 0.04 |
#[doc(alias = "ssr")]
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(LeanStatus)]
pub struct LeanScreenSpaceReflections {
    /// Perceptual roughness above which surfaces do not reflect the image, 0 to 1.25. Reflections fade from three quarters of it on;
    /// above 1, the roughest surfaces reflect too. Default 0.8.
    pub max_roughness: f32,
    /// Assumed thickness of surfaces, in metres; rays that pass further behind a surface miss it, unless they cross its depth within
    /// a pixel. More than 0. Default 0.25.
    pub thickness: f32,
    /// Share of the environment that reflections replace, 0 to 1. Default 1.
    pub intensity: f32,
    /// Range and precision of rays, as in the table above. Default [`LeanQuality::Medium`].
    pub quality: LeanQuality,
    /// Resolution at which rays are traced: see [`texel_side`](Self::texel_side). Default [`LeanResolution::Half`].
    pub resolution: LeanResolution,
    /// Settings that few games change.
    pub advanced: LeanScreenSpaceReflectionsAdvanced,
}

impl Default for LeanScreenSpaceReflections {
    fn default() -> Self {
        Self {
            max_roughness: 0.8,
            thickness: 0.25,
            intensity: 1.0,
            quality: default(),
            resolution: default(),
            advanced: default(),
        }
    }
}

/// Settings of [`LeanScreenSpaceReflections`] that few games change.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct LeanScreenSpaceReflectionsAdvanced {
    /// Width of the fade at the edges of the image, as a share of the viewport's height. 0 to 0.5. Default 0.05.
    pub edge_fade: f32,
    /// Reflections on forward meshes too: glass, water, grates, and all others that this crate's light functions
    /// [light](crate::view::LeanDeferredAdvanced::lights_forward_meshes). Each of their fragments marches a ray of its own, at full
    /// resolution and for each layer of blended meshes, where opaque surfaces share rays: so the cost has no bound per pixel, and the
    /// default is false. Needs a device with five bind groups.
    pub forward_meshes: bool,
}

impl Default for LeanScreenSpaceReflectionsAdvanced {
    fn default() -> Self {
        Self {
            edge_fade: 0.05,
            forward_meshes: false,
        }
    }
}

/// Rows from which on 4×4 pixels are about as small a part of the image as 2×2 are at 720 rows. No common height of a screen is near it.
const MANY_ROWS: u32 = 1360;
/// Part of the rows, in percent, by which a view has to be past [`MANY_ROWS`] before its texels change: dynamic resolution may cross
/// it in any frame.
const HYSTERESIS: u32 = 5;

impl LeanScreenSpaceReflections {
    /// Pixels per side of a texel, which sends one ray, in a view of `rows` rows: 1, 2 or 4. The divisor of the resolution, doubled with
    /// `Low`, and with `Medium` from 1360 rows on.
    pub fn texel_side(&self, rows: u32) -> u32 {
        self.resolution.divisor() * self.texel_step(rows)
    }

    /// As [`texel_side`](Self::texel_side), in a view whose texels had the side `last` in the frame before: it stays as it was near the
    /// number of rows at which it changes.
    pub(super) fn steady_texel_side(&self, rows: u32, last: Option<u32>) -> u32 {
        let near = [100 - HYSTERESIS, 100 + HYSTERESIS].map(|percent| rows * percent / 100);
        last.filter(|last| near.iter().any(|rows| self.texel_side(*rows) == *last))
            .unwrap_or_else(|| self.texel_side(rows))
    }

    /// Factor per side on the resolution's texels, in a view of `rows` rows.
    fn texel_step(&self, rows: u32) -> u32 {
        match self.quality {
            LeanQuality::Low => 2,
            LeanQuality::Medium if rows >= MANY_ROWS => 2,
            LeanQuality::Medium | LeanQuality::High | LeanQuality::Ultra => 1,
        }
    }

    /// Range and precision of rays with texels of this side.
    pub(super) fn marches(&self, texel_side: u32) -> Marches {
        let texel_step = (texel_side / self.resolution.divisor()).clamp(1, 2);
        let (smooth_steps, rough_segments, pixels, growth_percent) = match self.quality {
            LeanQuality::Low => (48, 48, 8, 45.0),
            LeanQuality::Medium => (64, 48, 8, 45.0),
            LeanQuality::High => (128, 96, 4, 15.0),
            LeanQuality::Ultra => (256, 192, 2, 8.0),
        };
        Marches {
            smooth_steps,
            rough_segments,
            shortest_segment: (pixels * texel_step) as f32,
            growth: 0.01 * growth_percent,
        }
    }
}

/// Range and precision of rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Marches {
    /// Most steps of a ray from a smooth surface (perceptual roughness up to 0.2) before it continues in segments.
    pub(super) smooth_steps: u32,
    /// Most segments of a ray from a rough surface, or of the rest of one from a smooth surface.
    pub(super) rough_segments: u32,
    /// Shortest segment, in pixels.
    pub(super) shortest_segment: f32,
    /// Length of a segment, as a share of the distance marched times the perceptual roughness squared.
    pub(super) growth: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_keep_their_size_while_the_resolution_is_scaled() {
        let settings = LeanScreenSpaceReflections::default();
        // Common screens have the texels of their size, whatever came before.
        for (rows, side) in [
            (720, 2),
            (1080, 2),
            (1200, 2),
            (1440, 4),
            (1600, 4),
            (2160, 4),
        ] {
            assert_eq!(settings.texel_side(rows), side);
            for last in [None, Some(2), Some(4)] {
                assert_eq!(
                    settings.steady_texel_side(rows, last),
                    side,
                    "{rows} {last:?}"
                );
            }
        }
        // Dynamic resolution around the threshold.
        for (first, side) in [(1430, 4), (1290, 2)] {
            let last = settings.steady_texel_side(first, None);
            assert_eq!(last, side);
            for rows in 1300..1420 {
                assert_eq!(settings.steady_texel_side(rows, Some(last)), last, "{rows}");
            }
        }
        // Another quality counts at once.
        let low = LeanScreenSpaceReflections {
            quality: LeanQuality::Low,
            ..settings
        };
        assert_eq!(low.steady_texel_side(1080, Some(2)), 4);
    }
}
