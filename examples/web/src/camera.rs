//! The camera: in the street, swaying a little.

use bevy::{camera::Hdr, prelude::*, render::renderer::RenderDevice};
use street::{Viewpoint, sky};

use crate::motion::Motion;

/// Marks the page's camera.
#[derive(Component)]
pub struct View;

const VIEWPOINT: Viewpoint = Viewpoint::STREET;

/// Amplitude of the sway in metres, and its rate in radians per second.
const SWAY: f32 = 0.6;
const RATE: f32 = 0.4;

/// Storage textures per stage that Bevy needs to make an environment map of the sky.
const STORAGE_TEXTURES: u32 = 6;

/// Spawns the camera without MSAA and with HDR, as lean rendering needs, so that switching changes the renderer and
/// nothing else.
pub fn spawn(mut commands: Commands, mut images: ResMut<Assets<Image>>, device: Res<RenderDevice>) {
    let mut camera = commands.spawn((
        View,
        Camera3d::default(),
        Hdr,
        Msaa::Off,
        VIEWPOINT.transform(),
        sky::air(),
    ));
    if device.limits().max_storage_textures_per_shader_stage >= STORAGE_TEXTURES {
        camera.insert(sky::light(&mut images));
    } else {
        // As bright as the mean of that sky.
        camera.insert(AmbientLight {
            color: Color::linear_rgb(1.0, 0.75, 0.6),
            brightness: 0.3,
            ..default()
        });
    }
}

pub fn sway(motion: Res<Motion>, time: Res<Time>, mut camera: Single<&mut Transform, With<View>>) {
    let side = if motion.0 {
        (time.elapsed_secs() * RATE).sin() * SWAY
    } else {
        0.0
    };
    let mut moved = VIEWPOINT.transform();
    moved.translation += moved.right() * side;
    camera.set_if_neq(moved.looking_at(VIEWPOINT.target, Vec3::Y));
}
