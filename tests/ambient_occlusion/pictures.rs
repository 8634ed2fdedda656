//! Multiplicative occlusion in the pictures of Bevy's forward renderer.

use bevy::{
    camera::{ClearColorConfig, Viewport},
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
};
use bevy_lean_deferred::{
    effects::ambient_occlusion::{
        LeanScreenSpaceAmbientOcclusionAdvanced, OcclusionApplication, OcclusionKernel,
    },
    prelude::*,
};

use crate::stage::{SIZE, Stage};
use kit::{log_watch, scenes::SceneBuilder};

fn solids(scene: &mut SceneBuilder) {
    scene.solids();
    scene.sun(true);
}

/// The blend multiplies by visibility, changes nothing where that is 1, and keeps alpha everywhere.
#[test]
fn the_blend_multiplies_and_keeps_what_is_open() {
    let mut stage = Stage::new(solids);
    let clear_color = Color::srgba(0.2, 0.3, 0.4, 0.35);
    stage.insert(Camera {
        clear_color: ClearColorConfig::Custom(clear_color),
        ..default()
    });
    let before = stage.picture();
    for resolution in [LeanResolution::Full, LeanResolution::Half] {
        let settings = LeanScreenSpaceAmbientOcclusion {
            resolution,
            ..default()
        };
        let visibility = stage.visibility(settings);
        let after = stage.picture_with(settings);
        let open = visibility.open();
        let kept = after.count(|i| open[i] && after.same_pixel(&before, i));
        let open = open.iter().filter(|open| **open).count();
        let error = |i: usize| {
            (after.rgb(i) - before.rgb(i) * visibility.rgb(i)).abs()
                / before.rgb(i).max(Vec3::splat(1e-3))
        };
        let largest = (0..after.len())
            .map(|i| error(i).max_element())
            .fold(0.0, f32::max);
        let dark = after.count(|i| visibility.rgb(i).x < 0.8);
        println!(
            "{resolution:?}: {kept} of {open} open pixels kept, {dark} dark ones; product off by up to {largest:.1e}"
        );
        assert!(kept == open && open > 20_000 && dark > 300);
        assert!(after.same_alpha(&before));
        assert!(largest <= 2e-3);
    }
    log_watch::assert_validation_layer_silent();
}

#[test]
fn fog_in_front_is_spared() {
    let mut stage = Stage::new(solids);
    let fog = |start, end| DistanceFog {
        color: Color::srgb(0.5, 0.6, 0.7),
        falloff: FogFalloff::Linear { start, end },
        ..default()
    };
    stage.insert(fog(0.1, 1.0));
    let hidden = stage.picture();
    let changed = stage.picture_with(default()).different(&hidden);
    println!("behind opaque fog {changed} pixels change");
    assert_eq!(changed, 0);

    stage
        .remove::<LeanScreenSpaceAmbientOcclusion>()
        .insert(fog(100.0, 200.0));
    let clear = stage.picture();
    let fogged = stage.picture_with(default());
    let darker = fogged.different(&clear);
    println!("before it begins, {darker}");
    assert!(darker > 1000);
    log_watch::assert_validation_layer_silent();
}

#[test]
fn switching_off_gives_back_the_former_picture() {
    let mut stage = Stage::new(solids);
    for lean in [false, true] {
        if lean {
            stage.insert(LeanDeferred::default());
        }
        let before = stage.picture();
        for application in [
            OcclusionApplication::Auto,
            OcclusionApplication::MultiplicativeBlend,
            OcclusionApplication::Indirect,
        ] {
            let with = stage.picture_with(LeanScreenSpaceAmbientOcclusion {
                application,
                ..default()
            });
            let changed = with.different(&before);
            let after = stage.remove::<LeanScreenSpaceAmbientOcclusion>().picture();
            println!(
                "lean {lean}, {application:?}: {changed} pixels changed, {} after",
                after.different(&before)
            );
            assert!(changed > 1000 && after == before);
        }
    }
    log_watch::assert_validation_layer_silent();
}

#[test]
fn with_msaa_there_is_a_warning_and_bevys_picture() {
    let mut stage = Stage::new(solids);
    stage.insert(Msaa::Sample4);
    let before = stage.picture();
    // Adding the component switches MSAA off.
    let without_msaa = stage.picture_with(default());
    stage.insert(Msaa::Sample4);
    let after = stage.picture();
    let warnings = log_watch::messages_with("its `Msaa` is not `Off`");
    println!(
        "{} pixels differ, {} with MSAA switched off; {warnings:?}",
        after.different(&before),
        without_msaa.different(&before)
    );
    assert!(after == before && without_msaa != before);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    log_watch::assert_validation_layer_silent();
}

#[test]
fn cameras_of_one_target_have_their_own() {
    let rects = [
        URect::new(0, 0, 101, SIZE.y),
        URect::new(101, 0, SIZE.x, SIZE.y),
    ];
    let mut cameras = Vec::new();
    let mut stage = Stage::new(|scene| {
        solids(scene);
        for (order, rect) in rects.iter().enumerate() {
            cameras.push(
                scene.camera(
                    Transform::from_xyz(-1.5 + 2.0 * order as f32, 2.8, 5.2)
                        .looking_at(Vec3::Y * 0.4, Vec3::Y),
                    Camera {
                        order: order as isize,
                        viewport: Some(Viewport {
                            physical_position: rect.min,
                            physical_size: rect.size(),
                            ..default()
                        }),
                        ..default()
                    },
                ),
            );
        }
    });
    let unused = stage.camera;
    stage.headless.world().despawn(unused);
    for camera in &cameras {
        stage.keep_colors(*camera);
    }
    let before = stage.picture();
    // Of different kernels and resolutions.
    let occlusion = [
        LeanScreenSpaceAmbientOcclusion::default(),
        LeanScreenSpaceAmbientOcclusion {
            resolution: LeanResolution::Half,
            advanced: LeanScreenSpaceAmbientOcclusionAdvanced {
                kernel: OcclusionKernel::Hdao,
                ..default()
            },
            ..default()
        },
    ];
    let put = |stage: &mut Stage, i: usize| {
        let mut camera = stage.entity(cameras[i]);
        camera.insert(occlusion[i]);
        if i == 0 {
            camera.insert(LeanDeferred::default());
        }
    };
    let alone = [0, 1].map(|i| {
        put(&mut stage, i);
        let after = stage.picture();
        let changed = rects.map(|rect| after.within(rect).different(&before.within(rect)));
        println!("camera {i}: changed pixels {changed:?}");
        assert!(changed[i] > 500 && changed[1 - i] == 0);
        stage
            .entity(cameras[i])
            .remove::<(LeanScreenSpaceAmbientOcclusion, LeanDeferred)>();
        after
    });
    for i in [0, 1] {
        put(&mut stage, i);
    }
    let both = stage.picture();
    for (rect, alone) in rects.into_iter().zip(alone) {
        let changed = both.within(rect).different(&alone.within(rect));
        println!("beside another camera: changed pixels {changed}");
        assert_eq!(changed, 0);
    }
    log_watch::assert_validation_layer_silent();
}

#[test]
fn targets_may_change_their_size() {
    let other = UVec2::new(160, 211);
    for lean in [false, true] {
        let make = |size| {
            let mut stage = Stage::with_size(size, solids);
            if lean {
                stage.insert(LeanDeferred::default());
            }
            stage.insert(LeanScreenSpaceAmbientOcclusion::default());
            stage
        };
        let fresh = make(other).picture();
        let mut stage = make(SIZE);
        let first = stage.picture();
        let resized = stage.resized(other).picture();
        let back = stage.resized(SIZE).picture();
        println!(
            "lean {lean}: {} pixels differ, and {} after going back",
            resized.different(&fresh),
            back.different(&first)
        );
        assert!(resized == fresh && back == first);
    }
    log_watch::assert_validation_layer_silent();
}
