//! The rows, from top to bottom.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;

pub const COLUMNS: usize = 9;

pub struct Row {
    pub name: &'static str,
    /// The parameter that changes from left to right.
    pub steps: &'static str,
    pub sample: fn(usize, &Textures) -> Sample,
    /// A bar above the row casts a shadow onto it.
    pub has_bar: bool,
    pub has_light_behind: bool,
    /// Distance behind the other rows, in metres.
    pub depth: f32,
}

impl Row {
    const fn new(
        name: &'static str,
        steps: &'static str,
        sample: fn(usize, &Textures) -> Sample,
    ) -> Self {
        Self {
            name,
            steps,
            sample,
            has_bar: false,
            has_light_behind: false,
            depth: 0.0,
        }
    }
}

pub struct Textures {
    pub specular: Handle<Image>,
    pub lightmap: Handle<Image>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Shape {
    #[default]
    Ball,
    /// A thin disc.
    Leaf,
    ThinSlab,
    ThickSlab,
    Bust,
}

#[derive(Default)]
pub struct Sample {
    pub base: StandardMaterial,
    pub extension: ShadingExtension,
    pub shape: Shape,
    pub ignores_shadows: bool,
    /// A lightmap, sampled bicubically if true.
    pub lightmap: Option<bool>,
}

impl From<StandardMaterial> for Sample {
    fn from(base: StandardMaterial) -> Self {
        Self { base, ..default() }
    }
}

pub const ROWS: [Row; 13] = [
    Row::new(
        "plain",
        "metallic 0, 0.5, 1 with roughness 0.1, 0.4, 0.8",
        plain,
    ),
    Row::new(
        "emissive",
        "light 0.05 to 8; last 4: exposed, 125 to 8000 nits",
        emissive,
    ),
    Row::new(
        "reflectance",
        "0 to 1; last 3: texture at 0.25, 0.5, 1",
        reflectance,
    ),
    Row::new(
        "clearcoat",
        "strength 0.3, 0.6, 1 with roughness 0.05, 0.3, 0.6",
        clearcoat,
    ),
    Row::new(
        "anisotropy",
        "strength 0.3, 0.6, 0.95 with rotation 0, 45, 90 degrees",
        anisotropy,
    ),
    Row {
        has_light_behind: true,
        ..Row::new(
            "diffuse transmission",
            "transmission 0.2 to 1; last 4: balls, thickness 0 to 1.5 m",
            diffuse_transmission,
        )
    },
    Row {
        // In the middle column of rows, so that no other row hides it.
        depth: 4.0,
        ..Row::new("fog", "with and without, by turns", fog)
    },
    Row::new("rim", "exponent 1, 2, 5 in three colours", rim),
    Row::new(
        "subsurface",
        "mean free path 1, 3, 10, 30, 100 mm; jade; a thin and a thick slab and a bust of 10 mm",
        subsurface,
    ),
    Row::new("unlit", "five colours; last 4: brightness 1 to 64", unlit),
    Row {
        has_bar: true,
        ..Row::new("shadows", "received and not, by turns", shadows)
    },
    Row::new(
        "lightmap",
        "exposure 250 to 4000; last 4: bicubic, of which 2 emissive",
        lightmap,
    ),
    Row {
        has_bar: true,
        ..Row::new(
            "combined",
            "clearcoat, anisotropy, diffuse transmission, rim: emissive, the next 4 without fog, one without shadows",
            combined,
        )
    },
];

const WARM: Color = Color::srgb(1.0, 0.6, 0.3);
const COOL: Color = Color::srgb(0.4, 0.7, 1.0);
const COLORS: [Color; 3] = [Color::WHITE, WARM, COOL];

/// Values of the two parameters of a row of three by three.
fn pair<A: Copy, B: Copy>(column: usize, outer: [A; 3], inner: [B; 3]) -> (A, B) {
    (outer[column / 3 % 3], inner[column % 3])
}

fn base(color: Color, metallic: f32, perceptual_roughness: f32) -> StandardMaterial {
    StandardMaterial {
        base_color: color,
        metallic,
        perceptual_roughness,
        ..default()
    }
}

fn clay() -> StandardMaterial {
    base(Color::srgb(0.6, 0.35, 0.25), 0.0, 0.6)
}

fn plain(column: usize, _: &Textures) -> Sample {
    let (metallic, roughness) = pair(column, [0.0, 0.5, 1.0], [0.1, 0.4, 0.8]);
    base(Color::srgb(0.85, 0.65, 0.35), metallic, roughness).into()
}

fn emissive(column: usize, _: &Textures) -> Sample {
    let (light, weight) = match column {
        0..5 => ([0.05, 0.2, 0.8, 2.5, 8.0][column], 0.0),
        _ => (125.0 * 4f32.powi(column as i32 - 5), 1.0),
    };
    StandardMaterial {
        emissive: LinearRgba::rgb(1.0, 0.5, 0.15) * light,
        emissive_exposure_weight: weight,
        ..base(Color::srgb(0.2, 0.2, 0.25), 0.0, 0.6)
    }
    .into()
}

fn reflectance(column: usize, textures: &Textures) -> Sample {
    StandardMaterial {
        reflectance: match column {
            0..6 => column as f32 / 5.0,
            _ => [0.25, 0.5, 1.0][(column - 6) % 3],
        },
        specular_texture: (column >= 6).then(|| textures.specular.clone()),
        ..base(Color::srgb(0.15, 0.05, 0.05), 0.0, 0.15)
    }
    .into()
}

fn clearcoat(column: usize, _: &Textures) -> Sample {
    let (strength, roughness) = pair(column, [0.3, 0.6, 1.0], [0.05, 0.3, 0.6]);
    StandardMaterial {
        clearcoat: strength,
        clearcoat_perceptual_roughness: roughness,
        ..base(Color::srgb(0.5, 0.05, 0.05), 0.3, 0.8)
    }
    .into()
}

fn anisotropy(column: usize, _: &Textures) -> Sample {
    let (strength, degrees) = pair(column, [0.3, 0.6, 0.95], [0.0f32, 45.0, 90.0]);
    StandardMaterial {
        anisotropy_strength: strength,
        anisotropy_rotation: degrees.to_radians(),
        ..base(Color::srgb(0.8, 0.8, 0.85), 1.0, 0.4)
    }
    .into()
}

fn diffuse_transmission(column: usize, _: &Textures) -> Sample {
    let is_leaf = column < 5;
    let base = StandardMaterial {
        diffuse_transmission: match column {
            0..5 => (column + 1) as f32 / 5.0,
            _ => 0.8,
        },
        thickness: match column {
            0..5 => 0.0,
            _ => (column - 5) as f32 * 0.5,
        },
        double_sided: is_leaf,
        cull_mode: (!is_leaf).then_some(bevy::render::render_resource::Face::Back),
        ..base(Color::srgb(0.4, 0.75, 0.2), 0.0, 0.7)
    };
    Sample {
        base,
        shape: if is_leaf { Shape::Leaf } else { Shape::Ball },
        ..default()
    }
}

fn unlit(column: usize, _: &Textures) -> Sample {
    let color = match column {
        0 => Color::srgb(0.05, 0.05, 0.05),
        1 => Color::srgb(0.9, 0.2, 0.1),
        2 => Color::srgb(0.1, 0.6, 0.2),
        3 => Color::srgb(0.2, 0.3, 0.9),
        4 => Color::srgb(0.8, 0.8, 0.8),
        _ => (LinearRgba::rgb(1.0, 0.4, 0.1) * 4f32.powi(column as i32 - 5)).into(),
    };
    StandardMaterial {
        base_color: color,
        unlit: true,
        ..default()
    }
    .into()
}

fn rim(column: usize, _: &Textures) -> Sample {
    let (color, exponent) = pair(column, COLORS, [1.0, 2.0, 5.0]);
    Sample {
        base: base(Color::srgb(0.08, 0.08, 0.1), 0.0, 0.8),
        extension: ShadingExtension::Rim { color, exponent },
        ..default()
    }
}

/// Materials that scatter light: in skin red travels furthest, in jade green.
fn subsurface(column: usize, _: &Textures) -> Sample {
    const PATHS: [f32; 9] = [0.001, 0.003, 0.01, 0.03, 0.1, 0.03, 0.01, 0.01, 0.01];
    const SHAPES: [Shape; 3] = [Shape::ThinSlab, Shape::ThickSlab, Shape::Bust];
    let skin = (LinearRgba::rgb(1.0, 0.35, 0.2), Color::srgb(0.85, 0.7, 0.6));
    let jade = (
        LinearRgba::rgb(0.3, 1.0, 0.5),
        Color::srgb(0.35, 0.65, 0.45),
    );
    let (color, base_color) = if column == 5 { jade } else { skin };
    Sample {
        base: base(base_color, 0.0, 0.5),
        extension: ShadingExtension::Subsurface {
            color: color.into(),
            mean_free_path: PATHS[column % PATHS.len()],
            albedo: default(),
        },
        shape: column
            .checked_sub(6)
            .and_then(|last| SHAPES.get(last).copied())
            .unwrap_or_default(),
        ..default()
    }
}

fn fog(column: usize, _: &Textures) -> Sample {
    StandardMaterial {
        fog_enabled: column.is_multiple_of(2),
        ..clay()
    }
    .into()
}

fn shadows(column: usize, _: &Textures) -> Sample {
    Sample {
        base: clay(),
        ignores_shadows: !column.is_multiple_of(2),
        ..default()
    }
}

fn lightmap(column: usize, _: &Textures) -> Sample {
    let base = StandardMaterial {
        lightmap_exposure: match column {
            0..5 => 250.0 * 2f32.powi(column as i32),
            _ => 2000.0,
        },
        emissive: if column >= 7 {
            LinearRgba::rgb(0.0, 0.1, 0.2)
        } else {
            LinearRgba::BLACK
        },
        ..base(Color::srgb(0.8, 0.8, 0.8), 0.0, 0.7)
    };
    Sample {
        base,
        lightmap: Some(column >= 5),
        ..default()
    }
}

fn combined(column: usize, textures: &Textures) -> Sample {
    let (model, what) = (column % 4, column / 4);
    let mut sample = match model {
        0 => clearcoat(8, textures),
        1 => anisotropy(8, textures),
        2 => diffuse_transmission(7, textures),
        _ => rim(3, textures),
    };
    match what {
        0 => sample.base.emissive = LinearRgba::rgb(0.0, 0.05, 0.1),
        1 => sample.base.fog_enabled = false,
        _ => sample.ignores_shadows = true,
    }
    sample
}
