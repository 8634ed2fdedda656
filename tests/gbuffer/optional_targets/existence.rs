//! A target exists while a visible mesh writes it, and for some frames longer.

use bevy::{light::NotShadowReceiver, pbr::Lightmap, prelude::*};
use bevy_lean_deferred::{
    gbuffer::{GBufferTargets, GBufferUsage},
    prelude::*,
};

use super::{SMALL, forward_draws, usage};
use kit::{
    headless::Headless,
    lean::{build, set_lean, settled, show},
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::build::material,
};

const EMISSIVE: GBufferTargets = GBufferTargets::EMISSIVE;
const SPECIALIZATION: GBufferTargets = GBufferTargets::SPECIALIZATION;
const NONE: GBufferTargets = GBufferTargets::empty();

/// Frames after which a view releases targets that no mesh needs.
const LINGERING: usize = 120;

fn clay() -> StandardMaterial {
    material((0.8, 0.3, 0.2), 0.0, 0.5)
}

/// Shows solids and a ball of `material` to a lean camera. Returns the ball.
fn show_ball(headless: &mut Headless, material: StandardMaterial, extra: impl Bundle) -> Entity {
    let mut ball = Entity::PLACEHOLDER;
    show(headless, |s| {
        s.solids();
        let mesh = Sphere::new(0.5)
            .mesh()
            .uv(24, 12)
            .with_generated_tangents()
            .expect("a sphere has all that tangents need");
        ball = s.mesh(mesh, material, Transform::from_xyz(0.0, 0.5, 1.5));
        s.world().entity_mut(ball).insert(extra);
        s.sun(true);
        s.default_camera(());
    });
    set_lean(headless, true);
    headless.settle();
    headless.frames(2);
    ball
}

#[test]
fn materials_get_the_targets_that_they_need() {
    in_own_process(|| {
        type Change = fn(&mut StandardMaterial);
        let cases: [(&str, GBufferTargets, Change); 12] = [
            ("plain", NONE, |_| {}),
            ("emissive", EMISSIVE, |m| {
                m.emissive = LinearRgba::rgb(1.0, 0.0, 0.0)
            }),
            ("emissive NaN", EMISSIVE, |m| {
                m.emissive = LinearRgba::rgb(f32::NAN, 0.0, 0.0)
            }),
            ("reflectance", SPECIALIZATION, |m| m.reflectance = 0.2),
            ("grey specular tint", SPECIALIZATION, |m| {
                m.specular_tint = Color::srgb(0.5, 0.5, 0.5)
            }),
            ("clearcoat", SPECIALIZATION, |m| m.clearcoat = 0.5),
            ("anisotropy", SPECIALIZATION, |m| {
                m.anisotropy_strength = 0.5
            }),
            ("diffuse transmission", SPECIALIZATION, |m| {
                m.diffuse_transmission = 0.5
            }),
            ("unlit", SPECIALIZATION, |m| m.unlit = true),
            ("no fog", SPECIALIZATION, |m| m.fog_enabled = false),
            ("emissive clearcoat", EMISSIVE.union(SPECIALIZATION), |m| {
                m.emissive = LinearRgba::rgb(1.0, 0.0, 0.0);
                m.clearcoat = 0.5;
            }),
            ("masked emissive", EMISSIVE, |m| {
                m.emissive = LinearRgba::rgb(1.0, 0.0, 0.0);
                m.alpha_mode = AlphaMode::Mask(0.5);
            }),
        ];
        let mut headless = Headless::new(SMALL);
        for (name, targets, change) in cases {
            let mut material = clay();
            change(&mut material);
            show_ball(&mut headless, material, ());
            assert_eq!(usage(&mut headless).targets, targets, "{name}");
            assert!(!forward_draws(&headless), "{name} goes forward");
        }
        meshes_get_the_targets_that_they_need(&mut headless);
    });
}

fn meshes_get_the_targets_that_they_need(headless: &mut Headless) {
    show_ball(headless, clay(), NotShadowReceiver);
    assert_eq!(usage(headless).targets, SPECIALIZATION, "no receiver");
    assert!(!forward_draws(headless), "no receiver");

    let ball = show_ball(headless, clay(), ());
    assert_eq!(usage(headless).targets, NONE, "a receiver");
    headless.world().entity_mut(ball).insert(NotShadowReceiver);
    headless.frames(4);
    assert_eq!(usage(headless).targets, SPECIALIZATION, "none any more");
    assert!(!forward_draws(headless), "no receiver any more");

    let ball = show_ball(headless, clay(), ());
    put_lightmap(headless, ball);
    let used = usage(headless);
    assert_eq!(used.targets, EMISSIVE, "a lightmap");
    assert_eq!(used.bytes_per_pixel(), 13, "a lightmap");
    assert!(!forward_draws(headless), "a lightmap");

    let unlit = StandardMaterial {
        unlit: true,
        ..clay()
    };
    let ball = show_ball(headless, unlit, ());
    put_lightmap(headless, ball);
    assert_eq!(usage(headless).targets, SPECIALIZATION, "an unlit lightmap");
    assert!(!forward_draws(headless), "an unlit lightmap");
}

/// Makes `mesh` a cube with a lightmap.
fn put_lightmap(headless: &mut Headless, mesh: Entity) {
    let cube = kit::scenes::materials::cube_with_second_uvs();
    let world = headless.world();
    let cube = world.resource_mut::<Assets<Mesh>>().add(cube);
    let image = world.resource_mut::<Assets<Image>>().add(Image::default());
    world
        .entity_mut(mesh)
        .insert((Mesh3d(cube), Lightmap { image, ..default() }));
    headless.settle();
    headless.frames(4);
}

/// Without binding arrays Bevy cannot compile lightmaps under an environment map, and draws nothing. Lean cameras draw these meshes.
#[test]
fn lightmapped_meshes_under_an_environment_are_lean() {
    in_own_process(|| {
        let mut lightmapped = Entity::PLACEHOLDER;
        let mut headless = build(SMALL, |s| {
            let image = s.add(Image::default());
            lightmapped = s.mesh(
                kit::scenes::materials::cube_with_second_uvs(),
                clay(),
                Transform::default(),
            );
            let lightmap = Lightmap { image, ..default() };
            s.world().entity_mut(lightmapped).insert(lightmap);
            let light = s.environment_map(1500.0);
            s.default_camera((light, LeanForwardMeshes::default()));
        });
        set_lean(&mut headless, true);
        let picture = settled(&mut headless);
        let world = headless.world();
        let mut reports = world.query::<&LeanForwardMeshes>();
        let report = reports.single(world).expect("there is one lean camera");
        assert!(report.counts.is_empty(), "{:?}", report.counts);
        let mut mesh = headless.world().entity_mut(lightmapped);
        mesh.insert(Visibility::Hidden);
        let without = settled(&mut headless);
        assert!(pixel_difference(&picture, &without).largest > 20);
    });
}

/// `forward_reasons` has the materials and meshes that forward draws.
#[test]
fn what_goes_forward_has_no_targets() {
    in_own_process(|| {
        let mut headless = Headless::new(SMALL);
        let material = StandardMaterial {
            clearcoat: 0.5,
            anisotropy_strength: 0.5,
            emissive: LinearRgba::rgb(1.0, 0.0, 0.0),
            ..clay()
        };
        show_ball(&mut headless, material, ());
        assert_eq!(usage(&mut headless).targets, NONE);
        assert!(forward_draws(&headless));
    });
}

#[test]
fn targets_go_a_while_after_what_needs_them() {
    in_own_process(|| {
        let glow = StandardMaterial {
            emissive: LinearRgba::rgb(1.0, 0.5, 0.0),
            clearcoat: 1.0,
            ..clay()
        };
        let mut headless = Headless::new(SMALL);
        let ball = show_ball(&mut headless, glow, ());
        let used = usage(&mut headless);
        assert_eq!(used.targets, EMISSIVE.union(SPECIALIZATION));
        assert_eq!(used.size, SMALL);
        assert_eq!(used.bytes_per_pixel(), 17);
        assert_eq!(used.bytes(), 64 * 48 * 17);
        let each: Vec<_> = used.each().collect();
        assert_eq!(
            each,
            [
                ("base", 64 * 48 * 8),
                ("valid mask", 64 * 48),
                ("emissive", 64 * 48 * 4),
                ("specialization", 64 * 48 * 4)
            ]
        );

        let mut hide = |hidden: bool, frames: usize| {
            let visibility = if hidden {
                Visibility::Hidden
            } else {
                Visibility::Inherited
            };
            headless.world().entity_mut(ball).insert(visibility);
            headless.frames(frames);
            usage(&mut headless).targets
        };
        assert_eq!(hide(true, LINGERING - 10), used.targets, "it went too soon");
        assert_eq!(hide(false, 1), used.targets);
        assert_eq!(hide(true, LINGERING - 10), used.targets, "not counted anew");
        assert_eq!(hide(true, 20), NONE, "it stays for ever");
        assert_eq!(hide(false, 5), used.targets, "it does not come back");
    });
}

/// Usage ends with the component, and is nothing while the camera is off or forward.
#[test]
fn usage_is_that_of_the_last_frame() {
    in_own_process(|| {
        let mut headless = Headless::new(SMALL);
        show_ball(&mut headless, clay(), ());
        assert!(usage(&mut headless).is_active());
        set_lean(&mut headless, false);
        headless.frames(2);
        let world = headless.world();
        assert_eq!(world.query::<&GBufferUsage>().iter(world).count(), 0);

        show_ball(&mut headless, clay(), ());
        let world = headless.world();
        let mut cameras = world.query::<&mut Camera>();
        cameras.single_mut(world).expect("one").is_active = false;
        headless.frames(3);
        assert_eq!(usage(&mut headless), GBufferUsage::default());

        let world = headless.world();
        let mut cameras = world.query::<(&mut Camera, &mut Msaa)>();
        let (mut camera, mut msaa) = cameras.single_mut(world).expect("one");
        camera.is_active = true;
        *msaa = Msaa::Sample4;
        headless.frames(3);
        assert_eq!(usage(&mut headless).bytes(), 0);
    });
}
