//! Changes to cameras and their render targets.

use bevy::{
    anti_alias::{fxaa::Fxaa, taa::TemporalAntiAliasing},
    camera::{ScalingMode, SubCameraView, Viewport, visibility::RenderLayers},
    core_pipeline::{
        Skybox,
        oit::OrderIndependentTransparencySettings,
        prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    },
    light::VolumetricFog,
    pbr::{DistanceFog, FogFalloff, ScreenSpaceAmbientOcclusion, ScreenSpaceReflections},
    post_process::{bloom::Bloom, dof::DepthOfField},
    prelude::*,
    render::occlusion_culling::OcclusionCulling,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    random::Random,
    random_values::{Values, toggle, toggle_between},
};

use crate::stage::{SIZES, STEADY, Stage};

const MOST_CAMERAS: usize = 3;

/// Makes one change and returns its description.
pub fn change(stage: &mut Stage, random: &mut Random) -> String {
    if stage.cameras.is_empty() {
        return add_camera(stage, random);
    }
    let camera = stage.cameras[random.below(stage.cameras.len())];
    match random.below(24) {
        0 => {
            if stage.cameras.len() < MOST_CAMERAS {
                return add_camera(stage, random);
            }
            "no camera more".into()
        }
        1 => {
            stage.cameras.retain(|other| *other != camera);
            stage.world().despawn(camera);
            "a camera goes".into()
        }
        2 => {
            let target = random.below(STEADY);
            let size = SIZES[random.below(SIZES.len())];
            stage.resize(target, size);
            format!("target {target} has {size}")
        }
        3..6 => change_view(stage, camera, random),
        6..11 if stage.is_lean => change_lean(stage, camera, random),
        11..15 if stage.is_lean => toggle_lean(stage, camera, random),
        _ => change_bevy(stage, camera, random),
    }
}

/// Adds a camera that has from its beginning what Bevy 0.19.1 cannot remove from a live one: without `MotionVectorPrepass` a pipeline of
/// its background still writes that texture. Components that fail in Bevy on targets of a few pixels are given to a camera whose target
/// keeps its size: on small ones Bevy binds the texture of a depth pyramid twice for writing.
fn add_camera(stage: &mut Stage, random: &mut Random) -> String {
    let kind = random.below(8);
    let target = if kind < 3 {
        STEADY
    } else {
        random.below(STEADY)
    };
    stage.add_camera(target);
    let camera = stage.cameras[stage.cameras.len() - 1];
    let mut entity = stage.entity(camera);
    match kind {
        0 => _ = entity.insert((ScreenSpaceAmbientOcclusion::default(), Msaa::Off)),
        1 => _ = entity.insert((DepthPrepass, OcclusionCulling)),
        2 => _ = entity.insert((ScreenSpaceReflections::default(), Msaa::Off)),
        3 => _ = entity.insert(DepthPrepass),
        4 => _ = entity.insert((DepthPrepass, NormalPrepass, MotionVectorPrepass)),
        5 => _ = entity.insert((DepthPrepass, DeferredPrepass)),
        6 => _ = entity.insert((TemporalAntiAliasing::default(), Msaa::Off)),
        _ => {}
    }
    format!("a camera comes, of kind {kind}")
}

fn change_view(stage: &mut Stage, camera: Entity, random: &mut Random) -> String {
    let is_steady = stage.is_steady(camera);
    let mut entity = stage.entity(camera);
    match random.below(8) {
        0 | 1 => {
            let mut to = Transform::from_xyz(
                random.range(-4.0, 4.0),
                random.range(0.2, 4.0),
                random.range(-6.0, 6.0),
            );
            to.look_at(Vec3::new(0.0, 0.5, 0.0), Vec3::Y);
            entity.insert(to);
            format!("a camera at {}", to.translation)
        }
        2 => {
            let mut settings = entity.get_mut::<Camera>().expect("it is one");
            settings.is_active ^= true;
            format!("active: {}", settings.is_active)
        }
        3 if is_steady => String::new(),
        3 => {
            let viewport = (random.below(3) > 0).then(|| Viewport {
                physical_position: UVec2::new(random.below(20) as u32, random.below(20) as u32),
                physical_size: UVec2::new(1 + random.below(40) as u32, 1 + random.below(40) as u32),
                ..default()
            });
            entity.get_mut::<Camera>().expect("it is one").viewport = viewport.clone();
            format!("{viewport:?}")
        }
        4 => {
            let mut projection = entity.get_mut::<Projection>().expect("it has one");
            *projection = if random.below(2) == 0 {
                Projection::Orthographic(OrthographicProjection {
                    scaling_mode: ScalingMode::FixedVertical {
                        viewport_height: random.range(0.1, 8.0),
                    },
                    ..OrthographicProjection::default_3d()
                })
            } else {
                Projection::Perspective(PerspectiveProjection {
                    fov: random.range(0.05, 2.5),
                    near: random.range(0.001, 1.0),
                    ..default()
                })
            };
            format!("{:?}", *projection)
        }
        5 => {
            let layers = RenderLayers::from_layers(&[0, random.below(3)]);
            entity.insert(layers.clone());
            format!("layers of a camera: {layers:?}")
        }
        6 => {
            // Off-centre, and of another shape than the target.
            let part = (random.below(2) == 0).then(|| SubCameraView {
                full_size: UVec2::new(100, 80),
                offset: Vec2::new(random.range(-60.0, 60.0), random.range(-60.0, 60.0)),
                size: UVec2::new(20 + random.below(80) as u32, 20 + random.below(80) as u32),
            });
            let description = format!("{part:?}");
            entity
                .get_mut::<Camera>()
                .expect("it is one")
                .sub_camera_view = part;
            description
        }
        _ => {
            let order = random.below(4) as isize;
            entity.get_mut::<Camera>().expect("it is one").order = order;
            format!("order: {order}")
        }
    }
}

/// Changes settings of an effect, of each kind.
fn change_lean(stage: &mut Stage, camera: Entity, random: &mut Random) -> String {
    let values = Values {
        hostile: 6,
        images: &[],
        kept: &[],
    };
    let change = values.change_lean(&mut stage.entity(camera), random);
    change.unwrap_or("settings that are not there".into())
}

fn toggle_lean(stage: &mut Stage, camera: Entity, random: &mut Random) -> String {
    let camera = &mut stage.entity(camera);
    match random.below(9) {
        0 | 1 => toggle::<LeanDeferred>(camera),
        2 | 3 => toggle::<LeanScreenSpaceAmbientOcclusion>(camera),
        4 => toggle::<LeanAutoExposure>(camera),
        5 => toggle::<LeanScreenSpaceGi>(camera),
        6 => toggle::<LeanScreenSpaceReflections>(camera),
        7 => toggle::<CameraCut>(camera),
        _ => toggle::<LeanSubsurfaceScattering>(camera),
    }
}

/// Changes Bevy's own components of cameras.
fn change_bevy(stage: &mut Stage, camera: Entity, random: &mut Random) -> String {
    match random.below(10) {
        0 => toggle::<Bloom>(&mut stage.entity(camera)),
        1 => toggle::<Fxaa>(&mut stage.entity(camera)),
        2 => toggle::<DepthOfField>(&mut stage.entity(camera)),
        3 => {
            let fog = DistanceFog {
                falloff: FogFalloff::Exponential { density: 0.1 },
                ..default()
            };
            toggle_between(&mut stage.entity(camera), fog)
        }
        4 => {
            let light = stage.builder().environment_map(1000.0);
            toggle_between(&mut stage.entity(camera), light)
        }
        5 => {
            let brightness = random.range(0.0, 500.0);
            stage.entity(camera).insert(AmbientLight {
                brightness,
                ..default()
            });
            format!("ambient light: {brightness}")
        }
        6 => toggle::<VolumetricFog>(&mut stage.entity(camera)),
        7 => {
            let sky = Skybox {
                image: Some(stage.builder().cube_map()),
                brightness: 800.0,
                ..default()
            };
            toggle_between(&mut stage.entity(camera), sky)
        }
        8 => toggle::<OrderIndependentTransparencySettings>(&mut stage.entity(camera)),
        _ => {
            let clear_color = [
                ClearColorConfig::Default,
                ClearColorConfig::None,
                ClearColorConfig::Custom(Color::linear_rgb(0.2, 3.0, f32::NAN)),
            ][random.below(3)];
            let mut entity = stage.entity(camera);
            entity.get_mut::<Camera>().expect("it is one").clear_color = clear_color;
            format!("{clear_color:?}")
        }
    }
}
