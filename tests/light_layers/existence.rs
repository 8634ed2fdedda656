//! The visibility mask exists where lights tell the visible meshes apart, and only there.

use bevy::{camera::visibility::RenderLayers, light::PointLight, prelude::*};
use bevy_lean_deferred::prelude::*;

use crate::common::{
    headless::{Headless, Picture},
    lean::{build, judge, report, set_lean},
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
    let mut entities = [Entity::PLACEHOLDER; 2];
    let mut headless = build(SIZE, |s| entities = scene(s, layers));
    set_lean(&mut headless, true);
    headless.settle();
    headless.frames(3);
    (headless, entities)
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
        ("no mesh has", on(&[0, 1]), on(&[1]), None, NONE),
        ("mesh and light have", on(&[0, 1]), on(&[1]), on(&[1]), MASK),
        ("high layers", on(&[0, 500]), on(&[500]), on(&[500]), MASK),
    ];
    for (name, camera, light, ball, expected) in cases {
        let (mut headless, _) = show(Layers {
            camera,
            light,
            ball,
        });
        assert_eq!(targets(&mut headless), expected, "{name}");
    }
}

/// Layers that change at run time give the picture of a scene that had them from the start.
#[test]
fn layers_change_at_run_time() {
    let start = |light: Option<RenderLayers>, ball: Option<RenderLayers>| Layers {
        camera: on(&[0, 1, 2]),
        light,
        ball,
    };
    let picture = |layers: Layers| show(layers).0.capture();
    let (mut headless, [light, ball]) = show(start(None, None));
    let mut results = Vec::new();
    let mut check = |name: &str, headless: &mut Headless, expected: Picture| {
        headless.settle();
        headless.frames(3);
        results.push(judge(name, &expected, &headless.capture(), 60.0));
    };

    headless
        .world()
        .entity_mut(light)
        .insert(RenderLayers::layer(1));
    check("light", &mut headless, picture(start(on(&[1]), None)));
    headless
        .world()
        .entity_mut(ball)
        .insert(RenderLayers::layer(1));
    check("ball", &mut headless, picture(start(on(&[1]), on(&[1]))));
    assert_eq!(targets(&mut headless), MASK);
    headless
        .world()
        .entity_mut(ball)
        .insert(RenderLayers::layer(2));
    check(
        "other layer",
        &mut headless,
        picture(start(on(&[1]), on(&[2]))),
    );
    headless.world().entity_mut(ball).remove::<RenderLayers>();
    check("without", &mut headless, picture(start(on(&[1]), None)));
    headless
        .world()
        .entity_mut(ball)
        .insert(RenderLayers::layer(2));
    check("again", &mut headless, picture(start(on(&[1]), on(&[2]))));
    headless.world().entity_mut(light).remove::<RenderLayers>();
    check("all lit", &mut headless, picture(start(None, on(&[2]))));
    assert_eq!(targets(&mut headless), NONE);
    report(results);
}
