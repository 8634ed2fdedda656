//! Scenes of meshes that Bevy's passes draw, under many lights.

use bevy::{
    camera::visibility::RenderLayers,
    core_pipeline::prepass::DepthPrepass,
    light::NotShadowReceiver,
    pbr::{ContactShadows, DistanceFog, FogFalloff, Lightmap},
    prelude::*,
    render::render_resource::TextureFormat,
};
use kit::scenes::{SceneBuilder, build::indoor, materials::cube_with_second_uvs};

/// A scene, and the number of its meshes that the light functions light in Bevy's passes.
pub struct Subject {
    pub name: &'static str,
    pub lit: usize,
    /// Number of these that are blended.
    pub blended: usize,
    pub build: fn(&mut SceneBuilder),
}

impl Subject {
    const fn blended(name: &'static str, count: usize, build: fn(&mut SceneBuilder)) -> Self {
        Self {
            name,
            lit: count,
            blended: count,
            build,
        }
    }
}

/// Blended meshes, and opaque and alpha-masked ones that the G-buffer does not carry, in fog.
pub const LIGHTS: Subject = Subject {
    name: "lights",
    lit: 16,
    blended: 8,
    build: |s| {
        s.floor();
        glass(s, |_| {});
        glass(s, invisible);
        glass(s, |m| {
            m.alpha_mode = AlphaMode::Opaque;
            m.specular_tint = Color::srgb(0.2, 1.0, 0.3);
        });
        glass(s, |m| {
            m.alpha_mode = AlphaMode::Mask(0.2);
            m.depth_bias = 5.0;
        });
        s.lamps();
        moon(s);
        s.default_camera((indoor(), fog()));
    },
};

/// Special surfaces under an environment map and a rectangular light.
pub const ENVIRONMENT: Subject = Subject::blended("environment", 8, |s| {
    s.floor();
    glass(s, |m| {
        m.perceptual_roughness = 0.8;
        m.clearcoat = 0.8;
        m.clearcoat_perceptual_roughness = 0.1;
    });
    glass(s, |m| {
        m.diffuse_transmission = 0.6;
        m.thickness = 0.3;
    });
    s.lamps();
    s.rect_light();
    let map = s.environment_map(400.0);
    s.default_camera((indoor(), map));
});

/// Combinations of features, which repeat much of what the others show.
pub const FURTHER: &[Subject] = &[
    Subject::blended("modes", 16, |s| {
        s.floor();
        for mode in [
            AlphaMode::Add,
            AlphaMode::Multiply,
            AlphaMode::Premultiplied,
        ] {
            glass(s, |m| m.alpha_mode = mode);
        }
        // Its light is not multiplied by alpha.
        glass(s, |m| {
            invisible(m);
            m.alpha_mode = AlphaMode::Premultiplied;
        });
        s.lamps();
        s.default_camera((indoor(), fog()));
    }),
    Subject::blended("probes", 8, |s| {
        s.floor();
        glass(s, |_| {});
        glass(s, |m| {
            m.anisotropy_strength = 0.8;
            m.anisotropy_rotation = 0.7;
        });
        s.lamps();
        s.decal(Vec3::splat(3.0));
        let volume = s.irradiance_volume(300.0);
        s.probe(volume);
        let map = s.environment_map(400.0);
        s.default_camera((indoor(), map));
    }),
    Subject::blended("maps", 6, maps),
    Subject::blended("contact_shadows", 4, |s| {
        s.solids();
        glass(s, |m| m.base_color = Color::srgba(0.8, 0.8, 0.8, 0.9));
        s.lamps();
        s.default_camera((indoor(), DepthPrepass, ContactShadows::default()));
    }),
];

fn fog() -> DistanceFog {
    DistanceFog {
        color: Color::srgb(0.4, 0.5, 0.6),
        falloff: FogFalloff::Exponential { density: 0.1 },
        ..default()
    }
}

/// With alpha 0, and light that would show.
fn invisible(material: &mut StandardMaterial) {
    material.base_color.set_alpha(0.0);
    material.emissive = LinearRgba::rgb(0.0, 0.0, 2.0);
}

/// Meshes of a green glass with a change: three slanted cards and a ball, one of which receives no shadows.
fn glass(s: &mut SceneBuilder, change: impl Fn(&mut StandardMaterial)) {
    let mut material = StandardMaterial {
        base_color: Color::srgba(0.3, 0.8, 0.5, 0.6),
        perceptual_roughness: 0.35,
        alpha_mode: AlphaMode::Blend,
        double_sided: true,
        cull_mode: None,
        ..default()
    };
    change(&mut material);
    let material = s.add::<StandardMaterial>(material);
    let card = Mesh::from(Rectangle::new(1.6, 1.6));
    let ball = Sphere::new(0.7).mesh().uv(32, 16);
    for (index, mut mesh) in [card.clone(), card.clone(), card, ball]
        .into_iter()
        .enumerate()
    {
        mesh.generate_tangents()
            .expect("these meshes have all that tangents need");
        let at = index as f32;
        let place = Transform::from_xyz(1.3 * (at - 1.5), 0.8, 0.6 - 0.7 * at)
            .with_rotation(Quat::from_rotation_y(0.4 * at - 0.5));
        let mesh = s.add::<Mesh>(mesh);
        let glass = s.spawn((Mesh3d(mesh), MeshMaterial3d(material.clone()), place));
        if index == 1 {
            s.world().entity_mut(glass).insert(NotShadowReceiver);
        }
    }
}

/// Dim light with shadows from above and behind.
fn moon(s: &mut SceneBuilder) {
    s.spawn((
        DirectionalLight {
            illuminance: 60.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(2.0, 4.0, -1.5).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// Normal-mapped and emissive glass under a rectangle light, and lightmapped and unlit ones.
fn maps(s: &mut SceneBuilder) {
    s.floor();
    let bumps = s.bumps();
    glass(s, |m| {
        m.normal_map_texture = Some(bumps.clone());
        m.emissive = LinearRgba::rgb(2.0, 0.5, 4.0);
    });
    let image = s.image(32, TextureFormat::Rgba8UnormSrgb, |u, v| {
        [(u * 255.0) as u8, (v * 255.0) as u8, 60, 255]
    });
    for (x, unlit) in [(-1.2, false), (1.2, true)] {
        let cube = s.mesh(
            cube_with_second_uvs(),
            StandardMaterial {
                base_color: Color::srgba(1.0, 1.0, 1.0, 0.7),
                alpha_mode: AlphaMode::Blend,
                lightmap_exposure: 60.0,
                unlit,
                ..default()
            },
            Transform::from_xyz(x, 0.7, 1.3).with_scale(Vec3::splat(0.6)),
        );
        if !unlit {
            let image = image.clone();
            s.world()
                .entity_mut(cube)
                .insert(Lightmap { image, ..default() });
        }
    }
    s.lamps();
    s.rect_light();
    s.default_camera((
        indoor(),
        AmbientLight {
            brightness: 15.0,
            ..default()
        },
    ));
}

/// The layers of lights in [`layered`].
pub const LAYERS: [usize; 2] = [0, 3];

/// Glass on layer 3, under two lamps of each layer. Without the `others`, only lamps of layer 3 are there.
pub fn layered(s: &mut SceneBuilder, others: bool) {
    s.floor();
    glass(s, |_| {});
    let world = s.world();
    let mut meshes = world.query_filtered::<Entity, With<Mesh3d>>();
    let meshes: Vec<Entity> = meshes.iter(world).collect();
    for mesh in meshes {
        world
            .entity_mut(mesh)
            .insert(RenderLayers::layer(LAYERS[1]));
    }
    for (index, layer) in [LAYERS[0], LAYERS[1], LAYERS[0], LAYERS[1]]
        .into_iter()
        .enumerate()
    {
        if layer == LAYERS[0] && !others {
            continue;
        }
        let x = index as f32 - 1.5;
        s.spawn((
            PointLight {
                intensity: if layer == LAYERS[0] {
                    50_000.0
                } else {
                    2_500.0
                },
                range: 10.0,
                color: Color::srgb(1.0, 0.4 + 0.2 * index as f32, 0.5),
                ..default()
            },
            Transform::from_xyz(x, 2.0, 1.5),
            RenderLayers::layer(layer),
        ));
    }
    s.default_camera((indoor(), RenderLayers::from_layers(&LAYERS)));
}

/// A ball with this material under many lamps.
pub fn lamplit(s: &mut SceneBuilder, material: impl Bundle) {
    s.floor();
    let mesh = s.add::<Mesh>(Sphere::new(0.8).mesh().uv(24, 12));
    s.spawn((Mesh3d(mesh), material, Transform::from_xyz(0.0, 0.8, 0.0)));
    s.lamps();
    s.default_camera(indoor());
}
