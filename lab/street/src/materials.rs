//! Materials of the street.

use bevy::prelude::*;
use bevy_lean_deferred::{
    material_extension::SubsurfaceAlbedo,
    prelude::{ExtendedStandardMaterial, ShadingExtension},
};

use crate::{
    sky::EXPOSURE,
    stage::Stage,
    textures::{Textures, Tile},
};

/// Number of colours of bulbs, awnings, coats and umbrellas.
pub const COLORS: usize = 6;

/// Materials of the street.
pub struct Materials {
    pub asphalt: Handle<StandardMaterial>,
    pub paving: Handle<StandardMaterial>,
    pub bricks: Vec<Handle<StandardMaterial>>,
    pub trim: Handle<StandardMaterial>,
    pub wood: Handle<StandardMaterial>,
    pub concrete: Handle<StandardMaterial>,
    /// Brushed metal: anisotropic.
    pub shutter: Handle<StandardMaterial>,
    /// Drawn by Bevy's transparent pass.
    pub glass: Handle<StandardMaterial>,
    /// Lit rooms.
    pub windows: Vec<Handle<StandardMaterial>>,
    pub dark_window: Handle<StandardMaterial>,
    pub awnings: Vec<Handle<StandardMaterial>>,
    /// Red, with a clear coat.
    pub lacquer: Handle<StandardMaterial>,
    pub gold: Handle<StandardMaterial>,
    /// Emissive.
    pub bulbs: Vec<Handle<StandardMaterial>>,
    pub lamp: Handle<StandardMaterial>,
    pub paper: Vec<Handle<StandardMaterial>>,
    /// Alpha-masked, with diffuse transmission.
    pub leaves: Handle<StandardMaterial>,
    pub pot: Handle<StandardMaterial>,
    pub fruits: Vec<Handle<StandardMaterial>>,
    /// Light scatters beneath the surfaces of these two.
    pub jade: Handle<ExtendedStandardMaterial>,
    pub wax: Handle<ExtendedStandardMaterial>,
    pub eyes: Handle<StandardMaterial>,
    /// Cloth with rim light.
    pub coats: Vec<Handle<ExtendedStandardMaterial>>,
    /// Transmits light diffusely.
    pub umbrellas: Vec<Handle<StandardMaterial>>,
}

/// Warm white, amber, red, pink, cyan, green.
pub const LIGHTS: [LinearRgba; COLORS] = [
    LinearRgba::rgb(1.0, 0.62, 0.28),
    LinearRgba::rgb(1.0, 0.42, 0.09),
    LinearRgba::rgb(1.0, 0.1, 0.06),
    LinearRgba::rgb(1.0, 0.12, 0.5),
    LinearRgba::rgb(0.1, 0.7, 1.0),
    LinearRgba::rgb(0.15, 1.0, 0.35),
];

/// A material as bright as `nits` times a colour at the exposure of [`sky::air`](crate::sky::air), and independent of
/// the exposure: Bevy's deferred renderer, which is compared, supports no other emission.
pub fn emission(color: LinearRgba, nits: f32) -> StandardMaterial {
    StandardMaterial {
        base_color: Color::BLACK,
        emissive: color * nits * EXPOSURE.exposure(),
        perceptual_roughness: 0.4,
        ..default()
    }
}

fn rough(red: f32, green: f32, blue: f32, perceptual_roughness: f32) -> StandardMaterial {
    StandardMaterial {
        base_color: Color::linear_rgb(red, green, blue),
        perceptual_roughness,
        ..default()
    }
}

/// A material whose texture tiles once per `metres`.
fn tiled(tile: &Tile, metres: f32, tint: Color) -> StandardMaterial {
    StandardMaterial {
        base_color: tint,
        base_color_texture: Some(tile.color.clone()),
        perceptual_roughness: 1.0,
        metallic_roughness_texture: Some(tile.roughness.clone()),
        normal_map_texture: Some(tile.normal.clone()),
        uv_transform: bevy::math::Affine2::from_scale(Vec2::splat(1.0 / metres)),
        ..default()
    }
}

impl Materials {
    pub fn new(stage: &mut Stage, textures: &Textures) -> Self {
        let mut add = |material: StandardMaterial| stage.standard.add(material);
        let scattering =
            |color: Color, base: Color, mean_free_path: f32| ExtendedStandardMaterial {
                base: StandardMaterial {
                    base_color: base,
                    perceptual_roughness: 0.25,
                    ..default()
                },
                extension: ShadingExtension::Subsurface {
                    color,
                    mean_free_path,
                    albedo: SubsurfaceAlbedo::AfterScattering,
                },
            };
        Self {
            asphalt: add(tiled(&textures.asphalt, 8.0, Color::WHITE)),
            paving: add(tiled(&textures.paving, 2.0, Color::WHITE)),
            bricks: BRICKS
                .map(|[r, g, b]| add(tiled(&textures.bricks, 2.0, Color::linear_rgb(r, g, b))))
                .into(),
            trim: add(rough(0.03, 0.032, 0.036, 0.45)),
            wood: add(rough(0.16, 0.08, 0.035, 0.6)),
            concrete: add(rough(0.2, 0.19, 0.18, 0.85)),
            shutter: add(StandardMaterial {
                metallic: 1.0,
                anisotropy_strength: 0.7,
                ..rough(0.42, 0.43, 0.45, 0.38)
            }),
            glass: add(StandardMaterial {
                base_color: Color::linear_rgba(0.02, 0.03, 0.03, 0.1),
                perceptual_roughness: 0.05,
                alpha_mode: AlphaMode::Blend,
                ..default()
            }),
            windows: textures
                .windows
                .iter()
                .map(|room| {
                    add(StandardMaterial {
                        emissive_texture: Some(room.clone()),
                        perceptual_roughness: 0.1,
                        ..emission(LinearRgba::WHITE, 55.0)
                    })
                })
                .collect(),
            dark_window: add(rough(0.01, 0.012, 0.016, 0.08)),
            awnings: AWNINGS
                .map(|[r, g, b]| {
                    add(StandardMaterial {
                        base_color_texture: Some(textures.stripes.clone()),
                        uv_transform: bevy::math::Affine2::from_scale(Vec2::splat(2.0)),
                        double_sided: true,
                        cull_mode: None,
                        ..rough(r, g, b, 0.8)
                    })
                })
                .into(),
            lacquer: add(StandardMaterial {
                clearcoat: 1.0,
                clearcoat_perceptual_roughness: 0.05,
                ..rough(0.55, 0.02, 0.012, 0.5)
            }),
            gold: add(StandardMaterial {
                metallic: 1.0,
                ..rough(0.9, 0.6, 0.2, 0.22)
            }),
            bulbs: LIGHTS.map(|color| add(emission(color, 260.0))).into(),
            lamp: add(emission(LIGHTS[0], 700.0)),
            paper: LIGHTS.map(|color| add(emission(color, 45.0))).into(),
            leaves: add(StandardMaterial {
                base_color_texture: Some(textures.leaves.clone()),
                alpha_mode: AlphaMode::Mask(0.4),
                diffuse_transmission: 0.35,
                double_sided: true,
                cull_mode: None,
                ..rough(1.0, 1.0, 1.0, 0.5)
            }),
            pot: add(rough(0.3, 0.1, 0.05, 0.7)),
            fruits: FRUITS.map(|[r, g, b]| add(rough(r, g, b, 0.3))).into(),
            jade: stage.extended.add(scattering(
                Color::linear_rgb(0.55, 1.0, 0.7),
                Color::linear_rgb(0.22, 0.62, 0.36),
                0.03,
            )),
            wax: stage.extended.add(scattering(
                Color::linear_rgb(1.0, 0.6, 0.35),
                Color::linear_rgb(0.9, 0.78, 0.62),
                0.03,
            )),
            eyes: add(rough(0.01, 0.01, 0.01, 0.1)),
            coats: COATS
                .map(|[r, g, b]| {
                    stage.extended.add(ExtendedStandardMaterial {
                        base: rough(r, g, b, 0.85),
                        extension: ShadingExtension::Rim {
                            color: Color::linear_rgb(0.5, 0.5, 0.55),
                            exponent: 4.0,
                        },
                    })
                })
                .into(),
            umbrellas: AWNINGS
                .map(|[r, g, b]| {
                    add(StandardMaterial {
                        diffuse_transmission: 0.6,
                        double_sided: true,
                        cull_mode: None,
                        ..rough(r, g, b, 0.35)
                    })
                })
                .into(),
        }
    }
}

const BRICKS: [[f32; 3]; 4] = [
    [0.34, 0.12, 0.08],
    [0.24, 0.2, 0.17],
    [0.3, 0.22, 0.13],
    [0.13, 0.15, 0.18],
];

const AWNINGS: [[f32; 3]; COLORS] = [
    [0.6, 0.04, 0.04],
    [0.05, 0.22, 0.45],
    [0.06, 0.3, 0.12],
    [0.7, 0.4, 0.05],
    [0.55, 0.5, 0.42],
    [0.4, 0.06, 0.28],
];

const FRUITS: [[f32; 3]; COLORS] = [
    [0.7, 0.06, 0.03],
    [0.8, 0.3, 0.02],
    [0.75, 0.6, 0.04],
    [0.2, 0.45, 0.05],
    [0.25, 0.04, 0.2],
    [0.6, 0.45, 0.25],
];

const COATS: [[f32; 3]; COLORS] = [
    [0.02, 0.025, 0.035],
    [0.16, 0.12, 0.08],
    [0.05, 0.08, 0.14],
    [0.3, 0.05, 0.04],
    [0.28, 0.26, 0.22],
    [0.06, 0.1, 0.06],
];
