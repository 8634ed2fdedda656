//! Lean cameras against twins that render forward: no mesh is lost, and light is finite wherever forward's is.

use bevy::{
    camera::{Hdr, RenderTarget},
    prelude::*,
    render::{RenderApp, sync_world::RenderEntity, view::ViewDepthTexture},
};
use bevy_lean_deferred::prelude::*;
use kit::{
    hdr::{Light, keep_light_of_views, kept_light},
    headless::{Headless, Picture, target_image},
};

use crate::stage::Stage;

/// Frames that Bevy may need to draw everything: lights that the GPU counts take effect some frames later.
const FRAMES: usize = 3;

fn is_lean(stage: &mut Stage, camera: Entity) -> bool {
    let entity = stage.entity(camera);
    let is_active = entity
        .get::<Camera>()
        .is_some_and(|camera| camera.is_active);
    is_active
        && entity
            .get::<LeanStatus>()
            .is_some_and(|status| status.deferred.is_on())
}

/// Searches the light of lean cameras for NaN and infinities; if there are any, or with `beside`, compares them with twins.
pub fn check(stage: &mut Stage, frame: usize, beside: bool) {
    keep_light_of_views(&mut stage.headless);
    stage.headless.settle();
    for camera in stage.cameras.clone() {
        if !is_lean(stage, camera) {
            continue;
        }
        let light = kept_light(&mut stage.headless, camera);
        let has_wrong_numbers = light.is_some_and(|light| wrong_numbers(&light).next().is_some());
        if beside || has_wrong_numbers {
            check_beside_twin(stage, camera, frame);
        }
    }
}

/// Pixels with a channel that is NaN or infinite.
fn wrong_numbers(light: &Light) -> impl Iterator<Item = usize> {
    let texels = light.texels.iter().enumerate();
    texels.filter_map(|(i, texel)| texel.iter().any(|x| !x.is_finite()).then_some(i))
}

/// Depths that this camera rendered, in metres⁻¹; 0 in the background.
fn depths(headless: &mut Headless, camera: Entity) -> Depths {
    let view = headless.world().get::<RenderEntity>(camera)?.id();
    let world = headless.app.sub_app(RenderApp).world();
    let texture = world.get::<ViewDepthTexture>(view)?.texture.clone();
    if texture.sample_count() > 1 {
        return None;
    }
    let bytes = headless.read(&texture);
    let depths = bytes.as_chunks::<4>().0;
    let depths = depths.iter().map(|bytes| f32::from_le_bytes(*bytes));
    let size = UVec2::new(texture.width(), texture.height());
    Some((size, depths.collect()))
}

fn check_beside_twin(stage: &mut Stage, camera: Entity, frame: usize) {
    let size = {
        let target = stage.entity(camera).get::<RenderTarget>().cloned();
        let image = target.and_then(|target| target.as_image().cloned());
        let targets = stage.targets.iter();
        let found = targets.filter(|(handle, _)| Some(handle) == image.as_ref());
        found.map(|(_, size)| *size).next().expect("it has one")
    };
    let forward = add_twin(stage, camera, size);
    let lean = add_twin(stage, camera, size);
    // Disables what forward does not do: it compares layers only between cameras and lights.
    stage.entity(lean).insert(LeanDeferred {
        light_layers: false,
        ..default()
    });
    stage.headless.settle();
    stage.headless.frames(FRAMES);

    let [shown, lean_light, forward_light] =
        [camera, lean, forward].map(|camera| kept_light(&mut stage.headless, camera));
    if let (Some(shown), Some(forward)) = (&shown, &forward_light) {
        let is_finite = |i: &usize| forward.texels[*i].iter().all(|x| x.is_finite());
        let mut alone = wrong_numbers(shown).filter(is_finite);
        if let Some(first) = alone.next() {
            save("shown", shown);
            save("forward", forward);
            panic!(
                "frame {frame}: camera {camera} has no number at pixel {first} and at {} more: {:?}, and forward {:?}",
                alone.count(),
                shown.texels[first],
                forward.texels[first]
            );
        }
    }
    if let (Some(lean), Some(forward)) = (&lean_light, &forward_light) {
        let other = other_light(lean, forward);
        // A few pixels may differ where outlines meet bright light.
        let allowed = 8 + lean.texels.len() / 100;
        if other.len() > allowed {
            save("lean", lean);
            save("forward", forward);
        }
        assert!(
            other.len() <= allowed,
            "frame {frame}: camera {camera}: {} of {} pixels have other light than forward's, the first {}: {:?} and not {:?}",
            other.len(),
            lean.texels.len(),
            other[0],
            lean.texels[other[0]],
            forward.texels[other[0]]
        );
    }
    let [lean_depths, forward_depths] =
        [lean, forward].map(|camera| depths(&mut stage.headless, camera));
    let name = format!("frame {frame}: the twin of camera {camera}");
    assert_same_depths(&name, lean_depths, &forward_depths);
    if has_its_target_alone(stage, camera) {
        let shown = depths(&mut stage.headless, camera);
        assert_same_depths(
            &format!("frame {frame}: camera {camera}"),
            shown,
            &forward_depths,
        );
    }
    for twin in [lean, forward] {
        stage.world().despawn(twin);
    }
    stage.headless.frames(1);
}

/// True if no other camera shares the target, and so the depth texture.
fn has_its_target_alone(stage: &mut Stage, camera: Entity) -> bool {
    let target_of = |stage: &mut Stage, camera| {
        let target = stage.entity(camera).get::<RenderTarget>().cloned();
        target.and_then(|target| target.as_image().cloned())
    };
    let target = target_of(stage, camera);
    let cameras = stage.cameras.clone();
    cameras
        .iter()
        .all(|other| *other == camera || target_of(stage, *other) != target)
}

/// Size and depths of a picture, if they can be read.
type Depths = Option<(UVec2, Vec<f32>)>;

fn assert_same_depths(name: &str, lean: Depths, forward: &Depths) {
    let (Some((size, lean)), Some((forward_size, forward))) = (lean, forward) else {
        return;
    };
    assert_eq!(size, *forward_size, "{name}");
    let lost: Vec<usize> = (0..lean.len())
        .filter(|i| (lean[*i] - forward[*i]).abs() > 1e-3 * forward[*i].abs())
        .collect();
    assert!(
        lost.is_empty(),
        "{name}, {size}: {} pixels have other depths than forward's, the first {}: {} and not {}",
        lost.len(),
        lost[0],
        lean[lost[0]],
        forward[lost[0]]
    );
}

/// A camera like this one on a target of its own, without this crate's components.
fn add_twin(stage: &mut Stage, camera: Entity, size: UVec2) -> Entity {
    let target = stage.builder().add::<Image>(target_image(size));
    let twin = stage.entity(camera).clone_and_spawn();
    let mut entity = stage.entity(twin);
    entity
        .remove::<(
            LeanDeferred,
            LeanScreenSpaceAmbientOcclusion,
            LeanAutoExposure,
            LeanScreenSpaceGi,
            LeanScreenSpaceReflections,
            LeanSubsurfaceScattering,
        )>()
        .insert((Hdr, Msaa::Off, RenderTarget::from(target)));
    if let Some(mut camera) = entity.get_mut::<Camera>() {
        camera.order = 100;
        // Without clearing, a new target shows arbitrary content.
        if matches!(camera.clear_color, ClearColorConfig::None) {
            camera.clear_color = ClearColorConfig::Default;
        }
    }
    twin
}

/// Saves a picture of light to the folder that `SOAK_PICTURES` names, if set.
fn save(name: &str, light: &Light) {
    let Some(folder) = std::env::var_os("SOAK_PICTURES") else {
        return;
    };
    let texels = light.texels.iter().flatten();
    // Compresses the range, to show bright light too.
    let rgba = texels.map(|x| ((x.max(0.0) / (1.0 + x.max(0.0))).sqrt() * 255.0) as u8);
    let picture = Picture {
        size: light.size,
        rgba: rgba.collect(),
    };
    picture.save(std::path::Path::new(&folder).join(format!("{name}.png")));
}

/// Pixels whose light differs from forward's, where that is finite.
fn other_light(lean: &Light, forward: &Light) -> Vec<usize> {
    let pairs = lean.texels.iter().zip(&forward.texels).enumerate();
    let other = pairs.filter(|(_, (lean, forward))| {
        let [lean, forward] = [lean, forward].map(|texel| Vec3::from_slice(&texel[..]));
        forward.is_finite()
            && (lean - forward).abs().max_element() > 0.05 + 0.1 * lean.max(forward).max_element()
    });
    other.map(|(i, _)| i).collect()
}
