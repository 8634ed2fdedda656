//! Once a scene is loaded, lean cameras create no lasting GPU resource: no pipeline, no texture, no buffer, and no bind group where the old
//! one still fits.
//!
//! In a process of its own: the ids of Bevy's GPU resource wrappers are counted.

use core::{f32::consts::TAU, num::NonZero};
use std::collections::BTreeSet;

use bevy::{
    anti_alias::fxaa::Fxaa,
    camera::{RenderTarget, Viewport},
    core_pipeline::prepass::{DepthPrepass, NormalPrepass},
    light::{DirectionalLightShadowMap, EnvironmentMapLight, PointLightShadowMap},
    pbr::DistanceFog,
    platform::collections::HashMap,
    prelude::*,
    render::{
        RenderApp,
        occlusion_culling::OcclusionCulling,
        render_resource::{BindGroupId, BufferId, PipelineCache, TextureId, TextureViewId},
        view::{ExtractedView, RetainedViewEntity},
    },
};
use bevy_lean_deferred::{gbuffer::GBufferTextures, lighting::ViewLighting};
use kit::{
    headless::{Headless, target_image},
    lean::{build, set_lean},
    log_watch,
    own_process::in_own_process,
    scenes::{SceneBuilder, build::default_camera_transform},
};

const SIZE: UVec2 = UVec2::new(160, 120);
const FRAMES: usize = 8;

/// Circles through its spawn position.
#[derive(Component, Clone, Copy)]
struct Circling {
    start: Vec3,
    radius: f32,
}

impl Circling {
    /// The component, and a transform at its start.
    fn from(start: Vec3, radius: f32) -> (Self, Transform) {
        (Self { start, radius }, Transform::from_translation(start))
    }
}

fn view(order: isize, x: u32) -> Camera {
    Camera {
        order,
        viewport: Some(Viewport {
            physical_position: UVec2::new(x, 0),
            physical_size: SIZE / UVec2::new(2, 1),
            ..default()
        }),
        ..default()
    }
}

/// Three cameras: two share a target and swap its main textures three times per frame, so that these alternate between frames; one has a
/// target of its own.
fn scene(s: &mut SceneBuilder) {
    s.world()
        .insert_resource(DirectionalLightShadowMap { size: 256 });
    s.world().insert_resource(PointLightShadowMap { size: 128 });
    s.solids();
    s.sun(true);
    s.mesh(
        Sphere::new(0.5),
        StandardMaterial {
            emissive: LinearRgba::rgb(0.3, 0.1, 0.3),
            ..default()
        },
        Transform::from_xyz(0.0, 0.5, 0.0),
    );
    for (x, shadow_maps_enabled) in [(-2.0, true), (2.0, false)] {
        let lamp = PointLight {
            intensity: 400_000.0,
            shadow_maps_enabled,
            ..default()
        };
        s.spawn((lamp, Circling::from(Vec3::new(x, 2.0, 1.0), 0.7)));
    }
    // Visible in some frames only.
    let walker = s.mesh(Cuboid::from_length(0.4), Color::WHITE, Transform::default());
    s.world()
        .entity_mut(walker)
        .insert(Circling::from(Vec3::new(1.0, 0.5, 2.5), 8.0));

    let map = s.cube_map();
    let environment = EnvironmentMapLight {
        diffuse_map: map.clone(),
        specular_map: map,
        intensity: 500.0,
        ..default()
    };
    let other = s.add::<Image>(target_image(UVec2::new(64, 48)));
    let transform = default_camera_transform();
    let circling = Circling {
        start: transform.translation,
        radius: 1.5,
    };
    s.camera(
        transform,
        (view(0, 0), environment, Fxaa::default(), circling),
    );
    s.camera(
        transform,
        (
            view(1, SIZE.x / 2),
            DepthPrepass,
            OcclusionCulling,
            circling,
        ),
    );
    let third = s.camera(transform, (NormalPrepass, DistanceFog::default(), circling));
    s.world()
        .entity_mut(third)
        .insert(RenderTarget::from(other));
}

/// Renders one frame. Moving things are where they are in frame `frame` of a round, or at their start if none.
fn frame(headless: &mut Headless, frame: Option<usize>) {
    let angle = frame.map_or(0.0, |frame| TAU * frame as f32 / FRAMES as f32);
    let world = headless.world();
    let mut circling = world.query::<(&mut Transform, &Circling)>();
    for (mut transform, Circling { start, radius }) in circling.iter_mut(world) {
        let offset = Vec3::new(angle.sin(), 0.0, angle.cos() - 1.0);
        transform.translation = start + radius * offset;
    }
    headless.frames(1);
}

const KINDS: [&str; 4] = ["textures", "texture views", "buffers", "pipelines"];

/// Number of resources of each kind created so far, by any crate.
fn made_so_far(headless: &Headless) -> [u32; 4] {
    let render_world = headless.app.sub_app(RenderApp).world();
    let pipelines = render_world.resource::<PipelineCache>().pipelines();
    let number = NonZero::<u32>::get;
    // Ids count up. Each call takes one id per kind, so two calls differ by one more than the number created between them.
    [
        number(TextureId::new().into()),
        number(TextureViewId::new().into()),
        number(BufferId::new().into()),
        pipelines.count() as u32,
    ]
}

/// Bind groups and texture views of each lean view.
fn held(
    headless: &mut Headless,
) -> HashMap<RetainedViewEntity, (BTreeSet<BindGroupId>, [TextureViewId; 2])> {
    let render_world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = render_world.query::<(&ExtractedView, &ViewLighting, &GBufferTextures)>();
    views
        .iter(render_world)
        .map(|(view, lighting, textures)| {
            let groups = lighting.lasting_bind_groups().map(|group| group.id());
            let textures = [&textures.surface, &textures.normal].map(|t| t.default_view.id());
            (view.retained_view_entity, (groups.collect(), textures))
        })
        .collect()
}

/// Renders a round in which no lean view may replace its resources. Returns the number created in it.
fn round(headless: &mut Headless, moving: bool) -> [u32; 4] {
    let before = made_so_far(headless);
    let held_before = held(headless);
    for i in 0..FRAMES {
        frame(headless, moving.then_some(i));
        assert_eq!(held(headless), held_before, "frame {i}, moving: {moving}");
    }
    let after = made_so_far(headless);
    core::array::from_fn(|kind| after[kind] - before[kind])
}

#[test]
fn nothing_is_made_anew() {
    in_own_process(|| {
        let mut headless = build(SIZE, scene);
        for moving in [false, true] {
            let [forward, lean] = [false, true].map(|lean| {
                set_lean(&mut headless, lean);
                // In the first round, pipelines compile and buffers grow.
                for i in 0..FRAMES {
                    frame(&mut headless, moving.then_some(i));
                }
                headless.settle();
                let groups_per_view: Vec<usize> = held(&mut headless)
                    .into_values()
                    .map(|(groups, _)| groups.len())
                    .collect();
                assert_eq!(groups_per_view, if lean { vec![3; 3] } else { vec![] });
                round(&mut headless, moving)
            });
            println!("moving: {moving}, {KINDS:?}: forward made {forward:?}, lean {lean:?}");
            for (kind, (forward, lean)) in KINDS.iter().zip(forward.into_iter().zip(lean)) {
                assert!(
                    lean <= forward,
                    "{kind}: lean made {lean}, forward {forward}"
                );
            }
        }
        log_watch::assert_validation_layer_silent();
    });
}
