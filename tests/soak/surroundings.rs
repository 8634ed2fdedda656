//! Changes to the surroundings of meshes: textures, light probes, decals, joints and morph weights.

use bevy::{
    asset::RenderAssetUsages,
    light::{ClusteredDecal, LightProbe},
    mesh::{morph::MeshMorphWeights, skinning::SkinnedMesh},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use kit::{
    random::Random,
    scenes::meshes::{morphed, skinned},
};

use crate::stage::Stage;

const MOST: usize = 6;

/// Makes one change and returns its description.
pub fn change(stage: &mut Stage, random: &mut Random) -> String {
    match random.below(12) {
        0..4 => change_image(stage, random),
        4 => spawn_probe(stage, random),
        5 => spawn_decal(stage, random),
        6 => spawn_skinned(stage),
        7 => spawn_morphed(stage),
        8 => despawn(stage, random),
        _ => change_one(stage, random),
    }
}

/// Changes the texels or the size of an image that materials have.
fn change_image(stage: &mut Stage, random: &mut Random) -> String {
    let handle = stage.images[random.below(stage.images.len())].clone();
    let side = [1, 3, 8, 64][random.below(4)];
    let texel = [0; 4].map(|_| random.below(256) as u8);
    let image = Image::new_fill(
        Extent3d {
            width: side,
            height: side,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        &texel,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    _ = stage
        .world()
        .resource_mut::<Assets<Image>>()
        .insert(&handle, image);
    format!("an image of {side}², {texel:?}")
}

fn has_room(stage: &mut Stage, random: &mut Random) -> bool {
    if stage.surroundings.len() >= MOST {
        despawn(stage, random);
    }
    stage.surroundings.len() < MOST
}

fn spawn_probe(stage: &mut Stage, random: &mut Random) -> String {
    if !has_room(stage, random) {
        return String::new();
    }
    let place = Transform::from_xyz(random.range(-2.0, 2.0), 0.5, random.range(-2.0, 2.0))
        .with_scale(Vec3::splat(random.range(0.5, 9.0)));
    let intensity = random.range(0.0, 2000.0);
    let is_volume = random.below(2) == 0;
    let mut s = stage.builder();
    let probe = if is_volume {
        let volume = s.irradiance_volume(intensity);
        s.spawn((LightProbe::default(), volume, place))
    } else {
        let map = s.environment_map(intensity);
        s.spawn((LightProbe::default(), map, place))
    };
    stage.surroundings.push(probe);
    format!("a probe of {intensity} comes, volume: {is_volume}")
}

/// Replaces any other decal: which of two lies on top is random in Bevy 0.19.1, whose clusters list them in the order in which the GPU
/// reaches them.
fn spawn_decal(stage: &mut Stage, random: &mut Random) -> String {
    let world = stage.headless.world();
    let mut decals = world.query_filtered::<Entity, With<ClusteredDecal>>();
    let there: Vec<Entity> = decals.iter(world).collect();
    for decal in there {
        stage.surroundings.retain(|entity| *entity != decal);
        stage.world().despawn(decal);
    }
    if !has_room(stage, random) {
        return String::new();
    }
    let decal = stage.builder().decal(Vec3::splat(random.range(0.1, 5.0)));
    stage.surroundings.push(decal);
    "a decal comes".into()
}

fn spawn_skinned(stage: &mut Stage) -> String {
    if stage.surroundings.len() >= MOST {
        return String::new();
    }
    let joint = skinned(&mut stage.builder());
    let world = stage.world();
    let mut columns = world.query::<(Entity, &SkinnedMesh)>();
    let column = columns
        .iter(world)
        .find(|(_, skin)| skin.joints.contains(&joint))
        .map(|(column, _)| column);
    stage.surroundings.extend(column);
    "a skinned mesh comes".into()
}

fn spawn_morphed(stage: &mut Stage) -> String {
    if stage.surroundings.len() >= MOST {
        return String::new();
    }
    let ball = morphed(&mut stage.builder());
    stage.surroundings.push(ball);
    "a morphed mesh comes".into()
}

fn despawn(stage: &mut Stage, random: &mut Random) -> String {
    if stage.surroundings.is_empty() {
        return String::new();
    }
    let index = random.below(stage.surroundings.len());
    let entity = stage.surroundings.swap_remove(index);
    stage.despawn_with_joints(entity);
    "what is around goes".into()
}

fn change_one(stage: &mut Stage, random: &mut Random) -> String {
    if stage.surroundings.is_empty() {
        return String::new();
    }
    let entity = stage.surroundings[random.below(stage.surroundings.len())];
    let mut entity = stage.entity(entity);
    if let Some(joint) = entity
        .get::<SkinnedMesh>()
        .and_then(|s| s.joints.last().copied())
    {
        let angle = random.range(-1.5, 1.5);
        let mut joint = stage.entity(joint);
        if let Some(mut transform) = joint.get_mut::<Transform>() {
            transform.rotation = Quat::from_rotation_z(angle);
        }
        return format!("a joint turns to {angle}");
    }
    if let Some(mut weights) = entity.get_mut::<MeshMorphWeights>() {
        let new: Vec<f32> = (0..2).map(|_| random.range(-0.5, 1.5)).collect();
        *weights = MeshMorphWeights::Value {
            weights: new.clone(),
        };
        return format!("morph weights: {new:?}");
    }
    if let Some(mut map) = entity.get_mut::<EnvironmentMapLight>() {
        map.intensity = random.range(0.0, 2000.0);
        return format!("a probe of {}", map.intensity);
    }
    if let Some(mut transform) = entity.get_mut::<Transform>() {
        transform.translation = Vec3::new(random.range(-2.0, 2.0), 0.5, random.range(-2.0, 2.0));
        return format!("what is around moves to {}", transform.translation);
    }
    String::new()
}
