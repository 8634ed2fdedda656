//! Debug views of all effects.

use bevy::{
    camera::Viewport,
    core_pipeline::{prepass::DepthPrepass, tonemapping::Tonemapping},
    material::OpaqueRendererMethod,
    prelude::*,
};
use bevy_lean_deferred::{effects::auto_exposure::MeteringPattern, prelude::*};
use kit::{
    headless::{Headless, Picture},
    lean::{build, change_cameras, instant_exposure, report, settled, show},
    log_watch,
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::build::ambient,
};

const SIZE: UVec2 = UVec2::new(192, 128);

/// One of each kind that is drawn in its own way.
const VIEWS: [DebugView; 11] = [
    DebugView::Albedo,
    DebugView::GeometricNormal,
    DebugView::DiffuseLight,
    DebugView::Forward,
    DebugView::AmbientOcclusion,
    DebugView::GiLight,
    DebugView::GiVisibility,
    DebugView::ReflectionLight,
    DebugView::ReflectionConfidence,
    DebugView::ReflectionHit,
    DebugView::ExposureWeights,
];

/// Puts the effect that `view` is of on a camera, and no other.
fn put_effect(camera: &mut EntityWorldMut, view: DebugView) {
    camera.remove::<(
        LeanScreenSpaceAmbientOcclusion,
        LeanScreenSpaceGi,
        LeanScreenSpaceReflections,
        LeanAutoExposure,
    )>();
    camera.insert(LeanDeferred::default());
    match view {
        DebugView::AmbientOcclusion => {
            camera.insert(LeanScreenSpaceAmbientOcclusion::default());
        }
        DebugView::GiLight | DebugView::GiVisibility => {
            camera.insert(LeanScreenSpaceGi::default());
        }
        DebugView::ReflectionLight | DebugView::ReflectionConfidence | DebugView::ReflectionHit => {
            camera.insert(LeanScreenSpaceReflections::default());
        }
        DebugView::ExposureWeights => {
            camera.insert(LeanAutoExposure {
                pattern: MeteringPattern::CenterWeighted,
                ..instant_exposure()
            });
        }
        _ => {}
    }
}

/// True if light bounces between frames while the effect runs that `view` is of.
fn bounces(view: DebugView) -> bool {
    matches!(
        view,
        DebugView::GiLight
            | DebugView::GiVisibility
            | DebugView::ReflectionLight
            | DebugView::ReflectionConfidence
            | DebugView::ReflectionHit
    )
}

/// A picture with `shown` on the camera, after `frames` in which light converges.
fn picture(headless: &mut Headless, shown: Option<LeanDebugView>, frames: usize) -> Picture {
    change_cameras(headless, |camera| match shown {
        Some(shown) => {
            camera.insert(shown);
        }
        None => {
            camera.remove::<LeanDebugView>();
        }
    });
    headless.settle();
    headless.frames(frames);
    settled(headless)
}

fn left(picture: &Picture) -> Picture {
    picture.crop(URect::new(0, 0, SIZE.x / 2, SIZE.y))
}

fn right(picture: &Picture) -> Picture {
    picture.crop(URect::new(SIZE.x / 2, 0, SIZE.x, SIZE.y))
}

/// With a split, the left part is that of the whole view, and the right part that of the picture, which comes back afterwards.
#[test]
fn views_cover_their_part_of_the_picture() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            s.solids();
            s.sun(false);
            let viewport = Viewport {
                physical_position: UVec2::new(16, 8),
                physical_size: SIZE - UVec2::new(32, 24),
                ..default()
            };
            let camera = Camera {
                viewport: Some(viewport),
                ..default()
            };
            s.default_camera((ambient(), camera));
        });
        let mut results = Vec::new();
        for shows in VIEWS {
            change_cameras(&mut headless, |camera| put_effect(camera, shows));
            let frames = if bounces(shows) { 12 } else { 1 };
            let before = picture(&mut headless, None, frames);
            let [whole, half] = [1.0, 0.5].map(|split| {
                let shown = Some(LeanDebugView { shows, split });
                picture(&mut headless, shown, frames)
            });
            let after = picture(&mut headless, None, frames);
            let differences = [
                pixel_difference(&left(&whole), &left(&half)),
                pixel_difference(&right(&before), &right(&half)),
                pixel_difference(&before, &after),
            ];
            let is_shown = pixel_difference(&before, &whole).psnr < 40.0;
            // While hits are shown, rough surfaces have the light of one frame of four.
            let least = if shows == DebugView::ReflectionHit {
                50.0
            } else {
                60.0
            };
            let is_right = differences.iter().all(|difference| difference.psnr > least);
            let line = format!(
                "{shows:?}: shown: {is_shown}; view: {}; beside it: {}; afterwards: {}",
                differences[0], differences[1], differences[2]
            );
            println!("{line}");
            results.push(if is_shown && is_right {
                Ok(())
            } else {
                Err(line)
            });
        }
        report(results);
    });
}

/// While a view is resized, textures of effects are larger than it is. Debug views show the part of the view alone.
#[test]
fn views_of_resized_cameras_are_not_scaled() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            s.solids();
            s.sun(false);
            s.default_camera(ambient());
        });
        let shown = [
            DebugView::GiLight,
            DebugView::ReflectionLight,
            DebugView::ReflectionHit,
        ];
        report(shown.map(|shows| {
            let shown = LeanDebugView { shows, split: 1.0 };
            change_cameras(&mut headless, |camera| {
                put_effect(camera, shows);
                camera.insert(shown);
            });
            for columns in [3, 4, 5] {
                change_cameras(&mut headless, |camera| {
                    let mut camera = camera.get_mut::<Camera>().expect("it is one");
                    camera.viewport = Some(Viewport {
                        physical_size: SIZE * UVec2::new(columns, 8) / 8,
                        ..default()
                    });
                });
                headless.settle();
                headless.frames(if columns == 3 { 70 } else { 2 });
            }
            headless.frames(20);
            let resized = settled(&mut headless);
            headless.frames(70);
            let at_rest = settled(&mut headless);
            let difference = pixel_difference(&resized, &at_rest);
            println!("{shows:?}: {difference}");
            if difference.psnr > 40.0 {
                Ok(())
            } else {
                Err(format!("{shows:?}: {difference}"))
            }
        }));
    });
}

/// Meshes that forward draws have their colour, with and without a prepass that draws their depth before lighting; all others are
/// magenta.
#[test]
fn forward_meshes_stand_out() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        let mut count = |method: OpaqueRendererMethod, has_prepass: bool| {
            show(&mut headless, |s| {
                s.sun(false);
                let green = |opaque_render_method| StandardMaterial {
                    base_color: Color::srgb(0.1, 0.8, 0.1),
                    opaque_render_method,
                    ..default()
                };
                s.mesh(
                    Cuboid::new(5.0, 3.0, 0.1),
                    green(OpaqueRendererMethod::Auto),
                    Transform::from_xyz(0.0, 0.5, -1.5),
                );
                s.mesh(
                    Sphere::new(0.8),
                    green(method),
                    Transform::from_xyz(0.0, 0.5, 0.0),
                );
                let shown = LeanDebugView::from(DebugView::Forward);
                let camera = s.default_camera((LeanDeferred::default(), shown));
                let mut camera = s.world().entity_mut(camera);
                camera.insert(Tonemapping::None);
                if has_prepass {
                    camera.insert(DepthPrepass);
                }
            });
            let picture = settled(&mut headless);
            let pixels = |is: fn(&[u8]) -> bool| picture.rgba.chunks(4).filter(|p| is(p)).count();
            let magenta = pixels(|p| p[1] < 4 && p[0].abs_diff(p[2]) < 4 && p[0] > 60);
            let green = pixels(|p| p[1] > 100 && p[1] / 2 > p[0] && p[1] / 2 > p[2]);
            println!("{method:?}, prepass {has_prepass}: {magenta} magenta, {green} green");
            [magenta, green]
        };
        let lean = count(OpaqueRendererMethod::Auto, false);
        let forward = [false, true].map(|prepass| count(OpaqueRendererMethod::Forward, prepass));
        assert!(lean[0] > 2000 && lean[1] == 0, "{lean:?}");
        for [magenta, green] in forward {
            assert!(magenta > 1000 && green > 200, "{forward:?}");
            assert!(magenta + green <= lean[0], "{lean:?}, {forward:?}");
        }
        let [without, with] = forward.map(|[magenta, _]| magenta);
        assert!(without.abs_diff(with) <= 20, "{forward:?}");
        log_watch::assert_validation_layer_silent();
    });
}
