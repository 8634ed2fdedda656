//! Every kind of light, shadow, probe and fog.

use bevy::{
    core_pipeline::Skybox,
    light::{
        AmbientLight, CascadeShadowConfigBuilder, DirectionalLightTexture, FogVolume,
        IrradianceVolume, LightProbe, PointLight, ShadowFilteringMethod, SpotLight,
        SpotLightTexture, VolumetricFog, VolumetricLight,
    },
    pbr::{ContactShadows, DistanceFog, FogFalloff, ScreenSpaceAmbientOcclusion},
    prelude::*,
};

use super::{Scene, SceneBuilder, build::indoor};

pub const SCENES: &[Scene] = &[
    Scene::new("directional", |s| {
        s.solids();
        s.sun(false);
        s.default_camera(());
    })
    .nightly(),
    Scene::new("directional_shadow_cascades", |s| {
        s.solids();
        let sun = s.sun(true);
        let cascades = CascadeShadowConfigBuilder {
            num_cascades: 3,
            maximum_distance: 20.0,
            ..default()
        };
        s.world().entity_mut(sun).insert(cascades.build());
        s.default_camera(());
    }),
    Scene::new("shadow_filter_hardware", |s| {
        s.solids();
        s.sun(true);
        s.default_camera(ShadowFilteringMethod::Hardware2x2);
    }),
    Scene::new("point", |s| {
        s.solids();
        points(s, false);
        s.default_camera(indoor());
    })
    .nightly(),
    Scene::new("point_shadow", |s| {
        s.solids();
        points(s, true);
        s.default_camera(indoor());
    }),
    Scene::new("spot", |s| {
        s.solids();
        spot(s, false);
        s.default_camera(indoor());
    })
    .nightly(),
    Scene::new("spot_shadow", |s| {
        s.solids();
        spot(s, true);
        s.default_camera(indoor());
    })
    .nightly(),
    Scene::new("rect", |s| {
        s.solids();
        s.rect_light();
        s.default_camera(indoor());
    }),
    Scene::new("ambient", |s| {
        s.solids();
        s.default_camera(AmbientLight {
            color: Color::srgb(0.8, 0.9, 1.0),
            brightness: 900.0,
            ..default()
        });
    }),
    Scene::new("environment_map", |s| {
        s.solids();
        let light = s.environment_map(1500.0);
        s.default_camera(light);
    }),
    Scene::new("reflection_probe", |s| {
        s.solids();
        let light = s.environment_map(1500.0);
        s.probe(light);
        s.sun(false);
        s.default_camera(());
    }),
    Scene::new("irradiance_volume", |s| {
        s.solids();
        let volume = s.irradiance_volume(1500.0);
        s.probe(volume.clone());
        // Bright up to its faces.
        s.spawn((
            LightProbe {
                falloff: Vec3::ZERO,
            },
            IrradianceVolume {
                intensity: 6000.0,
                ..volume
            },
            Transform::from_xyz(0.5, 0.5, 0.0).with_scale(Vec3::new(3.0, 1.6, 3.0)),
        ));
        s.default_camera(());
    }),
    Scene::new("fog_linear", |s| {
        fog(
            s,
            FogFalloff::Linear {
                start: 3.0,
                end: 12.0,
            },
        )
    })
    .nightly(),
    Scene::new("fog_exponential", |s| {
        fog(s, FogFalloff::Exponential { density: 0.12 })
    })
    .nightly(),
    Scene::new("fog_atmospheric", |s| {
        fog(
            s,
            FogFalloff::from_visibility_colors(
                20.0,
                Color::srgb(0.4, 0.5, 0.6),
                Color::srgb(0.7, 0.8, 1.0),
            ),
        )
    }),
    Scene::new("contact_shadows", |s| {
        s.solids();
        let sun = s.sun(true);
        s.world()
            .get_mut::<DirectionalLight>(sun)
            .unwrap()
            .contact_shadows_enabled = true;
        s.default_camera(ContactShadows::default());
    }),
    Scene::new("bevy_ssao", |s| {
        s.solids();
        s.default_camera((
            ScreenSpaceAmbientOcclusion::default(),
            AmbientLight {
                brightness: 1200.0,
                ..default()
            },
        ));
    }),
    Scene::new("skybox", |s| {
        s.solids();
        s.sun(true);
        let image = s.cube_map();
        s.default_camera(Skybox {
            image: Some(image),
            brightness: 1000.0,
            ..default()
        });
    })
    .nightly(),
    Scene::new("volumetric_fog", |s| {
        s.solids();
        let sun = s.sun(true);
        s.world().entity_mut(sun).insert(VolumetricLight);
        s.spawn((
            FogVolume::default(),
            Transform::from_scale(Vec3::splat(10.0)),
        ));
        s.default_camera(VolumetricFog {
            step_count: 16,
            ..default()
        });
    }),
    Scene::new("clustered_decal", |s| {
        s.solids();
        s.sun(true);
        s.decal(Vec3::new(4.0, 3.0, 3.0));
        s.default_camera(());
    })
    .needs_binding_arrays()
    .nightly(),
    Scene::new("light_textures", |s| {
        s.solids();
        let image = s.checker([255, 255, 255, 255], [20, 20, 60, 255]);
        let light = spot(s, true);
        s.world().entity_mut(light).insert(SpotLightTexture {
            image: image.clone(),
        });
        let sun = s.sun(true);
        s.world()
            .entity_mut(sun)
            .insert(DirectionalLightTexture { image, tiled: true });
        s.default_camera(indoor());
    })
    .needs_binding_arrays()
    .nightly(),
    Scene::new("many_lights_of_all_kinds", |s| {
        s.solids();
        points(s, true);
        spot(s, true);
        s.sun(true);
        s.default_camera(());
    }),
];

fn points(s: &mut SceneBuilder, shadow_maps_enabled: bool) {
    for (position, color) in [
        (Vec3::new(-2.0, 2.2, 1.8), Color::srgb(1.0, 0.7, 0.4)),
        (Vec3::new(2.2, 1.6, 1.0), Color::srgb(0.4, 0.7, 1.0)),
        (Vec3::new(0.0, 1.5, -3.0), Color::srgb(0.7, 1.0, 0.7)),
    ] {
        s.spawn((
            PointLight {
                color,
                intensity: 30_000.0,
                range: 12.0,
                shadow_maps_enabled,
                ..default()
            },
            Transform::from_translation(position),
        ));
    }
}

fn spot(s: &mut SceneBuilder, shadow_maps_enabled: bool) -> Entity {
    s.spawn((
        SpotLight {
            intensity: 120_000.0,
            range: 15.0,
            inner_angle: 0.4,
            outer_angle: 0.6,
            shadow_maps_enabled,
            ..default()
        },
        Transform::from_xyz(2.0, 4.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ))
}

fn fog(s: &mut SceneBuilder, falloff: FogFalloff) {
    s.solids();
    s.sun(true);
    s.default_camera(DistanceFog {
        color: Color::srgb(0.4, 0.5, 0.6),
        directional_light_color: Color::srgba(1.0, 0.9, 0.7, 0.5),
        directional_light_exponent: 20.0,
        falloff,
    });
}
