//! Scenes and helpers that tests of several effects share.

use bevy::{
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass},
    material::OpaqueRendererMethod,
    prelude::*,
};
use bevy_lean_deferred::{
    effects::{LeanScreenSpaceGiAdvanced, LeanScreenSpaceReflectionsAdvanced},
    prelude::*,
};
pub use kit::analytic_light::light_at;
use kit::{
    analytic_light::{Seen, camera, look_at_once, see, surface},
    headless::Headless,
    lean::{change_cameras, show},
    scenes::SceneBuilder,
};

pub const SIZE: UVec2 = UVec2::new(480, 360);
pub const SMALL: UVec2 = UVec2::new(192, 144);
/// As tall as large pictures.
pub const TALL: UVec2 = UVec2::new(1440, 1440);

/// Default position of cameras.
pub const EYE: Vec3 = Vec3::new(0.0, 1.2, 3.0);

/// Reflections that do not fade at the picture's edge.
pub fn reflections() -> LeanScreenSpaceReflections {
    LeanScreenSpaceReflections {
        advanced: LeanScreenSpaceReflectionsAdvanced {
            edge_fade: 0.0,
            ..default()
        },
        ..default()
    }
}

/// Diffuse GI with a radius larger than these scenes: only the picture bounds the march.
pub fn gi() -> LeanScreenSpaceGi {
    LeanScreenSpaceGi {
        radius: 100.0,
        advanced: LeanScreenSpaceGiAdvanced {
            falloff: 0.1,
            ..default()
        },
        ..default()
    }
}

/// Moves all cameras by this many metres.
pub fn move_cameras(headless: &mut Headless, by: Vec3) {
    change_cameras(headless, |camera| {
        let mut transform = camera.get_mut::<Transform>().expect("cameras have one");
        transform.translation += by;
    });
}

/// Scattering of a test: none, or of a quality.
pub const OFF: Option<LeanQuality> = None;
pub const LOW: Option<LeanQuality> = Some(LeanQuality::Low);
pub const HIGH: Option<LeanQuality> = Some(LeanQuality::High);

pub fn scattering(quality: LeanQuality) -> LeanSubsurfaceScattering {
    LeanSubsurfaceScattering {
        quality,
        ..default()
    }
}

/// Gives a camera scattering of this quality, or takes it away.
pub fn scatter(camera: &mut EntityWorldMut, quality: Option<LeanQuality>) {
    match quality {
        Some(quality) => _ = camera.insert(scattering(quality)),
        None => _ = camera.remove::<LeanSubsurfaceScattering>(),
    }
}

/// As [`camera`], with scattering of this quality.
pub fn scattering_camera(
    s: &mut SceneBuilder,
    transform: Transform,
    sky: f32,
    quality: Option<LeanQuality>,
) -> Entity {
    let camera = camera(s, transform, sky, ());
    scatter(&mut s.world().entity_mut(camera), quality);
    camera
}

/// Spawns a large floor at this height.
pub fn spawn_floor(s: &mut SceneBuilder, material: StandardMaterial, height: f32) -> Entity {
    let plane = Plane3d::default().mesh().size(12.0, 12.0);
    s.mesh(plane, material, Transform::from_xyz(0.0, height, 0.0))
}

/// A camera at `eye` that looks at a point `height` above the middle of the floor.
pub fn looking(eye: Vec3, height: f32) -> Transform {
    Transform::from_translation(eye).looking_at(Vec3::Y * height, Vec3::Y)
}

/// Position and light of the floor at each pixel whose ray meets its plane.
pub fn floor(seen: &Seen) -> impl Iterator<Item = (Vec3, f32)> {
    let places = seen.on_plane(Vec3::ZERO, Vec3::Y);
    places.map(|(_, place, light)| (place, light))
}

/// A floor of one material between things of another, under a sky of `sky`.
pub fn courtyard(
    s: &mut SceneBuilder,
    floor: StandardMaterial,
    things: StandardMaterial,
    sky: f32,
    effects: impl Bundle,
) -> Entity {
    let plane = Plane3d::default().mesh().size(30.0, 30.0);
    s.mesh(plane, floor, Transform::default());
    for (x, z) in [(-1.2, -0.6), (0.2, -1.4), (1.3, -0.2)] {
        let place = Transform::from_xyz(x, 0.6, z).with_rotation(Quat::from_rotation_y(x));
        s.mesh(Cuboid::new(0.6, 1.2, 0.6), things.clone(), place);
    }
    let ball = Sphere::new(0.3).mesh().ico(8).expect("few subdivisions");
    s.mesh(ball, things, Transform::from_xyz(0.3, 0.3, 0.3));
    let from = looking(Vec3::new(0.0, 1.3, 3.2), 0.2);
    let shown = Camera {
        clear_color: ClearColorConfig::Custom(Color::linear_rgb(sky, sky, sky)),
        ..default()
    };
    camera(s, from, sky, (shown, effects))
}

/// Light of the floor within 10 m of its middle.
pub fn floor_light(seen: &Seen) -> Vec<f32> {
    let near = floor(seen).filter(|(place, _)| place.xz().length() < 10.0);
    near.map(|(_, light)| light).collect()
}

pub fn range(light: &[f32]) -> (f32, f32) {
    let least = light.iter().copied().fold(f32::INFINITY, f32::min);
    (least, light.iter().copied().fold(0.0, f32::max))
}

/// Direction of a floor's mirror ray at `place` for a viewer at `eye`.
pub fn mirrored(eye: Vec3, place: Vec3) -> Vec3 {
    (place - eye) * Vec3::new(1.0, -1.0, 1.0)
}

/// That ray; `None` where the viewer is at the place.
pub fn mirror_ray(eye: Vec3, place: Vec3) -> Option<Ray3d> {
    let direction = Dir3::new(mirrored(eye, place)).ok()?;
    Some(Ray3d::new(place, direction))
}

/// A material that glows with 1, drawn by Bevy's forward pass or by the camera's own renderer.
pub fn glowing(forward: bool) -> StandardMaterial {
    StandardMaterial {
        opaque_render_method: if forward {
            OpaqueRendererMethod::Forward
        } else {
            OpaqueRendererMethod::Auto
        },
        ..surface(0.0, 1.0)
    }
}

/// Adds the components that motion vectors need, if `motion`.
pub fn with_motion(motion: bool, camera: &mut EntityWorldMut) {
    if motion {
        camera.insert((DepthPrepass, MotionVectorPrepass));
    }
}

/// Replaces the app's scene and looks at the new one after `frames` frames. Pipelines of earlier scenes are not compiled again.
pub fn show_next(
    headless: &mut Headless,
    frames: usize,
    scene: impl FnOnce(&mut SceneBuilder),
) -> Seen {
    show(headless, scene);
    see(headless, frames)
}

/// Moves by this much in each [`step`].
#[derive(Component)]
pub struct Mover(pub Vec3);

/// Moves all movers in each of `count` frames, and returns the last one's light.
pub fn step(headless: &mut Headless, count: usize) -> Seen {
    let mut seen = None;
    for _ in 0..count {
        let world = headless.world();
        let mut movers = world.query::<(&mut Transform, &Mover)>();
        for (mut transform, mover) in movers.iter_mut(world) {
            transform.translation += mover.0;
        }
        seen = Some(look_at_once(headless));
    }
    seen.expect("frames were seen")
}
