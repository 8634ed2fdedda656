//! Reflections on meshes that Bevy's passes draw: blended mirrors, and shaders of apps.

use bevy::{
    asset::uuid_handle,
    math::bounding::{Aabb3d, RayCast3d},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{DistanceFog, FogFalloff, MaterialPipeline, MaterialPipelineKey, MaterialPlugin},
    prelude::*,
    reflect::TypePath,
    render::render_resource::{
        AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError,
    },
    shader::ShaderRef,
};
use bevy_lean_deferred::{
    effects::LeanScreenSpaceReflectionsAdvanced, lighting::define_lean_lighting, prelude::*,
    view::LeanDeferredAdvanced,
};
use kit::{
    analytic_light::{Errors, Seen, camera, look, look_at_once, see, surface},
    analytic_mirrors::{metal, mirror_app_of, show_mirror},
    headless::Headless,
    lean::{build, change_cameras},
    own_process::in_own_process,
    scenes::SceneBuilder,
};

use super::scenes::{
    EYE, SIZE, SMALL, looking, mirror_ray, mirrored, range, reflections, show_next,
};

/// Reflections on forward meshes too.
fn on_forward_meshes() -> LeanScreenSpaceReflections {
    LeanScreenSpaceReflections {
        advanced: LeanScreenSpaceReflectionsAdvanced {
            forward_meshes: true,
            ..reflections().advanced
        },
        ..reflections()
    }
}

const ALPHA: f32 = 0.5;

/// A metal that is half transparent.
fn glass(roughness: f32) -> StandardMaterial {
    StandardMaterial {
        base_color: Color::WHITE.with_alpha(ALPHA),
        alpha_mode: AlphaMode::Blend,
        ..metal(roughness)
    }
}

/// The picture in a blended mirror is where the closed form has it, and as bright. Not so where a ray passes within the assumed
/// thickness behind the top of the ball: the last frame's distances do not tell that it faces away.
#[test]
fn blended_mirrors_are_exact() {
    in_own_process(|| {
        let mut headless = mirror_app_of(SIZE, glass(0.0), |camera| {
            camera.insert(on_forward_meshes());
        });
        let grazing = looking(Vec3::new(0.0, 0.35, 3.2), 0.3);
        let usual = Transform::from_xyz(0.0, 1.1, 3.2).looking_at(Vec3::Y * 0.35, Vec3::Y);
        for (name, from, least) in [("usual", usual, 25.0), ("grazing", grazing, 22.0)] {
            change_cameras(&mut headless, |camera| {
                camera.insert(from);
            });
            headless.settle();
            headless.frames(6);
            // Nothing is behind the mirror.
            let seen = look(&mut headless);
            seen.save(&format!("blended_mirror_{name}"), 1.0);
            let undone = seen
                .light
                .texels
                .iter()
                .map(|texel| texel.map(|x| x / ALPHA));
            let undone = seen.like(undone.collect());
            let found = kit::analytic_mirrors::compare(&mut headless, undone);
            println!(
                "{name}: {:.1} dB, without outlines {:.1} dB, {:.2} in the picture",
                found.everywhere.psnr(),
                found.inside.psnr(),
                found.share
            );
            assert!(found.share > 0.5 && found.inside.psnr() > least);
        }
    });
}

const GLOW: f32 = 0.9;
const FLOOR: f32 = 0.2;
const BELOW: f32 = -0.4;
const BOX: (Vec3, Vec3) = (Vec3::new(0.1, 0.35, -0.5), Vec3::new(0.4, 0.35, 0.2));

/// A glowing box over a mesh of `material`, which is over a dimly glowing floor.
fn box_over(s: &mut SceneBuilder, material: impl Bundle, effects: impl Bundle) {
    let floor = Plane3d::default().mesh().size(12.0, 12.0);
    s.mesh(
        floor,
        surface(0.0, FLOOR),
        Transform::from_xyz(0.0, BELOW, 0.0),
    );
    s.mesh(
        Cuboid::from_size(2.0 * BOX.1),
        surface(0.0, GLOW),
        Transform::from_translation(BOX.0),
    );
    let sheet = s.add::<Mesh>(Plane3d::default().mesh().size(3.0, 3.0));
    s.spawn((Mesh3d(sheet), material, Transform::default()));
    camera(s, looking(EYE, 0.1), 0.0, effects);
}

/// Light of the sheet where it mirrors the box, and elsewhere. Not outlines.
fn of_sheet(seen: &Seen) -> [Vec<f32>; 2] {
    let of = |grow: f32| Aabb3d::new(BOX.0, BOX.1 + grow);
    let hits = |ray: Ray3d, bounds: Aabb3d| {
        RayCast3d::from_ray(ray, 100.0)
            .aabb_intersection_at(&bounds)
            .is_some()
    };
    let [mut inside, mut outside] = [Vec::new(), Vec::new()];
    for (_, place, light) in seen.on_plane(Vec3::ZERO, Vec3::Y) {
        let direct = Ray3d::new(EYE, Dir3::new(place - EYE).expect("it is away"));
        let reflected = mirror_ray(EYE, place).expect("it is away");
        if place.x.abs().max(place.z.abs()) > 1.4 || hits(direct, of(0.06)) {
            continue;
        }
        if hits(reflected, of(-0.04)) {
            inside.push(light);
        } else if !hits(reflected, of(0.06)) {
            outside.push(light);
        }
    }
    [inside, outside]
}

fn mean(light: &[f32]) -> f32 {
    light.iter().sum::<f32>() / light.len() as f32
}

/// Share of pixels within 0.02 of the expected light.
fn share_of(light: &[f32], expected: f32) -> f32 {
    let near = light
        .iter()
        .filter(|light| (*light - expected).abs() < 0.02);
    near.count() as f32 / light.len() as f32
}

#[test]
fn light_in_a_blended_mirror_is_the_things() {
    in_own_process(|| {
        let mut headless = Headless::new(SMALL);
        for roughness in [0.0, 0.1] {
            let seen = show_next(&mut headless, 6, |s| {
                let glass = s.add::<StandardMaterial>(glass(roughness));
                box_over(s, MeshMaterial3d(glass), on_forward_meshes());
            });
            seen.save(&format!("blended_box_{roughness}"), 1.0);
            let [inside, outside] = of_sheet(&seen);
            let behind = (1.0 - ALPHA) * FLOOR;
            let [of_inside, of_outside] = [
                share_of(&inside, ALPHA * GLOW + behind),
                share_of(&outside, behind),
            ];
            println!(
                "{roughness}: {of_inside:.3} of {} pixels, {of_outside:.3} of {}; {:.3}, {:.3}",
                inside.len(),
                outside.len(),
                mean(&inside),
                mean(&outside)
            );
            assert!(inside.len() > 300 && outside.len() > 1000);
            assert!(of_inside > 0.97 && of_outside > 0.99);
        }
    });
}

/// The picture is the same to the bit while the option or the effect is off, or the camera is not lean.
#[test]
fn other_views_stay_as_they_are() {
    in_own_process(|| {
        // Nothing else reflects.
        let mut headless = build(SMALL, |s| {
            let glass = s.add::<StandardMaterial>(glass(0.0));
            box_over(s, MeshMaterial3d(glass), ());
        });
        let without = see(&mut headless, 6);
        let [inside, _] = of_sheet(&without);
        assert!(share_of(&inside, (1.0 - ALPHA) * FLOOR) > 0.99);
        type Dress = fn(&mut EntityWorldMut);
        let cases: [(&str, bool, Dress); 4] = [
            ("off", true, |camera| _ = camera.insert(reflections())),
            ("on", false, |camera| _ = camera.insert(on_forward_meshes())),
            ("Bevy's shader", true, |camera| {
                camera.insert(LeanDeferred {
                    advanced: LeanDeferredAdvanced {
                        lights_forward_meshes: false,
                        ..default()
                    },
                    ..default()
                });
            }),
            ("removed", true, |camera| {
                camera.remove::<LeanScreenSpaceReflections>();
                camera.insert(LeanDeferred::default());
            }),
        ];
        for (name, is_same, dress) in cases {
            change_cameras(&mut headless, dress);
            let with = see(&mut headless, 6);
            let pairs = without.light.texels.iter().zip(&with.light.texels);
            let differs = pairs.filter(|(a, b)| a != b).count();
            println!("{name}: {differs} pixels differ");
            assert_eq!(differs == 0, is_same, "{name}");
        }
    });
}

const MIRROR: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e61");

/// A shader of an app that shows what its mirror reflects, without any other light. Red on cameras without reflections would be 0.
const MIRROR_SOURCE: &str = "
#import bevy_lean_deferred::lighting::forward::reflected_light::lean_reflected_light
#import bevy_pbr::forward_io::VertexOutput

@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    let seen = lean_reflected_light(in.world_position.xyz, normalize(in.world_normal), 0.0);
    return vec4(seen.rgb * seen.a, 0.5);
}
";

/// A blended mirror whose shader lights nothing.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
struct BareMirror {}

impl Material for BareMirror {
    fn fragment_shader() -> ShaderRef {
        MIRROR.into()
    }

    fn alpha_mode(&self) -> AlphaMode {
        AlphaMode::Blend
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        _: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        define_lean_lighting(descriptor);
        Ok(())
    }
}

/// Shaders of apps get the light that a `StandardMaterial` does, and none on cameras of other kinds.
#[test]
fn shaders_of_apps_may_ask_for_the_light() {
    in_own_process(|| {
        let mut headless = Headless::with(SMALL, |app| {
            app.add_plugins(MaterialPlugin::<BareMirror>::default());
        });
        let mut shaders = headless.world().resource_mut::<Assets<Shader>>();
        shaders
            .insert(MIRROR.id(), Shader::from_wgsl(MIRROR_SOURCE, "mirror.wgsl"))
            .expect("a place for a constant handle");
        let seen = show_next(&mut headless, 6, |s| {
            let material = s.add::<BareMirror>(BareMirror {});
            box_over(s, MeshMaterial3d(material), on_forward_meshes());
        });
        seen.save("blended_function", 1.0);
        let behind = (1.0 - ALPHA) * FLOOR;
        let [inside, outside] = of_sheet(&seen);
        let shares = [
            share_of(&inside, ALPHA * GLOW + behind),
            share_of(&outside, behind),
        ];
        println!("{shares:.3?}");
        assert!(shares[0] > 0.97 && shares[1] > 0.99);
        for lean in [true, false] {
            change_cameras(&mut headless, |camera| {
                camera.remove::<LeanScreenSpaceReflections>();
                if !lean {
                    camera.remove::<LeanDeferred>();
                }
            });
            let [inside, _] = of_sheet(&see(&mut headless, 4));
            assert!(share_of(&inside, behind) > 0.99, "lean: {lean}");
        }
    });
}

/// Fog is on the whole way of the mirrored light once.
#[test]
fn light_in_blended_mirrors_is_fogged_once() {
    in_own_process(|| {
        const DISTANCE: f32 = 12.0;
        const LIGHT: f32 = 0.3;
        const WALL: Vec2 = Vec2::new(12.0, 3.6);
        let mut headless = Headless::new(SMALL);
        let left = |metres: f32| (-0.035 * metres).exp();
        let seen = show_next(&mut headless, 6, |s| {
            let plane = Plane3d::default().mesh().size(200.0, 200.0);
            let ground = Transform::from_xyz(0.0, -1e-2, 0.0);
            s.mesh(plane, surface(0.0, 0.0), ground);
            s.mesh(plane, glass(0.0), Transform::default());
            let at = Transform::from_xyz(0.0, 0.5 * WALL.y, -DISTANCE);
            s.mesh(Rectangle::from_size(WALL), surface(0.0, 1.0), at);
            let fog = DistanceFog {
                color: Color::linear_rgb(LIGHT, LIGHT, LIGHT),
                falloff: FogFalloff::Exponential { density: 0.035 },
                ..default()
            };
            let from = Transform::from_xyz(0.0, EYE.y, 0.0);
            camera(s, from, 0.0, (on_forward_meshes(), fog));
        });
        seen.save("blended_fog", 1.0);
        let eye = Vec3::Y * EYE.y;
        let off = seen
            .on_plane(Vec3::ZERO, Vec3::Y)
            .filter_map(|(_, place, found)| {
                let direction = mirrored(eye, place);
                let at = place + direction * (-DISTANCE - place.z) / direction.z;
                let is_inside = at.x.abs() < 0.45 * WALL.x && (0.1..0.9).contains(&(at.y / WALL.y));
                let [to_mirror, path] = [
                    left(eye.distance(place)),
                    left(eye.distance(place) + place.distance(at)),
                ];
                let of_mirror = path + LIGHT * (1.0 - path);
                let of_ground = LIGHT * (1.0 - to_mirror);
                let truth = ALPHA * of_mirror + (1.0 - ALPHA) * of_ground;
                (place.z > -DISTANCE && is_inside).then_some(found / truth - 1.0)
            });
        let off: Vec<f32> = off.collect();
        let count = off.len();
        let errors = Errors::of(off);
        println!("{errors:.4?} of {count} pixels");
        assert!(count > 100 && errors.rmse < 0.03);
    });
}

/// Blended mirrors that see each other, of which one adds its light to the picture, keep bounded light.
#[test]
fn mirrors_that_see_each_other_stay_bounded() {
    in_own_process(|| {
        let mut headless = build(SMALL, |s| {
            let added = s.add::<StandardMaterial>(StandardMaterial {
                alpha_mode: AlphaMode::Add,
                double_sided: true,
                cull_mode: None,
                ..metal(0.0)
            });
            let ball = s.add::<Mesh>(Sphere::new(0.5).mesh().uv(32, 16));
            for x in [-0.6, 0.6] {
                let place = Transform::from_xyz(x, 0.5, 0.4);
                s.spawn((Mesh3d(ball.clone()), MeshMaterial3d(added.clone()), place));
            }
            let glass = s.add::<StandardMaterial>(glass(0.05));
            box_over(s, MeshMaterial3d(glass), on_forward_meshes());
        });
        let first = see(&mut headless, 40);
        headless.frames(60);
        let later = look(&mut headless);
        later.save("blended_pair", 0.5);
        let brightest = |seen: &Seen| {
            let light = seen.light.texels.iter().map(|texel| texel[1]);
            let light: Vec<f32> = light.collect();
            assert!(light.iter().all(|light| light.is_finite()));
            range(&light).1
        };
        let [first, later] = [first, later].map(|seen| brightest(&seen));
        println!("brightest {first:.3}, 60 frames later {later:.3}");
        assert!(later < 1.02 * first && later < 6.0 * GLOW);
    });
}

/// NaN and infinite light of a thing in the picture stays in its own pixels, and is gone with it.
#[test]
fn hostile_light_stays_out_of_blended_mirrors() {
    in_own_process(|| {
        let mut headless = build(SMALL, |s| {
            let glass = s.add::<StandardMaterial>(glass(0.1));
            box_over(s, MeshMaterial3d(glass), on_forward_meshes());
        });
        let before = see(&mut headless, 6);
        for number in [f32::NAN, f32::INFINITY, 65504.0] {
            let mut s = SceneBuilder {
                headless: &mut headless,
            };
            let card = s.mesh(
                Rectangle::new(0.3, 0.3),
                StandardMaterial {
                    base_color: Color::linear_rgb(number, number, number),
                    alpha_mode: AlphaMode::Add,
                    unlit: true,
                    ..default()
                },
                Transform::from_xyz(0.1, 0.5, -0.2),
            );
            let with = see(&mut headless, 4);
            let [inside, outside] = of_sheet(&with);
            let light = [inside, outside].concat();
            let (_, most) = range(&light);
            let broken = light.iter().filter(|light| !light.is_finite()).count();
            headless.world().despawn(card);
            headless.frames(6);
            let after = look_at_once(&mut headless);
            let pairs = before.light.texels.iter().zip(&after.light.texels);
            let differs = pairs.filter(|(a, b)| a != b).count();
            println!("{number}: {broken} broken, at most {most}, then {differs} differ");
            // As bright as the history allows.
            assert!(broken == 0 && most < 1.01 * (ALPHA * 1024.0 + FLOOR));
            assert_eq!(differs, 0);
        }
    });
}

/// Without outlines, the mirror of an app with the effect is that of the opaque one.
#[test]
fn a_mask_of_the_same_metal_reflects_too() {
    in_own_process(|| {
        // Bevy's passes draw it for its depth bias.
        let mut headless = mirror_app_of(
            SMALL,
            StandardMaterial {
                depth_bias: 5.0,
                ..metal(0.0)
            },
            |camera| {
                camera.insert(on_forward_meshes());
            },
        );
        headless.settle();
        headless.frames(6);
        let found = show_mirror(&mut headless);
        found.seen.save("forward_mirror", 1.0);
        println!("{:.1} dB", found.inside.psnr());
        assert!(found.share > 0.5 && found.inside.psnr() > 28.0);
    });
}
