//! Occlusion in the pictures of lean cameras.

use bevy::{
    camera::Viewport,
    light::{EnvironmentMapLight, GlobalAmbientLight},
    prelude::*,
};
use bevy_lean_deferred::{
    effects::ambient_occlusion::{
        LeanScreenSpaceAmbientOcclusionAdvanced, OcclusionApplication, OcclusionFilter,
    },
    prelude::*,
};

use crate::stage::{Colors, Stage};
use kit::{
    log_watch,
    scenes::{SceneBuilder, special_materials::put_lightmaps},
};

fn default() -> LeanScreenSpaceAmbientOcclusion {
    LeanScreenSpaceAmbientOcclusion::default()
}

/// Boxes in a corner, so rough that specular light is occluded like diffuse light.
fn chalk(scene: &mut SceneBuilder) -> [Entity; 4] {
    let material = StandardMaterial {
        base_color: Color::srgb(0.8, 0.5, 0.3),
        perceptual_roughness: 1.0,
        lightmap_exposure: 1500.0,
        ..Default::default()
    };
    [
        (Vec3::new(12.0, 0.1, 12.0), Vec3::new(0.0, -0.05, 0.0)),
        (Vec3::new(12.0, 4.0, 0.1), Vec3::new(0.0, 2.0, -2.0)),
        (Vec3::new(1.0, 1.2, 1.0), Vec3::new(-0.7, 0.6, -0.8)),
        (Vec3::new(0.6, 0.6, 0.6), Vec3::new(0.8, 0.3, 0.4)),
    ]
    .map(|(size, position)| {
        scene.mesh(
            Cuboid::from_size(size),
            material.clone(),
            Transform::from_translation(position),
        )
    })
}

fn set_ambient(scene: &mut SceneBuilder, brightness: f32) {
    scene.world().insert_resource(GlobalAmbientLight {
        brightness,
        ..Default::default()
    });
}

fn lit_directly(scene: &mut SceneBuilder) {
    chalk(scene);
    scene.sun(true);
    set_ambient(scene, 0.0);
}

fn lit_indirectly(scene: &mut SceneBuilder) {
    chalk(scene);
    set_ambient(scene, 2000.0);
}

fn lit_by_lightmaps(scene: &mut SceneBuilder) {
    let boxes = chalk(scene);
    put_lightmaps(scene, &boxes, false);
    set_ambient(scene, 0.0);
}

/// Largest error of `after` against `before` times a visibility, relative to `before`.
fn product_error(before: &Colors, visibility: &Colors, after: &Colors) -> f32 {
    share_error(before, visibility, 1.0, after)
}

/// As [`product_error`], for this share of the occlusion.
fn share_error(before: &Colors, visibility: &Colors, share: f32, after: &Colors) -> f32 {
    let error = |i: usize| {
        let expected = before.rgb(i) * (1.0 - share * (1.0 - visibility.rgb(i)));
        let error = (after.rgb(i) - expected).abs() / before.rgb(i).max(Vec3::splat(1e-3));
        error.max_element()
    };
    (0..after.len()).map(error).fold(0.0, f32::max)
}

#[test]
fn direct_light_is_left_alone_unless_told_otherwise() {
    let mut stage = Stage::new(lit_directly);
    stage.insert(LeanDeferred::default());
    let before = stage.picture();
    let changed = stage.picture_with(default()).different(&before);
    println!("by default {changed} pixels in direct light change");
    assert_eq!(changed, 0);

    let visibility = stage.visibility(default());
    for direct_light in [0.5, 1.0] {
        let after = stage.picture_with(LeanScreenSpaceAmbientOcclusion {
            direct_light,
            ..default()
        });
        let darker = after.count(|i| after.rgb(i).x < 0.95 * before.rgb(i).x);
        let brighter = after.count(|i| after.rgb(i).cmpgt(before.rgb(i)).any());
        println!("with an effect of {direct_light}, {darker} are darker, {brighter} brighter");
        assert!(darker > 500 && brighter == 0);
        if direct_light == 1.0 {
            let error = product_error(&before, &visibility, &after);
            println!("product of visibility off by up to {error:.1e}");
            assert!(error <= 2e-3);
        }
    }
    log_watch::assert_validation_layer_silent();
}

#[test]
fn baked_light_is_left_alone_unless_told_otherwise() {
    let mut stage = Stage::new(lit_by_lightmaps);
    stage.insert(LeanDeferred::default());
    let before = stage.picture();
    let lit = before.count(|i| before.rgb(i).x > 0.01);
    let changed = stage.picture_with(default()).different(&before);
    println!("by default {changed} of {lit} pixels in baked light change");
    assert!(lit > 10_000);
    assert_eq!(changed, 0);

    let visibility = stage.visibility(default());
    for baked_light in [0.5, 1.0] {
        let after = stage.picture_with(LeanScreenSpaceAmbientOcclusion {
            advanced: LeanScreenSpaceAmbientOcclusionAdvanced {
                baked_light,
                multibounce: false,
                ..Default::default()
            },
            ..default()
        });
        let darker = after.count(|i| after.rgb(i).x < 0.95 * before.rgb(i).x);
        let brighter = after.count(|i| after.rgb(i).cmpgt(before.rgb(i)).any());
        let error = share_error(&before, &visibility, baked_light, &after);
        println!(
            "with {baked_light}, {darker} are darker, {brighter} brighter, off by {error:.1e}"
        );
        assert!(darker > 500 && brighter == 0);
        assert!(error <= 2e-3);
    }
    log_watch::assert_validation_layer_silent();
}

/// Under indirect light alone, occlusion multiplies the picture; multiple bounces restore some of the light.
#[test]
fn indirect_light_is_multiplied() {
    let mut stage = Stage::new(lit_indirectly);
    stage.insert(LeanDeferred::default());
    let before = stage.picture();
    let visibility = stage.visibility(default());
    let [single, blend, bounced] = [
        LeanScreenSpaceAmbientOcclusion {
            advanced: LeanScreenSpaceAmbientOcclusionAdvanced {
                multibounce: false,
                ..Default::default()
            },
            ..default()
        },
        LeanScreenSpaceAmbientOcclusion {
            application: OcclusionApplication::MultiplicativeBlend,
            ..default()
        },
        default(),
    ]
    .map(|settings| stage.picture_with(settings));
    // Applied after the opaque meshes, occlusion uses the geometric normal.
    let blended_visibility = stage.visibility(LeanScreenSpaceAmbientOcclusion {
        application: OcclusionApplication::MultiplicativeBlend,
        ..default()
    });
    let errors = [(&visibility, &single), (&blended_visibility, &blend)]
        .map(|(visibility, after)| product_error(&before, visibility, after));
    println!("product of visibility off by up to {errors:?}, lit and blended");
    assert!(errors.iter().all(|error| *error <= 2e-3));

    let is_dark = |i: usize| visibility.rgb(i).x < 0.9;
    let dark = single.count(is_dark);
    let is_lifted = |i: usize| {
        let (single, bounced) = (single.rgb(i), bounced.rgb(i));
        bounced.x > single.x && bounced.cmpge(single).all()
    };
    let lifted = single.count(|i| is_dark(i) && is_lifted(i));
    let brighter = bounced.count(|i| bounced.rgb(i).cmpgt(before.rgb(i) * 1.001).any());
    println!("bounces lift {lifted} of {dark} dark pixels, {brighter} above what they were");
    assert!(dark > 1000 && lifted == dark && brighter == 0);
    log_watch::assert_validation_layer_silent();
}

/// Occlusion is relative to the geometric horizon, so a normal map does not occlude a plane.
#[test]
fn normal_maps_do_not_occlude() {
    let mut stage = Stage::new(|scene| {
        let bumps = scene.bumps();
        let mesh = Plane3d::default().mesh().size(40.0, 40.0).build();
        let mesh = mesh
            .with_generated_tangents()
            .expect("a plane has all that tangents need");
        scene.mesh(
            mesh,
            StandardMaterial {
                normal_map_texture: Some(bumps),
                ..Default::default()
            },
            Transform::default(),
        );
        scene.sun(false);
    });
    stage.insert(LeanDeferred::default());
    for resolution in [LeanResolution::Full, LeanResolution::Half] {
        for quality in LeanQuality::ALL {
            let visibility = stage.visibility(LeanScreenSpaceAmbientOcclusion {
                resolution,
                quality,
                ..default()
            });
            let occluded = visibility.count(|i| visibility.rgb(i) != Vec3::ONE);
            println!(
                "{resolution:?}, {quality:?}: {occluded} pixels of a normal-mapped plane are occluded"
            );
            assert_eq!(occluded, 0);
        }
    }
    log_watch::assert_validation_layer_silent();
}

/// A ball of few facets with smooth normals in front of the sky shows no occluded facets.
#[test]
fn smooth_normals_show_no_facets() {
    let mut stage = Stage::new(|scene| {
        scene.mesh(
            Sphere::new(1.2).mesh().uv(12, 8),
            StandardMaterial::default(),
            Transform::from_xyz(0.0, 0.4, 0.0),
        );
        scene.sun(false);
    });
    for lean in [false, true] {
        if lean {
            stage.insert(LeanDeferred::default());
        }
        let visibility = stage.visibility(default());
        let occlusion = (0..visibility.len()).map(|i| 1.0 - visibility.rgb(i).x);
        let mean = occlusion.clone().sum::<f32>() / visibility.len() as f32;
        let dark = occlusion.filter(|x| *x > 0.02).count();
        println!("lean {lean}: {dark} pixels above 0.02, mean {mean:.1e}");
        assert!(dark <= 12 && mean <= 2.2e-5);
    }
    log_watch::assert_validation_layer_silent();
}

/// A transmissive box in front of a wall, lit from behind by indirect light.
fn leaves(scene: &mut SceneBuilder) {
    chalk(scene);
    scene.mesh(
        Cuboid::new(1.0, 1.0, 0.05),
        StandardMaterial {
            base_color: Color::srgb(0.3, 0.8, 0.2),
            perceptual_roughness: 1.0,
            diffuse_transmission: 0.8,
            thickness: 0.1,
            ..Default::default()
        },
        Transform::from_xyz(0.6, 0.5, -0.7),
    );
}

#[test]
fn transmitted_indirect_light_is_no_direct_light() {
    for has_map in [false, true] {
        let mut map = Handle::default();
        let mut stage = Stage::new(|scene| {
            leaves(scene);
            set_ambient(scene, if has_map { 0.0 } else { 2000.0 });
            map = scene.cube_map();
        });
        stage.insert(LeanDeferred::default());
        if has_map {
            stage.insert(EnvironmentMapLight {
                diffuse_map: map.clone(),
                specular_map: map,
                intensity: 2000.0,
                ..Default::default()
            });
        }
        let [without, with] = [0.0, 1.0].map(|direct_light| {
            stage.picture_with(LeanScreenSpaceAmbientOcclusion {
                direct_light,
                ..default()
            })
        });
        let lit = without.count(|i| without.rgb(i).max_element() > 0.01);
        let changed = with.different(&without);
        println!("environment map: {has_map}: {changed} of {lit} pixels change");
        assert!(lit > 10_000);
        assert_eq!(changed, 0);
    }
    log_watch::assert_validation_layer_silent();
}

/// A wall so far away that its depth is 0 is unoccluded, and lit all the same.
#[test]
fn infinitely_far_surfaces_are_open() {
    let mut stage = Stage::new(|scene| {
        chalk(scene);
        scene.world().insert_resource(ClearColor(Color::BLACK));
        let far = 1e16;
        let wall = Plane3d::new(Vec3::Z, Vec2::splat(3.0 * far));
        let wall = Mesh::from(wall).translated_by(Vec3::new(0.0, 0.0, -far));
        let wall = scene.mesh(wall, StandardMaterial::default(), Transform::default());
        scene
            .world()
            .entity_mut(wall)
            .insert(bevy::camera::visibility::NoFrustumCulling);
        set_ambient(scene, 2000.0);
    });
    stage.insert((
        LeanDeferred::default(),
        // Lets lighting detect geometry by the G-buffer, not by its depth.
        bevy::core_pipeline::prepass::DepthPrepass,
        Projection::from(PerspectiveProjection {
            // Divided by the wall's distance, this underflows: its depth is 0.
            near: 1e-30,
            ..Default::default()
        }),
        // Looks over the boxes at the far wall.
        Transform::from_xyz(0.0, 3.0, 6.0).looking_at(Vec3::new(0.0, 3.0, 0.0), Vec3::Y),
    ));
    let before = stage.picture();
    for settings in [
        default(),
        LeanScreenSpaceAmbientOcclusion {
            resolution: LeanResolution::Half,
            ..default()
        },
    ] {
        let after = stage.picture_with(settings);
        let row = |i: usize| i / after.size.x as usize;
        let far = (0..after.len()).filter(|i| row(*i) < 20);
        let lit = far.clone().filter(|i| before.rgb(*i).x > 0.01).count();
        let changed = far.filter(|i| !after.same_pixel(&before, *i)).count();
        println!("{changed} of {lit} far pixels change");
        assert!(lit > 4000);
        assert_eq!(changed, 0);
        assert_eq!(after.count(|i| !after.rgb(i).is_finite()), 0);
    }
    log_watch::assert_validation_layer_silent();
}

/// The bytes of the occlusion's textures.
fn bytes(stage: &mut Stage) -> u64 {
    let memory = stage.headless.world().get::<LeanMemory>(stage.camera);
    memory.expect("it is inserted").ambient_occlusion
}

/// The filter reads texels beyond the last ones of the view, which textures with headroom have.
#[test]
fn textures_with_headroom_have_the_occlusion_of_others() {
    let mut wide = default();
    wide.advanced.filter = OcclusionFilter::Wide;
    let half = LeanScreenSpaceAmbientOcclusion {
        resolution: LeanResolution::Half,
        ..default()
    };
    for (name, settings) in [("narrow", default()), ("wide", wide), ("half", half)] {
        for is_lean in [true, false] {
            let mut stage = Stage::new(lit_indirectly);
            stage.insert((settings, LeanMemory::default()));
            if is_lean {
                stage.insert(LeanDeferred::default());
            }
            stage.picture();
            for width in [150, 160, 170, 181] {
                let physical_size = UVec2::new(width, 99 + width / 2);
                let camera = stage.camera;
                let mut camera = stage.entity(camera);
                let mut camera = camera.get_mut::<Camera>().expect("it is one");
                camera.viewport = Some(Viewport {
                    physical_size,
                    ..Default::default()
                });
                stage.headless.frames(3);
            }
            let with_headroom = stage.picture();
            let large = bytes(&mut stage);
            stage.headless.frames(70);
            let exact = stage.picture();
            let small = bytes(&mut stage);
            println!("{name}, lean: {is_lean}: {large} and {small} bytes");
            assert!(large as f32 > 1.2 * small as f32);
            assert_eq!(with_headroom.different(&exact), 0);
        }
    }
    log_watch::assert_validation_layer_silent();
}
