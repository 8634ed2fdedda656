//! The visibility mask exists only where lights tell visible meshes apart.

use bevy::{
    camera::visibility::RenderLayers,
    light::{ClusteredDecal, PointLight, SpotLight},
    prelude::*,
};
use bevy_lean_deferred::gbuffer::{GBufferTargets, GBufferUsage};

use kit::{
    headless::{Headless, Picture},
    lean::{build, judge, report, set_lean},
    metrics::difference,
    own_process::in_own_process,
    scenes::{SceneBuilder, build::ambient},
};

const SIZE: UVec2 = UVec2::new(200, 150);
const MASK: GBufferTargets = GBufferTargets::VISIBILITY_MASK;
const NONE: GBufferTargets = GBufferTargets::empty();

/// Layers of camera, light and ball; `None` without the component.
struct Layers {
    camera: Option<RenderLayers>,
    light: Option<RenderLayers>,
    ball: Option<RenderLayers>,
}

fn on(layers: &[usize]) -> Option<RenderLayers> {
    Some(RenderLayers::from_layers(layers))
}

fn scene(s: &mut SceneBuilder, layers: Layers) -> [Entity; 2] {
    s.solids();
    let light = s.spawn((
        PointLight {
            intensity: 1_000_000.0,
            ..default()
        },
        Transform::from_xyz(1.0, 3.0, 3.0),
    ));
    let ball = s.mesh(
        Sphere::new(0.5).mesh().uv(24, 12),
        Color::srgb(0.8, 0.3, 0.2),
        Transform::from_xyz(0.0, 0.5, 1.5),
    );
    let camera = s.default_camera(ambient());
    for (entity, layers) in [
        (camera, layers.camera),
        (light, layers.light),
        (ball, layers.ball),
    ] {
        if let Some(layers) = layers {
            s.world().entity_mut(entity).insert(layers);
        }
    }
    [light, ball]
}

fn show(layers: Layers) -> (Headless, [Entity; 2]) {
    let mut headless = Headless::new(SIZE);
    let entities = show_in(&mut headless, layers);
    (headless, entities)
}

fn show_in(headless: &mut Headless, layers: Layers) -> [Entity; 2] {
    let mut entities = [Entity::PLACEHOLDER; 2];
    kit::lean::show(headless, |s| entities = scene(s, layers));
    set_lean(headless, true);
    headless.settle();
    headless.frames(3);
    entities
}

fn targets(headless: &mut Headless) -> GBufferTargets {
    let world = headless.world();
    let mut cameras = world.query::<&GBufferUsage>();
    let usage = cameras.single(world).expect("there is one lean camera");
    assert!(usage.is_active());
    usage.targets
}

#[test]
fn the_mask_exists_where_lights_tell_meshes_apart() {
    in_own_process(|| {
        let cases = [
            ("nothing has layers", None, None, None, NONE),
            ("no light has", on(&[0, 1]), None, on(&[1]), NONE),
            (
                "the light is on all",
                on(&[0, 1]),
                on(&[0, 1]),
                on(&[1]),
                NONE,
            ),
            (
                "the light is on more than all",
                on(&[0, 1]),
                on(&[0, 1, 2]),
                on(&[1]),
                NONE,
            ),
            ("one layer is seen", None, on(&[0, 1]), on(&[0, 1]), NONE),
            ("the light is not seen", None, on(&[1]), on(&[0, 1]), NONE),
            ("high layers", on(&[0, 500]), on(&[500]), on(&[500]), MASK),
            ("no mesh has", on(&[0, 1]), on(&[1]), None, NONE),
            ("mesh and light have", on(&[0, 1]), on(&[1]), on(&[1]), MASK),
        ];
        let mut headless = Headless::new(SIZE);
        for (name, camera, light, ball, expected) in cases {
            let layers = Layers {
                camera,
                light,
                ball,
            };
            show_in(&mut headless, layers);
            assert_eq!(targets(&mut headless), expected, "{name}");
        }
    });
}

/// Layers that change at run time give the picture of a scene that had them from the start.
#[test]
fn layers_change_at_run_time() {
    in_own_process(|| {
        let start = |light: Option<RenderLayers>, ball: Option<RenderLayers>| Layers {
            camera: on(&[0, 1, 2]),
            light,
            ball,
        };
        let picture = |layers: Layers| show(layers).0.capture();
        let light_on_1 = picture(start(on(&[1]), None));
        let ball_on_2 = picture(start(on(&[1]), on(&[2])));
        let (mut headless, [light, ball]) = show(start(None, None));
        let mut results = Vec::new();
        let mut check = |name: &str, headless: &mut Headless, expected: &Picture| {
            headless.settle();
            headless.frames(3);
            results.push(judge(name, expected, &headless.capture(), 60.0));
        };

        headless
            .world()
            .entity_mut(light)
            .insert(RenderLayers::layer(1));
        check("light", &mut headless, &light_on_1);
        headless
            .world()
            .entity_mut(ball)
            .insert(RenderLayers::layer(1));
        check("ball", &mut headless, &picture(start(on(&[1]), on(&[1]))));
        assert_eq!(targets(&mut headless), MASK);
        headless
            .world()
            .entity_mut(ball)
            .insert(RenderLayers::layer(2));
        check("other layer", &mut headless, &ball_on_2);
        headless.world().entity_mut(ball).remove::<RenderLayers>();
        check("without", &mut headless, &light_on_1);
        headless
            .world()
            .entity_mut(ball)
            .insert(RenderLayers::layer(2));
        check("again", &mut headless, &ball_on_2);
        headless.world().entity_mut(light).remove::<RenderLayers>();
        check("all lit", &mut headless, &picture(start(None, on(&[2]))));
        assert_eq!(targets(&mut headless), NONE);
        report(results);
    });
}

/// Six lights in a row, some of them only on layer 1, in front of a wall on layer 0.
fn row_of_lights(s: &mut SceneBuilder, on_another_layer: &[usize]) -> Vec<Entity> {
    s.solids();
    let lights: Vec<_> = (0..6)
        .map(|light| {
            let color = Color::hsl(light as f32 * 60.0, 0.8, 0.6);
            let light = PointLight {
                color,
                intensity: 600_000.0,
                range: 4.0,
                ..default()
            };
            s.spawn((light, Transform::default()))
        })
        .collect();
    for (index, light) in lights.iter().enumerate() {
        let place = Transform::from_xyz(index as f32 * 1.2 - 3.0, 1.5, 1.5);
        let mut light = s.world().entity_mut(*light);
        light.insert(place);
        if on_another_layer.contains(&index) {
            light.insert(RenderLayers::layer(1));
        }
    }
    s.default_camera((ambient(), RenderLayers::from_layers(&[0, 1])));
    lights
}

/// The picture of a scene after `change` was applied while frames ran.
fn changed<L>(scene: impl FnOnce(&mut SceneBuilder) -> L, change: fn(&mut World, L)) -> Picture {
    let mut lights = None;
    let mut headless = build(SIZE, |s| lights = Some(scene(s)));
    set_lean(&mut headless, true);
    headless.settle();
    headless.frames(3);
    change(headless.world(), lights.expect("the scene was built"));
    headless.settle();
    headless.frames(3);
    headless.capture()
}

#[test]
#[ignore = "nightly: nine scenes of one more change"]
fn lights_that_lose_their_layers_affect_all_again() {
    in_own_process(|| {
        let show = |layered: &[usize], change: fn(&mut World, Vec<Entity>)| {
            changed(|s| row_of_lights(s, layered), change)
        };
        let before = show(&[1, 5], |_, _| {});
        let after = show(&[1], |_, _| {});
        let psnr = difference(&before, &after).psnr;
        assert!(psnr < 40.0, "the last light shows: {psnr} dB");
        let removed = show(&[1, 5], |world, lights| {
            world.entity_mut(lights[5]).remove::<RenderLayers>();
        });
        // Whichever of them is last in Bevy's list.
        let after_first = show(&[5], |_, _| {});
        let removed_first = show(&[1, 5], |world, lights| {
            world.entity_mut(lights[1]).remove::<RenderLayers>();
        });
        // Another light takes the first one's place in Bevy's list, which becomes shorter by one.
        let despawned = show(&[1, 5], |world, lights| {
            world.entity_mut(lights[5]).remove::<RenderLayers>();
            world.despawn(lights[0]);
        });
        let without_first = show(&[1], |world, lights| {
            world.despawn(lights[0]);
        });
        let replaced = show(&[1, 5], |world, lights| {
            let mut last = world.entity_mut(lights[5]);
            let light = last.take::<PointLight>().expect("a point light");
            last.remove::<RenderLayers>().insert(SpotLight {
                color: light.color,
                intensity: light.intensity,
                range: light.range,
                ..default()
            });
        });
        let spot = show(&[1], |world, lights| {
            let mut last = world.entity_mut(lights[5]);
            let light = last.take::<PointLight>().expect("a point light");
            last.insert(SpotLight {
                color: light.color,
                intensity: light.intensity,
                range: light.range,
                ..default()
            });
        });
        report([
            judge("layers_removed", &after, &removed, 60.0),
            judge("first_layers_removed", &after_first, &removed_first, 60.0),
            judge("light_despawned", &without_first, &despawned, 60.0),
            judge("light_replaced", &spot, &replaced, 60.0),
        ]);
    });
}

/// Decals side by side, some of them only on layer 1.
fn row_of_decals(s: &mut SceneBuilder, on_another_layer: &[usize]) -> Vec<Entity> {
    s.floor();
    s.sun(false);
    let image = s.checker([240, 60, 40, 255], [40, 60, 240, 255]);
    let decals: Vec<_> = (0..4)
        .map(|index| {
            let decal = ClusteredDecal {
                base_color_texture: Some(image.clone()),
                ..default()
            };
            let place = Transform::from_xyz(index as f32 * 1.5 - 2.2, 0.0, 0.0)
                .looking_to(Vec3::NEG_Y, Vec3::Z)
                .with_scale(Vec3::splat(1.2));
            // Bevy lists decals by kind of entity, beginning with the kind that existed first.
            if on_another_layer.contains(&index) {
                s.spawn((decal, place, RenderLayers::layer(1)))
            } else {
                s.spawn((decal, place))
            }
        })
        .collect();
    s.default_camera((ambient(), RenderLayers::from_layers(&[0, 1])));
    decals
}

/// Only on devices that show decals at all: a software renderer may not.
#[test]
#[ignore = "nightly: as lights"]
fn decals_that_lose_their_layers_affect_all_again() {
    in_own_process(|| {
        let show = |layered: &[usize], change: fn(&mut World, Vec<Entity>)| {
            changed(|s| row_of_decals(s, layered), change)
        };
        let [first, last] = [0, 3].map(|layered| show(&[layered], |_, _| {}));
        if first.rgba == show(&[0, 1, 2, 3], |_, _| {}).rgba {
            println!("skipped: decals: the device has no binding arrays");
            return;
        }
        let last_removed = show(&[0, 3], |world, decals| {
            world.entity_mut(decals[3]).remove::<RenderLayers>();
        });
        let first_removed = show(&[0, 3], |world, decals| {
            world.entity_mut(decals[0]).remove::<RenderLayers>();
        });
        report([
            judge("last_layers_removed", &first, &last_removed, 60.0),
            judge("first_layers_removed", &last, &first_removed, 60.0),
        ]);
    });
}
