//! Effects that are added, removed and changed while their cameras are rendered.

use bevy::{
    camera::{ScalingMode, Viewport},
    prelude::*,
    render::{
        RenderApp,
        render_resource::{PipelineCache, PipelineDescriptor},
    },
};
use bevy_lean_deferred::{
    effects::{
        LeanScreenSpaceGiAdvanced, LeanScreenSpaceReflectionsAdvanced, TimesEachDispatch,
        ViewHistory, diffuse_gi::ViewGi, reflections::ViewReflections,
    },
    prelude::*,
};
use kit::{
    analytic_light::{Seen, look_at_once, see, surface},
    analytic_mirrors::metal,
    headless::Headless,
    lean::{build, change_cameras},
    log_watch,
    own_process::in_own_process,
    scenes::SceneBuilder,
};

use super::scenes::{courtyard, gi, reflections};

const SIZE: UVec2 = UVec2::new(96, 72);

fn both() -> (LeanScreenSpaceGi, LeanScreenSpaceReflections) {
    default()
}

fn stage(s: &mut SceneBuilder) {
    s.solids();
    s.sun(false);
    s.default_camera((LeanDeferred::default(), both()));
}

fn holds_anything(headless: &mut Headless) -> bool {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query::<(Has<ViewGi>, Has<ViewReflections>, Has<ViewHistory>)>();
    let held = views
        .iter(world)
        .flat_map(|(gi, reflections, history)| [gi, reflections, history]);
    let held: Vec<bool> = held.collect();
    let holds = held.contains(&true);
    // All three of them, or none.
    assert_eq!(
        held.iter().filter(|held| **held).count(),
        if holds { 3 } else { 0 }
    );
    holds
}

fn is_finite(headless: &mut Headless) -> bool {
    let light = kit::hdr::light(headless);
    light
        .texels
        .iter()
        .flatten()
        .all(|x| x.is_finite() && *x < 1e4)
}

#[test]
fn it_comes_and_goes() {
    in_own_process(|| {
        let mut headless = build(SIZE, stage);
        headless.settle();
        assert!(holds_anything(&mut headless));
        for frame in 0..12 {
            change_cameras(&mut headless, |camera| {
                if frame % 2 == 0 {
                    camera.remove::<(LeanScreenSpaceGi, LeanScreenSpaceReflections)>();
                } else {
                    camera.insert(both());
                }
            });
            headless.frames(1);
            assert_eq!(
                holds_anything(&mut headless),
                frame % 2 == 1,
                "frame {frame}"
            );
        }
        log_watch::assert_validation_layer_silent();
    });
}

/// Labels of the effects' pipelines that were requested.
fn pipelines(headless: &Headless) -> Vec<String> {
    let render_world = headless.app.sub_app(RenderApp).world();
    let pipelines = render_world.resource::<PipelineCache>().pipelines();
    let labels = pipelines.filter_map(|pipeline| match &pipeline.descriptor {
        PipelineDescriptor::ComputePipelineDescriptor(compute) => compute.label.clone(),
        PipelineDescriptor::RenderPipelineDescriptor(render) => render.label.clone(),
    });
    let of_effects = [
        "debug_view",
        "diffuse_gi",
        "history",
        "reflections",
        "subsurface",
    ];
    labels
        .map(String::from)
        .filter(|label| {
            let folder = label.strip_prefix("lean_deferred/effects/");
            folder.is_some_and(|folder| of_effects.iter().any(|effect| folder.starts_with(effect)))
        })
        .collect()
}

/// Without the components nothing of the effects is compiled.
#[test]
fn cameras_without_compile_nothing() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            s.solids();
            s.sun(true);
            s.default_camera(LeanDeferred::default());
        });
        headless.settle();
        assert_eq!(pipelines(&headless), [""; 0]);
        change_cameras(&mut headless, |camera| {
            camera.insert(both());
        });
        headless.settle();
        let with = pipelines(&headless);
        println!("{with:?}");
        assert!(with.len() >= 8);
    });
}

/// However often effects are switched: frames without them equal those of a camera that never had them, and frames with them equal those
/// after a cut, so that they contain nothing of an older frame.
#[test]
fn pictures_do_not_depend_on_what_was_switched_before() {
    in_own_process(|| {
        type Change = fn(&mut EntityWorldMut);
        let effects: [(&str, Change); 3] = [
            ("diffuse GI", |camera| {
                camera.insert(gi());
            }),
            ("reflections", |camera| {
                camera.insert(reflections());
            }),
            ("both", |camera| {
                camera.insert((gi(), reflections()));
            }),
        ];
        let mut headless = build(SIZE, |s| {
            // Smooth enough that no rays scatter: those of the first frames would depend on their phase.
            let floor = StandardMaterial {
                metallic: 0.5,
                ..metal(0.1)
            };
            courtyard(s, floor, surface(0.5, 0.3), 0.4, ());
        });
        let without = see(&mut headless, 2);
        for (name, insert) in effects {
            change_cameras(&mut headless, insert);
            let steady = see(&mut headless, 12);
            change_cameras(&mut headless, |camera| {
                camera.insert(CameraCut);
            });
            let after_cut = [(); 3].map(|()| look_at_once(&mut headless));
            change_cameras(&mut headless, |camera| {
                camera.remove::<(LeanScreenSpaceGi, LeanScreenSpaceReflections)>();
            });
            assert_eq!(
                most_off(&look_at_once(&mut headless), &without),
                0.0,
                "{name}"
            );
            let mut most = [0.0_f32; 2];
            for shown in [1, 0, 2, 0, 0, 3, 0, 1, 0, 1] {
                for expected in &after_cut[..shown] {
                    change_cameras(&mut headless, insert);
                    most[1] = most[1].max(most_off(&look_at_once(&mut headless), expected));
                }
                if shown == 0 {
                    change_cameras(&mut headless, |camera| {
                        camera.remove::<(LeanScreenSpaceGi, LeanScreenSpaceReflections)>();
                    });
                    most[0] = most[0].max(most_off(&look_at_once(&mut headless), &without));
                }
            }
            change_cameras(&mut headless, insert);
            let again = see(&mut headless, 12);
            let (off, same) = (most_off(&steady, &without), most_off(&steady, &again));
            println!(
                "{name}: without off by {:.5}, with {:.5}; at last {same:.5}; it changes {off:.3}",
                most[0], most[1]
            );
            assert!(
                off > 0.04 && most[0] == 0.0 && most[1] < 1e-3 && same < 1e-3,
                "{name}"
            );
            change_cameras(&mut headless, |camera| {
                camera.remove::<(LeanScreenSpaceGi, LeanScreenSpaceReflections)>();
            });
            headless.settle();
        }
    });
}

fn most_off(a: &Seen, b: &Seen) -> f32 {
    let pairs = a
        .light
        .texels
        .iter()
        .flatten()
        .zip(b.light.texels.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Bounced light stays as bright in the first frame of another resolution or quality, where after a cut it is gone.
#[test]
fn light_stays_when_settings_change() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            // Without a sky, whose light would take the place of bounced light after a cut.
            courtyard(s, surface(0.5, 0.0), surface(0.5, 0.3), 0.0, gi());
        });
        let steady = see(&mut headless, 12);
        change_cameras(&mut headless, |camera| {
            camera.insert(CameraCut);
        });
        let lost = mean_off(&look_at_once(&mut headless), &steady);
        see(&mut headless, 12);
        let (half, full) = (LeanResolution::Half, LeanResolution::Full);
        for (resolution, quality) in [
            (full, LeanQuality::Medium),
            (half, LeanQuality::Medium),
            (half, LeanQuality::High),
        ] {
            change_cameras(&mut headless, |camera| {
                camera.insert(LeanScreenSpaceGi {
                    resolution,
                    quality,
                    ..gi()
                });
            });
            let first = look_at_once(&mut headless);
            let off = mean_off(&first, &see(&mut headless, 12));
            println!("{resolution}, {quality}: {off:.5}; after a cut {lost:.5}");
            assert!(off < 0.25 * lost);
        }
    });
}

fn mean_off(a: &Seen, b: &Seen) -> f32 {
    let pairs = a.light.texels.iter().zip(&b.light.texels);
    let sum: f32 = pairs.map(|(a, b)| (a[1] - b[1]).abs()).sum();
    sum / a.light.texels.len() as f32
}

/// Effects come with `LeanDeferred`, and are off where an app removes it on purpose: the status tells so, and no warning does.
#[test]
fn without_lean_deferred_it_is_off() {
    in_own_process(|| {
        let mut camera = Entity::PLACEHOLDER;
        let mut headless = build(SIZE, |s| {
            s.solids();
            s.sun(false);
            camera = s.default_camera(both());
        });
        headless.settle();
        assert!(holds_anything(&mut headless));
        headless.world().entity_mut(camera).remove::<LeanDeferred>();
        headless.settle();
        headless.frames(2);
        assert!(!holds_anything(&mut headless));
        let status = headless.world().get::<LeanStatus>(camera);
        let status = status.expect("it has effects").clone();
        let expected = LeanStatus {
            diffuse_gi: EffectStatus::Off(LeanOffReason::NoLeanDeferred),
            reflections: EffectStatus::Off(LeanOffReason::NoLeanDeferred),
            ..default()
        };
        assert_eq!(status, expected);
        let warnings = log_watch::messages_with("it has no `LeanDeferred`");
        assert!(warnings.is_empty(), "{warnings:?}");
    });
}

#[test]
#[ignore = "nightly: presets have four of these"]
fn each_quality_has_each_resolution() {
    in_own_process(|| {
        let mut headless = build(SIZE, stage);
        for quality in LeanQuality::ALL {
            for resolution in LeanResolution::ALL {
                change_cameras(&mut headless, |camera| {
                    camera.insert(LeanScreenSpaceGi {
                        quality,
                        resolution,
                        ..default()
                    });
                });
                headless.settle();
                assert!(is_finite(&mut headless), "{quality:?}, {resolution:?}");
            }
        }
        for quality in LeanQuality::ALL {
            for resolution in LeanResolution::ALL {
                change_cameras(&mut headless, |camera| {
                    camera.insert(LeanScreenSpaceReflections {
                        quality,
                        resolution,
                        ..default()
                    });
                });
                headless.settle();
                assert!(is_finite(&mut headless), "{quality:?}, {resolution:?}");
            }
        }
        log_watch::assert_validation_layer_silent();
    });
}

/// Settings may have any value, also orders of magnitude beyond what is useful.
#[test]
fn settings_may_be_anything() {
    in_own_process(|| {
        let mut headless = build(SIZE, stage);
        headless.settle();
        for number in [0.0, -1.0, 1e-30, 1e30, f32::INFINITY, f32::NAN] {
            change_cameras(&mut headless, |camera| {
                camera.insert(LeanScreenSpaceGi {
                    radius: number,
                    intensity: number,
                    advanced: LeanScreenSpaceGiAdvanced {
                        bias: number,
                        falloff: number,
                    },
                    ..default()
                });
                camera.insert(LeanScreenSpaceReflections {
                    thickness: number,
                    max_roughness: number,
                    advanced: LeanScreenSpaceReflectionsAdvanced {
                        edge_fade: number,
                        ..default()
                    },
                    intensity: number,
                    ..default()
                });
            });
            assert!(is_finite(&mut headless), "{number}");
        }
        log_watch::assert_validation_layer_silent();
    });
}

#[test]
fn views_may_be_anything() {
    in_own_process(|| check_views(Projection::default()));
}

#[test]
#[ignore = "nightly: another projection"]
fn orthographic_views_may_be_anything() {
    in_own_process(|| {
        check_views(Projection::Orthographic(OrthographicProjection {
            scaling_mode: ScalingMode::FixedVertical {
                viewport_height: 5.0,
            },
            ..OrthographicProjection::default_3d()
        }));
    });
}

/// Views of any kind may follow one another without a cut.
fn check_views(projection: Projection) {
    let mut headless = build(SIZE, stage);
    headless.settle();
    let viewports = [
        (0, 0, 96, 72),
        (13, 7, 41, 33),
        (95, 71, 1, 1),
        (2, 3, 5, 3),
    ];
    for (x, y, width, height) in viewports {
        change_cameras(&mut headless, |camera| {
            camera.insert(projection.clone());
            if let Some(mut camera) = camera.get_mut::<Camera>() {
                camera.viewport = Some(Viewport {
                    physical_position: UVec2::new(x, y),
                    physical_size: UVec2::new(width, height),
                    ..default()
                });
            }
        });
        headless.settle();
        assert!(is_finite(&mut headless), "{width}×{height}");
    }
    log_watch::assert_validation_layer_silent();
}

/// The light of a view with this many rows, in its first frame and once all is compiled, and the heights of its reflections' textures then.
fn with_rows(headless: &mut Headless, rows: u32) -> ([Seen; 2], Vec<u32>) {
    change_cameras(headless, |camera| {
        let mut camera = camera.get_mut::<Camera>().expect("it is one");
        camera.viewport = Some(Viewport {
            physical_size: UVec2::new(64, rows),
            ..default()
        });
    });
    let seen = [look_at_once(headless), see(headless, 12)];
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query::<&ViewReflections>();
    let view = views.single(world).expect("there are reflections");
    (
        seen,
        view.textures().map(|texture| texture.height()).collect(),
    )
}

/// A view grows to a number of rows at which its texels become larger, and shrinks again.
#[test]
fn texels_grow_and_shrink_with_the_view() {
    in_own_process(|| {
        let mut headless = build(UVec2::new(64, 1500), |s| {
            let effects = (gi(), reflections());
            courtyard(s, metal(0.2), surface(0.5, 0.3), 0.4, effects);
        });
        see(&mut headless, 2);
        let shown = [1438, 1442, 1438].map(|rows| {
            let (seen, heights) = with_rows(&mut headless, rows);
            let side = reflections().texel_side(rows);
            // Textures keep the size of a larger view for some frames.
            let allocated = [rows, 1500].map(|rows| rows.div_ceil(side));
            let is_of_side = allocated.iter().any(|rows| heights.contains(rows));
            assert!(is_of_side, "{heights:?}");
            let mut light = seen
                .iter()
                .flat_map(|seen| seen.light.texels.iter().flatten());
            assert!(light.all(|x| x.is_finite() && *x < 2.0), "{rows} rows");
            seen
        });
        let [[_, before], _, [_, after]] = &shown;
        let off = most_off(before, after);
        println!("off by {off}");
        assert!(off < 1e-3);
        log_watch::assert_validation_layer_silent();
    });
}

/// Dispatches in separate passes give the same result as in one.
#[test]
fn timed_one_by_one_they_find_the_same() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            let effects = (gi(), reflections());
            courtyard(s, metal(0.2), surface(0.5, 0.3), 0.4, effects);
        });
        let together = see(&mut headless, 24);
        let render_app = headless.app.sub_app_mut(RenderApp);
        render_app.insert_resource(TimesEachDispatch);
        let one_by_one = see(&mut headless, 24);
        let off = most_off(&together, &one_by_one);
        println!("off by {off}");
        assert!(off < 1e-4);
        log_watch::assert_validation_layer_silent();
    });
}
