//! Live GPU resources once nothing is shown.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use kit::gpu_usage::GpuUsage;

use crate::stage::{SIZES, Stage};

/// Panics if the last epoch left more than the first half of them, in which Bevy's buffers reach their sizes. The allowances are for what
/// Bevy alone sometimes keeps: views of a shadow map whose light was removed in an unlucky frame (four of them with one texture, in the
/// seven epochs of seeds 31 and 32); buffers of views that are gone (seed 1 has 83 after 256 frames and 249 after 384); and memory (8 MiB
/// from one half of seed 3's frames 640 to 768 to the other). Bevy does not release bind groups, which [`left_by`] compares, and it keeps
/// each pipeline that it made.
pub fn assert_it_does_not_climb(held: &[GpuUsage]) {
    let (first_half, rest) = held.split_at(held.len().div_ceil(2));
    let Some(last) = rest.last() else {
        return;
    };
    let climbs = |count: fn(&GpuUsage) -> usize, allowed: usize| {
        count(last) > first_half.iter().map(count).max().unwrap_or(0) + allowed
    };
    let climbs = climbs(|held| held.textures, 3)
        || climbs(|held| held.texture_views, 20)
        || climbs(|held| held.buffers, 200)
        || climbs(|held| held.bytes, 16 << 20);
    assert!(!climbs, "{held:?}");
}

/// Things that are added and removed again and again.
#[derive(Clone, Copy, Debug)]
pub enum Coming {
    Camera,
    Light,
    Material,
    Size,
    Component,
}

fn come_and_go(stage: &mut Stage, what: Coming, turn: usize) {
    match what {
        Coming::Camera => {
            stage.add_camera(1);
            let camera = stage.cameras.pop().expect("it came");
            give_all(stage, camera);
            stage.headless.frames(3);
            stage.world().despawn(camera);
        }
        Coming::Light => {
            let light = PointLight {
                shadow_maps_enabled: true,
                ..default()
            };
            let place = Transform::from_xyz(0.0, 2.0, 0.0);
            let light = stage.builder().spawn((light, place));
            stage.headless.frames(3);
            stage.world().despawn(light);
        }
        Coming::Material => {
            let color = Color::linear_rgb(turn as f32 / 32.0, 0.0, 0.0);
            let material = stage.builder().add::<StandardMaterial>(color);
            let mesh = stage.meshes[0];
            stage.entity(mesh).insert(MeshMaterial3d(material));
        }
        Coming::Size => stage.resize(0, SIZES[turn % 2]),
        Coming::Component => {
            let camera = stage.cameras[0];
            if stage.is_lean {
                stage.entity(camera).remove::<LeanDeferred>();
                stage.headless.frames(3);
                give_all(stage, camera);
            }
        }
    }
    stage.headless.frames(3);
}

/// Gives a camera all of this crate's components, except occlusion, which is a part of diffuse GI and leaves no trace.
fn give_all(stage: &mut Stage, camera: Entity) {
    if stage.is_lean {
        stage.entity(camera).insert((
            LeanDeferred::default(),
            LeanAutoExposure::default(),
            LeanScreenSpaceGi::default(),
            LeanScreenSpaceReflections::default(),
            LeanSubsurfaceScattering::default(),
        ));
    }
}

/// Growth of the live resources over twelve further turns.
pub fn left_by(what: Coming, is_lean: bool) -> GpuUsage {
    let mut stage = Stage::new(is_lean, true);
    let camera = stage.cameras[0];
    give_all(&mut stage, camera);
    let [before, after] = [0, 1].map(|part| {
        for turn in 0..12 {
            come_and_go(&mut stage, what, part * 12 + turn);
        }
        GpuUsage::once_settled(&mut stage.headless)
    });
    after.more_than(&before)
}
