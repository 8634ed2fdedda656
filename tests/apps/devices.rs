//! Devices that lack a capability: Bevy renders their cameras with its own settings, and the main world knows the reason. In processes of
//! their own, because of their logs.

use bevy::{
    camera::Hdr,
    prelude::*,
    render::render_resource::{DownlevelFlags, TextureFormat, TextureUsages},
};
use bevy_lean_deferred::{
    activation::{NEEDED_FLAGS, NEEDED_FORMATS, NEEDED_LIMITS, NeededLimit, missing_of},
    effects::{self, ambient_occlusion, auto_exposure, subsurface},
    prelude::*,
};
use kit::{
    analytic_slabs::{SKIN, slab},
    gpu,
    headless::Headless,
    lean::active_lean_views,
    log_watch,
    own_process::in_own_process,
    scenes::SceneBuilder,
};
use wgpu::Limits;

const SIZE: UVec2 = UVec2::new(96, 64);

/// An app on a device with limits no better than `limits`, and a camera with Bevy's defaults.
fn app_within(limits: Limits) -> (Headless, Entity) {
    let mut headless = Headless::within(limits, SIZE, |_| {});
    let mut s = SceneBuilder {
        headless: &mut headless,
    };
    s.solids();
    s.sun(true);
    let camera = spawn_camera(&mut s, Camera::default());
    (headless, camera)
}

fn spawn_camera(s: &mut SceneBuilder, camera: Camera) -> Entity {
    let target = s.headless.render_target();
    let place = Transform::from_xyz(-1.5, 2.8, 5.2).looking_at(Vec3::ZERO, Vec3::Y);
    s.spawn((Camera3d::default(), camera, target, place))
}

fn settings(headless: &mut Headless, camera: Entity) -> (Msaa, bool) {
    let camera = headless.world().entity(camera);
    (*camera.get::<Msaa>().unwrap(), camera.contains::<Hdr>())
}

fn assert_no_errors() {
    let errors = log_watch::messages_with("Caught rendering error");
    assert!(errors.is_empty(), "{errors:?}");
    log_watch::assert_validation_layer_silent();
}

const BEVYS: (Msaa, bool) = (Msaa::Sample4, false);

/// On a device that lacks an attachment, a camera with effects and one above it keep Bevy's settings and picture.
#[test]
fn cameras_that_can_never_be_lean_stay_as_they_are() {
    in_own_process(|| {
        let limits = Limits {
            max_color_attachments: 6,
            ..gpu::limits()
        };
        let (mut headless, camera) = app_within(limits);
        // Before the first frame, so that `Startup` can query it.
        let support = headless.world().resource::<LeanSupport>();
        let missing = "max_color_attachments of 7 (it has 6)".to_string();
        assert_eq!(support.deferred, Err(missing.clone()));
        // They need a lean camera.
        assert_eq!(support.screen_space, Err(missing.clone()));
        assert_eq!(support.auto_exposure, Ok(()));

        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        let above = spawn_camera(
            &mut s,
            Camera {
                order: 1,
                clear_color: ClearColorConfig::None,
                ..default()
            },
        );
        headless.settle();
        let before = headless.capture();
        headless.world().entity_mut(camera).insert((
            LeanDeferred::default(),
            LeanScreenSpaceGi::default(),
            LeanScreenSpaceReflections::default(),
        ));
        headless.settle();
        assert_eq!(settings(&mut headless, camera), BEVYS);
        assert_eq!(settings(&mut headless, above), BEVYS);
        assert!(headless.capture() == before, "the picture is not Bevy's");
        let status = headless.world().get::<LeanStatus>(camera).unwrap();
        let reason = LeanOffReason::Device(missing);
        let off = EffectStatus::Off(reason.clone());
        assert_eq!(
            *status,
            LeanStatus {
                deferred: off.clone(),
                diffuse_gi: off.clone(),
                reflections: off,
                ..default()
            }
        );
        let told = log_watch::messages_with(&format!("is off on all cameras: {reason}"));
        assert_eq!(told.len(), 3, "{told:?}");
        assert_no_errors();
    });
}

/// Lighting and occlusion need little shared memory; effects that need more are off. (With fewer than 256 invocations per workgroup Bevy's
/// own mip pipelines are rejected, which ends the app.)
#[test]
fn effects_are_off_where_workgroups_are_small() {
    in_own_process(|| {
        let limits = Limits {
            max_compute_workgroup_storage_size: 8192,
            ..gpu::limits()
        };
        let (mut headless, camera) = app_within(limits);
        let support = headless.world().resource::<LeanSupport>();
        assert!(support.deferred.is_ok(), "{support:?}");
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        let ball = s.add::<Mesh>(Sphere::new(0.5));
        let skin = s.add::<ExtendedStandardMaterial>(slab(SKIN, 0.05));
        let place = Transform::from_xyz(0.0, 0.5, 2.2);
        s.spawn((Mesh3d(ball), MeshMaterial3d(skin), place));
        headless.world().entity_mut(camera).insert((
            LeanDeferred::default(),
            LeanScreenSpaceAmbientOcclusion::default(),
            LeanScreenSpaceGi::default(),
            LeanScreenSpaceReflections::default(),
            LeanSubsurfaceScattering::default(),
        ));
        headless.settle();
        headless.frames(4);
        assert_no_errors();
        assert_eq!(active_lean_views(&mut headless), 1);
        let status = headless.world().get::<LeanStatus>(camera).unwrap().clone();
        assert!(status.deferred.is_on() && status.ambient_occlusion.is_on());
        for (effect, status, need) in [
            ("LeanScreenSpaceGi", &status.diffuse_gi, 12544),
            ("LeanScreenSpaceReflections", &status.reflections, 12544),
            ("LeanSubsurfaceScattering", &status.subsurface, 16352),
        ] {
            let missing = format!("max_compute_workgroup_storage_size of {need} (it has 8192)");
            let warnings = log_watch::messages_with(&format!("{effect} is off on all cameras"));
            assert_eq!(warnings.len(), 1, "{effect}: {warnings:?}");
            assert!(warnings[0].contains(&missing), "{warnings:?}");
            let EffectStatus::Off(LeanOffReason::Device(reason)) = status else {
                panic!("{effect}: {status}");
            };
            assert!(reason.contains(&missing), "{effect}: {reason}");
        }
    });
}

/// Occlusion falls back from compute passes to render passes.
#[test]
fn occlusion_is_drawn_where_it_cannot_be_computed() {
    in_own_process(|| {
        let needed = &ambient_occlusion::COMPUTE_LIMITS[3];
        assert_eq!(needed.name, "max_compute_workgroup_storage_size");
        let (mut headless, camera) = app_within(just_less(needed));
        headless.settle();
        let without = headless.capture();
        headless
            .world()
            .entity_mut(camera)
            .insert(LeanScreenSpaceAmbientOcclusion::default());
        headless.settle();
        let support = headless.world().resource::<LeanSupport>();
        let missing = support.ambient_occlusion_by_compute.clone().unwrap_err();
        assert!(missing.starts_with(needed.name), "{missing}");
        assert!(headless.capture() != without, "nothing is darker");
        assert_no_errors();
    });
}

/// Limits of a device that lacks only `needed`.
fn just_less(needed: &NeededLimit) -> Limits {
    let mut limits = gpu::limits();
    *(needed.field)(&mut limits) = needed.least - 1;
    limits
}

#[test]
fn exposure_leaves_cameras_alone_where_it_cannot_meter() {
    let alignments = || Limits {
        min_storage_buffer_offset_alignment: 256,
        min_uniform_buffer_offset_alignment: 128,
        ..gpu::limits()
    };
    in_own_process(move || {
        cannot_meter(alignments(), "storage buffers at the offsets of uniforms");
    });
}

#[test]
fn exposure_leaves_cameras_alone_where_workgroups_are_small() {
    in_own_process(|| {
        let needed = (auto_exposure::NEEDED_LIMITS.iter())
            .find(|needed| needed.name == "max_compute_workgroup_storage_size")
            .expect("it shares memory");
        let (least, has) = (needed.least, needed.least - 1);
        let missing = format!("max_compute_workgroup_storage_size of {least} (it has {has})");
        cannot_meter(just_less(needed), &missing);
    });
}

fn cannot_meter(limits: Limits, expected: &str) {
    let (mut headless, camera) = app_within(limits);
    let support = headless.world().resource::<LeanSupport>();
    assert_eq!(support.auto_exposure, Err(expected.to_string()));
    headless.settle();
    let before = headless.capture();
    let exposure = LeanAutoExposure::default();
    headless.world().entity_mut(camera).insert(exposure);
    headless.settle();
    assert_eq!(settings(&mut headless, camera), BEVYS);
    assert!(headless.capture() == before, "the picture is not Bevy's");
    let status = headless.world().get::<LeanStatus>(camera).unwrap();
    let reason = LeanOffReason::Device(expected.into());
    assert_eq!(status.auto_exposure, EffectStatus::Off(reason));
    assert_no_errors();
}

/// Tables of needed limits, by effect.
const TABLES: [(&str, &[NeededLimit]); 5] = [
    ("LeanDeferred", NEEDED_LIMITS),
    (
        "LeanScreenSpaceAmbientOcclusion",
        ambient_occlusion::COMPUTE_LIMITS,
    ),
    ("GI and reflections", effects::NEEDED_LIMITS),
    ("scattering", subsurface::NEEDED_LIMITS),
    ("LeanAutoExposure", auto_exposure::NEEDED_LIMITS),
];

/// All effects run on a device with no more than the limits of all tables.
#[test]
fn the_tables_are_enough() {
    in_own_process(|| {
        let mut limits = gpu::limits();
        let mut least = limits.clone();
        for needed in TABLES.iter().flat_map(|(_, table)| *table) {
            *(needed.field)(&mut least) = 0;
        }
        for needed in TABLES.iter().flat_map(|(_, table)| *table) {
            let limit = (needed.field)(&mut least);
            *limit = needed.least.max(*limit);
        }
        limits = least;
        println!("{limits:?}");
        let (mut headless, camera) = app_within(limits);
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        let ball = s.add::<Mesh>(Sphere::new(0.5));
        let skin = s.add::<ExtendedStandardMaterial>(slab(SKIN, 0.05));
        let place = Transform::from_xyz(0.0, 0.5, 2.2);
        s.spawn((Mesh3d(ball), MeshMaterial3d(skin), place));
        s.mesh(
            Sphere::new(0.4),
            StandardMaterial {
                clearcoat: 1.0,
                emissive: LinearRgba::rgb(0.2, 0.1, 0.3),
                ..default()
            },
            Transform::from_xyz(1.2, 0.4, 1.6),
        );
        s.spawn((
            PointLight {
                intensity: 300_000.0,
                shadow_maps_enabled: true,
                ..default()
            },
            bevy::camera::visibility::RenderLayers::layer(1),
            Transform::from_xyz(1.0, 2.0, 1.5),
        ));
        headless.world().entity_mut(camera).insert((
            bevy::camera::visibility::RenderLayers::from_layers(&[0, 1]),
            LeanDeferred::default(),
            LeanScreenSpaceAmbientOcclusion::default(),
            LeanScreenSpaceReflections::default(),
            LeanSubsurfaceScattering::default(),
            LeanAutoExposure::default(),
        ));
        headless.settle();
        headless.frames(4);
        headless
            .world()
            .entity_mut(camera)
            .insert(LeanScreenSpaceGi::default());
        headless.settle();
        headless.frames(4);
        assert_no_errors();
        assert_eq!(active_lean_views(&mut headless), 1);
        let off = log_watch::messages_with("is off");
        assert!(off.is_empty(), "{off:?}");
    });
}

/// A device just below one of the limits of `LeanDeferred` lacks that limit alone.
#[test]
fn a_device_with_just_less_of_a_limit_is_told_from_one_with_enough() {
    let full = gpu::limits();
    let missing = |limits: &Limits| {
        missing_of(
            DownlevelFlags::all(),
            |_| TextureUsages::all(),
            &gpu::limits_within(limits),
        )
    };
    assert_eq!(missing(&full), [""; 0]);
    for needed in NEEDED_LIMITS {
        let within = |limit| {
            let mut limits = full.clone();
            *(needed.field)(&mut limits) = limit;
            missing(&limits)
        };
        let NeededLimit { name, least, .. } = *needed;
        assert_eq!(within(least), [""; 0], "{name}");
        let less = least - 1;
        assert_eq!(
            within(less),
            [format!("{name} of {least} (it has {less})")],
            "{name}"
        );
    }
}

#[test]
fn an_adapter_without_a_flag_or_a_format_is_told_from_a_full_one() {
    let limits = gpu::limits();
    let all = |_: TextureFormat| TextureUsages::all();
    for (flag, name) in NEEDED_FLAGS {
        let flags = DownlevelFlags::all() - flag;
        assert_eq!(missing_of(flags, all, &limits), [name]);
    }
    assert!(
        NEEDED_FLAGS
            .iter()
            .any(|(flag, _)| *flag == DownlevelFlags::INDEPENDENT_BLEND)
    );
    for (format, usage, name) in NEEDED_FORMATS {
        let usages = |other| match other == format {
            true => TextureUsages::all() - usage,
            false => TextureUsages::all(),
        };
        let missing = missing_of(DownlevelFlags::all(), usages, &limits);
        assert!(missing.contains(&name.to_string()), "{missing:?}");
    }
}
