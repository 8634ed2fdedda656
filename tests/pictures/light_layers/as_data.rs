//! Layers of meshes are data of their draws: meshes share pipelines, and each is drawn with its own layers.

use bevy::{
    camera::visibility::RenderLayers,
    prelude::*,
    render::{
        RenderApp,
        batching::NoAutomaticBatching,
        render_resource::{PipelineCache, PipelineDescriptor},
        view::NoIndirectDrawing,
    },
};
use bevy_lean_deferred::prelude::*;

use kit::{
    headless::{Headless, Picture},
    lean::change_cameras,
    own_process::in_own_process,
    scenes::{SceneBuilder, build::material},
};

const SIZE: UVec2 = UVec2::new(320, 80);
/// Number of balls, side by side.
const BALLS: usize = 8;

/// Ways of drawing the balls.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Drawing {
    Usual,
    Unbatched,
    AlphaMasked,
    Direct,
}

/// Balls on `sets` alternating layers.
fn scene(s: &mut SceneBuilder, sets: usize, drawing: Drawing) {
    let mesh = s.add::<Mesh>(Sphere::new(0.45).mesh().uv(16, 8));
    let mut clay = material((0.8, 0.6, 0.4), 0.2, 0.4);
    if drawing == Drawing::AlphaMasked {
        clay.alpha_mode = AlphaMode::Mask(0.5);
    }
    let clay = s.add::<StandardMaterial>(clay);
    for ball in 0..BALLS {
        let layers = RenderLayers::layer(1 + ball % sets);
        let ball = s.spawn((
            Mesh3d(mesh.clone()),
            MeshMaterial3d(clay.clone()),
            Transform::from_xyz(ball as f32 - 3.5, 0.0, 0.0),
            layers,
        ));
        if drawing == Drawing::Unbatched {
            s.world().entity_mut(ball).insert(NoAutomaticBatching);
        }
    }
    s.spawn((
        PointLight::default(),
        Transform::from_xyz(0.0, 1.0, 2.0),
        RenderLayers::layer(1),
    ));
    let all: Vec<usize> = (0..=BALLS).collect();
    let camera = s.camera(
        Transform::from_xyz(0.0, 0.0, 6.0),
        (
            Projection::Orthographic(OrthographicProjection {
                scaling_mode: bevy::camera::ScalingMode::FixedHorizontal {
                    viewport_width: BALLS as f32,
                },
                ..OrthographicProjection::default_3d()
            }),
            RenderLayers::from_layers(&all),
        ),
    );
    if drawing == Drawing::Direct {
        s.world().entity_mut(camera).insert(NoIndirectDrawing);
    }
}

fn show(sets: usize, drawing: Drawing) -> Headless {
    let mut headless = Headless::new(SIZE);
    show_in(&mut headless, sets, drawing);
    headless
}

fn show_in(headless: &mut Headless, sets: usize, drawing: Drawing) {
    kit::lean::show(headless, |s| scene(s, sets, drawing));
    change_cameras(headless, |camera| {
        camera.insert((
            LeanDeferred::default(),
            LeanDebugView::from(DebugView::VisibilityMask),
        ));
    });
    headless.settle();
    headless.frames(3);
}

fn gbuffer_pipelines(headless: &Headless) -> usize {
    let world = headless.app.sub_app(RenderApp).world();
    let is_of_gbuffer = |descriptor: &PipelineDescriptor| match descriptor {
        PipelineDescriptor::RenderPipelineDescriptor(descriptor) => {
            descriptor.label.as_deref() == Some("lean_deferred/gbuffer")
        }
        PipelineDescriptor::ComputePipelineDescriptor(_) => false,
    };
    (world.resource::<PipelineCache>().pipelines())
        .filter(|pipeline| is_of_gbuffer(&pipeline.descriptor))
        .count()
}

/// Colours at the centres of all balls.
fn colors(picture: &Picture) -> Vec<[u8; 3]> {
    let ball = picture.size.x / BALLS as u32;
    (0..BALLS as u32)
        .map(|index| {
            let middle = UVec2::new(index * ball + ball / 2, picture.size.y / 2);
            let rgba = picture.crop(URect::from_corners(middle, middle + 1)).rgba;
            [rgba[0], rgba[1], rgba[2]]
        })
        .collect()
}

#[test]
fn sets_of_layers_share_pipelines() {
    in_own_process(|| {
        let [one, all] = [1, BALLS].map(|sets| gbuffer_pipelines(&show(sets, Drawing::Usual)));
        assert!(one > 0);
        assert_eq!(one, all);
    });
}

#[test]
fn each_mesh_is_drawn_with_its_own_layers() {
    in_own_process(|| {
        let mut headless = show(BALLS, Drawing::Usual);
        let expected = colors(&headless.capture());
        for (index, color) in expected.iter().enumerate() {
            assert!(!expected[..index].contains(color), "{expected:?}");
        }
        for drawing in [Drawing::Unbatched, Drawing::AlphaMasked, Drawing::Direct] {
            show_in(&mut headless, BALLS, drawing);
            let shown = colors(&headless.capture());
            assert_eq!(shown, expected, "{drawing:?}");
        }
    });
}

/// Changing layers do not fill memory: sets of layers without a mesh are dropped.
#[test]
fn layers_may_change_in_each_frame() {
    in_own_process(|| {
        let mut headless = show(BALLS, Drawing::Usual);
        let expected = colors(&headless.capture());
        for frame in 0..64usize {
            let world = headless.world();
            let mut meshes = world.query_filtered::<&mut RenderLayers, With<Mesh3d>>();
            for (index, mut layers) in meshes.iter_mut(world).enumerate() {
                let bits = (frame * BALLS + index).to_le_bytes()[..2].to_vec();
                let set = (0..16).filter(|bit| bits[bit / 8] & (1 << (bit % 8)) != 0);
                *layers = RenderLayers::from_layers(&set.map(|bit| bit + 9).collect::<Vec<_>>())
                    .with(1 + index);
            }
            headless.frames(1);
        }
        let world = headless.world();
        let mut meshes = world.query_filtered::<&mut RenderLayers, With<Mesh3d>>();
        for (index, mut layers) in meshes.iter_mut(world).enumerate() {
            *layers = RenderLayers::layer(1 + index);
        }
        headless.settle();
        assert_eq!(colors(&headless.capture()), expected);
    });
}
