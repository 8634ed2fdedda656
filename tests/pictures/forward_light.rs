//! Meshes that Bevy's passes draw are lit by the crate's light functions, as Bevy lights them.

pub mod scenes;

use bevy::{
    asset::uuid_handle,
    core_pipeline::core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{
        ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline,
        MaterialPlugin,
    },
    prelude::*,
    reflect::TypePath,
    render::{
        RenderApp,
        render_phase::{BinnedPhaseItem, ViewBinnedRenderPhases, ViewSortedRenderPhases},
        render_resource::{
            AsBindGroup, CachedRenderPipelineId, PipelineCache, PipelineDescriptor,
            RenderPipelineDescriptor, SpecializedMeshPipelineError,
        },
    },
    shader::ShaderRef,
};
use bevy_lean_deferred::{
    lighting::{define_lean_lighting, forward::PIPELINE_LABEL},
    prelude::*,
    view::LeanDeferredAdvanced,
};
use kit::{
    headless::{Headless, Picture, small_shadow_maps},
    lean::{change_cameras, judge, report, set_lean, settled, show},
    metrics::difference,
    own_process::in_own_process,
    scenes::{LEAST_PSNR, SceneBuilder},
};
use scenes::{ENVIRONMENT, FURTHER, LIGHTS, Subject};

use super::fragment_shaders::{forward_main, insert_shader};

const SIZE: UVec2 = UVec2::new(160, 120);

/// Least PSNR in dB from forward: what the G-buffer loses on surfaces beside and behind these meshes decides it.
const LEAST_FROM_FORWARD: f64 = 54.0;

/// Least PSNR in dB between light by the crate's functions and by Bevy's, on the same camera. The order of sums differs.
const LEAST_BETWEEN_LOOPS: f64 = 60.0;

/// A picture by cameras that are lean, with Bevy's fragment shader or the crate's for meshes in Bevy's passes, and the number of these
/// meshes that the crate lights.
fn lean(headless: &mut Headless, lights_forward_meshes: bool) -> (Picture, usize) {
    change_cameras(headless, |camera| {
        camera.insert((
            LeanDeferred {
                advanced: LeanDeferredAdvanced {
                    lights_forward_meshes,
                    ..default()
                },
                ..default()
            },
            LeanForwardMeshes::default(),
        ));
    });
    let picture = settled(headless);
    let world = headless.world();
    let mut reports = world.query::<&LeanForwardMeshes>();
    let lit = reports.iter(world).map(|report| report.lit).sum();
    (picture, lit)
}

/// Number of blended meshes, and of kinds of opaque and alpha-masked ones, whose pipeline in Bevy's phases is the crate's.
fn drawn_by_own_pipelines(headless: &Headless) -> (usize, usize) {
    let world = headless.app.sub_app(RenderApp).world();
    let cache = world.resource::<PipelineCache>();
    let is_own = |id: CachedRenderPipelineId| {
        let pipeline = cache.pipelines().nth(id.id());
        pipeline.is_some_and(|pipeline| match &pipeline.descriptor {
            PipelineDescriptor::RenderPipelineDescriptor(descriptor) => {
                descriptor.label.as_deref() == Some(PIPELINE_LABEL)
            }
            PipelineDescriptor::ComputePipelineDescriptor(_) => false,
        })
    };
    let transparent = world.resource::<ViewSortedRenderPhases<Transparent3d>>();
    let items = transparent.values().flat_map(|phase| phase.items.values());
    let blended = items.filter(|item| is_own(item.pipeline)).count();
    let opaque = keys(world.resource::<ViewBinnedRenderPhases<Opaque3d>>());
    let masked = keys(world.resource::<ViewBinnedRenderPhases<AlphaMask3d>>());
    let pipelines = opaque
        .map(|key| key.pipeline)
        .chain(masked.map(|key| key.pipeline));
    (blended, pipelines.filter(|id| is_own(*id)).count())
}

/// True if the light functions are defined in pipelines with this fragment shader.
fn is_lit_by_functions(headless: &Headless, shader: &Handle<Shader>) -> bool {
    let world = headless.app.sub_app(RenderApp).world();
    let mut pipelines = world.resource::<PipelineCache>().pipelines();
    pipelines.any(|pipeline| match &pipeline.descriptor {
        PipelineDescriptor::RenderPipelineDescriptor(descriptor) => (descriptor.fragment.as_ref())
            .is_some_and(|fragment| {
                fragment.shader == *shader && fragment.shader_defs.contains(&"FORWARD_MESH".into())
            }),
        PipelineDescriptor::ComputePipelineDescriptor(_) => false,
    })
}

/// The keys of all meshes in binned phases.
fn keys<P: BinnedPhaseItem>(
    phases: &ViewBinnedRenderPhases<P>,
) -> impl Iterator<Item = &P::BatchSetKey> {
    phases.values().flat_map(|phase| {
        let multidrawable = phase.multidrawable_meshes.keys();
        let batchable = phase.batchable_meshes.keys().map(|(key, _)| key);
        let unbatchable = phase.unbatchable_meshes.keys().map(|(key, _)| key);
        multidrawable.chain(batchable).chain(unbatchable)
    })
}

fn compare(headless: &mut Headless, subject: &Subject) -> Result<(), String> {
    show(headless, subject.build);
    let forward = settled(headless);
    let (bevys, lit_by_bevy) = lean(headless, false);
    assert_eq!(lit_by_bevy, 0, "{}", subject.name);
    assert_eq!(drawn_by_own_pipelines(headless), (0, 0));
    let (own, lit) = lean(headless, true);
    assert_eq!(lit, subject.lit, "{}", subject.name);
    let (blended, kinds) = drawn_by_own_pipelines(headless);
    assert_eq!(blended, subject.blended, "{}", subject.name);
    assert_eq!(kinds > 0, lit > blended, "{}", subject.name);
    let name = |of: &str| format!("forward_light_{}{of}", subject.name);
    judge(&name(""), &forward, &own, LEAST_FROM_FORWARD)?;
    judge(&name("_loops"), &bevys, &own, LEAST_BETWEEN_LOOPS)
}

fn compare_all<'a>(subjects: impl IntoIterator<Item = &'a Subject>) {
    let mut headless = Headless::new(SIZE);
    let subjects = subjects.into_iter();
    report(subjects.map(|subject| compare(&mut headless, subject)));
}

#[test]
fn meshes_of_bevys_passes_are_lit_as_bevy_lights_them() {
    in_own_process(|| compare_all([&LIGHTS]));
}

#[test]
fn blended_meshes_under_environment_maps_are_lit_as_bevy_lights_them() {
    in_own_process(|| compare_all([&ENVIRONMENT]));
}

#[test]
#[ignore = "nightly: combinations of features that have tests of their own"]
fn further_meshes_of_bevys_passes_are_lit_as_bevy_lights_them() {
    in_own_process(|| compare_all(FURTHER));
}

/// Only lamps that share a layer with the glass light it.
#[test]
fn light_layers_hold_for_blended_meshes() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        show(&mut headless, |s| scenes::layered(s, false));
        let expected = settled(&mut headless);
        show(&mut headless, |s| scenes::layered(s, true));
        let all = settled(&mut headless);
        assert!(difference(&expected, &all).psnr < 35.0, "layers matter");
        let (own, lit) = lean(&mut headless, true);
        if headless.device().limits().max_bind_groups <= 4 {
            println!("skipped: there is no bind group for layers");
            return;
        }
        assert_eq!(lit, 4);
        report([judge("forward_light_layers", &expected, &own, LEAST_PSNR)]);
    });
}

/// A camera that stops being lean gives its meshes back to Bevy's pipelines.
#[test]
fn forward_cameras_have_bevys_pipelines() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        show(&mut headless, LIGHTS.build);
        let forward = settled(&mut headless);
        lean(&mut headless, true);
        assert_eq!(drawn_by_own_pipelines(&headless).0, LIGHTS.blended);
        change_cameras(&mut headless, |camera| {
            camera
                .get_mut::<LeanDeferred>()
                .expect("it was inserted")
                .enabled = false;
        });
        headless.settle();
        assert_eq!(drawn_by_own_pipelines(&headless), (0, 0));
        lean(&mut headless, true);
        assert_eq!(drawn_by_own_pipelines(&headless).0, LIGHTS.blended);
        set_lean(&mut headless, false);
        let again = settled(&mut headless);
        assert_eq!(drawn_by_own_pipelines(&headless), (0, 0));
        assert!(difference(&forward, &again).psnr > 80.0);
    });
}

const TINT: &str = "pbr.material.base_color.r = 0.9;";

const TINTED: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e51");

/// A tint by a fragment shader of its own.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
struct Tint {}

impl MaterialExtension for Tint {
    fn fragment_shader() -> ShaderRef {
        TINTED.into()
    }
}

type Tinted = ExtendedMaterial<StandardMaterial, Tint>;

const LIT_BY_FUNCTIONS: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e52");

/// The same tint, whose shader calls the light functions.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
struct LeanTint {}

impl MaterialExtension for LeanTint {
    fn fragment_shader() -> ShaderRef {
        LIT_BY_FUNCTIONS.into()
    }

    fn specialize(
        _: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        _: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        define_lean_lighting(descriptor);
        Ok(())
    }
}

type LeanTinted = ExtendedMaterial<StandardMaterial, LeanTint>;

/// An extension without a fragment shader.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
struct Swayed {}

impl MaterialExtension for Swayed {}

type SwayedMaterial = ExtendedMaterial<StandardMaterial, Swayed>;

/// Materials with a fragment shader of their own keep it; extensions without one are lit as `StandardMaterial`.
#[test]
fn custom_fragment_shaders_stay() {
    in_own_process(|| {
        let mut headless = Headless::with(SIZE, |app| {
            small_shadow_maps(app);
            app.add_plugins((
                MaterialPlugin::<Tinted>::default(),
                MaterialPlugin::<SwayedMaterial>::default(),
            ));
        });
        insert_shader(&mut headless, TINTED, forward_main(TINT), "tinted.wgsl");
        show(&mut headless, |s: &mut SceneBuilder| {
            s.floor();
            let base = StandardMaterial {
                base_color: Color::srgba(0.2, 0.5, 0.9, 0.5),
                alpha_mode: AlphaMode::Blend,
                ..default()
            };
            let mesh = s.add::<Mesh>(Sphere::new(0.8).mesh().uv(24, 12));
            let tinted = s.add::<Tinted>(Tinted {
                base: base.clone(),
                extension: Tint {},
            });
            let swayed = s.add::<SwayedMaterial>(SwayedMaterial {
                base,
                extension: Swayed {},
            });
            let place = |x| Transform::from_xyz(x, 0.8, 0.0);
            s.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(tinted), place(-1.0)));
            s.spawn((Mesh3d(mesh), MeshMaterial3d(swayed), place(1.0)));
            s.sun(false);
            s.default_camera(());
        });
        let forward = settled(&mut headless);
        let (own, lit) = lean(&mut headless, true);
        assert_eq!(lit, 1);
        assert_eq!(drawn_by_own_pipelines(&headless), (1, 0));
        report([judge("forward_light_custom", &forward, &own, LEAST_PSNR)]);
    });
}

/// Shaders of apps may call the light functions, on cameras of any kind.
#[test]
fn custom_fragment_shaders_may_call_the_light_functions() {
    in_own_process(|| {
        let mut headless = Headless::with(SIZE, |app| {
            small_shadow_maps(app);
            app.add_plugins((
                MaterialPlugin::<Tinted>::default(),
                MaterialPlugin::<LeanTinted>::default(),
            ));
        });
        let bevys = forward_main(TINT);
        let own = bevys
            .replace("apply_pbr_lighting, ", "")
            .replace("apply_pbr_lighting", "apply_lean_lighting");
        let import = "#import bevy_lean_deferred::lighting::forward::light::apply_lean_lighting\n";
        insert_shader(&mut headless, TINTED, bevys, "tinted.wgsl");
        insert_shader(
            &mut headless,
            LIT_BY_FUNCTIONS,
            format!("{import}{own}"),
            "lean_tinted.wgsl",
        );
        let base = StandardMaterial {
            base_color: Color::srgba(0.2, 0.5, 0.9, 0.5),
            alpha_mode: AlphaMode::Blend,
            ..default()
        };
        show(&mut headless, |s| {
            let material = s.add::<Tinted>(Tinted {
                base: base.clone(),
                extension: Tint {},
            });
            scenes::lamplit(s, MeshMaterial3d(material));
        });
        let expected = settled(&mut headless);
        show(&mut headless, |s| {
            let material = s.add::<LeanTinted>(LeanTinted {
                base: base.clone(),
                extension: LeanTint {},
            });
            scenes::lamplit(s, MeshMaterial3d(material));
        });
        let forward = settled(&mut headless);
        // Without the definitions, the function is Bevy's.
        assert!(is_lit_by_functions(&headless, &LIT_BY_FUNCTIONS));
        assert!(!is_lit_by_functions(&headless, &TINTED));
        let (own, lit) = lean(&mut headless, true);
        // Its own shader stays.
        assert_eq!(lit, 0);
        report([
            judge(
                "forward_light_function",
                &expected,
                &forward,
                LEAST_BETWEEN_LOOPS,
            ),
            judge("forward_light_function_lean", &expected, &own, LEAST_PSNR),
        ]);
    });
}
