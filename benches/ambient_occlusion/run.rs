//! Measures one contender at one size.

use bevy::{
    camera::Hdr,
    core_pipeline::{
        prepass::node::{early_prepass, late_prepass},
        schedule::{Core3d, Core3dSystems},
        tonemapping::{DebandDither, Tonemapping},
    },
    prelude::*,
    render::{RenderApp, diagnostic::RenderDiagnosticsPlugin, renderer::RenderContext},
};
use figures::benches::ambient_occlusion::Measurement;
use std::collections::HashMap;

use crate::{
    Args,
    contender::{Contender, Kind},
    naive,
    scene::{self, BenchScene},
    show,
};
use kit::{
    bench_spans::{CAMERA, PREPASS, add_camera_span},
    gpu_time::{Samples, begin, end},
    headless::{Headless, Picture},
    occlusion::errors::Errors,
    scenes::boxes::Boxes,
};

/// Closed forms, by scene and size: casting their rays takes longer than all frames of a measurement.
pub type Truths = HashMap<(&'static str, UVec2), (Vec<Option<f32>>, Vec<bool>)>;

/// Renders the warm-up frames, measures the next ones, and renders the pictures for the errors.
pub fn measure(
    contender: &Contender,
    size: UVec2,
    args: &Args,
    truths: &mut Truths,
) -> Measurement {
    let boxes = if args.small {
        BenchScene::Boxes(Boxes::small(32))
    } else {
        BenchScene::Boxes(Boxes::full(64))
    };
    let mut headless = app(contender, boxes, size, false);
    headless.settle();
    let samples = Samples::of_frames(&mut headless, args.warm_up, args.frames);
    let device = headless.adapter_and_driver();
    drop(headless);

    let shown = |scene: BenchScene| -> Option<Vec<f32>> {
        contender.occlusion?;
        let mut headless = app(contender, scene, size, true);
        headless.settle();
        headless.frames(3);
        let occlusion: Vec<f32> = show::read_main_texture(&mut headless)
            .into_iter()
            .map(|visibility| 1.0 - visibility)
            .collect();
        if let Some(folder) = &args.pictures {
            let name = contender.name.replace([' ', ','], "_");
            let file = format!("{name}_{}_{}x{}.png", scene.name(), size.x, size.y);
            picture(&occlusion, size).save(std::path::Path::new(folder).join(file));
        }
        Some(occlusion)
    };
    let mut errors = |scene: BenchScene| {
        let shown = shown(scene)?;
        let (truth, mask) = truths
            .entry((scene.name(), size))
            .or_insert_with(|| scene.truth(size).expect("these scenes have a closed form"));
        Some(Errors::measure(&shown, truth, mask))
    };
    let occluded = shown(boxes).map_or(0.0, |occlusion| {
        let some = occlusion.iter().filter(|o| **o > 0.0).count();
        some as f64 / occlusion.len() as f64
    });
    Measurement {
        device,
        frames: Some(args.frames),
        size: size.to_array(),
        contender: contender.name.clone(),
        lean: contender.lean,
        passes: contender
            .spans()
            .iter()
            .filter_map(|name| samples.time(name))
            .collect(),
        lighting: samples.time("lean_deferred/lighting"),
        prepass: samples.time(PREPASS),
        camera: samples.time(CAMERA),
        bytes: contender.bytes(occluded),
        occluded,
        wall: errors(BenchScene::Wall).map(|e| (e.rmse, e.bias)),
        plane: errors(BenchScene::Plane).map(|e| e.mean),
    }
}

pub fn app(contender: &Contender, scene: BenchScene, size: UVec2, shows: bool) -> Headless {
    let mut headless = Headless::with(size, |app| {
        app.add_plugins((RenderDiagnosticsPlugin, naive::plugin));
        if shows && matches!(contender.occlusion, Some(Kind::Bevy(_))) {
            app.add_plugins(show::plugin);
        }
        add_spans(app);
    });
    let transform = scene.spawn(&mut headless);
    let target = headless.render_target();
    let mut camera = headless.world().spawn((
        Camera3d::default(),
        Hdr,
        Msaa::Off,
        target,
        transform,
        scene::ambient(),
    ));
    if shows {
        // The read-back must get the exact values that the passes wrote.
        camera.insert((Tonemapping::None, DebandDither::Disabled));
    }
    contender.dress(&mut camera, shows);
    headless
}

fn picture(occlusion: &[f32], size: UVec2) -> Picture {
    let grey = |o: &f32| ((1.0 - o) * 255.0).clamp(0.0, 255.0).round() as u8;
    Picture {
        size,
        rgba: occlusion
            .iter()
            .map(grey)
            .flat_map(|g| [g, g, g, 255])
            .collect(),
    }
}

/// Adds the span of the camera, and one around Bevy's prepass.
fn add_spans(app: &mut App) {
    add_camera_span(app);
    app.sub_app_mut(RenderApp).add_systems(
        Core3d,
        (
            (|ctx: RenderContext| begin(ctx, PREPASS))
                .in_set(Core3dSystems::Prepass)
                .before(early_prepass),
            end.in_set(Core3dSystems::Prepass)
                .after(early_prepass)
                .before(late_prepass),
        ),
    );
}
