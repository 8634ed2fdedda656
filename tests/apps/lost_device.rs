//! A lost device: Bevy can create another, on which the picture is the same. In processes of their own, because the loss is logged as an
//! error.

use bevy::{
    prelude::*,
    render::{
        RenderApp, RenderStartup,
        error_handler::{RenderErrorHandler, RenderErrorPolicy},
        render_resource::PollType,
        renderer::RenderDevice,
    },
};
use bevy_lean_deferred::prelude::*;
use kit::{
    analytic_slabs::{SKIN, slab},
    device::render_creation,
    headless::{Headless, Picture},
    lean::{active_lean_views, build, change_cameras, instant_exposure, set_lean},
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::{SceneBuilder, special_materials::put_lightmaps},
    skipped::where_light_scatters,
};

const SIZE: UVec2 = UVec2::new(160, 120);

fn scene(s: &mut SceneBuilder) {
    s.solids();
    s.sun(true);
    s.mesh(
        Sphere::new(0.4),
        StandardMaterial {
            clearcoat: 1.0,
            emissive: LinearRgba::rgb(0.2, 0.1, 0.3),
            ..default()
        },
        Transform::from_xyz(0.0, 0.4, 1.2),
    );
    s.spawn((
        PointLight {
            intensity: 300_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        bevy::camera::visibility::RenderLayers::layer(1),
        Transform::from_xyz(1.0, 2.0, 1.5),
    ));
}

/// Devices created since the loss.
#[derive(Resource)]
struct Devices(usize);

/// Loses the device and renders until there is another.
fn lose_device(headless: &mut Headless) {
    headless
        .world()
        .insert_resource(RenderErrorHandler(|error, _, _| {
            println!("recovering from {:?}", error.ty);
            RenderErrorPolicy::Recover(render_creation())
        }));
    let render_app = headless.app.sub_app_mut(RenderApp);
    if render_app.world().get_resource::<Devices>().is_none() {
        render_app.add_systems(RenderStartup, |mut devices: ResMut<Devices>| devices.0 += 1);
    }
    render_app.insert_resource(Devices(0));
    let device = render_app.world().resource::<RenderDevice>();
    device.wgpu_device().destroy();
    _ = device.poll(PollType::wait_indefinitely());
    for _ in 0..20 {
        headless.frame();
        let render_world = headless.app.sub_app(RenderApp).world();
        if render_world.resource::<Devices>().0 > 0 {
            return;
        }
    }
    panic!("no other device after 20 frames");
}

/// Asserts that a camera with `effects` shows the same before and after the loss.
fn survives(name: &str, effects: impl Bundle) -> Headless {
    survives_losses(1, name, |_| {}, effects)
}

/// As [`survives`], after each of several losses, with more in the scene.
fn survives_losses(
    losses: usize,
    name: &str,
    more: impl FnOnce(&mut SceneBuilder),
    effects: impl Bundle,
) -> Headless {
    let mut camera = Entity::PLACEHOLDER;
    let mut headless = build(SIZE, |s| {
        scene(s);
        more(s);
        camera = s.default_camera(bevy::camera::visibility::RenderLayers::from_layers(&[0, 1]));
    });
    let images = images(&mut headless);
    headless.world().entity_mut(camera).insert(effects);
    let before = settled(&mut headless);
    let lean_before = active_lean_views(&mut headless);
    for loss in 1..=losses {
        lose_device(&mut headless);
        restore(&images, &mut headless);
        let after = settled(&mut headless);
        let difference = pixel_difference(&before, &after);
        println!("{name}, loss {loss}: {difference}");
        // Single pixels that mirror themselves may come to rest at another value once light has begun anew.
        let least = if name == "reflections" {
            60.0
        } else {
            f64::INFINITY
        };
        assert!(difference.psnr >= least, "{name}: {difference}");
        assert_eq!(active_lean_views(&mut headless), lean_before, "{name}");
    }
    headless
}

type Images = Vec<(AssetId<Image>, Image)>;

/// Copies of the images, made before any is moved to the render world.
fn images(headless: &mut Headless) -> Images {
    let images = headless.world().resource::<Assets<Image>>();
    images
        .iter()
        .map(|(id, image)| (id, image.clone()))
        .collect()
}

/// Restores images. Bevy drops the pixels of those that only the render world has, such as its look-up tables of reflected light, without
/// which all is black: on the next device they are empty.
fn restore(images: &Images, headless: &mut Headless) {
    let mut assets = headless.world().resource_mut::<Assets<Image>>();
    for (id, image) in images {
        _ = assets.insert(*id, image.clone());
    }
}

/// Frames in which light between mirrors converges: rough reflections are the mean of four frames.
const BOUNCES: usize = 32;

fn settled(headless: &mut Headless) -> Picture {
    headless.settle();
    headless.frames(BOUNCES);
    headless.capture()
}

#[test]
#[ignore = "nightly: lean cameras without effects"]
fn lean_cameras_survive() {
    in_own_process(|| {
        survives("lean", LeanDeferred::default());
    });
}

#[test]
fn occlusion_survives() {
    in_own_process(|| {
        survives("occlusion", LeanScreenSpaceAmbientOcclusion::default());
        survives_losses(
            2,
            "lean with occlusion",
            |_| {},
            (
                LeanDeferred::default(),
                LeanScreenSpaceAmbientOcclusion::default(),
            ),
        );
    });
}

#[test]
fn what_is_found_on_the_screen_survives() {
    in_own_process(|| {
        survives(
            "diffuse GI",
            (LeanDeferred::default(), LeanScreenSpaceGi::default()),
        );
        survives(
            "reflections",
            (
                LeanDeferred::default(),
                LeanScreenSpaceReflections::default(),
            ),
        );
    });
}

#[test]
fn scattering_survives() {
    where_light_scatters(|| {
        let ball = |s: &mut SceneBuilder| {
            let mesh = s.add::<Mesh>(Sphere::new(0.5));
            let material = s.add::<ExtendedStandardMaterial>(slab(SKIN, 0.1));
            let place = Transform::from_xyz(-0.6, 0.5, 1.6);
            s.spawn((Mesh3d(mesh), MeshMaterial3d(material), place));
        };
        let mut headless =
            survives_losses(1, "scattering", ball, LeanSubsurfaceScattering::default());
        let with = settled(&mut headless);
        change_cameras(&mut headless, |camera| {
            camera.remove::<LeanSubsurfaceScattering>();
        });
        let difference = pixel_difference(&with, &settled(&mut headless));
        println!("without scattering: {difference}");
        assert!(difference.largest > 8);
    });
}

#[test]
fn exposure_survives() {
    in_own_process(|| {
        let mut headless = survives(
            "exposure",
            (
                LeanDeferred::default(),
                instant_exposure(),
                MeteredExposure::default(),
                LeanDebugView::from(DebugView::ExposureWeights),
            ),
        );
        // Metered exposure is still read back.
        let world = headless.world();
        let mut cameras = world.query::<&mut MeteredExposure>();
        let mut metered = cameras.single_mut(world).expect("there is one");
        let before = core::mem::take(&mut *metered);
        headless.frames(4);
        let world = headless.world();
        let after = cameras.single(world).expect("there is one");
        assert_eq!(before, *after);
    });
}

/// Bevy forgets which meshes have lightmaps and lights these without, until they become visible again. Lean matches forward.
#[test]
fn lightmapped_meshes_are_lit_as_bevy_has_them() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            scene(s);
            let material = StandardMaterial {
                lightmap_exposure: 3000.0,
                ..default()
            };
            let place = Transform::from_xyz(-0.6, 0.5, 1.6);
            let ball = s.mesh(Sphere::new(0.5), material, place);
            put_lightmaps(s, &[ball], false);
            s.default_camera(LeanDeferred::default());
        });
        let images = images(&mut headless);
        settled(&mut headless);
        lose_device(&mut headless);
        restore(&images, &mut headless);
        let lean = settled(&mut headless);
        assert_eq!(active_lean_views(&mut headless), 1);
        set_lean(&mut headless, false);
        let forward = settled(&mut headless);
        let difference = pixel_difference(&forward, &lean);
        println!("{difference}");
        assert!(difference.psnr > 45.0);
    });
}
