//! The features that come and go.

use bevy::{
    anti_alias::taa::TemporalAntiAliasing,
    camera::visibility::RenderLayers,
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass},
    light::{ClusteredDecal, RectLight, ShadowFilteringMethod},
    prelude::*,
    render::camera::{MipBias, TemporalJitter},
};
use bevy_lean_deferred::prelude::*;

use super::{
    Walk,
    changes::{ball, cut, hud, many_lights, point_light, probe, resize, set_levels, spot_light},
};
use crate::{renderer::Renderer, scenes::special_materials::put_lightmaps};

/// A part of the level, or a setting of its camera, that comes and goes.
pub struct Feature {
    pub name: &'static str,
    /// Returns the spawned entities, which are despawned when it goes.
    pub(super) come: fn(&mut Walk) -> Vec<Entity>,
    /// Reverts all else.
    pub(super) go: fn(&mut Walk),
}

impl Feature {
    const fn new(name: &'static str, come: fn(&mut Walk) -> Vec<Entity>) -> Self {
        Self {
            name,
            come,
            go: |_| {},
        }
    }

    const fn reverted_by(mut self, go: fn(&mut Walk)) -> Self {
        self.go = go;
        self
    }
}

/// All features, in the order in which they come. Environment maps are gone when lightmaps come: without binding arrays, Bevy's shader for
/// both does not compile.
pub const FEATURES: &[Feature] = &[
    Feature::new("directional light", |walk| vec![walk.scene().sun(false)]),
    Feature::new("shadowed directional light", |walk| {
        vec![walk.scene().sun(true)]
    }),
    Feature::new("shadow filter", |walk| {
        let filter = ShadowFilteringMethod::Hardware2x2;
        walk.camera_mut().insert(filter);
        vec![]
    })
    .reverted_by(|walk| {
        let filter = ShadowFilteringMethod::default();
        walk.camera_mut().insert(filter);
    }),
    Feature::new("point light", |walk| point_light(walk, false)),
    Feature::new("shadowed point light", |walk| point_light(walk, true)),
    Feature::new("spot light", |walk| spot_light(walk, false)),
    Feature::new("shadowed spot light", |walk| spot_light(walk, true)),
    Feature::new("rectangular light", |walk| {
        let light = RectLight {
            intensity: 400_000.0,
            width: 2.0,
            height: 1.0,
            ..default()
        };
        let place = Transform::from_translation(walk.ahead(0.0, 2.5, 2.0));
        let target = walk.ahead(0.0, 0.0, 5.0);
        vec![
            walk.scene()
                .spawn((light, place.looking_at(target, Vec3::Y))),
        ]
    }),
    Feature::new("2,100 lights", many_lights),
    Feature::new("decal", |walk| {
        let checker = walk.scene().checker([240, 60, 40, 255], [40, 60, 240, 90]);
        let decal = ClusteredDecal {
            base_color_texture: Some(checker),
            ..default()
        };
        let place = Transform::from_translation(walk.ahead(0.0, 0.5, 4.0))
            .looking_to(Vec3::NEG_Y, Vec3::Z)
            .with_scale(Vec3::splat(3.0));
        vec![walk.scene().spawn((decal, place))]
    }),
    Feature::new("fog", |walk| {
        walk.camera_mut().insert(DistanceFog {
            falloff: FogFalloff::from_visibility(20.0),
            ..default()
        });
        vec![]
    })
    .reverted_by(|walk| {
        walk.camera_mut().remove::<DistanceFog>();
    }),
    Feature::new("environment map", |walk| {
        let light = walk.scene().environment_map(600.0);
        walk.camera_mut().insert(light);
        vec![]
    })
    .reverted_by(|walk| {
        walk.camera_mut().remove::<EnvironmentMapLight>();
    }),
    Feature::new("reflection probe", |walk| {
        let light = walk.scene().environment_map(1500.0);
        probe(walk, light)
    }),
    Feature::new("irradiance volume", |walk| {
        let volume = walk.scene().irradiance_volume(1500.0);
        probe(walk, volume)
    }),
    Feature::new("emissive material", |walk| {
        ball(walk, |material| {
            material.emissive = LinearRgba::rgb(0.1, 0.6, 0.3);
        })
    }),
    Feature::new("reflectance", |walk| {
        ball(walk, |material| material.reflectance = 1.0)
    }),
    Feature::new("clearcoat", |walk| {
        ball(walk, |material| material.clearcoat = 1.0)
    }),
    Feature::new("anisotropy", |walk| {
        ball(walk, |material| material.anisotropy_strength = 0.8)
    }),
    Feature::new("diffuse transmission", |walk| {
        ball(walk, |material| {
            material.diffuse_transmission = 0.7;
            material.thickness = 0.2;
        })
    }),
    Feature::new("unlit material", |walk| {
        ball(walk, |material| material.unlit = true)
    }),
    Feature::new("specular transmission", |walk| {
        ball(walk, |material| {
            material.specular_transmission = 0.9;
            material.thickness = 0.5;
        })
    }),
    Feature::new("blended material", |walk| {
        ball(walk, |material| {
            material.alpha_mode = AlphaMode::Blend;
            material.base_color.set_alpha(0.5);
        })
    }),
    Feature::new("lightmap", |walk| {
        let balls = ball(walk, |material| material.lightmap_exposure = 1500.0);
        put_lightmaps(&mut walk.scene(), &balls, false);
        balls
    }),
    Feature::new("light layers", |walk| {
        let mut entities = ball(walk, |_| {});
        let both = RenderLayers::from_layers(&[0, 1]);
        let world = walk.headless.world();
        world.entity_mut(entities[0]).insert(both.clone());
        walk.camera_mut().insert(both);
        let lights = point_light(walk, false);
        let world = walk.headless.world();
        world.entity_mut(lights[0]).insert(RenderLayers::layer(1));
        entities.extend(lights);
        entities
    })
    .reverted_by(|walk| {
        walk.camera_mut().remove::<RenderLayers>();
    }),
    // A camera for meshes does not draw it, but its visible entities are of one more class.
    Feature::new("sprite", |walk| {
        let place = Transform::from_translation(walk.ahead(0.0, 1.0, 4.0));
        let sprite = Sprite::from_color(Color::WHITE, Vec2::ONE);
        vec![walk.scene().spawn((sprite, place))]
    }),
    Feature::new("HUD camera", hud),
    Feature::new("ambient occlusion", |walk| {
        // GI finds occlusion too.
        if walk.renderer == Renderer::Lean && !walk.camera_mut().contains::<LeanScreenSpaceGi>() {
            let occlusion = LeanScreenSpaceAmbientOcclusion::default();
            walk.camera_mut().insert(occlusion);
        }
        vec![]
    })
    .reverted_by(|walk| {
        walk.camera_mut()
            .remove::<LeanScreenSpaceAmbientOcclusion>();
    }),
    Feature::new("TAA", |walk| {
        walk.camera_mut().insert(TemporalAntiAliasing::default());
        vec![]
    })
    .reverted_by(|walk| {
        let renderer = walk.renderer;
        let mut camera = walk.camera_mut();
        camera.remove::<(TemporalAntiAliasing, TemporalJitter, MipBias)>();
        // Bevy's deferred renderer needs depth, and Bevy 0.19 fails if motion vectors go while depth stays.
        if renderer != Renderer::BevyDeferred {
            camera.remove::<(DepthPrepass, MotionVectorPrepass)>();
        }
    }),
    Feature::new("quality of effects", |walk| {
        set_levels(walk, LeanQuality::High, LeanResolution::Half);
        vec![]
    })
    .reverted_by(|walk| set_levels(walk, LeanQuality::Medium, LeanResolution::Half)),
    Feature::new("resolution of effects", |walk| {
        set_levels(walk, LeanQuality::Medium, LeanResolution::Full);
        vec![]
    })
    .reverted_by(|walk| set_levels(walk, LeanQuality::Medium, LeanResolution::Half)),
    Feature::new("resize", |walk| {
        let size = walk.headless.size * 3 / 4;
        resize(walk, size);
        vec![]
    })
    .reverted_by(|walk| {
        let size = walk.headless.size;
        resize(walk, size);
    }),
    Feature::new("cut", |walk| {
        cut(walk, 0.6);
        vec![]
    })
    .reverted_by(|walk| cut(walk, 0.0)),
];
