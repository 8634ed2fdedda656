//! The boxes under any number of lights.

use bevy::{
    camera::Hdr,
    light::cluster::{ClusterConfig, GlobalClusterSettings},
    prelude::*,
};
use kit::{
    headless::Headless,
    scenes::boxes::{self, Boxes, LightField},
};

use crate::{contender::Contender, plan::Plan};

/// Placement of the lights.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub enum Arrangement {
    /// Over the whole field.
    Spread,
    /// On 8 × 8 m.
    Heaped,
}

impl Arrangement {
    pub const ALL: [Self; 2] = [Self::Spread, Self::Heaped];

    pub fn name(self) -> &'static str {
        match self {
            Self::Spread => "spread",
            Self::Heaped => "heaped",
        }
    }

    /// Centre and side lengths of the lit ground, in the whole scene.
    fn ground(self) -> (Vec2, Vec2) {
        match self {
            Self::Spread => (Vec2::ZERO, Vec2::splat(SIDE)),
            // The camera is at z = 22 and looks along −z. With the lights' range of 5 m, this is the lower left quarter
            // of the picture, and the view frustum intersects the sphere of each light: the CPU culls none.
            Self::Heaped => (Vec2::new(-9.0, 8.0), Vec2::splat(8.0)),
        }
    }
}

/// Up to this many lights have 20,000 lm each. More of them share this total: otherwise the picture would be white, and
/// all renderers would agree.
const BRIGHT_LIGHTS: u32 = 64;

/// Side of the whole scene's field of lights, in metres.
const SIDE: f32 = 40.0;

fn boxes_of(plan: &Plan) -> Boxes {
    if plan.small {
        Boxes::small(0)
    } else {
        Boxes::full(0)
    }
}

/// Replaces the lights of the last point.
pub fn replace_lights(world: &mut World, arrangement: Arrangement, count: u32, plan: &Plan) {
    let mut lights = world.query_filtered::<Entity, With<PointLight>>();
    let old: Vec<Entity> = lights.iter(world).collect();
    for light in old {
        world.despawn(light);
    }
    let (center, spread) = arrangement.ground();
    let scale = boxes_of(plan).side as f32 / SIDE;
    let field = LightField::default();
    LightField {
        count,
        center: center * scale,
        spread: spread * scale,
        intensity: field.intensity * (BRIGHT_LIGHTS as f32 / count as f32).min(1.0),
        ..field
    }
    .spawn(&mut world.commands());
    world.flush();
}

/// Spawns everything but the point lights; returns the camera.
pub fn spawn(headless: &mut Headless, contender: Contender, plan: &Plan) -> Entity {
    let boxes = boxes_of(plan);
    let target = headless.render_target();
    let world = headless.world();
    // 16,384 heaped lights need 195,256 depth slices and 643,811 indices; 5.5 million indices in a grid of fixed size.
    // Between two points the grid is still that of the fewer lights, and lists are longer for a frame. Bevy uploads the
    // indices in every frame, before its first pass.
    let indices = if plan.fixed_grid { 1 << 23 } else { 1 << 22 };
    boxes::spawn_into(world, boxes);
    let mut settings = world.resource_mut::<GlobalClusterSettings>();
    boxes::reserve_cluster_lists(&mut settings, 1 << 18, indices);
    let transform = boxes::camera_transform(boxes);
    let mut camera = world.spawn((Camera3d::default(), Hdr, Msaa::Off, target, transform));
    if plan.fixed_grid {
        let mut grid = ClusterConfig::default();
        if let ClusterConfig::FixedZ {
            dynamic_resizing, ..
        } = &mut grid
        {
            *dynamic_resizing = false;
        }
        camera.insert(grid);
    }
    contender.prepare_camera(&mut camera);
    camera.id()
}
