//! Decals cost only where they are, and only for what they hold: no shadow map is sampled for them elsewhere, and no missing texture is
//! bound.

use std::collections::BTreeMap;

use bevy::{
    camera::{ScalingMode, visibility::RenderLayers},
    light::{ClusteredDecal, DirectionalLightTexture, NotShadowCaster},
    prelude::*,
    render::{RenderApp, settings::WgpuFeatures},
};
use bevy_lean_deferred::lighting::ViewLighting;
use kit::{
    hdr::settled_light,
    headless::{Headless, small_shadow_maps},
    lean::{active_lean_views, judge, report, set_lean, settled, show},
    own_process::in_own_process,
    scenes::{
        SceneBuilder,
        build::{indoor, material},
    },
    shader_files::replace_shader,
    skipped::skips_without_binding_arrays,
};

const SIZE: UVec2 = UVec2::new(64, 64);

/// Replaces the only occurrence of `old` in `source`.
fn replaced(source: &str, old: &str, new: &str) -> String {
    assert_eq!(source.matches(old).count(), 1, "{old}");
    source.replace(old, new)
}

/// An app whose lean cameras show the number of samples of directional shadow maps.
fn counting_app() -> Headless {
    let shadow_maps = include_str!("../../src/lighting/bevy/shadow_maps.wgsl");
    let body = "    return fetch_directional_shadow(";
    let shadow_maps = replaced(shadow_maps, body, &format!("    samplings += 1.0;\n{body}"));
    let lighting = include_str!("../../src/lighting/lighting.wgsl");
    let shown = "textureStore(output_texture, pixel.position, shaded.color);";
    let counted =
        "textureStore(output_texture, pixel.position, vec4(samplings, 0.25, 0.125, 1.0));";
    let lighting = replaced(lighting, shown, counted);
    Headless::with(SIZE, |app| {
        small_shadow_maps(app);
        replace_shader(
            app,
            "lighting/bevy/shadow_maps.wgsl",
            format!("{shadow_maps}\nvar<private> samplings: f32 = 0.0;\n"),
        );
        replace_shader(
            app,
            "lighting/lighting.wgsl",
            format!(
                "#import bevy_lean_deferred::lighting::bevy::shadow_maps::samplings\n{lighting}"
            ),
        );
    })
}

/// Spawns a sun in direction `from`.
fn sun(s: &mut SceneBuilder, from: Vec3) -> Entity {
    s.spawn((
        DirectionalLight {
            illuminance: 400.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Z),
    ))
}

/// Direction of a sun that the floor faces.
const FACED: Vec3 = Vec3::new(0.3, 1.0, 0.2);
/// Direction of a sun slightly below the floor.
const AVERTED: Vec3 = Vec3::new(0.95, -0.3, 0.0);

/// A floor of 4 × 4 m, seen from above, and two suns.
fn floor(s: &mut SceneBuilder) -> [Entity; 2] {
    let floor = Plane3d::default().mesh().size(4.0, 4.0).build();
    let floor = floor
        .with_generated_tangents()
        .expect("a plane has all that tangents need");
    let floor = s.mesh(
        floor,
        material((0.7, 0.7, 0.7), 0.0, 0.6),
        Transform::default(),
    );
    s.world().entity_mut(floor).insert(NotShadowCaster);
    s.camera(
        Transform::from_xyz(0.0, 3.0, 0.0).looking_at(Vec3::ZERO, Vec3::NEG_Z),
        (
            Projection::Orthographic(OrthographicProjection {
                scaling_mode: ScalingMode::FixedHorizontal {
                    viewport_width: 4.0,
                },
                ..OrthographicProjection::default_3d()
            }),
            indoor(),
            RenderLayers::from_layers(&[0, 1]),
        ),
    );
    [FACED, AVERTED].map(|from| sun(s, from))
}

/// Spawns a decal on a quarter of the floor.
fn decal(s: &mut SceneBuilder, has_normal_map: bool) -> Entity {
    let color = s.checker([240, 60, 40, 255], [40, 60, 240, 255]);
    let bumps = s.bumps();
    s.spawn((
        ClusteredDecal {
            base_color_texture: Some(color),
            normal_map_texture: has_normal_map.then_some(bumps),
            ..default()
        },
        Transform::default()
            .looking_to(Vec3::NEG_Y, Vec3::Z)
            .with_scale(Vec3::new(2.0, 2.0, 1.0)),
    ))
}

/// Number of pixels of the scene by their number of shadow map samples.
fn samplings(headless: &mut Headless, scene: impl FnOnce(&mut SceneBuilder)) -> BTreeMap<u32, u32> {
    show(headless, scene);
    set_lean(headless, true);
    let light = settled_light(headless);
    assert_eq!(active_lean_views(headless), 1);
    let mut pixels = BTreeMap::new();
    for texel in &light.texels {
        assert_eq!(texel[1..], [0.25, 0.125, 1.0], "lighting has written it");
        *pixels.entry(texel[0] as u32).or_default() += 1;
    }
    pixels
}

const PIXELS: u32 = SIZE.x * SIZE.y;

/// A sun on layers other than the floor's does not sample its shadow map there.
#[test]
fn shadows_of_suns_on_other_layers_are_not_sampled() {
    in_own_process(|| {
        let headless = &mut counting_app();
        let all = samplings(headless, |s| {
            floor(s);
            sun(s, Vec3::new(-0.3, 1.0, 0.0));
        });
        assert_eq!(all, BTreeMap::from([(2, PIXELS)]), "on one layer");
        let some = samplings(headless, |s| {
            floor(s);
            let other = sun(s, Vec3::new(-0.3, 1.0, 0.0));
            s.world().entity_mut(other).insert(RenderLayers::layer(1));
        });
        assert_eq!(some, BTreeMap::from([(1, PIXELS)]), "on two");
    });
}

/// The shadow map of a sun behind the surface is sampled only where a decal may turn the surface.
#[test]
fn shadows_are_sampled_for_decals_only_where_these_turn_the_surface() {
    in_own_process(|| {
        let headless = &mut counting_app();
        let device = headless.device().clone();
        if skips_without_binding_arrays(&device, "shadows beneath decals") {
            return;
        }
        let one = BTreeMap::from([(1, PIXELS)]);
        let textured = samplings(headless, |s| {
            let [sun, _] = floor(s);
            let image = s.checker([255; 4], [90, 90, 90, 255]);
            s.world()
                .entity_mut(sun)
                .insert(DirectionalLightTexture { image, tiled: true });
        });
        let flat = samplings(headless, |s| {
            floor(s);
            decal(s, false);
        });
        let elsewhere = samplings(headless, |s| {
            floor(s);
            let decal = decal(s, true);
            s.world().entity_mut(decal).insert(RenderLayers::layer(1));
        });
        let bumpy = samplings(headless, |s| {
            floor(s);
            decal(s, true);
        });
        println!("textured {textured:?}, flat {flat:?}, elsewhere {elsewhere:?}, bumpy {bumpy:?}");
        assert_eq!(textured, one, "with the texture of a light");
        assert_eq!(flat, one, "with a decal without a normal map");
        assert_eq!(
            elsewhere, one,
            "with a decal on a layer that the floor is not on"
        );
        let quarter = BTreeMap::from([(1, PIXELS * 3 / 4), (2, PIXELS / 4)]);
        assert_eq!(bumpy, quarter, "with a decal with a normal map");
    });
}

/// A surface that a decal turns towards a sun behind it is in that sun's shadow, as in forward.
#[test]
fn surfaces_that_decals_turn_are_in_shadow() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE * 4);
        let device = headless.device().clone();
        if skips_without_binding_arrays(&device, "shadows beneath decals") {
            return;
        }
        show(headless, |s| {
            floor(s);
            decal(s, true);
            s.mesh(
                Cuboid::new(0.2, 0.8, 0.8),
                material((0.7, 0.7, 0.7), 0.0, 0.6),
                Transform::from_xyz(0.7, -0.35, 0.2),
            );
        });
        let forward = settled(headless);
        set_lean(headless, true);
        let lean = settled(headless);
        // 46.9 dB without these shadows.
        report([judge("turned_by_decal", &forward, &lean, 48.5)]);
    });
}

/// No texture is bound for missing decals, though Bevy's layout has room for 1,024.
#[test]
fn no_texture_is_bound_for_decals_that_are_not_there() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        let device = headless.device().clone();
        if skips_without_binding_arrays(&device, "textures of decals") {
            return;
        }
        for decals in [1, 3] {
            show(headless, |s| {
                floor(s);
                for _ in 0..decals {
                    decal(s, true);
                }
            });
            set_lean(headless, true);
            settled(headless);
            assert_eq!(active_lean_views(headless), 1);
            let world = headless.app.sub_app_mut(RenderApp).world_mut();
            let mut views = world.query::<&ViewLighting>();
            let bound = views.single(world).expect("one view").textures_in_arrays();
            println!("{decals} decals: {bound} textures");
            if device
                .features()
                .contains(WgpuFeatures::PARTIALLY_BOUND_BINDING_ARRAY)
            {
                assert_eq!(bound, 2 * decals);
            } else {
                println!("skipped: textures of decals: the device wants arrays of whole length");
            }
        }
    });
}
