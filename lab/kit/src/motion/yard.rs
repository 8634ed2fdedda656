//! A yard under an even sky: glowing pillars, a lamp, a car, a walker, and a door to a bright room.

use bevy::{anti_alias::taa::TemporalAntiAliasing, prelude::*, render::camera::TemporalJitter};
use bevy_lean_deferred::prelude::*;

use super::paths::Pose;
use crate::{
    analytic_light::{camera, seen, surface},
    analytic_mirrors::metal,
    hdr::{Light, keep_colors, light_target_app, target_light},
    headless::Headless,
    scenes::SceneBuilder,
};

/// The effects that the floor of a yard shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The floor is a metal of roughness 0.05 on the left, 0.3 on the right.
    Reflections,
    /// The floor is diffuse.
    DiffuseLight,
}

impl Subject {
    pub const ALL: [Self; 2] = [Self::Reflections, Self::DiffuseLight];

    pub fn name(self) -> &'static str {
        match self {
            Self::Reflections => "reflections",
            Self::DiffuseLight => "diffuse light",
        }
    }
}

const SKY: f32 = 0.3;
const LAMP: Vec3 = Vec3::new(0.5, 0.6, -0.9);
const LAMP_RADIUS: f32 = 0.15;

/// An app of the yard.
pub struct Yard {
    headless: Headless,
    camera: Entity,
    weapon: Entity,
    car: Entity,
    walker: Entity,
    door: Entity,
    lamp: Handle<StandardMaterial>,
}

impl Yard {
    /// A yard of which a camera, after `dress`, shows `subject`.
    pub fn new(size: UVec2, subject: Subject, dress: impl FnOnce(&mut EntityWorldMut)) -> Self {
        let mut headless = light_target_app(size);
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        let [left, right] = match subject {
            Subject::Reflections => [metal(0.05), metal(0.3)],
            Subject::DiffuseLight => [surface(0.6, 0.0), surface(0.6, 0.0)],
        };
        let half = Plane3d::default().mesh().size(8.0, 16.0);
        s.mesh(half, left, Transform::from_xyz(-4.0, 0.0, 0.0));
        s.mesh(half, right.clone(), Transform::from_xyz(4.0, 0.0, 0.0));
        spawn_walls(&mut s);
        spawn_pillars(&mut s);
        let lamp = spawn_lamp(&mut s);
        let car = Cuboid::new(1.6, 0.6, 0.8);
        let car = s.mesh(car, glowing(0.7, 0.1, 0.1), Transform::default());
        let walker = Capsule3d::new(0.18, 1.1);
        let walker = s.mesh(walker, glowing(0.1, 0.3, 0.2), Transform::default());
        let door = Cuboid::new(1.0, 2.0, 0.06);
        let door = s.mesh(door, surface(0.4, 0.0), Transform::default());
        let weapon = Cuboid::new(0.08, 0.08, 0.5);
        let weapon = s.mesh(weapon, right, Transform::from_xyz(0.15, -0.12, -0.5));
        let shown = Camera {
            clear_color: ClearColorConfig::Custom(Color::linear_rgb(SKY, SKY, SKY)),
            ..default()
        };
        let camera = camera(&mut s, Pose::default().camera, SKY, shown);
        s.world().entity_mut(weapon).insert(ChildOf(camera));
        let mut entity = s.world().entity_mut(camera);
        keep_colors(&mut entity);
        dress(&mut entity);
        let mut yard = Self {
            headless,
            camera,
            weapon,
            car,
            walker,
            door,
            lamp,
        };
        yard.pose(&Pose {
            is_armed: true,
            ..default()
        });
        yard.headless.settle();
        yard
    }

    pub fn headless(&self) -> &Headless {
        &self.headless
    }

    /// Moves everything to where it is in the next frame.
    pub fn pose(&mut self, pose: &Pose) {
        // About its hinge, towards the camera.
        let turned = Quat::from_rotation_y(-pose.door);
        let door = Transform::from_translation(HINGE + turned * Vec3::new(0.5, 1.0, 0.0))
            .with_rotation(turned);
        let places = [
            (self.camera, pose.camera),
            (self.car, Transform::from_xyz(pose.car, 0.3, 0.1)),
            (self.walker, Transform::from_xyz(pose.walker, 0.73, 0.9)),
            (self.door, door),
        ];
        let world = self.headless.world();
        for (entity, place) in places {
            if let Some(mut own) = world.get_mut::<Transform>(entity) {
                own.set_if_neq(place);
            }
        }
        if let Some(mut own) = world.get_mut::<Visibility>(self.weapon) {
            own.set_if_neq(if pose.is_armed {
                Visibility::Inherited
            } else {
                Visibility::Hidden
            });
        }
        let emission = LinearRgba::rgb(pose.lamp, pose.lamp, pose.lamp);
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let mut lamp = materials
            .get_mut(&self.lamp)
            .expect("the yard has its handle");
        if lamp.emissive != emission {
            lamp.emissive = emission;
        }
    }

    /// Light of the next frame.
    pub fn frame(&mut self) -> Light {
        self.headless.frame();
        target_light(&self.headless)
    }

    /// Rests at `pose` for `count` frames after a cut. Returns the light of the last two.
    pub fn rest(&mut self, pose: &Pose, count: usize) -> [Light; 2] {
        self.cut_to(pose);
        self.headless.frames(count.saturating_sub(2));
        [self.frame(), self.frame()]
    }

    /// Rests at `pose` for `count` frames after a cut. Returns the mean light of the second half, in all of which the patterns of effects
    /// differ.
    pub fn converged(&mut self, pose: &Pose, count: usize) -> Light {
        self.cut_to(pose);
        let size = self.headless.size;
        let kept = (count / 2).max(1);
        let mut sum = vec![Vec4::ZERO; size.element_product() as usize];
        for frame in 0..count {
            self.turn_patterns(frame);
            let light = self.frame();
            if frame + kept >= count {
                for (sum, texel) in sum.iter_mut().zip(&light.texels) {
                    *sum += Vec4::from_array(*texel) / kept as f32;
                }
            }
        }
        Light {
            size,
            texels: sum.iter().map(Vec4::to_array).collect(),
        }
    }

    /// True for the pixels of the lamp and of its outline, in the last frame.
    pub fn lamp_pixels(&mut self) -> Vec<bool> {
        let light = target_light(&self.headless);
        let seen = seen(&mut self.headless, light);
        let is_lamp = |ray: &Ray3d| {
            let off = (LAMP - ray.origin).reject_from_normalized(*ray.direction);
            off.length() < 1.3 * LAMP_RADIUS
        };
        seen.rays().iter().map(is_lamp).collect()
    }

    fn cut_to(&mut self, pose: &Pose) {
        self.pose(pose);
        let mut camera = self.headless.world().entity_mut(self.camera);
        camera.insert(CameraCut);
        if let Some(mut taa) = camera.get_mut::<TemporalAntiAliasing>() {
            taa.reset = true;
        }
    }

    /// Effects turn their patterns from frame to frame while the projection's jitter changes. TAA changes it by itself; elsewhere a
    /// jitter that moves nothing visibly does.
    fn turn_patterns(&mut self, frame: usize) {
        let mut camera = self.headless.world().entity_mut(self.camera);
        if !camera.contains::<TemporalAntiAliasing>() {
            let side = if frame.is_multiple_of(2) { 1e-4 } else { -1e-4 };
            camera.insert(TemporalJitter {
                offset: Vec2::splat(side),
            });
        }
    }
}

const WALL_Z: f32 = -3.0;
const HINGE: Vec3 = Vec3::new(-0.5, 0.0, WALL_Z);

/// A wall with a doorway, and a bright room behind it.
fn spawn_walls(s: &mut SceneBuilder) {
    let parts = [
        (Vec3::new(4.5, 2.4, 0.1), Vec3::new(-2.75, 1.2, WALL_Z)),
        (Vec3::new(4.5, 2.4, 0.1), Vec3::new(2.75, 1.2, WALL_Z)),
        (Vec3::new(1.0, 0.4, 0.1), Vec3::new(0.0, 2.2, WALL_Z)),
    ];
    for (size, place) in parts {
        let place = Transform::from_translation(place);
        s.mesh(Cuboid::from_size(size), surface(0.5, 0.0), place);
    }
    let room = Transform::from_xyz(0.0, 1.2, WALL_Z - 1.0);
    s.mesh(Rectangle::new(3.0, 2.4), glowing(3.0, 2.5, 2.0), room);
}

fn spawn_pillars(s: &mut SceneBuilder) {
    let pillars = [
        (-2.4, -1.6, [0.2, 0.4, 1.0]),
        (-1.1, -0.9, [1.0, 0.3, 0.2]),
        (1.3, -1.3, [0.3, 1.0, 0.4]),
        (2.6, -0.7, [1.0, 0.8, 0.2]),
    ];
    for (x, z, [red, green, blue]) in pillars {
        let place = Transform::from_xyz(x, 0.7, z);
        let pillar = Cuboid::new(0.2, 1.4, 0.2);
        s.mesh(pillar, glowing(red, green, blue), place);
    }
}

fn spawn_lamp(s: &mut SceneBuilder) -> Handle<StandardMaterial> {
    let ball = Sphere::new(LAMP_RADIUS).mesh().ico(5);
    let ball = s.add::<Mesh>(ball.expect("few subdivisions"));
    let material = s.add::<StandardMaterial>(surface(0.0, 1.0));
    s.spawn((
        Mesh3d(ball),
        MeshMaterial3d(material.clone()),
        Transform::from_translation(LAMP),
    ));
    material
}

/// A surface of albedo 0.4 that glows.
fn glowing(red: f32, green: f32, blue: f32) -> StandardMaterial {
    StandardMaterial {
        emissive: LinearRgba::rgb(red, green, blue),
        ..surface(0.4, 0.0)
    }
}
