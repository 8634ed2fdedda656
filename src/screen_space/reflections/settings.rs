use bevy::{prelude::*, render::extract_component::ExtractComponent};

use crate::screen_space::ScreenSpaceResolution;

/// What surfaces mirror of the picture: rays through this frame's depth, into the light of the last frame.
///
/// For cameras with [`LeanDeferred`](crate::LeanDeferred). A smooth mirror shows one place, found for each pixel; a rough
/// one the mean of rays in sixteen directions of its lobe (GGX), shared by neighbours. Nothing is random from frame to frame unless
/// the camera's frames are averaged, as TAA does. Lighting mixes it with environment maps, reflection probes and ambient
/// light, in the place of which it is seen: with the same Fresnel, roughness and energy terms, and with or without them.
///
/// What the picture does not show is not mirrored: what is beyond its rim, hidden, or turned away. There the
/// environment is seen, as without the component. Nor are meshes that Bevy's forward passes draw, unless the camera has
/// `DepthPrepass`; they mirror nothing. What they and transparent meshes add to the picture in front of what is mirrored is in
/// it. Without `MotionVectorPrepass` the light of what moves is a frame behind it. Anisotropic surfaces mirror as isotropic
/// ones.
///
/// Rays pass through empty cells of depth (Uludag 2014, "Hi-Z Screen-Space Cone-Traced Reflections"), in directions of the microfacets
/// that the viewer sees (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps"). Neighbours share theirs, after
/// Stachowiak 2015, "Stochastic Screen-Space Reflections".
///
/// Adding or removing it at run time switches the effect and frees what it held.
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
pub struct LeanScreenSpaceReflections {
    /// How far surfaces reach behind their front, in metres: what passes further behind is not mirrored. More than 0. Default
    /// 0.25.
    pub thickness: f32,
    /// Perceptual roughness from which on surfaces mirror nothing of the picture, 0 to 1.25. From three quarters of it on they fade:
    /// with more than 1 the roughest ones mirror too. Default 0.8.
    pub max_roughness: f32,
    /// Share of the viewport's height, from its rim, over which reflections fade. 0 to 0.5. Default 0.05.
    pub edge_fade: f32,
    /// How much of it is shown in the place of the environment, 0 to 1. Default 1.
    pub intensity: f32,
    /// How far rays go. Default [`ScreenSpaceReflectionsQuality::Medium`].
    pub quality: ScreenSpaceReflectionsQuality,
    /// How many pixels share a texel, which sends a ray: see [`texel_side`](Self::texel_side). Default
    /// [`ScreenSpaceResolution::Half`].
    pub resolution: ScreenSpaceResolution,
    /// What is shown in place of the picture. Default `None`, the picture.
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
    /// Pixels a side of a texel, which sends a ray, in a view of so many rows: 1, 2 or 4. That of the resolution, and twice that with
    /// `Low`, and with `Medium` from 1440 rows on.
    pub fn texel_side(&self, rows: u32) -> u32 {
        self.resolution.divisor() * self.quality.texel_step(rows)
    }

    /// The shortest segment of a ray, in pixels.
    pub(super) fn shortest_segment(&self, rows: u32) -> u32 {
        let pixels = match self.quality {
            ScreenSpaceReflectionsQuality::Low | ScreenSpaceReflectionsQuality::Medium => 8,
            ScreenSpaceReflectionsQuality::High => 4,
        };
        pixels * self.quality.texel_step(rows)
    }
}

/// How closely a ray looks, and when it is given up. That of a surface of a perceptual roughness up to 0.2 goes from cell to cell, of 4 to 64
/// pixels a side, the largest that it can pass at once, and in them from pixel to pixel: each is a step. That of a rougher one goes in
/// segments that grow with the way as the lobe does; where it goes behind something in one, that is halved down to a pixel. So does the
/// rest of a smooth surface's ray that has had its steps.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum ScreenSpaceReflectionsQuality {
    /// 48 steps, or 48 segments of 16 pixels, or 0.22 of the lobe's radius where that is longer. Texels are twice as large each way.
    Low,
    /// 64 steps, or 48 segments of 8 pixels, or 0.22 of the radius. In views of 1440 rows or more texels and segments are as large as with
    /// `Low`.
    #[default]
    Medium,
    /// 128 steps, or 96 segments of 4 pixels, or 0.075 of the radius.
    High,
}

/// In a picture of so many rows or more, 4×4 pixels are no larger a part of it than 2×2 are in one of 720.
const MANY_ROWS: u32 = 1440;

impl ScreenSpaceReflectionsQuality {
    /// All of them, cheapest first.
    pub const ALL: [Self; 3] = [Self::Low, Self::Medium, Self::High];

    /// The most steps of a ray from a smooth surface, of a perceptual roughness up to 0.2, before it goes on in segments.
    pub fn smooth_steps(self) -> u32 {
        match self {
            Self::Low => 48,
            Self::Medium => 64,
            Self::High => 128,
        }
    }

    /// The most segments of a ray from a rough surface, or of the rest of one from a smooth surface.
    pub fn rough_segments(self) -> u32 {
        match self {
            Self::Low | Self::Medium => 48,
            Self::High => 96,
        }
    }

    /// How long they are, in hundredths of their way times the perceptual roughness squared.
    pub(super) fn growth_percent(self) -> u32 {
        match self {
            Self::Low | Self::Medium => 45,
            Self::High => 15,
        }
    }

    /// How many times larger texels are each way than those of the resolution, in a view of so many rows.
    fn texel_step(self, rows: u32) -> u32 {
        match self {
            Self::Low => 2,
            Self::Medium if rows >= MANY_ROWS => 2,
            Self::Medium | Self::High => 1,
        }
    }
}

/// What has been found, for [`LeanScreenSpaceReflections::debug_view`].
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[reflect(Clone, PartialEq)]
pub enum ScreenSpaceReflectionsDebugView {
    /// What each pixel mirrors of the picture, exposed, before it is weighed by how much its surface mirrors. Black where that
    /// is nothing.
    Light,
    /// How much of the environment it takes the place of, grey.
    Confidence,
    /// How far away the mirror image is that each ray has met, grey: `1 / (1 + metres)`. Black where it met nothing.
    Hit,
}

impl ScreenSpaceReflectionsDebugView {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Light, Self::Confidence, Self::Hit];
}
