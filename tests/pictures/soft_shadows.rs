//! Percentage-closer soft shadows, against Bevy forward.
//!
//! With Bevy's feature their width grows with the distance of blockers:
//! `cargo test --test pictures --features bevy/experimental_pbr_pcss soft_shadows`. Tests do not enable it by default: with it, Vulkan's
//! validation layer complains about each frame that Bevy renders on llvmpipe. Without it the same filters run, at their least width.

use bevy::{
    light::{CascadeShadowConfig, CascadeShadowConfigBuilder, ShadowFilteringMethod},
    pbr::{
        ExtractedDirectionalLight, ExtractedPointLight, MeshPipeline, MeshPipelineViewLayoutKey,
    },
    prelude::*,
    render::{Render, RenderApp, RenderSystems},
};
use bevy_lean_deferred::lighting::bevy::binding_numbers::view;
use kit::{
    headless::Headless,
    lean::{active_lean_views, change_cameras, judge, report, set_lean, settled, show},
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::{LEAST_PSNR, SceneBuilder},
};

const SIZE: UVec2 = UVec2::new(200, 150);

/// Lights with soft shadows. Components have this setting only with Bevy's feature `experimental_pbr_pcss`; the render world has fields for
/// it without it, too.
#[derive(Resource, Clone, Copy, Default, PartialEq, Debug)]
struct Soft {
    sun: bool,
    lamps: bool,
}

fn soften(
    soft: Res<Soft>,
    mut suns: Query<&mut ExtractedDirectionalLight>,
    mut lamps: Query<&mut ExtractedPointLight>,
) {
    for mut sun in &mut suns {
        sun.soft_shadow_size = soft.sun.then_some(20.0);
    }
    for mut lamp in &mut lamps {
        lamp.soft_shadows_enabled = soft.lamps;
    }
}

fn app() -> Headless {
    let mut headless = Headless::new(SIZE);
    headless
        .app
        .sub_app_mut(RenderApp)
        .init_resource::<Soft>()
        .add_systems(
            Render,
            soften
                .after(RenderSystems::ExtractCommands)
                .before(RenderSystems::PrepareAssets),
        );
    headless
}

/// True if Bevy is built with the feature: it then binds samplers for it. Without them it takes the distance of blockers as 0.
fn searches_for_blockers(headless: &Headless) -> bool {
    let render_world = headless.app.sub_app(RenderApp).world();
    let pipeline = render_world.resource::<MeshPipeline>();
    let layout = pipeline.get_view_layout(MeshPipelineViewLayoutKey::empty());
    let mut entries = layout.main_layout.entries.iter();
    entries.any(|entry| entry.binding == view::POINT_SHADOW_TEXTURES_LINEAR_SAMPLER)
}

fn set(headless: &mut Headless, soft: Soft) {
    let render_app = headless.app.sub_app_mut(RenderApp);
    render_app.insert_resource::<Soft>(soft);
}

/// Compares lean with forward under each filter.
fn compare(headless: &mut Headless, name: &str, soft: Soft, scene: impl FnOnce(&mut SceneBuilder)) {
    show(headless, |s| {
        s.solids();
        scene(s);
        s.default_camera(());
    });
    headless.frames(1);
    let is_soft = searches_for_blockers(headless);
    let filters = [
        ShadowFilteringMethod::Hardware2x2,
        ShadowFilteringMethod::Gaussian,
        ShadowFilteringMethod::Temporal,
    ];
    let results = filters.map(|filter| {
        change_cameras(headless, |camera| {
            camera.insert(filter);
        });
        set(headless, Soft::default());
        set_lean(headless, false);
        let hard = settled(headless);
        set(headless, soft);
        let forward = settled(headless);
        let softened = pixel_difference(&hard, &forward);
        set_lean(headless, true);
        let lean = settled(headless);
        let name = format!("{name}_{filter:?}");
        println!("{name}: hard to soft {softened}");
        assert_eq!(active_lean_views(headless), 1, "{name} is not lean");
        if is_soft && softened.largest < 16 {
            return Err(format!("{name} is not soft: {softened}"));
        }
        judge(&name, &forward, &lean, LEAST_PSNR)
    });
    if is_soft {
        // The validation layer complains about Bevy's samplers, with and without this crate: not every device can filter depth.
        let failures: Vec<String> = results.into_iter().filter_map(Result::err).collect();
        assert!(failures.is_empty(), "\n{}", failures.join("\n"));
    } else {
        report(results);
    }
}

/// A cascade in whose depth range blockers are far away.
fn small_cascade() -> CascadeShadowConfig {
    CascadeShadowConfigBuilder {
        num_cascades: 1,
        maximum_distance: 12.0,
        ..default()
    }
    .into()
}

#[test]
fn of_all_lights() {
    in_own_process(|| {
        let headless = &mut app();
        let sun = Soft {
            sun: true,
            lamps: false,
        };
        let lamps = Soft {
            sun: false,
            lamps: true,
        };
        compare(headless, "soft_sun", sun, |s| {
            let sun = s.sun(true);
            s.world().entity_mut(sun).insert(small_cascade());
        });
        compare(headless, "soft_point_light", lamps, |s| {
            s.spawn((
                PointLight {
                    intensity: 900_000.0,
                    radius: 2.5,
                    shadow_maps_enabled: true,
                    ..default()
                },
                Transform::from_xyz(-1.5, 2.5, 1.5),
            ));
        });
        compare(headless, "soft_spot_light", lamps, |s| {
            s.spawn((
                SpotLight {
                    intensity: 3_000_000.0,
                    radius: 2.5,
                    outer_angle: 0.7,
                    shadow_maps_enabled: true,
                    ..default()
                },
                Transform::from_xyz(-2.0, 5.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
            ));
        });
        // Hard shadows beside soft ones are unchanged.
        compare(headless, "soft_beside_hard", sun, |s| {
            s.sun(true);
            s.spawn((
                PointLight {
                    intensity: 300_000.0,
                    radius: 0.2,
                    shadow_maps_enabled: true,
                    ..default()
                },
                Transform::from_xyz(-1.5, 2.5, 1.5),
            ));
        });
    });
}
