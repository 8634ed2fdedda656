//! Cubes all around a camera that sees half of them, and an emissive one.

use core::f32::consts::PI;

use bevy::{
    camera::{Hdr, visibility::RenderLayers},
    core_pipeline::prepass::MotionVectorPrepass,
    light::NotShadowReceiver,
    prelude::*,
};

use kit::headless::Headless;

/// Share of the meshes that move.
#[derive(Resource, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    Nothing,
    Tenth,
    All,
}

impl Motion {
    pub const ALL: [Self; 3] = [Self::Nothing, Self::Tenth, Self::All];

    /// One mesh in this many moves.
    fn every(self) -> Option<usize> {
        match self {
            Self::Nothing => None,
            Self::Tenth => Some(10),
            Self::All => Some(1),
        }
    }
}

/// Index of a mesh.
#[derive(Component)]
pub struct Numbered(usize);

/// The only mesh that needs an optional target. Hidden at first.
#[derive(Resource)]
pub struct Lamp(pub Entity);

#[derive(Resource)]
pub struct Eye(pub Entity);

const KINDS: usize = 16;

/// Spawns the scene. `extra` is added to the camera.
pub fn spawn(headless: &mut Headless, meshes: usize, extra: impl Bundle) {
    let target = headless.render_target();
    let world = headless.world();
    let add_mesh = |world: &mut World, mesh: Mesh| world.resource_mut::<Assets<Mesh>>().add(mesh);
    let forms: Vec<_> = (0..KINDS)
        .map(|kind| {
            let side = 0.6 + 0.4 * kind as f32 / KINDS as f32;
            add_mesh(world, Cuboid::new(side, 1.0, side).into())
        })
        .collect();
    let materials: Vec<_> = (0..KINDS)
        .map(|kind| {
            let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
            materials.add(StandardMaterial {
                base_color: Color::hsl(360.0 * kind as f32 / KINDS as f32, 0.6, 0.5),
                perceptual_roughness: 0.2 + 0.05 * kind as f32,
                ..default()
            })
        })
        .collect();
    // Evenly over a sphere (González 2010, "Measurement of Areas on a Sphere Using Fibonacci and Latitude–Longitude
    // Lattices"), as near as there is room.
    let radius = 12.0 + 0.6 * (meshes as f32).sqrt();
    let golden = PI * (3.0 - 5f32.sqrt());
    let cubes: Vec<_> = (0..meshes)
        .map(|number| {
            let height = 1.0 - 2.0 * (number as f32 + 0.5) / meshes as f32;
            let around = golden * number as f32;
            let flat = (1.0 - height * height).sqrt();
            let place = radius * Vec3::new(flat * around.cos(), height, flat * around.sin());
            (
                Mesh3d(forms[number % KINDS].clone()),
                MeshMaterial3d(materials[number / KINDS % KINDS].clone()),
                Transform::from_translation(place),
                Numbered(number),
            )
        })
        .collect();
    world.spawn_batch(cubes);
    world.spawn((
        DirectionalLight {
            illuminance: 8_000.0,
            ..default()
        },
        Transform::from_xyz(3.0, 8.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));

    let ball = add_mesh(world, Sphere::new(0.5).into());
    let glow = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            emissive: LinearRgba::rgb(200.0, 60.0, 20.0),
            ..default()
        });
    // In front of the camera until its first turn; the events of the lamp come before it.
    let lamp = world
        .spawn((
            Mesh3d(ball),
            MeshMaterial3d(glow),
            Transform::from_xyz(0.0, 0.0, -5.0),
            Visibility::Hidden,
        ))
        .id();
    world.insert_resource(Lamp(lamp));
    let eye = world
        .spawn((
            Camera3d::default(),
            Hdr,
            Msaa::Off,
            target,
            // Sees half of the sphere.
            Projection::from(PerspectiveProjection {
                fov: 1.9,
                far: 4000.0,
                ..default()
            }),
            Transform::default(),
            extra,
        ))
        .id();
    world.insert_resource(Eye(eye));
    world.insert_resource(Motion::Nothing);
}

/// Adds components that extraction follows, to all meshes and to the camera.
pub fn add_followed_components(world: &mut World) {
    let mut numbered = world.query_filtered::<Entity, With<Numbered>>();
    let meshes: Vec<Entity> = numbered.iter(world).collect();
    let components = (RenderLayers::layer(0), NotShadowReceiver);
    world.insert_batch(meshes.into_iter().map(|mesh| (mesh, components.clone())));
    let eye = world.resource::<Eye>().0;
    world.entity_mut(eye).insert(MotionVectorPrepass);
}

/// Moves each of the moving meshes up and down a little.
pub fn move_meshes(
    motion: Res<Motion>,
    time: Res<Time>,
    mut meshes: Query<(&mut Transform, &Numbered)>,
) {
    let Some(every) = motion.every() else {
        return;
    };
    let step = 0.02 * (4.0 * time.elapsed_secs()).cos();
    for (mut transform, Numbered(number)) in &mut meshes {
        if number % every == 0 {
            transform.translation.y += step;
        }
    }
}

/// Shows or hides the emissive mesh.
pub fn show_lamp(world: &mut World, shown: bool) {
    let lamp = world.resource::<Lamp>().0;
    *world
        .get_mut::<Visibility>(lamp)
        .expect("the lamp has a visibility") = if shown {
        Visibility::Visible
    } else {
        Visibility::Hidden
    };
}

/// Turns the camera around: all meshes leave its view, and as many enter.
pub fn turn_around(world: &mut World) {
    let eye = world.resource::<Eye>().0;
    world
        .get_mut::<Transform>(eye)
        .expect("the camera has a place")
        .rotate_y(PI);
}
