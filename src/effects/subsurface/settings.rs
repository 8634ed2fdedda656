use bevy::{prelude::*, render::extract_component::ExtractComponent};

use crate::view::{LeanQuality, LeanStatus};

/// Screen-space scattering of light beneath surfaces with
/// [`ShadingExtension::Subsurface`](crate::material_extension::ShadingExtension).
///
/// For cameras with [`LeanDeferred`](crate::LeanDeferred), which is added with it. Other cameras light such surfaces like their base.
/// Diffuse light of the lighting pass scatters, including ambient light; emission, reflections and lightmaps do not. Light leaves up to
/// about ten mean free paths away, in metres: the result does not depend on distance, resolution or projection. Light does not cross to
/// another material, over a step in depth, or off screen; it stays on the surface instead, so that none is lost. Thin parts therefore
/// do not transmit light.
///
/// The result is free of noise, and independent of other frames.
///
/// Can be added and removed at run time; removing it frees its GPU resources. It costs nothing while no such surface is visible.
///
/// ```
/// # use bevy::prelude::*;
/// use bevy_lean_deferred::{material_extension::SubsurfaceAlbedo, prelude::*};
///
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
///     commands.spawn((Camera3d::default(), LeanSubsurfaceScattering::default()));
/// }
/// ```
#[doc(alias("sss", "sssss"))]
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(LeanStatus)]
pub struct LeanSubsurfaceScattering {
    /// Accuracy on surfaces seen at an angle. Default [`LeanQuality::High`].
    ///
    /// - `Low`, `Medium`: kernels are circular on screen. Where a surface is foreshortened, they are as narrow along its width as
    ///   across it.
    /// - `High`, `Ultra`: kernels are up to twice as long along the width: correct on surfaces turned away by up to 60 degrees.
    pub quality: LeanQuality,
    /// Settings that few games change.
    pub advanced: LeanSubsurfaceScatteringAdvanced,
}

impl Default for LeanSubsurfaceScattering {
    fn default() -> Self {
        Self {
            quality: LeanQuality::High,
            advanced: default(),
        }
    }
}

/// Settings of [`LeanSubsurfaceScattering`] that few games change.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct LeanSubsurfaceScatteringAdvanced {
    /// Largest distance that light travels on screen, in pixels; close to the camera the profile shrinks to it. More than 0, at most
    /// 256. Default 256.
    pub largest_radius: f32,
}

impl Default for LeanSubsurfaceScatteringAdvanced {
    fn default() -> Self {
        Self {
            largest_radius: LARGEST_RADIUS,
        }
    }
}

/// Limit of the coarsest level, in pixels.
pub(super) const LARGEST_RADIUS: f32 = 256.0;
