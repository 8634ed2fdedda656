//! Surfaces with special shading models, emission and lightmaps, under every light and with every texture that affects them.

use bevy::{
    core_pipeline::Skybox,
    light::{
        AmbientLight, EnvironmentMapLight, IrradianceVolume, NotShadowReceiver, PointLight,
        SpotLight, TransmittedShadowReceiver,
    },
    mesh::UvChannel,
    pbr::{ContactShadows, DistanceFog, FogFalloff, Lightmap, ScreenSpaceAmbientOcclusion},
    prelude::*,
    render::render_resource::TextureFormat,
};

use super::{
    Scene, SceneBuilder,
    build::{ambient, indoor, material},
};

pub const SCENES: &[Scene] = &[
    Scene::new("special_sun_and_ambient", |s| {
        gallery(s);
        s.sun(true);
        s.default_camera(ambient());
    }),
    Scene::new("special_clustered_lights", |s| {
        gallery(s);
        for (x, shadow_maps_enabled) in [(-2.0, true), (2.0, false)] {
            s.spawn((
                PointLight {
                    intensity: 30_000.0,
                    range: 12.0,
                    shadow_maps_enabled,
                    ..default()
                },
                Transform::from_xyz(x, 2.0, 1.5),
            ));
            s.spawn((
                SpotLight {
                    intensity: 100_000.0,
                    range: 15.0,
                    shadow_maps_enabled,
                    ..default()
                },
                Transform::from_xyz(x, 4.0, -2.0).looking_at(Vec3::ZERO, Vec3::Y),
            ));
        }
        s.default_camera(indoor());
    }),
    Scene::new("special_rect_light", |s| {
        gallery(s);
        s.rect_light();
        s.default_camera(indoor());
    }),
    Scene::new("special_environment_map", |s| {
        gallery(s);
        let light = s.environment_map(1500.0);
        let sky = Skybox {
            image: Some(light.specular_map.clone()),
            brightness: 1000.0,
            ..default()
        };
        s.default_camera((light, sky));
    }),
    Scene::new("special_environment_map_and_sun", |s| {
        gallery(s);
        s.sun(true);
        let light = s.environment_map(1500.0);
        s.default_camera(light);
    })
    .nightly(),
    Scene::new("special_reflection_probe", |s| {
        gallery(s);
        let light = s.environment_map(1500.0);
        s.probe(light);
        s.sun(false);
        s.default_camera(());
    })
    .nightly(),
    Scene::new("special_irradiance_volume", |s| {
        gallery(s);
        let volume = s.irradiance_volume(1500.0);
        s.probe(volume);
        s.default_camera(());
    }),
    Scene::new("special_bevy_ssao", |s| {
        gallery(s);
        s.default_camera((
            ScreenSpaceAmbientOcclusion::default(),
            AmbientLight {
                brightness: 1200.0,
                ..default()
            },
        ));
    })
    .nightly(),
    Scene::new("special_contact_shadows", |s| {
        gallery(s);
        let sun = s.sun(true);
        let mut sun = s.world().entity_mut(sun);
        let mut sun = sun.get_mut::<DirectionalLight>().expect("it is one");
        sun.contact_shadows_enabled = true;
        s.default_camera(ContactShadows::default());
    })
    .nightly(),
    Scene::new("special_fog", |s| {
        gallery(s);
        s.sun(true);
        s.default_camera(DistanceFog {
            color: Color::srgb(0.4, 0.5, 0.6),
            falloff: FogFalloff::Exponential { density: 0.12 },
            ..default()
        });
    })
    .nightly(),
    Scene::new("special_decal", |s| {
        gallery(s);
        s.sun(true);
        s.decal(Vec3::new(6.0, 4.0, 3.0));
        s.default_camera(());
    })
    .needs_binding_arrays()
    .nightly(),
    Scene::new("special_orthographic", |s| {
        gallery(s);
        s.sun(true);
        let projection = Projection::Orthographic(OrthographicProjection {
            scale: 0.016,
            ..OrthographicProjection::default_3d()
        });
        s.default_camera((projection, ambient()));
    })
    .nightly(),
    Scene::new("special_without_shadows", |s| {
        for ball in gallery(s) {
            s.world().entity_mut(ball).insert(NotShadowReceiver);
        }
        s.sun(true);
        s.default_camera(ambient());
    })
    .nightly(),
    Scene::new("special_normal_map", |s| {
        let bumps = s.bumps();
        gallery_of(s, |material| {
            // Clearcoat and anisotropy over a normal map are drawn forward.
            material.normal_map_texture = Some(bumps.clone());
        });
        s.sun(true);
        s.default_camera(ambient());
    }),
    Scene::new("special_textures", |s| {
        let image = s.tiled_image(64, TextureFormat::Rgba8Unorm, |u, v| {
            let wave = |x: f32| (127.5 + 127.5 * (x * 12.0).sin()) as u8;
            [wave(u), wave(v), wave(u + v), wave(u - v)]
        });
        gallery_of(s, |material| {
            let image = Some(image.clone());
            material.base_color_texture = image.clone();
            material.emissive_texture = image.clone();
            material.specular_texture = image.clone();
            material.clearcoat_texture = image.clone();
            material.clearcoat_roughness_texture = image.clone();
            material.anisotropy_texture = image.clone();
            material.diffuse_transmission_texture = image.clone();
            material.thickness_texture = image;
        });
        s.sun(true);
        s.default_camera(ambient());
    }),
    Scene::new("special_second_uvs", |s| {
        let checker = s.checker([255, 255, 255, 255], [60, 90, 30, 128]);
        let balls = gallery_of(s, |material| {
            material.emissive_texture = Some(checker.clone());
            material.emissive_channel = UvChannel::Uv1;
            material.clearcoat_texture = Some(checker.clone());
            material.clearcoat_channel = UvChannel::Uv1;
        });
        with_second_uvs(s, &balls);
        s.sun(true);
        s.default_camera(ambient());
    })
    .nightly(),
    Scene::new("special_exposed_emission", |s| {
        gallery_of(s, |material| {
            material.emissive = LinearRgba::rgb(300.0, 900.0, 200.0);
            material.emissive_exposure_weight = 1.0;
        });
        s.sun(true);
        s.default_camera(ambient());
    }),
    Scene::new("special_transmitted_shadows", |s| {
        s.floor();
        s.mesh(
            Cuboid::new(6.0, 0.1, 0.4),
            material((0.4, 0.4, 0.4), 0.0, 0.6),
            Transform::from_xyz(0.0, 2.0, -1.4),
        );
        for (x, receives) in [(-1.2, true), (1.2, false)] {
            let leaf = s.mesh(
                Rectangle::new(1.6, 1.6),
                StandardMaterial {
                    diffuse_transmission: 0.8,
                    thickness: 0.1,
                    ..material((0.3, 0.7, 0.2), 0.0, 0.8)
                },
                Transform::from_xyz(x, 0.9, 0.0),
            );
            if receives {
                s.world().entity_mut(leaf).insert(TransmittedShadowReceiver);
            }
        }
        s.spawn((
            DirectionalLight {
                illuminance: 6_000.0,
                shadow_maps_enabled: true,
                ..default()
            },
            Transform::from_xyz(0.0, 3.0, -4.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
        s.default_camera(ambient());
    }),
    Scene::new("lightmapped_specials", |s| {
        lightmapped(s, false);
        s.sun(true);
        s.default_camera(ambient());
    })
    .nightly(),
    Scene::new("lightmapped_specials_bicubic", |s| {
        lightmapped(s, true);
        s.sun(false);
        s.default_camera(ambient());
    }),
    // The lightmap has the diffuse light of some of the lights.
    Scene::new("lightmapped_plain", |s| {
        baked_corner(s);
        for (x, affects_lightmapped_mesh_diffuse) in [(-1.5, false), (1.5, true)] {
            s.spawn((
                PointLight {
                    intensity: 30_000.0,
                    range: 12.0,
                    affects_lightmapped_mesh_diffuse,
                    ..default()
                },
                Transform::from_xyz(x, 2.0, 1.5),
            ));
            s.spawn((
                SpotLight {
                    intensity: 100_000.0,
                    affects_lightmapped_mesh_diffuse,
                    ..default()
                },
                Transform::from_xyz(x, 3.0, 1.0).looking_at(Vec3::ZERO, Vec3::Z),
            ));
        }
        s.spawn((
            DirectionalLight {
                illuminance: 6_000.0,
                shadow_maps_enabled: true,
                affects_lightmapped_mesh_diffuse: false,
                ..default()
            },
            Transform::from_xyz(2.0, 3.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
        s.default_camera(AmbientLight {
            brightness: 1_000.0,
            affects_lightmapped_meshes: false,
            ..default()
        });
    }),
    // Bevy's lightmaps hold no transmitted ambient light.
    Scene::new("lightmapped_specials_ambient_light_apart", |s| {
        lightmapped(s, false);
        s.default_camera(AmbientLight {
            brightness: 2_000.0,
            affects_lightmapped_meshes: false,
            ..default()
        });
    }),
    // Without binding arrays Bevy compiles neither forward nor deferred shaders for this: nothing is drawn.
    Scene::new("lightmapped_specials_environment_map", |s| {
        lightmapped(s, false);
        let light = s.environment_map(1500.0);
        s.default_camera(light);
    })
    .needs_binding_arrays()
    .nightly(),
    // In the next two scenes only the floor, which has no lightmap, takes the diffuse light.
    Scene::new("lightmapped_specials_irradiance_volume", |s| {
        lightmapped(s, false);
        let volume = s.irradiance_volume(1500.0);
        s.probe(IrradianceVolume {
            affects_lightmapped_meshes: false,
            ..volume
        });
        s.default_camera(());
    }),
    Scene::new("lightmapped_specials_environment_map_apart", |s| {
        lightmapped(s, false);
        let light = s.environment_map(1500.0);
        s.default_camera(EnvironmentMapLight {
            affects_lightmapped_mesh_diffuse: false,
            ..light
        });
    })
    .needs_binding_arrays()
    .nightly(),
];

/// One material of each kind.
fn kinds() -> [StandardMaterial; 8] {
    let base = |metallic| material((0.75, 0.4, 0.25), metallic, 0.35);
    [
        StandardMaterial {
            emissive: LinearRgba::rgb(0.05, 0.2, 0.05),
            ..base(0.0)
        },
        StandardMaterial {
            reflectance: 1.0,
            ..base(0.0)
        },
        StandardMaterial {
            clearcoat: 1.0,
            clearcoat_perceptual_roughness: 0.1,
            ..base(0.0)
        },
        StandardMaterial {
            anisotropy_strength: 0.8,
            anisotropy_rotation: 0.5,
            ..base(1.0)
        },
        StandardMaterial {
            diffuse_transmission: 0.7,
            thickness: 0.2,
            ..base(0.0)
        },
        StandardMaterial {
            unlit: true,
            ..base(0.0)
        },
        StandardMaterial {
            fog_enabled: false,
            ..base(0.3)
        },
        StandardMaterial {
            emissive: LinearRgba::rgb(0.0, 0.05, 0.2),
            anisotropy_strength: 0.5,
            reflectance: 0.8,
            ..base(0.5)
        },
    ]
}

fn gallery(s: &mut SceneBuilder) -> Vec<Entity> {
    gallery_of(s, |_| {})
}

/// A ball of each kind, modified by `change`, in two rows on a floor.
fn gallery_of(s: &mut SceneBuilder, change: impl Fn(&mut StandardMaterial)) -> Vec<Entity> {
    s.floor();
    let ball = Sphere::new(0.5)
        .mesh()
        .uv(48, 24)
        .with_generated_tangents()
        .expect("a sphere has all that tangents need");
    let mut place = |(i, mut material): (usize, StandardMaterial)| {
        change(&mut material);
        let (column, row) = ((i % 4) as f32, (i / 4) as f32);
        let x = (column - 1.5) * 1.25 + row * 0.5;
        s.mesh(
            ball.clone(),
            material,
            Transform::from_xyz(x, 0.5, 1.0 - row * 1.6),
        )
    };
    kinds().into_iter().enumerate().map(&mut place).collect()
}

/// A corner of plain surfaces with a lightmap, and a ball without one.
fn baked_corner(s: &mut SceneBuilder) {
    let baked = [
        (Vec3::new(8.0, 0.1, 6.0), Vec3::new(0.0, -0.05, 0.0)),
        (Vec3::new(8.0, 3.0, 0.1), Vec3::new(0.0, 1.5, -2.0)),
        (Vec3::ONE, Vec3::new(-0.9, 0.5, 0.0)),
    ]
    .map(|(size, position)| {
        s.mesh(
            Cuboid::from_size(size),
            StandardMaterial {
                lightmap_exposure: 1000.0,
                ..material((0.7, 0.6, 0.5), 0.2, 0.4)
            },
            Transform::from_translation(position),
        )
    });
    put_lightmaps(s, &baked, false);
    s.mesh(
        Sphere::new(0.5),
        material((0.3, 0.5, 0.7), 0.0, 0.4),
        Transform::from_xyz(0.9, 0.5, 0.4),
    );
}

/// The gallery with a lightmap on each ball.
fn lightmapped(s: &mut SceneBuilder, bicubic_sampling: bool) {
    let balls = gallery_of(s, |material| material.lightmap_exposure = 1500.0);
    put_lightmaps(s, &balls, bicubic_sampling);
}

/// Puts one lightmap on meshes, and gives them second UVs.
pub fn put_lightmaps(s: &mut SceneBuilder, entities: &[Entity], bicubic_sampling: bool) {
    with_second_uvs(s, entities);
    let image = s.image(16, TextureFormat::Rgba8UnormSrgb, |u, v| {
        [(u * 255.0) as u8, (v * 255.0) as u8, 60, 255]
    });
    for &entity in entities {
        s.world().entity_mut(entity).insert(Lightmap {
            image: image.clone(),
            bicubic_sampling,
            ..default()
        });
    }
}

fn with_second_uvs(s: &mut SceneBuilder, entities: &[Entity]) {
    for &entity in entities {
        let handle = s.world().get::<Mesh3d>(entity).expect("a mesh").0.clone();
        let mut meshes = s.world().resource_mut::<Assets<Mesh>>();
        let mut mesh = meshes.get_mut(&handle).expect("just added");
        let uvs = mesh.attribute(Mesh::ATTRIBUTE_UV_0).cloned();
        mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, uvs.expect("a ball has UVs"));
    }
}
