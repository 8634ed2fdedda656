//! A lean camera in BSN, Bevy's notation of scenes. Fields that are not named have their defaults.
//!
//! `cargo run --example bsn`

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, LeanDeferredPlugins))
        .add_systems(Startup, scene.spawn())
        .run();
}

fn camera() -> impl Scene {
    bsn! {
        Camera3d
        LeanDeferred
        LeanScreenSpaceGi { radius: 6.0, quality: LeanQuality::High }
        LeanScreenSpaceReflections { resolution: LeanResolution::Full }
        template_value(Transform::from_xyz(-2.5, 4.5, 9.0).looking_at(Vec3::ZERO, Vec3::Y))
    }
}

fn scene() -> impl SceneList {
    bsn_list! [
        camera(),
        (
            DirectionalLight { shadow_maps_enabled: true }
            template_value(Transform::from_xyz(3.0, 8.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y))
        ),
        (
            #Floor
            Mesh3d(asset_value(Circle::new(4.0)))
            MeshMaterial3d::<StandardMaterial>(asset_value(Color::WHITE))
            Transform::from_rotation(Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2))
        ),
        (
            #Cube
            Mesh3d(asset_value(Cuboid::new(1.0, 1.0, 1.0)))
            MeshMaterial3d::<StandardMaterial>(asset_value(Color::srgb_u8(124, 144, 255)))
            Transform::from_xyz(0.0, 0.5, 0.0)
        ),
    ]
}
