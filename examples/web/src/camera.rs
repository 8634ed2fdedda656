//! The camera: at a place of the street, swaying a little.

use core::sync::atomic::{AtomicUsize, Ordering};

use bevy::{
    anti_alias::smaa::Smaa, camera::Hdr, post_process::bloom::Bloom, prelude::*,
    render::renderer::RenderDevice,
};
use street::{Viewpoint, sky};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::motion::Motion;

/// Marks the page's camera.
#[derive(Component)]
pub struct View;

/// Viewpoints of the street, and their names on the page.
const PLACES: [(&str, Viewpoint); 4] = [
    ("street", Viewpoint::STREET),
    ("stall", Viewpoint::STALL),
    ("puddle", Viewpoint::PUDDLE),
    ("cats", Viewpoint::CATS),
];

/// Index in [`PLACES`]. The page writes it between frames.
static PLACE: AtomicUsize = AtomicUsize::new(0);

/// Amplitude of the sway, as a share of the distance to the target, and its rate in radians per second.
const SWAY: f32 = 0.04;
const RATE: f32 = 0.4;

/// Storage textures per stage that Bevy needs to make an environment map of the sky.
const STORAGE_TEXTURES: u32 = 6;

/// Moves the camera to a place. Returns false if nothing has that name.
#[wasm_bindgen]
pub fn set_place(name: &str) -> bool {
    let index = PLACES.iter().position(|(other, _)| *other == name);
    if let Some(index) = index {
        PLACE.store(index, Ordering::Relaxed);
    }
    index.is_some()
}

/// Spawns the camera without MSAA and with HDR, as lean rendering needs, so that switching changes the renderer and
/// nothing else.
pub fn spawn(mut commands: Commands, mut images: ResMut<Assets<Image>>, device: Res<RenderDevice>) {
    let mut camera = commands.spawn((
        View,
        Camera3d::default(),
        Hdr,
        Msaa::Off,
        Smaa::default(),
        Bloom::NATURAL,
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
    let (_, place) = PLACES[PLACE.load(Ordering::Relaxed)];
    let side = if motion.0 {
        (time.elapsed_secs() * RATE).sin() * SWAY * place.eye.distance(place.target)
    } else {
        0.0
    };
    let mut moved = place.transform();
    moved.translation += moved.right() * side;
    camera.set_if_neq(moved.looking_at(place.target, Vec3::Y));
}
