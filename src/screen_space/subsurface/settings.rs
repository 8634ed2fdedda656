use bevy::{prelude::*, render::extract_component::ExtractComponent};

/// Settings of light scattering beneath surfaces with [`ShadingExtension::Subsurface`](crate::shading_extension::ShadingExtension).
///
/// For cameras with [`LeanDeferred`](crate::LeanDeferred), which scatter with the default settings without this component. Diffuse
/// light of the lighting pass scatters, including ambient light; emission, reflections and lightmaps do not. Light leaves up to about
/// ten mean free paths away, in metres: the result does not depend on distance, resolution or projection. Light does not cross to
/// another material, over a step in depth, or off screen; it stays on the surface instead, so that none is lost. Thin parts
/// therefore do not transmit light.
///
/// The result is free of noise, and independent of other frames.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn_bust(
///     mut commands: Commands,
///     mut meshes: ResMut<Assets<Mesh>>,
///     mut materials: ResMut<Assets<ExtendedStandardMaterial>>,
/// ) {
///     commands.spawn((
///         Mesh3d(meshes.add(Sphere::new(0.1))),
///         MeshMaterial3d(materials.add(ExtendedStandardMaterial {
///             base: Color::srgb(0.85, 0.7, 0.6).into(),
///             // Skin: red light scatters furthest, 5 mm.
///             extension: ShadingExtension::Subsurface {
///                 color: LinearRgba::rgb(1.0, 0.35, 0.2).into(),
///                 mean_free_path: 0.005,
///                 albedo: SubsurfaceAlbedo::AfterScattering,
///             },
///         })),
///     ));
/// }
///
/// fn spawn_camera(mut commands: Commands) {
///     commands.spawn((
///         Camera3d::default(),
///         LeanDeferred::default(),
///         // Only for other settings: light scatters with the defaults without it.
///         LeanSubsurfaceScattering {
///             quality: SubsurfaceScatteringQuality::Low,
///             ..default()
///         },
///     ));
/// }
/// ```
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(crate::view::LeanStatus)]
pub struct LeanSubsurfaceScattering {
    /// Default [`SubsurfaceScatteringQuality::High`].
    pub quality: SubsurfaceScatteringQuality,
    /// Largest distance that light travels on screen, in pixels; close to the camera the profile shrinks to it. More than 0, at most
    /// 256. Default 256.
    pub largest_radius: f32,
}

impl Default for LeanSubsurfaceScattering {
    fn default() -> Self {
        Self {
            quality: default(),
            largest_radius: LARGEST_RADIUS,
        }
    }
}

/// Limit of the coarsest level, in pixels.
pub(super) const LARGEST_RADIUS: f32 = 256.0;

/// Accuracy of the scattering.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum SubsurfaceScatteringQuality {
    /// No scattering: light leaves where it enters.
    Off,
    /// Kernels are circular on screen. On surfaces seen at an angle they are as narrow along the width as across it, where the surface
    /// is foreshortened.
    Low,
    /// Kernels are up to twice as long along the width: correct on surfaces turned away by up to 60 degrees.
    #[default]
    High,
}

impl SubsurfaceScatteringQuality {
    /// All variants, cheapest first.
    pub const ALL: [Self; 3] = [Self::Off, Self::Low, Self::High];
}
