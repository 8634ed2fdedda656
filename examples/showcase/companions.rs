//! Animated figures of a glTF file that walk among the people.

use bevy::{
    asset::RecursiveDependencyLoadState,
    camera::primitives::Aabb,
    gltf::{Gltf, GltfLoaderSettings},
    prelude::*,
    world_serialization::WorldAssetRoot,
};
use kit::example::{
    model::{NO_MESH, first_line},
    run::SceneReady,
};
use street::{Detail, NEAREST, Walker, Walking};

/// Length of the longest side of a figure, in metres.
const LENGTH: f32 = 1.3;

/// Speed, in metres per second.
const SPEED: f32 = 1.1;

/// Number of people per figure.
const PEOPLE: usize = 3;

/// Loads the file and spawns its figures; the scene is ready only then.
pub struct CompanionsPlugin {
    pub path: String,
}

impl Plugin for CompanionsPlugin {
    fn build(&self, app: &mut App) {
        // Asset paths start in a folder of their own, but the user means the working directory.
        let path = std::path::absolute(&self.path).unwrap_or_else(|_| self.path.clone().into());
        let assets = app.world().resource::<AssetServer>();
        let file = assets
            .load_builder()
            .with_settings(|settings: &mut GltfLoaderSettings| settings.load_cameras = false)
            .load(path);
        app.insert_resource(Companions {
            file,
            are_there: false,
        })
        .add_systems(Update, (spawn, size, animate, keep_pace).chain());
    }
}

#[derive(Resource)]
struct Companions {
    file: Handle<Gltf>,
    are_there: bool,
}

/// A figure whose bounds are still unknown.
#[derive(Component)]
struct OfAnySize;

fn spawn(
    mut commands: Commands,
    mut companions: ResMut<Companions>,
    detail: Res<Detail>,
    files: Res<Assets<Gltf>>,
    assets: Res<AssetServer>,
    mut exit: MessageWriter<AppExit>,
) {
    if companions.are_there {
        return;
    }
    let scene = match assets.get_recursive_dependency_load_state(&companions.file) {
        Some(RecursiveDependencyLoadState::Loaded) => {
            let file = files.get(&companions.file);
            let first = file.and_then(|file| file.default_scene.as_ref().or(file.scenes.first()));
            first.cloned().ok_or(NO_MESH.into())
        }
        Some(RecursiveDependencyLoadState::Failed(error)) => Err(first_line(&error)),
        _ => return,
    };
    companions.are_there = true;
    let scene = match scene {
        Ok(scene) => scene,
        Err(why) => {
            eprintln!("error: the figure's file: {why}");
            exit.write(AppExit::error());
            return;
        }
    };
    let count = detail.figures.div_ceil(PEOPLE);
    for number in 0..count {
        let is_even = number.is_multiple_of(2);
        let walker = Walker {
            lane: Vec2::new(if is_even { 0.45 } else { -0.35 }, 0.0),
            towards_us: is_even,
            speed: SPEED,
            far: detail.far + 3.0,
            near: NEAREST,
            way: detail.length() * (number as f32 + 0.8) / count as f32,
        };
        let scene = WorldAssetRoot(scene.clone());
        commands.spawn((walker, walker.transform(), scene, OfAnySize));
    }
}

/// Scales each figure once its meshes have bounds.
fn size(
    mut commands: Commands,
    companions: Res<Companions>,
    mut figures: Query<(Entity, &mut Transform), With<OfAnySize>>,
    children: Query<&Children>,
    bounds: Query<(&Aabb, &GlobalTransform)>,
) {
    let mut are_sized = companions.are_there;
    for (figure, mut transform) in &mut figures {
        let parts = children.iter_descendants(figure);
        let sides = parts.filter_map(|part| {
            let (aabb, place) = bounds.get(part).ok()?;
            Some(2.0 * (Vec3::from(aabb.half_extents) * place.scale()).max_element())
        });
        let longest = sides.fold(0.0, f32::max);
        if longest > 0.0 {
            transform.scale = Vec3::splat(LENGTH / longest);
            commands.entity(figure).remove::<OfAnySize>();
        } else {
            are_sized = false;
        }
    }
    if are_sized {
        commands.insert_resource(SceneReady);
    }
}

/// Plays the walking animation if there is one, else the first, with a different start for each figure.
fn animate(
    mut commands: Commands,
    companions: Res<Companions>,
    files: Res<Assets<Gltf>>,
    mut graphs: ResMut<Assets<AnimationGraph>>,
    mut players: Query<(Entity, &mut AnimationPlayer), Added<AnimationPlayer>>,
) {
    let Some(file) = files.get(&companions.file) else {
        return;
    };
    let mut named = file.named_animations.iter();
    let walk = named.find(|(name, _)| name.to_lowercase().contains("walk"));
    let Some(clip) = walk.map(|(_, clip)| clip).or(file.animations.first()) else {
        return;
    };
    for (number, (figure, mut player)) in players.iter_mut().enumerate() {
        let (graph, node) = AnimationGraph::from_clip(clip.clone());
        player.play(node).repeat().seek_to(0.23 * number as f32);
        let graph = AnimationGraphHandle(graphs.add(graph));
        commands.entity(figure).insert(graph);
    }
}

/// Stops with the people, who stand while pictures are compared.
fn keep_pace(walking: Option<Res<Walking>>, mut players: Query<&mut AnimationPlayer>) {
    let pace = walking.map_or(1.0, |walking| walking.0);
    for mut player in &mut players {
        for (_, animation) in player.playing_animations_mut() {
            animation.set_speed(pace);
        }
    }
}
