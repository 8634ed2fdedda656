//! Meshes that are removed while a window is minimised: its cameras are active, their target has size 0, and Bevy keeps their phases.

use bevy::{
    camera::visibility::VisibilitySystems,
    core_pipeline::prepass::DepthPrepass,
    material::OpaqueRendererMethod,
    prelude::*,
    render::{RenderApp, camera::ExtractedCamera, view::ExtractedView},
};
use bevy_lean_deferred::LeanDeferred;
use kit::{
    headless::Headless,
    lean::{active_lean_views, build, settled},
    log_watch,
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::SceneBuilder,
};

const SIZE: UVec2 = UVec2::new(96, 64);

/// True while the targets of cameras have size 0.
#[derive(Resource, Default)]
struct Minimised(bool);

/// Sets target sizes as `camera_system` does when a window loses its size and regains it.
fn minimise(minimised: Res<Minimised>, mut cameras: Query<&mut Camera>) {
    for mut camera in &mut cameras {
        if let Some(info) = &mut camera.computed.target_info {
            info.physical_size = if minimised.0 { UVec2::ZERO } else { SIZE };
        }
    }
}

/// Despawns and hides meshes while minimised: lean, forward, masked and blended ones.
fn check(name: &str, extra: impl Bundle + Clone) {
    let mut despawned = Vec::new();
    let mut hidden = Vec::new();
    let mut headless = build(SIZE, |s| {
        s.floor();
        s.sun(false);
        for (z, method, alpha_mode) in [
            (-1.5, OpaqueRendererMethod::Auto, AlphaMode::Opaque),
            (-0.5, OpaqueRendererMethod::Forward, AlphaMode::Opaque),
            (0.5, OpaqueRendererMethod::Auto, AlphaMode::Mask(0.5)),
            (1.5, OpaqueRendererMethod::Auto, AlphaMode::Blend),
        ] {
            let mut ball = |x| {
                s.mesh(
                    Sphere::new(0.3),
                    StandardMaterial {
                        base_color: Color::srgb(0.9, 0.1, 0.1),
                        opaque_render_method: method,
                        alpha_mode,
                        ..default()
                    },
                    Transform::from_xyz(x, 0.4, z),
                )
            };
            despawned.push(ball(-1.0));
            hidden.push(ball(0.0));
            ball(1.0);
        }
        s.default_camera((LeanDeferred::default(), extra.clone()));
    });
    headless.app.init_resource::<Minimised>().add_systems(
        PostUpdate,
        minimise.before(VisibilitySystems::CheckVisibility),
    );
    let before = settled(&mut headless);
    assert_eq!(active_lean_views(&mut headless), 1);

    let set = |headless: &mut Headless, minimised: bool| {
        headless.world().insert_resource(Minimised(minimised));
        headless.frames(3);
    };
    set(&mut headless, true);
    let render_world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views =
        render_world.query_filtered::<(), (With<ExtractedView>, With<ExtractedCamera>)>();
    assert_eq!(
        views.iter(render_world).count(),
        0,
        "{name}: it is still drawn"
    );
    for &mesh in &despawned {
        headless.world().despawn(mesh);
    }
    for &mesh in &hidden {
        headless.world().entity_mut(mesh).insert(Visibility::Hidden);
    }
    // New meshes reuse the GPU slots of the removed ones: stale items would show them there.
    let mut s = SceneBuilder {
        headless: &mut headless,
    };
    for i in 0..8 {
        s.mesh(
            Cuboid::from_length(0.3),
            StandardMaterial::from(Color::srgb(0.1, 0.1, 0.9)),
            Transform::from_xyz(0.4 * i as f32 - 1.4, 1.2, 0.0),
        );
    }
    headless.frames(3);
    headless.world().insert_resource(Minimised(false));
    let film = headless.film(6, |_, _| {});
    assert_eq!(active_lean_views(&mut headless), 1);

    // Phases of deactivated cameras are recreated.
    for is_active in [false, true] {
        let world = headless.world();
        let mut cameras = world.query::<&mut Camera>();
        cameras.single_mut(world).expect("one").is_active = is_active;
        headless.frames(3);
    }
    let expected = settled(&mut headless);
    let gone = pixel_difference(&before, &expected);
    assert!(gone.psnr < 35.0, "{name}: nothing to tell apart, {gone}");
    let wrong: Vec<String> = (film.iter().enumerate())
        .map(|(frame, picture)| (frame, pixel_difference(&expected, picture)))
        .inspect(|(frame, difference)| println!("{name}, frame {frame} after: {difference}"))
        .filter(|(_, difference)| difference.psnr < 50.0)
        .map(|(frame, difference)| format!("{name}, frame {frame}: {difference}"))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    log_watch::assert_validation_layer_silent();
}

#[test]
fn meshes_that_go_while_a_window_is_minimised_stay_away() {
    in_own_process(|| {
        check("no prepass", ());
        check("depth prepass", DepthPrepass);
    });
}
