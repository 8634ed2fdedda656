//! Every property of `StandardMaterial` and of meshes that is drawn forward, among materials that the G-buffer carries.

use bevy::{
    light::NotShadowReceiver,
    material::OpaqueRendererMethod,
    pbr::{DistanceFog, FogFalloff, Lightmap},
    prelude::*,
    render::render_resource::TextureFormat,
};

use super::{
    Scene, SceneBuilder,
    build::{ambient, material},
    materials::{cube_with_second_uvs, red},
};

pub const SCENES: &[Scene] = &[
    Scene::new("emissive", |s| {
        among(s, |m| m.emissive = LinearRgba::rgb(0.1, 0.4, 0.1))
    }),
    Scene::new("clearcoat", |s| among(s, |m| m.clearcoat = 1.0)).nightly(),
    Scene::new("anisotropy", |s| {
        among(s, |m| {
            m.anisotropy_strength = 0.9;
            m.anisotropy_rotation = 0.7;
            m.metallic = 1.0;
        })
    })
    .nightly(),
    Scene::new("reflectance", |s| among(s, |m| m.reflectance = 1.0)),
    Scene::new("specular_tint", |s| {
        among(s, |m| {
            m.specular_tint = Color::srgb(0.1, 1.0, 0.1);
            m.perceptual_roughness = 0.3;
        })
    }),
    Scene::new("unlit", |s| among(s, |m| m.unlit = true)).nightly(),
    Scene::new("specular_transmission", |s| {
        among(s, |m| {
            m.base_color = Color::srgb(0.9, 1.0, 0.9);
            m.specular_transmission = 0.9;
            m.thickness = 0.5;
            m.perceptual_roughness = 0.1;
        })
    })
    .nightly(),
    Scene::new("diffuse_transmission", |s| {
        among(s, |m| m.diffuse_transmission = 0.8)
    }),
    Scene::new("alpha_blend", |s| transparent(s, AlphaMode::Blend)),
    Scene::new("alpha_add", |s| transparent(s, AlphaMode::Add)).nightly(),
    Scene::new("alpha_multiply", |s| transparent(s, AlphaMode::Multiply)).nightly(),
    Scene::new("alpha_premultiplied", |s| {
        transparent(s, AlphaMode::Premultiplied)
    })
    .nightly(),
    // `Deferred` is in `parity.rs`: Bevy does not draw it on a camera without `DeferredPrepass`.
    Scene::new("method_forward", |s| {
        among(s, |m| {
            m.opaque_render_method = OpaqueRendererMethod::Forward
        })
    }),
    Scene::new("fog_disabled", |s| {
        s.among_lean(StandardMaterial {
            fog_enabled: false,
            ..red()
        });
        s.sun(true);
        s.default_camera(DistanceFog {
            color: Color::srgb(0.4, 0.5, 0.6),
            falloff: FogFalloff::Exponential { density: 0.2 },
            ..default()
        });
    }),
    Scene::new("depth_bias", |s| {
        s.floor();
        for (x, depth_bias) in [(-1.5, 0.0), (0.0, 20_000.0), (1.5, -20_000.0)] {
            s.mesh(
                Cuboid::new(1.0, 0.01, 1.0),
                StandardMaterial {
                    depth_bias,
                    ..red()
                },
                Transform::from_xyz(x, 0.001, 0.0),
            );
        }
        s.sun(true);
        s.default_camera(ambient());
    }),
    Scene::new("not_shadow_receiver", |s| {
        let floor = s.floor();
        s.world().entity_mut(floor).insert(NotShadowReceiver);
        s.mesh(
            Cuboid::new(8.0, 0.1, 0.5),
            red(),
            Transform::from_xyz(0.0, 1.8, 0.6),
        );
        for (x, receives) in [(-1.0, true), (1.0, false)] {
            let ball = s.mesh(
                Sphere::new(0.6),
                material((0.3, 0.7, 0.4), 0.0, 0.6),
                Transform::from_xyz(x, 0.6, 0.0),
            );
            if !receives {
                s.world().entity_mut(ball).insert(NotShadowReceiver);
            }
        }
        s.sun(true);
        s.default_camera(ambient());
    }),
    Scene::new("lightmap", |s| {
        s.solids();
        let image = s.image(64, TextureFormat::Rgba8UnormSrgb, |u, v| {
            [(u * 255.0) as u8, (v * 255.0) as u8, 60, 255]
        });
        let cube = s.mesh(
            cube_with_second_uvs(),
            StandardMaterial {
                base_color: Color::WHITE,
                lightmap_exposure: 3000.0,
                ..default()
            },
            Transform::from_xyz(0.2, 1.2, 0.6),
        );
        s.world()
            .entity_mut(cube)
            .insert(Lightmap { image, ..default() });
        s.sun(true);
        s.default_camera(());
    }),
];

/// [`SceneBuilder::among_lean`] with a changed red material, in sun and ambient light.
fn among(s: &mut SceneBuilder, change: impl Fn(&mut StandardMaterial)) {
    let mut material = red();
    change(&mut material);
    s.among_lean(material);
    s.sun(true);
    s.default_camera(ambient());
}

fn transparent(s: &mut SceneBuilder, alpha_mode: AlphaMode) {
    cards(s, alpha_mode);
    s.sun(true);
    s.default_camera(ambient());
}

/// Solids, and one transparent card in front of all of them, one between them, one behind them.
pub fn cards(s: &mut SceneBuilder, alpha_mode: AlphaMode) {
    s.solids();
    for (z, color) in [
        (1.8, Color::srgba(0.9, 0.3, 0.2, 0.5)),
        (0.2, Color::srgba(0.3, 0.9, 0.2, 0.5)),
        (-2.6, Color::srgba(0.2, 0.3, 0.9, 0.5)),
    ] {
        s.mesh(
            Rectangle::new(2.0, 1.6),
            StandardMaterial {
                base_color: color,
                alpha_mode,
                ..default()
            },
            Transform::from_xyz(-z * 0.5, 0.9, z),
        );
    }
}
