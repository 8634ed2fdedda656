//! A lean camera stays lean while parts of its scene come and go, before any pipeline is compiled for them: general pipelines light it.
//!
//! In processes of their own: compilation is delayed in all of the process.

use bevy::{
    light::ShadowFilteringMethod,
    pbr::{ContactShadows, DistanceFog},
    prelude::*,
    render::{
        RenderApp,
        render_resource::{CachedPipeline, CachedPipelineState, PipelineCache, PipelineDescriptor},
    },
};
use bevy_lean_deferred::{lighting::CompiledLighting, prelude::*};
use kit::{
    gpu,
    headless::{Headless, small_shadow_maps},
    lean::{active_lean_views, compile_lighting, is_lit_by_general},
    log_watch,
    own_process::in_own_process,
    scenes::SceneBuilder,
    shader_files::replace_shader,
    stalled_pipelines::StalledPipelines,
};
use wgpu::Limits;

const SIZE: UVec2 = UVec2::new(96, 64);
/// Frames after a change for which compilation is delayed.
const HELD_BACK: usize = 4;
/// More frames than those in which a view gets pipelines that fit although each delays a frame.
const FIRST_FRAMES: usize = 40;
/// More frames than those for which optional targets stay.
const LINGERING_FRAMES: usize = 130;

/// The things that the changes act on.
#[derive(Clone)]
struct Subject {
    camera: Entity,
    material: Handle<StandardMaterial>,
}

type Change = fn(&mut World, &Subject);

#[derive(Component)]
struct Added;

pub(super) fn set_material(
    world: &mut World,
    material: &Handle<StandardMaterial>,
    change: fn(&mut StandardMaterial),
) {
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    change(&mut materials.get_mut(material).expect("it is there"));
}

fn remove_lights(world: &mut World, _: &Subject) {
    let mut added = world.query_filtered::<Entity, With<Added>>();
    let added: Vec<Entity> = added.iter(world).collect();
    for light in added {
        world.despawn(light);
    }
}

/// Things that come and go.
const CHANGES: &[(&str, Change)] = &[
    ("spot light", |world, _| {
        let place = Transform::from_xyz(-2.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y);
        world.spawn((SpotLight::default(), place, Added));
    }),
    ("shadows of a point light", |world, _| {
        let lamp = PointLight {
            shadow_maps_enabled: true,
            radius: 0.1,
            ..default()
        };
        world.spawn((lamp, Transform::from_xyz(1.0, 2.0, 1.0), Added));
    }),
    ("fog", |world, subject| {
        let mut camera = world.entity_mut(subject.camera);
        camera.insert(DistanceFog::default());
    }),
    ("no added lights", remove_lights),
    ("rectangular light", |world, _| {
        let place = Transform::from_xyz(0.0, 2.5, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
        world.spawn((RectLight::default(), place, Added));
    }),
    ("contact shadows", |world, subject| {
        let mut camera = world.entity_mut(subject.camera);
        camera.insert(ContactShadows::default());
    }),
    ("emission", |world, subject| {
        set_material(world, &subject.material, |material| {
            material.emissive = LinearRgba::rgb(0.2, 0.6, 0.2);
        });
    }),
    ("clear coat", |world, subject| {
        set_material(world, &subject.material, |material| {
            material.clearcoat = 1.0
        });
    }),
    ("no fog", |world, subject| {
        world.entity_mut(subject.camera).remove::<DistanceFog>();
    }),
    ("plain material", |world, subject| {
        set_material(world, &subject.material, |material| {
            material.emissive = LinearRgba::BLACK;
            material.clearcoat = 0.0;
        });
    }),
    ("no rectangular light", remove_lights),
    ("shadow filter", |world, subject| {
        let filter = ShadowFilteringMethod::Hardware2x2;
        world.entity_mut(subject.camera).insert(filter);
    }),
    ("ambient occlusion", |world, subject| {
        let occlusion = LeanScreenSpaceAmbientOcclusion::default();
        world.entity_mut(subject.camera).insert(occlusion);
    }),
    ("neither occlusion nor contact shadows", |world, subject| {
        let mut camera = world.entity_mut(subject.camera);
        camera.remove::<(LeanScreenSpaceAmbientOcclusion, ContactShadows)>();
    }),
    ("orthographic projection", |world, subject| {
        let projection = OrthographicProjection {
            scale: 0.05,
            ..OrthographicProjection::default_3d()
        };
        let mut camera = world.entity_mut(subject.camera);
        camera.insert(Projection::from(projection));
    }),
];

/// Builds a scene with a sun and a lean camera.
fn build(headless: &mut Headless) -> Subject {
    let mut s = SceneBuilder { headless };
    s.solids();
    s.sun(true);
    let material = s.add::<StandardMaterial>(Color::srgb(0.7, 0.4, 0.3));
    let mesh = s.add::<Mesh>(Sphere::new(0.6));
    s.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material.clone()),
        Transform::from_xyz(0.0, 0.6, 1.6),
    ));
    let camera = s.default_camera(LeanDeferred::default());
    Subject { camera, material }
}

/// The change of that name.
fn change(name: &str) -> Change {
    let mut changes = CHANGES.iter();
    let (_, change) = changes.find(|(other, _)| *other == name).expect(name);
    *change
}

/// An app that shows the scene after the changes `first`.
fn app(synchronous: bool, first: &[&str], configure: impl FnOnce(&mut App)) -> (Headless, Subject) {
    let mut headless = Headless::with_compilation(SIZE, synchronous, |app| {
        small_shadow_maps(app);
        compile_lighting(app, CompiledLighting::All);
        configure(app);
    });
    let subject = build(&mut headless);
    for name in first {
        change(name)(headless.world(), &subject);
    }
    headless.settle();
    headless.frames(FIRST_FRAMES);
    (headless, subject)
}

fn assert_lean(headless: &mut Headless, subject: &Subject, name: &str) {
    assert_eq!(active_lean_views(headless), 1, "{name}");
    let status = headless.world().get::<LeanStatus>(subject.camera);
    let status = &status.expect("it has effects").deferred;
    assert!(status.is_on(), "{name}: {status}");
}

/// The lighting pipelines that were requested so far.
fn lighting_pipelines(headless: &Headless) -> impl Iterator<Item = &CachedPipeline> {
    let render_world = headless.app.sub_app(RenderApp).world();
    let pipelines = render_world.resource::<PipelineCache>().pipelines();
    pipelines.filter(|pipeline| match &pipeline.descriptor {
        PipelineDescriptor::ComputePipelineDescriptor(descriptor) => {
            descriptor.label.as_deref() == Some("lean_deferred/lighting")
        }
        PipelineDescriptor::RenderPipelineDescriptor(_) => false,
    })
}

/// Number of those that are not compiled yet.
fn waiting_pipelines(headless: &Headless) -> usize {
    lighting_pipelines(headless)
        .filter(|pipeline| !matches!(pipeline.state, CachedPipelineState::Ok(_)))
        .count()
}

#[test]
fn features_come_and_go_without_a_forward_frame() {
    in_own_process(|| {
        let (mut headless, subject) = app(false, &[], |_| {});
        assert_lean(&mut headless, &subject, "at first");
        assert!(!is_lit_by_general(&mut headless));
        for (name, change) in CHANGES {
            let stalled_pipelines = StalledPipelines::new();
            change(headless.world(), &subject);
            for frame in 0..HELD_BACK {
                headless.frame();
                assert_lean(&mut headless, &subject, &format!("{name}, frame {frame}"));
                // Those of Bevy for which it waits within the frame would wait for more.
                assert!(waiting_pipelines(&headless) <= 1, "{name}");
            }
            drop(stalled_pipelines);
            headless.settle();
            headless.frames(2);
            assert_lean(&mut headless, &subject, name);
            let is_general = is_lit_by_general(&mut headless);
            assert!(!is_general, "{name}: none is compiled that fits");
        }
        log_watch::assert_validation_layer_silent();
    });
}

/// Lighting is compiled only for the first frames if Bevy compiles within the frame, as on macOS and the web.
#[test]
fn synchronous_apps_compile_lighting_once() {
    in_own_process(|| {
        let (mut headless, subject) = app(true, &[], |_| {});
        let compiled = lighting_pipelines(&headless).count();
        // The general ones for all tiles and for those with special surfaces, one that fits, and perhaps one that fitted the first
        // frame.
        assert!((3..=4).contains(&compiled), "{compiled}");
        assert!(!is_lit_by_general(&mut headless));
        for (name, change) in CHANGES {
            change(headless.world(), &subject);
            for frame in 0..HELD_BACK {
                headless.frame();
                assert_lean(&mut headless, &subject, &format!("{name}, frame {frame}"));
            }
            assert_eq!(lighting_pipelines(&headless).count(), compiled, "{name}");
        }
        assert!(is_lit_by_general(&mut headless));
        log_watch::assert_validation_layer_silent();
    });
}

/// Number of Bevy's pipelines for opaque meshes that were requested so far.
fn opaque_pipelines_of_bevy(headless: &Headless) -> usize {
    let render_world = headless.app.sub_app(RenderApp).world();
    let pipelines = render_world.resource::<PipelineCache>().pipelines();
    let of_bevy = |pipeline: &&CachedPipeline| match &pipeline.descriptor {
        PipelineDescriptor::RenderPipelineDescriptor(descriptor) => {
            descriptor.label.as_deref() == Some("pbr_opaque_mesh_pipeline")
        }
        PipelineDescriptor::ComputePipelineDescriptor(_) => false,
    };
    pipelines.filter(of_bevy).count()
}

/// Bevy's pipelines are compiled for the meshes that forward draws alone, if each delays a frame.
#[test]
fn meshes_in_the_gbuffer_ask_bevy_for_no_pipeline() {
    in_own_process(|| {
        let (mut headless, subject) = app(true, &[], |_| {});
        let before = opaque_pipelines_of_bevy(&headless);
        let other_kind = |material: &mut StandardMaterial| material.cull_mode = None;
        set_material(headless.world(), &subject.material, other_kind);
        headless.frames(HELD_BACK);
        assert_lean(&mut headless, &subject, "another kind of mesh");
        assert_eq!(opaque_pipelines_of_bevy(&headless), before);
        // Forward draws it.
        let unmet = |material: &mut StandardMaterial| material.depth_bias = 100.0;
        set_material(headless.world(), &subject.material, unmet);
        headless.frames(HELD_BACK);
        assert!(opaque_pipelines_of_bevy(&headless) > before);
    });
}

/// Pipelines that fitted the scene go on when it has less to show.
#[test]
fn what_goes_needs_no_pipeline() {
    in_own_process(|| {
        let first = [
            "rectangular light",
            "contact shadows",
            "fog",
            "emission",
            "clear coat",
            "ambient occlusion",
        ];
        let (mut headless, subject) = app(true, &first, |_| {});
        let compiled = lighting_pipelines(&headless).count();
        assert!(!is_lit_by_general(&mut headless));
        let losses = [
            "no rectangular light",
            "no fog",
            "plain material",
            "neither occlusion nor contact shadows",
        ];
        for name in losses {
            change(name)(headless.world(), &subject);
            for frame in 0..LINGERING_FRAMES {
                headless.frame();
                assert_lean(&mut headless, &subject, &format!("{name}, frame {frame}"));
                assert!(!is_lit_by_general(&mut headless), "{name}, frame {frame}");
            }
        }
        assert_eq!(lighting_pipelines(&headless).count(), compiled);
        log_watch::assert_validation_layer_silent();
    });
}

/// Without general pipelines a camera waits for its own, and stays lean.
#[test]
fn a_broken_general_pipeline_is_not_waited_for() {
    in_own_process(|| {
        let (mut headless, subject) = app(true, &[], |app| {
            let shader = include_str!("../../src/lighting/lighting.wgsl");
            let broken = "#ifdef SUPERSET\nfn broken() -> u32 { return missing_name; }\n#endif\n";
            replace_shader(app, "lighting/lighting.wgsl", format!("{shader}{broken}"));
        });
        assert_lean(&mut headless, &subject, "at first");
        for (name, change) in CHANGES {
            change(headless.world(), &subject);
            headless.settle();
            headless.frames(2);
            assert_lean(&mut headless, &subject, name);
            assert!(!is_lit_by_general(&mut headless), "{name}");
        }
    });
}

/// A device with no more storage buffers than lean cameras need has general pipelines too, with fewer parts.
#[test]
fn devices_with_few_bindings_have_general_pipelines() {
    in_own_process(|| {
        let limits = Limits {
            max_storage_buffers_per_shader_stage: 8,
            ..gpu::limits()
        };
        let mut headless = Headless::within(limits, SIZE, |app| {
            small_shadow_maps(app);
            compile_lighting(app, CompiledLighting::General);
        });
        let subject = build(&mut headless);
        headless.settle();
        headless.frames(2);
        assert_lean(&mut headless, &subject, "with 8 storage buffers");
        assert!(is_lit_by_general(&mut headless));
        let errors = log_watch::messages_with("Caught rendering error");
        assert!(errors.is_empty(), "{errors:?}");
        log_watch::assert_validation_layer_silent();
    });
}
