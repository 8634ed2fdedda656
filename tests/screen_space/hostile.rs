//! Light that is NaN, infinite, or as bright as half floats allow: effects keep and compute only finite and bounded light, and no trace is
//! left once the source is removed.

use bevy::{
    core_pipeline::prepass::DepthPrepass,
    math::bounding::{Aabb3d, RayCast3d},
    prelude::*,
    render::{RenderApp, render_resource::TextureFormat},
};
use bevy_lean_deferred::effects::{ViewHistory, diffuse_gi::ViewGi};
use kit::{
    analytic_light::{Seen, look, see, surface},
    analytic_mirrors::metal,
    hdr::read_light,
    headless::Headless,
    lean::build,
    own_process::in_own_process,
    scenes::SceneBuilder,
};

use super::scenes::{SMALL, courtyard, gi, glowing, reflections};

const HOSTILE: [f32; 3] = [f32::NAN, f32::INFINITY, 65504.0];
/// Position of the hostile thing, in front of the courtyard's boxes.
const PLACE: Vec3 = Vec3::new(0.2, 0.6, -0.9);
const SIDE: f32 = 0.5;
/// Frames after which no trace is left, including those rendered to look.
const FRAMES: usize = 16;
/// As in `diffuse_gi/levels.wgsl` and `history/levels.wgsl`, for pictures that are shown as exposed.
const LARGEST_LIGHT: [f32; 2] = [256.0, 1024.0];
/// A single slice may exceed its share of the hemisphere, so gathered light may exceed the bound by this factor before the filter.
const OF_A_SLICE: f32 = 2.0;

/// Spawns a hostile thing from a number.
type Make = fn(&mut SceneBuilder, f32) -> Entity;

fn card(s: &mut SceneBuilder, material: StandardMaterial) -> Entity {
    s.mesh(
        Rectangle::new(SIDE, SIDE),
        material,
        Transform::from_translation(PLACE),
    )
}

fn lamp(s: &mut SceneBuilder, intensity: f32) -> Entity {
    let light = PointLight {
        intensity,
        ..default()
    };
    s.spawn((light, Transform::from_translation(PLACE)))
}

/// Name of a thing, true if it corrupts at most its own pixels in the picture itself, and its constructor.
const THINGS: [(&str, bool, Make); 5] = [
    ("emission", true, |s, number| card(s, surface(0.0, number))),
    ("base colour", true, |s, number| {
        let material = StandardMaterial {
            base_color: Color::linear_rgb(number, number, number),
            ..surface(0.0, 1.0)
        };
        card(s, material)
    }),
    ("transparent card", true, |s, number| {
        let material = StandardMaterial {
            base_color: Color::linear_rgba(number, number, number, 0.9),
            alpha_mode: AlphaMode::Blend,
            unlit: true,
            ..default()
        };
        card(s, material)
    }),
    ("forward card", true, |s, number| {
        let material = StandardMaterial {
            base_color: Color::linear_rgb(number, number, number),
            unlit: true,
            ..glowing(true)
        };
        card(s, material)
    }),
    ("lamp", false, lamp),
];

/// Panics unless everything that the effects have kept and computed is finite and bounded.
fn check_kept(headless: &mut Headless, name: &str) {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query::<(&ViewGi, &ViewHistory)>();
    let (gi, history) = views.single(world).expect("one camera has both");
    let found = gi
        .textures()
        .filter(|texture| texture.format() == TextureFormat::Rgba16Float);
    let kept: Vec<_> = found.chain([history.texture()]).cloned().collect();
    assert_eq!(kept.len(), 3);
    let [of_gi, of_history] = LARGEST_LIGHT;
    for (texture, largest) in kept.iter().zip([OF_A_SLICE * of_gi, of_gi, of_history]) {
        let light = read_light(headless, texture);
        let most = light.texels.iter().flat_map(|texel| &texel[..3]);
        let (mut brightest, mut broken) = (0.0_f32, 0);
        for light in most {
            broken += i32::from(!(*light >= 0.0 && light.is_finite()));
            brightest = brightest.max(*light);
        }
        assert_eq!(broken, 0, "{name}");
        // Half floats are rounded.
        assert!(brightest <= 1.001 * largest, "{name}: {brightest}");
    }
}

/// Pixels that show the card or touch it.
fn shows_card(seen: &Seen) -> Vec<bool> {
    let bounds = Aabb3d::new(PLACE, Vec3::new(0.5 * SIDE + 0.02, 0.5 * SIDE + 0.02, 0.01));
    let hits = |ray: &Ray3d| RayCast3d::from_ray(*ray, 100.0).aabb_intersection_at(&bounds);
    seen.rays().iter().map(|ray| hits(ray).is_some()).collect()
}

/// All numbers from one source, and one number from each.
fn is_daily(name: &str, number: f32) -> bool {
    name == "emission" || number.is_nan()
}

#[test]
fn hostile_light_is_bounded_and_does_not_stay() {
    in_own_process(|| check_hostile_light(is_daily));
}

#[test]
#[ignore = "nightly: further numbers from further sources"]
fn further_hostile_light_is_bounded_and_does_not_stay() {
    in_own_process(|| check_hostile_light(|name, number| !is_daily(name, number)));
}

/// Looks at the things and numbers for which `is_asked` is true, one after the other.
fn check_hostile_light(is_asked: fn(&str, f32) -> bool) {
    let mut headless = build(SMALL, |s| {
        let floor = StandardMaterial {
            base_color: Color::linear_rgb(0.8, 0.8, 0.8),
            ..metal(0.4)
        };
        // Half of it is diffuse.
        let floor = StandardMaterial {
            metallic: 0.5,
            ..floor
        };
        let camera = courtyard(s, floor, surface(0.5, 0.3), 0.4, (gi(), reflections()));
        s.world().entity_mut(camera).insert(DepthPrepass);
    });
    let before = see(&mut headless, 30);
    let is_card = shows_card(&before);
    assert!(is_card.iter().filter(|is_card| **is_card).count() > 100);
    for (name, is_kept_apart, make) in THINGS {
        for number in HOSTILE.into_iter().filter(|number| is_asked(name, *number)) {
            let mut s = SceneBuilder {
                headless: &mut headless,
            };
            let thing = make(&mut s, number);
            let with = see(&mut headless, 2);
            let name = format!("{name} of {number}");
            check_kept(&mut headless, &name);
            let texels = with.light.texels.iter().zip(&is_card);
            let broken = texels
                .filter(|(texel, is_card)| !**is_card && texel.iter().any(|x| !x.is_finite()));
            let broken = broken.count();
            assert!(!is_kept_apart || broken == 0, "{name}: {broken} pixels");
            let brightest = with
                .light
                .texels
                .iter()
                .zip(&is_card)
                .filter(|(_, is_card)| !**is_card);
            let brightest = brightest.map(|(texel, _)| texel[1]).fold(0.0, f32::max);
            headless.world().despawn(thing);
            headless.frames(FRAMES);
            let after = look(&mut headless);
            check_kept(&mut headless, &name);
            let pairs = before
                .light
                .texels
                .iter()
                .flatten()
                .zip(after.light.texels.iter().flatten());
            let most = pairs.map(|(a, b)| {
                if b.is_finite() {
                    (a - b).abs()
                } else {
                    f32::INFINITY
                }
            });
            let most = most.fold(0.0, f32::max);
            println!(
                "{name}: {broken} pixels beside it are no numbers, at most {brightest}; then off by {most:.4}"
            );
            assert!(most < 4e-3, "{name}");
        }
    }
}
