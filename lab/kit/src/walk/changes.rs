//! Changes that several features share, or that are longer than a few lines.

use bevy::{camera::Hdr, light::LightProbe, prelude::*, render::render_resource::Extent3d};
use bevy_lean_deferred::prelude::*;

use super::Walk;
use crate::{renderer::Renderer, scenes::build::material};

/// More than the lights for which lean cameras cull per pixel.
const MANY_LIGHTS: usize = 2100;

pub(super) fn point_light(walk: &mut Walk, shadow_maps_enabled: bool) -> Vec<Entity> {
    let light = PointLight {
        intensity: 300_000.0,
        range: 12.0,
        shadow_maps_enabled,
        ..default()
    };
    let place = Transform::from_translation(walk.ahead(0.5, 2.5, 4.0));
    vec![walk.scene().spawn((light, place))]
}

pub(super) fn spot_light(walk: &mut Walk, shadow_maps_enabled: bool) -> Vec<Entity> {
    let light = SpotLight {
        intensity: 500_000.0,
        range: 15.0,
        shadow_maps_enabled,
        ..default()
    };
    let place = Transform::from_translation(walk.ahead(-1.0, 4.0, 2.0));
    let target = walk.ahead(0.5, 0.0, 5.0);
    vec![
        walk.scene()
            .spawn((light, place.looking_at(target, Vec3::Y))),
    ]
}

/// Small lights all over the floor before the camera.
pub(super) fn many_lights(walk: &mut Walk) -> Vec<Entity> {
    let corner = walk.ahead(-5.0, 0.3, 2.0);
    let lights = (0..MANY_LIGHTS).map(move |number| {
        let [x, z] = [number % 42, number / 42].map(|step| 0.24 * step as f32);
        let light = PointLight {
            intensity: 4_000.0,
            range: 0.5,
            ..default()
        };
        let place = corner + Vec3::new(x, 0.0, -z);
        (light, Transform::from_translation(place))
    });
    walk.headless.world().spawn_batch(lights).collect()
}

/// Spawns a light probe all around the camera and what it sees.
pub(super) fn probe(walk: &mut Walk, light: impl Bundle) -> Vec<Entity> {
    let place = Transform::from_translation(walk.ahead(0.0, 1.0, 4.0));
    let place = place.with_scale(Vec3::splat(14.0));
    vec![walk.scene().spawn((LightProbe::default(), light, place))]
}

/// Spawns a ball of a new material, which `change` makes special.
pub(super) fn ball(walk: &mut Walk, change: impl FnOnce(&mut StandardMaterial)) -> Vec<Entity> {
    let mut surface = material((0.75, 0.4, 0.25), 0.0, 0.35);
    change(&mut surface);
    let mesh = Sphere::new(0.5)
        .mesh()
        .uv(32, 16)
        .with_generated_tangents()
        .expect("a sphere has all that tangents need");
    // Beside the balls that came just before.
    let right = 1.2 * ((walk.came % 3) as f32 - 1.0);
    let place = Transform::from_translation(walk.ahead(right, 0.8, 4.0));
    vec![walk.scene().mesh(mesh, surface, place)]
}

/// Spawns a camera that draws a bar over the picture.
pub(super) fn hud(walk: &mut Walk) -> Vec<Entity> {
    let over = Camera {
        order: 1,
        clear_color: ClearColorConfig::None,
        ..default()
    };
    let target = walk.headless.render_target();
    let mut s = walk.scene();
    let camera = s.spawn((Camera2d, over, Hdr, Msaa::Off, target));
    let bar = Node {
        width: Val::Percent(40.0),
        height: Val::Percent(10.0),
        ..default()
    };
    let bar = s.spawn((bar, BackgroundColor(Color::WHITE), UiTargetCamera(camera)));
    vec![bar, camera]
}

/// Sets the levels of GI and reflections, where the camera has them.
pub(super) fn set_levels(walk: &mut Walk, quality: LeanQuality, resolution: LeanResolution) {
    let mut camera = walk.camera_mut();
    if let Some(mut gi) = camera.get_mut::<LeanScreenSpaceGi>() {
        (gi.quality, gi.resolution) = (quality, resolution);
    }
    if let Some(mut reflections) = camera.get_mut::<LeanScreenSpaceReflections>() {
        (reflections.quality, reflections.resolution) = (quality, resolution);
    }
}

pub(super) fn resize(walk: &mut Walk, size: UVec2) {
    let target = walk.headless.target.clone();
    let mut images = walk.headless.world().resource_mut::<Assets<Image>>();
    let mut image = images.get_mut(&target).expect("the target is there");
    image.resize(Extent3d {
        width: size.x,
        height: size.y,
        depth_or_array_layers: 1,
    });
}

/// The camera jumps to `aside` of its path.
pub(super) fn cut(walk: &mut Walk, aside: f32) {
    walk.aside = aside;
    walk.place();
    if walk.renderer == Renderer::Lean {
        walk.camera_mut().insert(CameraCut);
    }
}
