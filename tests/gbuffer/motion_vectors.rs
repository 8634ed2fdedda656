//! The motion vectors of a lean camera are those that Bevy's prepass writes.

mod case;
mod culling;
mod custom_material;
mod pictures;
mod probe;
mod sorting;
mod targets;
mod vectors;

use bevy::{
    anti_alias::taa::TemporalAntiAliasing, diagnostic::FrameCount, material::OpaqueRendererMethod,
    prelude::*, render::RenderApp,
};
use bevy_lean_deferred::view::ActiveLeanView;
use kit::{headless::Headless, scenes::SceneBuilder};

const SIZE: UVec2 = UVec2::new(320, 240);
/// For tests that compare no picture.
const SMALL: UVec2 = UVec2::new(64, 48);

/// Marks moving meshes.
#[derive(Component)]
struct Mover;

fn camera_transform(angle: f32) -> Transform {
    let (sin, cos) = angle.sin_cos();
    Transform::from_xyz(6.0 * sin, 2.5, 6.0 * cos).looking_at(Vec3::new(0.0, 0.5, 0.0), Vec3::Y)
}

/// Solids of the G-buffer; balls that only forward draws in front of them, behind them and through the floor; an alpha-masked and an
/// emissive one. Sky beyond.
fn scene(s: &mut SceneBuilder, camera: impl Bundle) {
    s.solids();
    s.sun(false);
    for (x, z) in [(-2.0, 1.8), (0.2, -2.4), (2.6, 0.8)] {
        s.mesh(
            Sphere::new(0.5),
            StandardMaterial {
                opaque_render_method: OpaqueRendererMethod::Forward,
                ..Color::srgb(0.4, 0.3, 0.7).into()
            },
            Transform::from_xyz(x, 0.3, z),
        );
    }
    let checker = s.checker([255; 4], [255, 255, 255, 0]);
    s.mesh(
        Rectangle::new(1.2, 1.2),
        StandardMaterial {
            base_color_texture: Some(checker),
            alpha_mode: AlphaMode::Mask(0.5),
            ..default()
        },
        Transform::from_xyz(-1.0, 0.8, 1.8),
    );
    s.mesh(
        Sphere::new(0.3),
        StandardMaterial {
            emissive: LinearRgba::rgb(0.2, 0.6, 0.2),
            ..default()
        },
        Transform::from_xyz(1.6, 0.3, 1.6),
    );
    s.camera(camera_transform(0.0), camera);
}

/// Spawns a lean and a forward-only ball that will move.
fn movers(s: &mut SceneBuilder) {
    for (x, method) in [
        (0.0, OpaqueRendererMethod::Auto),
        (1.2, OpaqueRendererMethod::Forward),
    ] {
        let ball = s.mesh(
            Sphere::new(0.4),
            StandardMaterial {
                opaque_render_method: method,
                ..Color::srgb(0.9, 0.6, 0.2).into()
            },
            Transform::from_xyz(x, 1.0, 1.0),
        );
        s.world().entity_mut(ball).insert(Mover);
    }
}

fn turn_camera(world: &mut World, angle: f32) {
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    *cameras.single_mut(world).expect("one camera") = camera_transform(angle);
}

fn shift_movers(world: &mut World, by: Vec3) {
    let mut movers = world.query_filtered::<&mut Transform, With<Mover>>();
    for mut mover in movers.iter_mut(world) {
        mover.translation += by;
    }
}

fn taa() -> impl Bundle {
    TemporalAntiAliasing::default()
}

fn still_and_moving(s: &mut SceneBuilder, camera: impl Bundle) {
    scene(s, camera);
    movers(s);
}

fn move_all(world: &mut World, frame: usize) {
    turn_camera(world, frame as f32 * 0.01);
    shift_movers(world, Vec3::new(0.05, 0.02, -0.03));
}

/// Renders until all is loaded, then `frames` frames without history. Frame numbers are the same in each app, so that jitter, noise and TAA
/// history are the same.
fn align(headless: &mut Headless, frames: u32) {
    headless.settle();
    let world = headless.world();
    let made = &mut world.resource_mut::<FrameCount>().0;
    *made = ALIGNED.checked_sub(frames).expect("not so many");
    let mut gathering = world.query::<&mut TemporalAntiAliasing>();
    for mut taa in gathering.iter_mut(world) {
        taa.reset = true;
    }
    headless.frames(frames as usize);
}

/// Frame count of aligned apps.
const ALIGNED: u32 = 256;

/// The view of the last frame, if it was lean.
fn active_view(headless: &mut Headless) -> Option<ActiveLeanView> {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query::<&ActiveLeanView>();
    views.iter(world).next().copied()
}
