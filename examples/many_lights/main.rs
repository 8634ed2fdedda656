//! The scene of the benches, live: 1600 meshes under hundreds of moving point lights. The text keeps, for each renderer, its
//! last GPU time for the meshes and their lighting, with the number of lights.
//!
//! `cargo run --example many_lights -- [--lights N] [--headless OUT.png] [--help]`
//!
//! The keys 1, 2 and 3 choose Bevy forward, Bevy deferred and lean, and the panel has the number of lights; `docs/examples.md` lists the
//! other keys.

mod times;

use bevy::{camera::Hdr, light::cluster::GlobalClusterSettings, prelude::*, ui::IsDefaultUiCamera};
use bevy_lean_deferred::prelude::*;
use kit::{
    bench_spans,
    example::{
        panel::{Panel, PanelCamera, fixed_panel, panel},
        renderers::RenderersPlugin,
        run::{self, Example, SceneReady},
    },
    headless::Headless,
    renderer::Renderer,
    scenes::boxes::{self, Boxes},
};
use times::GpuTimes;

kit::example_args! {
    /// The scene of the benches, live.
    struct Args {
        /// point lights, default 512
        #[argh(option, default = "512")]
        lights: u32,

        /// a grid of 10 by 10 meshes in place of 40 by 40, for software renderers
        #[argh(switch)]
        small: bool,

        /// forward, deferred or lean (the default)
        #[argh(option, default = "Renderer::Lean")]
        renderer: Renderer,

        /// time the other renderers first, with --headless
        #[argh(switch)]
        compare: bool,
    }
}

/// The meshes, and the lights at the start.
#[derive(Resource, Clone, Copy)]
struct Meshes(Boxes);

/// The number of lights, on the panel.
#[derive(Component, Reflect, Default)]
#[reflect(Component, Default)]
struct Lights {
    count: u32,
}

fn main() -> AppExit {
    let args: Args = argh::from_env();
    let boxes = if args.small {
        Boxes::small(args.lights)
    } else {
        Boxes::full(args.lights)
    };
    let (chosen, compare) = (args.renderer, args.compare);
    let frames = args.frames.unwrap_or(times::FRAMES);
    let example = Example {
        // The picture is about the times in it.
        text: true,
        ..args.example("many lights", UVec2::new(1280, 720), times::FRAMES)
    };
    let example = example.written_by(move |mut headless, path| {
        if compare && let Err(exit) = time_others(&mut headless, chosen) {
            return exit;
        }
        run::write_picture(headless, path, frames)
    });
    let mut app = App::new();
    app.add_plugins((
        example.set_up(DefaultPlugins),
        LeanDeferredPlugins,
        example,
        RenderersPlugin(args.renderer),
        fixed_panel::<Lights>("point lights"),
        panel::<LeanDeferred>("LeanDeferred"),
    ))
    .insert_resource(Meshes(boxes))
    .insert_resource(SceneReady)
    .init_resource::<GpuTimes>()
    .add_systems(Startup, setup)
    .add_systems(
        Update,
        (move_lights, spawn_lights, times::measure, write_head).chain(),
    );
    bench_spans::add_bench_spans(&mut app);
    app.run()
}

/// Renders some frames with each renderer, with `chosen` last.
fn time_others(headless: &mut Headless, chosen: Renderer) -> Result<(), AppExit> {
    run::make_ready(headless)?;
    let others = Renderer::ALL.into_iter().filter(|other| *other != chosen);
    for renderer in others.chain([chosen]) {
        headless.world().insert_resource(renderer);
        headless.settle();
        headless.frames(times::FRAMES);
    }
    Ok(())
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    scene: Res<Meshes>,
    mut clusters: ResMut<GlobalClusterSettings>,
) {
    boxes::reserve_clusters(&mut clusters);
    boxes::spawn(&mut commands, &mut meshes, &mut materials, scene.0);
    commands.spawn((
        Camera3d::default(),
        LeanDeferred::default(),
        // LeanDeferred adds both; all renderers have them, so that they compare.
        Hdr,
        Msaa::Off,
        PanelCamera,
        Lights {
            count: scene.0.point_lights,
        },
        IsDefaultUiCamera,
        boxes::camera_transform(scene.0),
    ));
}

/// Most lights of the panel.
const MOST: u32 = 16_384;

/// Respawns all lights when their number changes.
fn spawn_lights(
    mut commands: Commands,
    scene: Res<Meshes>,
    wanted: Single<&Lights, Changed<Lights>>,
    lights: Query<Entity, With<PointLight>>,
) {
    let point_lights = wanted.count.min(MOST);
    if lights.iter().len() == point_lights as usize {
        return;
    }
    for light in &lights {
        commands.entity(light).despawn();
    }
    boxes::spawn_point_lights(
        &mut commands,
        Boxes {
            point_lights,
            ..scene.0
        },
    );
}

/// Moves each light around the place where it was spawned.
fn move_lights(time: Res<Time>, mut lights: Query<&mut Transform, With<PointLight>>) {
    let step = time.delta_secs();
    let now = time.elapsed_secs();
    for (i, mut transform) in lights.iter_mut().enumerate() {
        let phase = i as f32 * 2.399;
        transform.translation.x += (now + phase).cos() * step;
        transform.translation.z += (now + phase).sin() * step;
    }
}

const EXPLANATION: &str =
    "GPU time to draw and light all meshes, from when each renderer was last on";

fn write_head(renderer: Res<Renderer>, times: Res<GpuTimes>, mut panel: ResMut<Panel>) {
    panel.head = format!("{}{EXPLANATION}", times.table(*renderer));
}
