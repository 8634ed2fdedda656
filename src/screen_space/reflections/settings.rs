use bevy::{prelude::*, render::extract_component::ExtractComponent};

use crate::screen_space::ScreenSpaceResolution;

/// Screen-space reflections: traces rays through this frame's depth into the light of the last frame.
///
/// For cameras with [`LeanDeferred`](crate::LeanDeferred). Smooth surfaces reflect a single direction, resolved per pixel; rough ones
/// the mean of rays in sixteen directions of the GGX lobe, shared by neighbours. The pattern is the same every frame, unless the
/// camera's frames are averaged, as with TAA. In lighting, reflections replace environment maps, reflection probes and ambient light
/// with the same Fresnel, roughness and energy terms; they also work in scenes without these.
///
/// Surfaces that are off screen, hidden or turned away are not reflected; the environment shows there, as without the component.
/// Meshes in Bevy's forward passes are reflected only if the camera has `DepthPrepass`, and reflect nothing themselves. Light that
/// they and transparent meshes add to the image in front of a reflected surface is reflected with it. Without `MotionVectorPrepass`,
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
///         LeanDeferred::default(),
///         LeanScreenSpaceReflections {
///             max_roughness: 0.5,
///             resolution: ScreenSpaceResolution::Full,
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
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(crate::view::LeanStatus)]
pub struct LeanScreenSpaceReflections {
    /// Assumed thickness of surfaces, in metres; rays that pass further behind a surface miss it. More than 0. Default 0.25.
    pub thickness: f32,
    /// Perceptual roughness above which surfaces do not reflect the image, 0 to 1.25. Reflections fade from three quarters of it on;
    /// above 1, the roughest surfaces reflect too. Default 0.8.
    pub max_roughness: f32,
    /// Width of the fade at the edges of the image, as a share of the viewport's height. 0 to 0.5. Default 0.05.
    pub edge_fade: f32,
    /// Share of the environment that reflections replace, 0 to 1. Default 1.
    pub intensity: f32,
    /// Range and precision of rays. Default [`ScreenSpaceReflectionsQuality::Medium`].
    pub quality: ScreenSpaceReflectionsQuality,
    /// Resolution at which rays are traced: see [`texel_side`](Self::texel_side). Default [`ScreenSpaceResolution::Half`].
    pub resolution: ScreenSpaceResolution,
    /// Output that is shown in place of the image. Default `None`, the image.
    pub debug_view: Option<ScreenSpaceReflectionsDebugView>,
}

impl Default for LeanScreenSpaceReflections {
    fn default() -> Self {
        Self {
            thickness: 0.25,
            max_roughness: 0.8,
            edge_fade: 0.05,
            intensity: 1.0,
            quality: default(),
            resolution: default(),
            debug_view: None,
        }
    }
}

impl LeanScreenSpaceReflections {
    /// Pixels per side of a texel, which sends one ray, in a view of `rows` rows: 1, 2 or 4. The divisor of the resolution, doubled with
    /// `Low`, and with `Medium` from 1440 rows on.
    pub fn texel_side(&self, rows: u32) -> u32 {
        self.resolution.divisor() * self.quality.texel_step(rows)
    }

    /// Shortest segment of a ray, in pixels.
    pub(super) fn shortest_segment(&self, rows: u32) -> u32 {
        let pixels = match self.quality {
            ScreenSpaceReflectionsQuality::Low | ScreenSpaceReflectionsQuality::Medium => 8,
            ScreenSpaceReflectionsQuality::High => 4,
        };
        pixels * self.quality.texel_step(rows)
    }
}

/// Precision and maximum length of ray marches. A ray from a surface with a perceptual roughness up to 0.2 steps through the hi-z:
/// over the largest cell that it can skip, of 4 to 64 pixels per side, and from pixel to pixel inside others. Rays from rougher
/// surfaces march in segments that grow with the distance, as the lobe does; a segment in which the ray passes behind a surface is
/// bisected down to a pixel. A smooth surface's ray that has used up its steps continues in segments.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum ScreenSpaceReflectionsQuality {
    /// 48 steps, or 48 segments of 16 pixels, or of 0.22 of the lobe's radius if that is longer. Texels are twice as large per side.
    Low,
    /// 64 steps, or 48 segments of 8 pixels, or of 0.22 of the lobe's radius if that is longer. In views of 1440 rows or more, texels
    /// and segments are as large as with `Low`.
    #[default]
    Medium,
    /// 128 steps, or 96 segments of 4 pixels, or of 0.075 of the lobe's radius if that is longer.
    High,
}

/// Rows from which on 4×4 pixels are no larger a part of the image than 2×2 are at 720 rows.
const MANY_ROWS: u32 = 1440;

impl ScreenSpaceReflectionsQuality {
    /// All variants, cheapest first.
    pub const ALL: [Self; 3] = [Self::Low, Self::Medium, Self::High];

    /// Most steps of a ray from a smooth surface (perceptual roughness up to 0.2) before it continues in segments.
    pub fn smooth_steps(self) -> u32 {
        match self {
            Self::Low => 48,
            Self::Medium => 64,
            Self::High => 128,
        }
    }

    /// Most segments of a ray from a rough surface, or of the rest of one from a smooth surface.
    pub fn rough_segments(self) -> u32 {
        match self {
            Self::Low | Self::Medium => 48,
            Self::High => 96,
        }
    }

    /// Length of a segment, in percent of the distance marched times the perceptual roughness squared.
    pub(super) fn growth_percent(self) -> u32 {
        match self {
            Self::Low | Self::Medium => 45,
            Self::High => 15,
        }
    }

    /// Factor per side on the resolution's texels, in a view of `rows` rows.
    fn texel_step(self, rows: u32) -> u32 {
        match self {
            Self::Low => 2,
            Self::Medium if rows >= MANY_ROWS => 2,
            Self::Medium | Self::High => 1,
        }
    }
}

/// Outputs for [`LeanScreenSpaceReflections::debug_view`].
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[reflect(Clone, PartialEq)]
pub enum ScreenSpaceReflectionsDebugView {
    /// Reflected light, exposed, before it is weighted by the surface's reflectance. Black where nothing is reflected.
    Light,
    /// Share of the environment that reflections replace, in grey.
    Confidence,
    /// Distance of the mirror image at each ray's hit, in grey: `1 / (1 + metres)`. Black for misses.
    Hit,
}

impl ScreenSpaceReflectionsDebugView {
    /// All variants.
    pub const ALL: [Self; 3] = [Self::Light, Self::Confidence, Self::Hit];
}
