//! Cameras that become lean, or stop being lean, while they are rendered, in apps with crates that keep pipelines per camera. In processes
//! of their own: some of them end with an error, as they do when Bevy's own components change.
//!
//! - `Outlines` are kept as `bevy_mod_outline` 0.13 keeps them: one pipeline per view, created when the view is first seen. Like Bevy's,
//!   its table of items to respecialize has a list of views, but nothing is ever added to it.
//! - `Particles` are drawn as `bevy_hanabi` 0.19 draws opaque and masked ones: in each frame by a temporary entity, in Bevy's `Opaque3d`
//!   under a key that holds the pipeline. An item left under an old key has a despawned entity, which the crate unwraps.
//! - Crates that follow `DirtySpecializations`, as Bevy's meshes do, need nothing.

use bevy::{
    camera::Hdr,
    core_pipeline::{
        core_3d::{
            CORE_3D_DEPTH_FORMAT, Opaque3d, Opaque3dBatchSetKey, Opaque3dBinKey,
            main_opaque_pass_3d,
        },
        schedule::{Core3d, Core3dSystems},
    },
    platform::collections::HashMap,
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        camera::DirtySpecializations,
        render_phase::{
            BinnedRenderPhaseType, Draw, DrawError, DrawFunctions, InputUniformIndex, PhaseItem,
            TrackedRenderPass, ViewBinnedRenderPhases,
        },
        render_resource::{
            CachedRenderPipelineId, ColorTargetState, ColorWrites, CompareFunction,
            DepthStencilState, FragmentState, MultisampleState, PipelineCache,
            RenderPassDescriptor, RenderPipelineDescriptor, TextureFormat, VertexState,
        },
        renderer::{RenderContext, ViewQuery},
        sync_world::{MainEntity, TemporaryRenderEntity},
        view::{ExtractedView, RetainedViewEntity, ViewTarget},
    },
};
use bevy_lean_deferred::prelude::*;
use kit::{
    headless::{Headless, Picture, small_shadow_maps},
    lean::active_lean_views,
    log_watch,
    own_process::in_own_process,
    scenes::SceneBuilder,
};

use crate::actions;

const SIZE: UVec2 = UVec2::new(96, 64);

/// A triangle in the lower left corner, in front of everything.
const SHADER: &str = "
@vertex fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4(vec2(f32(i & 1u), f32(i >> 1u)) * 0.6 - 0.95, 0.99, 1.0);
}
@fragment fn fragment() -> @location(0) vec4<f32> {
    return vec4(0.0, 1.0, 0.0, 1.0);
}
";

/// Shader of the triangle that both outlines and particles draw, in the render world.
#[derive(Resource, Clone)]
struct Triangle(Handle<Shader>);

impl Triangle {
    /// Bevy's cache does not merge equal descriptors of different frames, so callers must keep the id.
    fn pipeline(&self, samples: u32, format: TextureFormat) -> RenderPipelineDescriptor {
        RenderPipelineDescriptor {
            label: Some("tests/triangle".into()),
            vertex: VertexState {
                shader: self.0.clone(),
                entry_point: Some("vertex".into()),
                ..default()
            },
            fragment: Some(FragmentState {
                shader: self.0.clone(),
                entry_point: Some("fragment".into()),
                targets: vec![Some(ColorTargetState {
                    format,
                    blend: None,
                    write_mask: ColorWrites::ALL,
                })],
                ..default()
            }),
            multisample: MultisampleState {
                count: samples,
                ..default()
            },
            ..default()
        }
    }
}

fn load_triangle(app: &mut App) {
    let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
    let shader = shaders.add(Shader::from_wgsl(SHADER, "tests/triangle.wgsl"));
    app.sub_app_mut(RenderApp).insert_resource(Triangle(shader));
}

/// Pipelines by view.
#[derive(Resource)]
struct Outlines {
    by_view: HashMap<RetainedViewEntity, CachedRenderPipelineId>,
    /// Recreates the pipelines of views in Bevy's table.
    follow: bool,
}

fn specialize_outlines(
    mut outlines: ResMut<Outlines>,
    triangle: Res<Triangle>,
    dirty: Res<DirtySpecializations>,
    cache: Res<PipelineCache>,
    views: Query<(&ExtractedView, &Msaa)>,
) {
    let Outlines { by_view, follow } = &mut *outlines;
    for (view, msaa) in &views {
        let retained = view.retained_view_entity;
        if *follow && dirty.must_wipe_specializations_for_view(retained) {
            by_view.remove(&retained);
        }
        by_view.entry(retained).or_insert_with(|| {
            cache.queue_render_pipeline(triangle.pipeline(msaa.samples(), view.target_format))
        });
    }
    by_view.retain(|retained, _| {
        (views.iter()).any(|(view, _)| view.retained_view_entity == *retained)
    });
}

fn draw_outlines(
    view: ViewQuery<(&ExtractedView, &ViewTarget)>,
    outlines: Res<Outlines>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (view, target) = view.into_inner();
    let pipeline = outlines.by_view.get(&view.retained_view_entity);
    let Some(pipeline) = pipeline.and_then(|id| cache.get_render_pipeline(*id)) else {
        return;
    };
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("tests/outlines"),
        color_attachments: &[Some(target.get_color_attachment())],
        ..default()
    });
    pass.set_render_pipeline(pipeline);
    pass.draw(0..3, 0..1);
}

fn add_outlines(app: &mut App, follow: bool) {
    load_triangle(app);
    app.sub_app_mut(RenderApp)
        .insert_resource(Outlines {
            by_view: default(),
            follow,
        })
        .add_systems(
            Render,
            specialize_outlines.in_set(RenderSystems::PrepareMeshes),
        )
        .add_systems(
            Core3d,
            draw_outlines
                .in_set(Core3dSystems::MainPass)
                .after(main_opaque_pass_3d),
        );
}

/// Marks the temporary entity by which particles are drawn.
#[derive(Component)]
struct Batch;

#[derive(Resource, Default)]
struct Particles {
    pipelines: HashMap<(u32, TextureFormat), CachedRenderPipelineId>,
    /// Number of draws by a despawned entity.
    strays: std::sync::atomic::AtomicUsize,
    drawn: std::sync::atomic::AtomicUsize,
}

struct DrawParticles;

impl Draw<Opaque3d> for DrawParticles {
    fn draw<'w>(
        &mut self,
        world: &'w World,
        pass: &mut TrackedRenderPass<'w>,
        _: Entity,
        item: &Opaque3d,
    ) -> Result<(), DrawError> {
        use std::sync::atomic::Ordering::Relaxed;
        let particles = world.resource::<Particles>();
        // `bevy_hanabi` unwraps here.
        if world.get::<Batch>(item.entity()).is_none() {
            particles.strays.fetch_add(1, Relaxed);
        }
        let cache = world.resource::<PipelineCache>();
        if let Some(pipeline) = cache.get_render_pipeline(item.batch_set_key.pipeline) {
            pass.set_render_pipeline(pipeline);
            pass.draw(0..3, 0..1);
            particles.drawn.fetch_add(1, Relaxed);
        }
        Ok(())
    }
}

fn spawn_batch(mut commands: Commands) {
    commands.spawn((Batch, TemporaryRenderEntity));
}

fn queue_particles(
    mut particles: ResMut<Particles>,
    triangle: Res<Triangle>,
    cache: Res<PipelineCache>,
    functions: Res<DrawFunctions<Opaque3d>>,
    mut phases: ResMut<ViewBinnedRenderPhases<Opaque3d>>,
    views: Query<(&ExtractedView, &Msaa)>,
    batches: Query<Entity, With<Batch>>,
) {
    let draw_function = functions.read().id::<DrawParticles>();
    for (view, msaa) in &views {
        let Some(phase) = phases.get_mut(&view.retained_view_entity) else {
            continue;
        };
        let key = (msaa.samples(), view.target_format);
        let pipeline = *particles.pipelines.entry(key).or_insert_with(|| {
            cache.queue_render_pipeline(RenderPipelineDescriptor {
                depth_stencil: Some(DepthStencilState {
                    format: CORE_3D_DEPTH_FORMAT,
                    depth_write_enabled: Some(false),
                    depth_compare: Some(CompareFunction::Always),
                    stencil: default(),
                    bias: default(),
                }),
                ..triangle.pipeline(key.0, key.1)
            })
        });
        for batch in &batches {
            phase.add(
                Opaque3dBatchSetKey {
                    pipeline,
                    draw_function,
                    material_bind_group_index: None,
                    slabs: default(),
                    lightmap_slab: None,
                },
                Opaque3dBinKey {
                    asset_id: AssetId::<Mesh>::invalid().untyped(),
                },
                (batch, MainEntity::from(Entity::PLACEHOLDER)),
                InputUniformIndex::default(),
                BinnedRenderPhaseType::NonMesh,
            );
        }
    }
}

fn add_particles(app: &mut App) {
    load_triangle(app);
    let render_app = app.sub_app_mut(RenderApp);
    render_app.init_resource::<Particles>().add_systems(
        Render,
        (
            spawn_batch.in_set(RenderSystems::PrepareAssets),
            queue_particles.in_set(RenderSystems::QueueMeshes),
        ),
    );
    let functions = render_app.world().resource::<DrawFunctions<Opaque3d>>();
    functions.write().add(DrawParticles);
}

struct Stage {
    headless: Headless,
    camera: Entity,
}

impl Stage {
    fn new(camera: impl Bundle, plugin: impl FnOnce(&mut App)) -> Self {
        let mut headless = Headless::with(SIZE, |app| {
            small_shadow_maps(app);
            actions::add_actions(app);
            plugin(app);
        });
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        s.solids();
        s.sun(true);
        let target = s.headless.render_target();
        let place = Transform::from_xyz(-1.5, 2.8, 5.2).looking_at(Vec3::ZERO, Vec3::Y);
        let camera = s.spawn((Camera3d::default(), target, place, camera));
        headless.settle();
        Self { headless, camera }
    }

    fn act(&mut self, action: impl FnOnce(&mut EntityCommands) + Send + Sync + 'static) {
        actions::act(&mut self.headless, self.camera, action);
        self.headless.frames(3);
    }

    /// Asserts that the triangle is visible.
    fn assert_marked(&mut self, name: &str) {
        let Picture { size, rgba } = self.headless.capture();
        let [x, y] = [size.x / 8, size.y * 7 / 8];
        let pixel = &rgba[((y * size.x + x) * 4) as usize..][..3];
        assert!(pixel[1] > 2 * pixel[0].max(pixel[2]), "{name}: {pixel:?}");
    }

    fn set_enabled(&mut self, enabled: bool) {
        self.act(move |camera| {
            camera
                .entry::<LeanDeferred>()
                .and_modify(move |mut lean| lean.enabled = enabled);
        });
    }
}

fn errors() -> Vec<String> {
    log_watch::messages_with("Caught rendering error")
}

fn warnings() -> Vec<String> {
    log_watch::messages_with("was rendered without")
}

/// A camera with the needed settings from its spawn on changes nothing that crates must follow.
#[test]
fn what_keeps_pipelines_goes_on_where_the_settings_stay() {
    in_own_process(|| {
        let add = |app: &mut App| add_outlines(app, false);
        let mut stage = Stage::new((Hdr, Msaa::Off), add);
        stage.assert_marked("forward");
        for _ in 0..2 {
            stage.act(|camera| {
                camera.insert(LeanDeferred::default());
            });
            assert_eq!(active_lean_views(&mut stage.headless), 1);
            stage.assert_marked("lean");
            stage.act(|camera| {
                camera.remove::<LeanDeferred>();
            });
            stage.assert_marked("forward again");
        }
        assert_eq!(warnings(), [""; 0]);

        let waiting = LeanDeferred {
            enabled: false,
            ..default()
        };
        let mut stage = Stage::new(waiting, add);
        let status = |stage: &mut Stage| {
            let camera = stage.camera;
            let status = stage.headless.world().get::<LeanStatus>(camera);
            status.map(|status| status.deferred.clone())
        };
        let disabled = Some(EffectStatus::Off(LeanOffReason::Disabled));
        assert_eq!(status(&mut stage), disabled);
        stage.assert_marked("waiting");
        let before = stage.headless.capture();
        for _ in 0..2 {
            stage.set_enabled(true);
            assert_eq!(status(&mut stage), Some(EffectStatus::On));
            stage.assert_marked("enabled");
            stage.set_enabled(false);
            assert_eq!(status(&mut stage), disabled);
            assert_eq!(active_lean_views(&mut stage.headless), 0);
        }
        stage.headless.settle();
        assert!(stage.headless.capture() == before);
        assert_eq!(warnings(), [""; 0]);
        assert_eq!(errors(), [""; 0]);
    });
}

/// Before a late switch ends an app, a warning names the camera and the fix. An app that follows Bevy gets the warning too, and continues.
#[test]
fn a_camera_that_is_changed_late_is_named() {
    in_own_process(|| {
        let mut stage = Stage::new((), |app| add_outlines(app, true));
        for _ in 0..2 {
            stage.act(|camera| {
                camera.insert(LeanDeferred::default());
            });
            assert_eq!(active_lean_views(&mut stage.headless), 1);
            stage.assert_marked("lean");
            stage.act(|camera| {
                camera.remove::<LeanDeferred>();
            });
            stage.assert_marked("forward");
        }
        let warned = warnings();
        assert_eq!(warned.len(), 1, "once for each camera: {warned:?}");
        assert!(warned[0].contains(&format!("Camera {}", stage.camera)));
        assert!(warned[0].contains("`Msaa::Off` and `Hdr`"), "{warned:?}");
        assert_eq!(errors(), [""; 0]);

        // Before its first frame no crate keeps a pipeline for the camera.
        let spawned = Stage::new(LeanDeferred::default(), |app| add_outlines(app, false));
        drop(spawned);
        assert_eq!(warnings().len(), 1);
        assert_eq!(errors(), [""; 0]);

        let mut stage = Stage::new((), |app| add_outlines(app, false));
        stage.act(|camera| {
            camera.insert(LeanDeferred::default());
        });
        assert_eq!(warnings().len(), 2);
        let error = errors().join("\n");
        assert!(error.contains("incompatible with render pass"), "{error}");
    });
}

/// Nothing is drawn with a pipeline or by an entity of an earlier frame.
#[test]
fn items_of_others_in_bevys_phases_follow() {
    in_own_process(|| {
        use std::sync::atomic::Ordering::Relaxed;
        let mut stage = Stage::new((), add_particles);
        stage.assert_marked("forward");
        for _ in 0..2 {
            stage.act(|camera| {
                camera.insert(LeanDeferred::default());
            });
            assert_eq!(active_lean_views(&mut stage.headless), 1);
            stage.assert_marked("lean");
            stage.act(|camera| {
                camera.remove::<LeanDeferred>();
            });
            stage.assert_marked("forward again");
        }
        let render_world = stage.headless.app.sub_app(RenderApp).world();
        let particles = render_world.resource::<Particles>();
        assert!(particles.drawn.load(Relaxed) > 10);
        assert_eq!(particles.strays.load(Relaxed), 0);
        assert_eq!(errors(), [""; 0]);
    });
}
