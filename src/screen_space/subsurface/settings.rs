use bevy::{prelude::*, render::extract_component::ExtractComponent};

/// How light scatters beneath surfaces with [`ShadingExtension::Subsurface`](crate::shading_extension::ShadingExtension).
///
/// For cameras with [`LeanDeferred`](crate::LeanDeferred), which scatter it also without this component, as its defaults say.
/// What enters is the diffuse light of the lighting pass, ambient light included; emission, reflections and the light of
/// lightmaps stay where they are. It leaves up to some ten mean free paths away: in metres, so that the picture is the same at
/// any distance, resolution and projection. Nothing goes to another material, across a step in depth, or beyond the picture:
/// light that would stays on the surface, so that none is lost; so thin parts do not let light through.
///
/// A frame has no noise, and needs no other frame.
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
///             // Skin: red light goes furthest, 5 mm.
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
///         // Only to change how: the default scatters without it.
///         LeanSubsurfaceScattering {
///             quality: SubsurfaceScatteringQuality::Low,
///             ..default()
///         },
///     ));
/// }
/// ```
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct LeanSubsurfaceScattering {
    /// Default [`SubsurfaceScatteringQuality::High`].
    pub quality: SubsurfaceScatteringQuality,
    /// From how far light comes at most, in pixels: nearer to the camera the profile shrinks to that. More than 0; 256 is the
    /// default, and the most.
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

/// What the coarsest level of the light has room for.
pub(super) const LARGEST_RADIUS: f32 = 256.0;

/// How exactly light scatters.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum SubsurfaceScatteringQuality {
    /// Light leaves where it enters.
    Off,
    /// On surfaces that are turned away light scatters as little along their width as it seems to across.
    Low,
    /// It scatters twice as far that way: right on surfaces that are turned away by up to 60 degrees.
    #[default]
    High,
}

impl SubsurfaceScatteringQuality {
    /// All of them, cheapest first.
    pub const ALL: [Self; 3] = [Self::Off, Self::Low, Self::High];
}
