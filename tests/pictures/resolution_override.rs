//! Cameras whose main pass is smaller than their viewport, as upscalers such as DLSS need it, match forward.

use bevy::{
    camera::{MainPassResolutionOverride, Viewport},
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass},
    light::AmbientLight,
    material::OpaqueRendererMethod,
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        camera::{ExtractedCamera, MipBias, TemporalJitter},
        occlusion_culling::OcclusionCulling,
    },
};
use kit::{
    headless::Headless,
    lean::{active_lean_views, judge, report, set_lean, settled, show},
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::LEAST_PSNR,
};

const SIZE: UVec2 = UVec2::new(320, 240);

/// Size of the main pass; none for that of the viewport.
#[derive(Resource, Clone, Copy, Default)]
struct MainPassSize(Option<UVec2>);

/// Runs when Bevy's DLSS would insert it.
fn override_resolution(
    mut commands: Commands,
    size: Res<MainPassSize>,
    cameras: Query<Entity, With<ExtractedCamera>>,
) {
    for camera in &cameras {
        let mut camera = commands.entity(camera);
        match size.0 {
            Some(size) => camera.insert(MainPassResolutionOverride(size)),
            None => camera.remove::<MainPassResolutionOverride>(),
        };
    }
}

fn set_size(headless: &mut Headless, size: Option<UVec2>) {
    headless
        .app
        .sub_app_mut(RenderApp)
        .insert_resource(MainPassSize(size));
}

/// Solids and an emissive ball in Bevy's forward pass, with lights.
fn show_scene(headless: &mut Headless, camera: impl Bundle) {
    show(headless, |s| {
        s.solids();
        s.sun(true);
        s.mesh(
            Sphere::new(0.6),
            StandardMaterial {
                emissive: LinearRgba::rgb(0.3, 0.1, 0.3),
                opaque_render_method: OpaqueRendererMethod::Forward,
                ..default()
            },
            Transform::from_xyz(-0.2, 0.6, 0.3),
        );
        for x in [-2.0, 2.0] {
            s.spawn((
                PointLight {
                    intensity: 400_000.0,
                    shadow_maps_enabled: x < 0.0,
                    ..default()
                },
                Transform::from_xyz(x, 2.0, 1.0),
            ));
        }
        s.default_camera((
            AmbientLight {
                brightness: 300.0,
                ..default()
            },
            camera,
        ));
    });
}

fn app() -> Headless {
    let mut headless = Headless::new(SIZE);
    headless
        .app
        .sub_app_mut(RenderApp)
        .init_resource::<MainPassSize>()
        .add_systems(
            Render,
            override_resolution.in_set(RenderSystems::PrepareViews),
        );
    headless
}

/// Compares forward and lean with the override, with another one, and without.
fn compare(headless: &mut Headless, name: &str, camera: impl Bundle, sizes: [UVec2; 2]) {
    show_scene(headless, camera);
    let mut results = Vec::new();
    let full = settled(headless);
    for size in [Some(sizes[0]), Some(sizes[1]), None] {
        set_size(headless, size);
        set_lean(headless, false);
        let forward = settled(headless);
        set_lean(headless, true);
        let lean = settled(headless);
        assert_eq!(active_lean_views(headless), 1, "{name} is not lean");
        match size {
            Some(_) => assert!(
                pixel_difference(&full, &forward).psnr < 30.0,
                "{name}: the override changes nothing"
            ),
            None => assert!(forward.rgba == full.rgba, "{name}: the override stays"),
        }
        let size = size.map_or("full".into(), |size| format!("{}x{}", size.x, size.y));
        results.push(judge(
            &format!("override_{name}_{size}"),
            &forward,
            &lean,
            LEAST_PSNR,
        ));
    }
    report(results);
}

const SIZES: [UVec2; 2] = [UVec2::new(213, 160), UVec2::new(107, 201)];

#[test]
fn each_size_matches_forward() {
    in_own_process(|| {
        let headless = &mut app();
        compare(headless, "plain", (), SIZES);
        let in_a_viewport = Camera {
            viewport: Some(Viewport {
                physical_position: UVec2::new(37, 21),
                physical_size: UVec2::new(201, 155),
                ..default()
            }),
            ..default()
        };
        let sizes = [UVec2::new(134, 103), UVec2::new(67, 155)];
        compare(headless, "viewport", in_a_viewport, sizes);
        let with_occlusion_culling = (DepthPrepass, OcclusionCulling);
        compare(headless, "culling", with_occlusion_culling, SIZES);
        // The components that Bevy's `Dlss` requires.
        let as_with_dlss = (
            DepthPrepass,
            MotionVectorPrepass,
            MipBias(-0.6),
            TemporalJitter {
                offset: Vec2::new(0.3, -0.2),
            },
        );
        compare(headless, "dlss", as_with_dlss, SIZES);
    });
}
