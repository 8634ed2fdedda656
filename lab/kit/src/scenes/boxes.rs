//! The boxes scene of the benches: 1600 meshes on a plane, many point lights, one shadow-casting sun.

use bevy::{ecs::system::RunSystemOnce, light::cluster::GlobalClusterSettings, prelude::*};

/// Size of the scene.
#[derive(Clone, Copy)]
pub struct Boxes {
    /// Meshes per side of the grid.
    pub side: u32,
    /// Subdivisions of the icospheres; 4 makes 5120 triangles.
    pub subdivisions: u32,
    pub point_lights: u32,
    /// Range of each point light, in metres.
    pub range: f32,
}

impl Boxes {
    /// The full scene.
    pub fn full(point_lights: u32) -> Self {
        Self {
            side: 40,
            subdivisions: 4,
            point_lights,
            range: 5.0,
        }
    }

    /// A reduced scene for software renderers.
    pub fn small(point_lights: u32) -> Self {
        Self {
            side: 10,
            subdivisions: 2,
            point_lights,
            range: 5.0,
        }
    }
}

/// Reserves space for hundreds of lights in Bevy's cluster lists.
pub fn reserve_clusters(settings: &mut GlobalClusterSettings) {
    reserve_cluster_lists(settings, 1 << 16, 1 << 20);
}

/// Reserves space in Bevy's cluster lists for so many depth slices and light indices: lists that Bevy grows at run time hold garbage for
/// some frames.
pub fn reserve_cluster_lists(settings: &mut GlobalClusterSettings, slices: usize, indices: usize) {
    if let Some(gpu) = &mut settings.gpu_clustering {
        gpu.initial_z_slice_list_capacity = slices;
        gpu.initial_index_list_capacity = indices;
    }
}

/// Spawns everything but the camera immediately, and reserves the cluster lists.
pub fn spawn_into(world: &mut World, boxes: Boxes) {
    reserve_clusters(&mut world.resource_mut::<GlobalClusterSettings>());
    world
        .run_system_once(
            move |mut commands: Commands,
                  mut meshes: ResMut<Assets<Mesh>>,
                  mut materials: ResMut<Assets<StandardMaterial>>| {
                spawn(&mut commands, &mut meshes, &mut materials, boxes);
            },
        )
        .expect("the boxes need only asset stores");
}

/// Spawns everything but the camera.
pub fn spawn(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    materials: &mut Assets<StandardMaterial>,
    boxes: Boxes,
) {
    let extent = 1.4 * boxes.side as f32;
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(extent + 4.0, extent + 4.0))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.6, 0.6, 0.6),
            perceptual_roughness: 0.6,
            ..default()
        })),
    ));

    let cube = meshes.add(Cuboid::default());
    let ball = meshes.add(
        Sphere::new(0.5)
            .mesh()
            .ico(boxes.subdivisions)
            .expect("few subdivisions"),
    );
    for i in 0..boxes.side {
        for j in 0..boxes.side {
            let material = materials.add(StandardMaterial {
                base_color: Color::hsl((i * 40 + j) as f32 * 0.225 % 360.0, 0.6, 0.5),
                metallic: (i % 5) as f32 / 4.0,
                perceptual_roughness: 0.1 + (j % 9) as f32 / 10.0,
                ..default()
            });
            commands.spawn((
                Mesh3d(if (i + j) % 2 == 0 {
                    cube.clone()
                } else {
                    ball.clone()
                }),
                MeshMaterial3d(material),
                Transform::from_xyz(
                    (i as f32 + 0.5) * 1.4 - extent / 2.0,
                    0.5,
                    (j as f32 + 0.5) * 1.4 - extent / 2.0,
                ),
            ));
        }
    }

    spawn_point_lights(commands, boxes);
    commands.spawn((
        DirectionalLight {
            illuminance: 8_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(3.0, 8.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// Spawns the point lights, without shadows.
pub fn spawn_point_lights(commands: &mut Commands, boxes: Boxes) {
    LightField {
        count: boxes.point_lights,
        spread: Vec2::splat(boxes.side as f32),
        range: boxes.range,
        ..default()
    }
    .spawn(commands);
}

/// Point lights without shadows over a rectangle of ground, 0.5 to 3.5 m above it.
#[derive(Clone, Copy)]
pub struct LightField {
    pub count: u32,
    /// X and Z of the rectangle's middle, in metres.
    pub center: Vec2,
    /// Its sides along X and Z, in metres.
    pub spread: Vec2,
    /// Range of each light, in metres.
    pub range: f32,
    /// Power of each light, in lumens.
    pub intensity: f32,
}

impl Default for LightField {
    fn default() -> Self {
        Self {
            count: 0,
            center: Vec2::ZERO,
            spread: Vec2::ZERO,
            range: 5.0,
            intensity: 20_000.0,
        }
    }
}

impl LightField {
    pub fn spawn(self, commands: &mut Commands) {
        // A low-discrepancy sequence (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences").
        for n in 0..self.count {
            let r = |a: f32| (0.5 + a * n as f32).fract();
            let (u, v, w) = (r(0.819_172_5), r(0.671_043_6), r(0.549_700_5));
            let ground = self.center + self.spread * (Vec2::new(u, v) - 0.5);
            commands.spawn((
                PointLight {
                    color: Color::hsl(360.0 * w, 0.7, 0.7),
                    intensity: self.intensity,
                    range: self.range,
                    ..default()
                },
                Transform::from_xyz(ground.x, 0.5 + 3.0 * w, ground.y),
            ));
        }
    }
}

/// The camera of the benches: 22 m from the middle of the full scene.
pub fn camera_transform(boxes: Boxes) -> Transform {
    let scale = boxes.side as f32 / 40.0;
    Transform::from_xyz(0.0, 6.0 * scale, 22.0 * scale)
        .looking_at(Vec3::new(0.0, 1.0, 0.0), Vec3::Y)
}
