//! Auto exposure on cameras of an app.

use bevy::{
    asset::RenderAssetUsages,
    camera::{ClearColorConfig, Hdr, Viewport},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_lean_deferred::{
    CameraCut,
    effects::auto_exposure::{
        ExposureClock, LeanAutoExposure, LuminanceTrim, MeteredExposure, MeteringPattern,
    },
    prelude::*,
};

use crate::instant;
use kit::{headless::Headless, log_watch, own_process::in_own_process};

const SIZE: UVec2 = UVec2::new(64, 48);

fn grey(value: f32) -> Color {
    LinearRgba::rgb(value, value, value).into()
}

/// A 3D camera that sees only its background.
fn camera(headless: &mut Headless, background: f32, settings: LeanAutoExposure) -> Entity {
    camera_of(Camera3d::default(), headless, background, settings)
}

fn camera_of(
    kind: impl Bundle,
    headless: &mut Headless,
    background: f32,
    settings: LeanAutoExposure,
) -> Entity {
    let target = headless.render_target();
    headless
        .world()
        .spawn((
            kind,
            Camera {
                clear_color: ClearColorConfig::Custom(grey(background)),
                ..default()
            },
            (
                Hdr,
                Msaa::Off,
                Tonemapping::Reinhard,
                DebandDither::Disabled,
            ),
            target,
            settings,
            MeteredExposure::default(),
        ))
        .id()
}

fn set_background(headless: &mut Headless, camera: Entity, value: f32) {
    let mut entity = headless.world().entity_mut(camera);
    let mut camera = entity.get_mut::<Camera>().expect("it is one");
    camera.clear_color = ClearColorConfig::Custom(grey(value));
}

fn metered_now(headless: &mut Headless, camera: Entity) -> MeteredExposure {
    *headless
        .world()
        .get::<MeteredExposure>(camera)
        .expect("it was spawned with one")
}

/// The exposure read back after some frames.
fn metered(headless: &mut Headless, camera: Entity) -> MeteredExposure {
    headless.settle();
    headless.frames(4);
    metered_now(headless, camera)
}

/// Value of one pixel before tonemapping.
fn shown(headless: &mut Headless, pixel: UVec2) -> f32 {
    let picture = headless.capture();
    let value = picture.rgba[4 * (pixel.y * picture.size.x + pixel.x) as usize];
    let tonemapped = LinearRgba::from(Srgba::rgb_u8(value, value, value)).red;
    tonemapped / (1.0 - tonemapped)
}

/// Pictures come out at the requested middle grey, in 3D and 2D, with and without a G-buffer, and the metered values are read back.
#[test]
fn pictures_come_out_middle_grey() {
    let mut headless = Headless::new(SIZE);
    for background in [0.002, 0.18, 20.0] {
        let camera = camera(&mut headless, background, instant());
        for lean in [false, true] {
            if lean {
                headless
                    .world()
                    .entity_mut(camera)
                    .insert(LeanDeferred::default());
            }
            let metered = metered(&mut headless, camera);
            let shown = shown(&mut headless, UVec2::new(30, 20));
            println!(
                "{background} is metered as {}, shown as {shown}",
                metered.luminance
            );
            assert!((metered.luminance / background - 1.0).abs() < 1e-3);
            assert!((metered.exposure - (0.18 / background).log2()).abs() < 1e-2);
            assert!((shown - 0.18).abs() < 0.005);
        }
        headless.world().despawn(camera);
    }
    let mut headless = Headless::new(SIZE);
    let camera = camera_of(Camera2d, &mut headless, 2.0, instant());
    metered(&mut headless, camera);
    let shown = shown(&mut headless, UVec2::new(30, 20));
    assert!((shown - 0.18).abs() < 0.005, "2D shows {shown}");
    log_watch::assert_validation_layer_silent();
}

/// Two cameras side by side meter their own halves.
#[test]
fn cameras_meter_their_own_viewports() {
    let size = UVec2::new(150, 90);
    let mut headless = Headless::new(size);
    let backgrounds = [0.25, 4.0];
    let cameras = backgrounds.map(|value| camera(&mut headless, value, instant()));
    let mut left = 0;
    for (order, (camera, width)) in cameras.into_iter().zip([67, 83]).enumerate() {
        // Outside viewports the target is not cleared, so each camera sees a wall.
        let layer = bevy::camera::visibility::RenderLayers::layer(order + 1);
        let wall = headless
            .world()
            .resource_mut::<Assets<Mesh>>()
            .add(Plane3d::new(Vec3::Z, Vec2::splat(50.0)));
        let value = backgrounds[order];
        let material = headless
            .world()
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial {
                base_color: LinearRgba::rgb(value, value, value).into(),
                unlit: true,
                ..default()
            });
        headless.world().spawn((
            Mesh3d(wall),
            MeshMaterial3d(material),
            Transform::from_xyz(0.0, 0.0, -5.0),
            layer.clone(),
        ));
        let mut entity = headless.world().entity_mut(camera);
        entity.insert(layer);
        let mut camera = entity.get_mut::<Camera>().expect("it is one");
        camera.order = order as isize;
        camera.viewport = Some(Viewport {
            physical_position: UVec2::new(left, 0),
            physical_size: UVec2::new(width, size.y),
            ..default()
        });
        if order > 0 {
            camera.clear_color = ClearColorConfig::None;
        }
        left += width;
    }
    for (camera, value) in cameras.into_iter().zip(backgrounds) {
        let metered = metered(&mut headless, camera);
        println!("{value} is metered as {}", metered.luminance);
        assert!((metered.luminance / value - 1.0).abs() < 1e-3);
    }
    log_watch::assert_validation_layer_silent();
}

/// Exposures of the next frames, as they are read back.
fn exposures(headless: &mut Headless, camera: Entity, frames: usize) -> Vec<f32> {
    (0..frames)
        .map(|_| {
            headless.frames(1);
            metered_now(headless, camera).exposure
        })
        .collect()
}

/// Adaptation takes time, a cut or a new component does not, and resizing, masks and other settings cause no flash.
#[test]
fn nothing_flashes() {
    let mut headless = Headless::new(SIZE);
    let camera = camera(&mut headless, 0.18, LeanAutoExposure::default());
    let start = metered(&mut headless, camera);
    assert_eq!(start.exposure, start.target_exposure);
    assert!(start.exposure.abs() < 1e-2);

    set_background(&mut headless, camera, 0.18 * 16.0);
    let adapting = exposures(&mut headless, camera, 30);
    println!("adapting: {adapting:?}");
    let per_frame = 1.0 / 60.0;
    for pair in adapting.windows(2) {
        assert!(pair[1] <= pair[0] && pair[0] - pair[1] <= 3.1 * per_frame);
    }
    assert!(*adapting.last().expect("30") > -2.0);

    // None of these changes what is metered: the exposure continues as before.
    let changes: [fn(&mut Headless, Entity); 4] = [
        |headless, camera| {
            let mut entity = headless.world().entity_mut(camera);
            let mut settings = entity.get_mut::<LeanAutoExposure>().expect("it has one");
            settings.pattern = MeteringPattern::CenterWeighted;
        },
        |headless, camera| {
            let mut entity = headless.world().entity_mut(camera);
            let mut settings = entity.get_mut::<LeanAutoExposure>().expect("it has one");
            settings.trim = Some(LuminanceTrim {
                low: 0.1,
                high: 0.1,
            });
        },
        |headless, _| {
            let target = headless.target.clone();
            *headless
                .world()
                .resource_mut::<Assets<Image>>()
                .get_mut(&target)
                .expect("it is there") = kit::headless::target_image(UVec2::new(91, 33));
        },
        |headless, camera| {
            let mut entity = headless.world().entity_mut(camera);
            let mut settings = entity.get_mut::<LeanAutoExposure>().expect("it has one");
            settings.trim = None;
        },
    ];
    let mut last = metered_now(&mut headless, camera).exposure;
    for change in changes {
        change(&mut headless, camera);
        for exposure in exposures(&mut headless, camera, 6) {
            assert!(
                exposure <= last && last - exposure <= 3.1 * per_frame,
                "{last}, {exposure}"
            );
            last = exposure;
        }
    }

    headless.world().entity_mut(camera).insert(CameraCut);
    let after = metered(&mut headless, camera);
    assert_eq!(after.exposure, after.target_exposure);
    assert!(headless.world().get::<CameraCut>(camera).is_none());

    set_background(&mut headless, camera, 0.18);
    headless
        .world()
        .entity_mut(camera)
        .remove::<LeanAutoExposure>();
    headless.frames(2);
    assert!((shown(&mut headless, UVec2::new(30, 20)) - 0.18).abs() < 0.005);
    headless
        .world()
        .entity_mut(camera)
        .insert(LeanAutoExposure::default());
    let again = metered(&mut headless, camera);
    assert_eq!(again.exposure, again.target_exposure);
    log_watch::assert_validation_layer_silent();
}

/// A camera that was inactive for a while has adapted in the meantime.
#[test]
fn pauses_count() {
    let mut headless = Headless::new(SIZE);
    let camera = camera(&mut headless, 0.18, LeanAutoExposure::default());
    metered(&mut headless, camera);
    let set_active = |headless: &mut Headless, active: bool| {
        let mut entity = headless.world().entity_mut(camera);
        entity.get_mut::<Camera>().expect("it is one").is_active = active;
    };
    set_active(&mut headless, false);
    headless.frames(240);
    set_background(&mut headless, camera, 0.18 * 16.0);
    set_active(&mut headless, true);
    headless.frames(5);
    let metered = metered_now(&mut headless, camera);
    assert!(
        (metered.exposure - metered.target_exposure).abs() < 0.01,
        "{metered:?}"
    );
}

/// Exposure adapts while the game is paused, unless it uses the game's clock.
#[test]
fn exposure_adapts_while_the_game_is_paused() {
    for clock in [ExposureClock::Real, ExposureClock::Virtual] {
        let mut headless = Headless::new(SIZE);
        let settings = LeanAutoExposure {
            clock,
            // Soon there.
            speed_brighten: 30.0,
            ..default()
        };
        let camera = camera(&mut headless, 0.18, settings);
        metered(&mut headless, camera);
        headless.world().resource_mut::<Time<Virtual>>().pause();
        set_background(&mut headless, camera, 0.18 * 16.0);
        let adapting = exposures(&mut headless, camera, 60);
        let last = *adapting.last().expect("60");
        println!("{clock:?}: {last} stops");
        let expected = match clock {
            ExposureClock::Real => -4.0,
            ExposureClock::Virtual => 0.0,
        };
        assert!((last - expected).abs() < 0.05, "{clock:?}: {last}");
        headless.world().resource_mut::<Time<Virtual>>().unpause();
        let adapting = exposures(&mut headless, camera, 60);
        let last = *adapting.last().expect("60");
        assert!((last + 4.0).abs() < 0.05, "{clock:?}: {last}");
    }
}

/// Without tonemapping, the default of 2D cameras, Bevy applies no exposure: one warning names the camera.
#[test]
fn without_tonemapping_there_is_a_warning() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        let target = headless.render_target();
        let camera = headless.world().spawn((Camera2d, target, instant())).id();
        headless.settle();
        let warnings = || log_watch::messages_with(&format!("LeanAutoExposure on camera {camera}"));
        let told = warnings();
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(told[0].contains("Tonemapping"), "{told:?}");
        let mut entity = headless.world().entity_mut(camera);
        entity.insert(Tonemapping::Reinhard);
        headless.settle();
        assert_eq!(warnings().len(), 1);
        let mut entity = headless.world().entity_mut(camera);
        entity.insert(Tonemapping::None);
        headless.settle();
        assert_eq!(warnings().len(), 2);
    });
}

/// Without `Hdr` there is one warning, and the picture is unchanged.
#[test]
fn without_hdr_there_is_a_warning() {
    let mut headless = Headless::new(SIZE);
    let camera = camera(&mut headless, 0.5, instant());
    headless.world().entity_mut(camera).remove::<Hdr>();
    headless.settle();
    let with = headless.capture();
    headless
        .world()
        .entity_mut(camera)
        .remove::<LeanAutoExposure>();
    headless.settle();
    assert!(with == headless.capture());
    let warnings = log_watch::messages_with("LeanAutoExposure on camera");
    assert_eq!(warnings.len(), 1, "{warnings:?}");
}

/// While the mask's asset is missing, all pixels count.
#[test]
fn masks_are_assets() {
    let mut headless = Headless::new(SIZE);
    let camera = camera(&mut headless, 2.0, instant());
    let mask = headless
        .world()
        .resource_mut::<Assets<Image>>()
        .reserve_handle();
    let settings = LeanAutoExposure {
        pattern: MeteringPattern::Mask(mask.clone()),
        ..instant()
    };
    headless.world().entity_mut(camera).insert(settings);
    let before = metered(&mut headless, camera);
    assert!((before.luminance - 2.0).abs() < 1e-3);
    // With a black mask nothing counts: the metered luminance stays.
    let black = Image::new_fill(
        Extent3d::default(),
        TextureDimension::D2,
        &[0],
        TextureFormat::R8Unorm,
        RenderAssetUsages::RENDER_WORLD,
    );
    headless
        .world()
        .resource_mut::<Assets<Image>>()
        .insert(&mask, black)
        .expect("the handle is alive");
    headless.settle();
    set_background(&mut headless, camera, 0.1);
    let masked = metered(&mut headless, camera);
    println!("masked: {masked:?}");
    assert!((masked.luminance - 2.0).abs() < 1e-3);
    log_watch::assert_validation_layer_silent();
}

/// An image that is no mask causes one warning, and all pixels count.
#[test]
fn images_that_are_no_masks_are_named() {
    for (name, layers, format) in [
        (
            "this device cannot filter its format",
            1,
            TextureFormat::R8Uint,
        ),
        ("it is no plain picture", 2, TextureFormat::R8Unorm),
    ] {
        let mut headless = Headless::new(SIZE);
        let camera = camera(&mut headless, 2.0, instant());
        let size = Extent3d {
            depth_or_array_layers: layers,
            ..default()
        };
        let (dimension, usage) = (TextureDimension::D2, RenderAssetUsages::RENDER_WORLD);
        let image = Image::new_fill(size, dimension, &[0], format, usage);
        let mask = headless.world().resource_mut::<Assets<Image>>().add(image);
        let settings = LeanAutoExposure {
            pattern: MeteringPattern::Mask(mask),
            ..instant()
        };
        let shows = LeanDebugView::from(DebugView::ExposureWeights);
        headless
            .world()
            .entity_mut(camera)
            .insert((settings, shows));
        let metered = metered(&mut headless, camera);
        assert!((metered.luminance - 2.0).abs() < 1e-3, "{name}");
        let warnings = log_watch::messages_with(name);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
    }
    log_watch::assert_validation_layer_silent();
}

/// Exposure does not need `Msaa::Off`: its overlay is drawn on the resolved picture.
#[test]
fn the_overlay_lies_on_what_was_sampled_several_times() {
    let shows = LeanDebugView::from(DebugView::ExposureWeights);
    let pictures = [Msaa::Off, Msaa::Sample4].map(|msaa| {
        let mut headless = Headless::new(UVec2::new(160, 90));
        let camera = camera(&mut headless, 0.5, instant());
        headless.world().entity_mut(camera).insert((msaa, shows));
        headless.settle();
        headless.frames(3);
        headless.capture()
    });
    assert!(pictures[0] == pictures[1]);
    log_watch::assert_validation_layer_silent();
}

/// A viewport may be empty, as when a part of a split screen closes. In a process of its own, since Bevy's own passes are invalid in Vulkan
/// then.
#[test]
fn viewports_may_be_empty() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        let camera = camera_of(Camera2d, &mut headless, 2.0, instant());
        for width in [SIZE.x, 0, SIZE.x] {
            let mut entity = headless.world().entity_mut(camera);
            let mut camera = entity.get_mut::<Camera>().expect("it is one");
            camera.viewport = Some(Viewport {
                physical_size: UVec2::new(width, SIZE.y),
                ..default()
            });
            headless.settle();
            headless.frames(3);
        }
        let metered = metered(&mut headless, camera);
        assert!((metered.luminance - 2.0).abs() < 1e-3);
    });
}

/// The overlay darkens uncounted pixels and marks exposure and target on its scale, in its part of the picture; the other part, and the
/// picture without it, are unchanged.
#[test]
fn the_overlay_shows_what_is_metered() {
    let mut headless = Headless::new(UVec2::new(640, 360));
    let settings = LeanAutoExposure {
        pattern: MeteringPattern::Spot { radius: 0.3 },
        speed_brighten: 1.0,
        ..default()
    };
    let camera = camera(&mut headless, 0.18, settings);
    metered(&mut headless, camera);
    let without = headless.capture();
    let shows = LeanDebugView {
        shows: DebugView::ExposureWeights,
        split: 0.9,
    };
    headless.world().entity_mut(camera).insert(shows);
    set_background(&mut headless, camera, 0.18 * 16.0);
    headless.settle();
    headless.frames(30);
    let state = metered(&mut headless, camera);
    let with = headless.capture();
    let at = |x: u32, y: u32| {
        let i = 4 * (y * with.size.x + x) as usize;
        [with.rgba[i], with.rgba[i + 1], with.rgba[i + 2]]
    };
    // Tonemapped and stored as sRGB.
    let counted = LinearRgba::from(Srgba::rgb_u8(at(320, 180)[0], 0, 0)).red;
    let uncounted = LinearRgba::from(Srgba::rgb_u8(at(5, 5)[0], 0, 0)).red;
    assert!(
        (uncounted / counted - 0.35).abs() < 0.02,
        "{uncounted} of {counted}"
    );
    let beside = LinearRgba::from(Srgba::rgb_u8(at(580, 5)[0], 0, 0)).red;
    assert!(
        (beside / counted - 1.0).abs() < 0.02,
        "{beside} of {counted}"
    );

    // The scale spans -8 to 8 stops, and half a stop on either side, over 0.6 of the width.
    let column = |stops: f32| (640.0 * (0.2 + 0.6 * (stops + 8.5) / 17.0)) as u32;
    println!("{state:?}");
    assert_eq!(at(column(state.exposure), 332), [255; 3]);
    let [red, green, _] = at(column(state.target_exposure), 341);
    assert!(green > 200 && red < 150);
    assert!(at(column(5.5), 341)[1] < 100);

    set_background(&mut headless, camera, 0.18);
    headless
        .world()
        .entity_mut(camera)
        .remove::<LeanDebugView>()
        .insert(CameraCut);
    metered(&mut headless, camera);
    assert!(headless.capture() == without);
    log_watch::assert_validation_layer_silent();
}
