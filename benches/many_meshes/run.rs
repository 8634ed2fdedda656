//! Measures one number of meshes with each renderer.

use std::{
    sync::{Arc, Mutex},
    time::Instant,
};

use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    render::{RenderApp, render_resource::PollType, renderer::RenderDevice},
};
use bevy_lean_deferred::{LeanDeferred, LeanDeferredPlugins};
use figures::benches::many_meshes::{Measurement, Times};

use crate::{Motion, scene, stages};
use kit::{
    headless::{Headless, Picture},
    metrics,
};

/// A way to render the scene.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Contender {
    /// Without this crate.
    Forward,
    /// Forward, with the plugins of this crate but none of its components.
    Unused,
    /// Without this crate.
    BevyDeferred,
    Lean,
}

impl Contender {
    /// Forward first: its picture is the reference.
    pub const ALL: [Self; 4] = [Self::Forward, Self::Unused, Self::BevyDeferred, Self::Lean];

    pub fn name(self) -> &'static str {
        match self {
            Self::Forward => "Bevy forward",
            Self::Unused => "plugins added, no component",
            Self::BevyDeferred => "Bevy deferred",
            Self::Lean => "lean",
        }
    }
}

/// Adds the difference between `picture` and forward's.
pub fn compare(measurement: &mut Measurement, reference: &Picture, picture: &Picture) {
    let difference = metrics::difference(reference, picture);
    measurement.psnr = Some(difference.psnr);
    measurement.flip = Some(difference.flip);
}

/// Start of the extraction.
type Began = Arc<Mutex<Option<Instant>>>;

struct Stage {
    headless: Headless,
    began: Began,
}

impl Stage {
    fn new(meshes: usize, contender: Contender, size: UVec2, followed: bool) -> Self {
        let mut app = App::new();
        app.add_plugins(Headless::default_plugins());
        if matches!(contender, Contender::Unused | Contender::Lean) {
            app.add_plugins(LeanDeferredPlugins);
        }
        let mut headless = Headless::from_app(size, app, |app| {
            if contender == Contender::BevyDeferred {
                app.insert_resource(DefaultOpaqueRendererMethod::deferred());
            }
            app.add_systems(Update, scene::move_meshes);
        });
        match contender {
            Contender::Forward | Contender::Unused => scene::spawn(&mut headless, meshes, ()),
            Contender::BevyDeferred => {
                scene::spawn(&mut headless, meshes, (DepthPrepass, DeferredPrepass));
            }
            Contender::Lean => scene::spawn(&mut headless, meshes, LeanDeferred::default()),
        }
        if followed {
            scene::add_followed_components(headless.world());
        }
        let began = Began::default();
        let render_app = headless.app.sub_app_mut(RenderApp);
        if let Some(mut extract) = render_app.take_extract() {
            let began = began.clone();
            render_app.set_extract(move |main_world, render_world| {
                *began.lock().unwrap() = Some(Instant::now());
                extract(main_world, render_world);
            });
        }
        stages::record(headless.app.sub_app_mut(RenderApp));
        Self { headless, began }
    }

    /// Time per stage of the last frame.
    fn stage_times(&self) -> Option<stages::StageTimes> {
        let began = (*self.began.lock().unwrap())?;
        Some(stages::times(self.headless.app.sub_app(RenderApp), began))
    }

    fn frame(&mut self) -> Times {
        let start = Instant::now();
        self.headless.app.update();
        let end = Instant::now();
        let render_app = self.headless.app.sub_app(RenderApp);
        let device = render_app.world().resource::<RenderDevice>();
        if let Err(error) = device.poll(PollType::wait_indefinitely()) {
            warn!("waiting for the GPU: {error}");
        }
        let milliseconds = |from: Instant| end.duration_since(from).as_secs_f64() * 1e3;
        Times {
            render_world: (self.began.lock().unwrap()).map_or(f64::NAN, milliseconds),
            frame: milliseconds(start),
        }
    }

    fn frames(&mut self, count: usize) -> Vec<Times> {
        (0..count).map(|_| self.frame()).collect()
    }

    /// The most expensive of the frames that may show an effect of `event`.
    fn event(&mut self, event: impl FnOnce(&mut World)) -> Times {
        event(self.headless.world());
        dearest(&self.frames(EVENT_FRAMES))
    }

    /// Shows the lamp, hides it again, and lets its target expire.
    fn show_lamp_for_a_while(&mut self) -> [Times; 2] {
        let emissive = self.event(|world| scene::show_lamp(world, true));
        scene::show_lamp(self.headless.world(), false);
        self.frames(4);
        [emissive, dearest(&self.frames(EXPIRY_FRAMES))]
    }

    /// Turns the camera around; also returns the times per stage of that frame.
    fn turn(&mut self) -> (Times, Option<stages::StageTimes>) {
        self.frames(2);
        scene::turn_around(self.headless.world());
        let first = self.frame();
        let stages = self.stage_times();
        let rest = self.frames(EVENT_FRAMES - 1);
        (dearest(&[&[first][..], &rest].concat()), stages)
    }
}

/// Long enough to create and fill new targets.
const EVENT_FRAMES: usize = 6;
/// Longer than a view keeps a target that no mesh needs any more.
const EXPIRY_FRAMES: usize = 130;

fn dearest(frames: &[Times]) -> Times {
    frames.iter().fold(Times::default(), |most, times| Times {
        render_world: most.render_world.max(times.render_world),
        frame: most.frame.max(times.frame),
    })
}

fn median(times: &[Times]) -> Times {
    let of = |part: fn(&Times) -> f64| {
        let mut values: Vec<f64> = times.iter().map(part).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    Times {
        render_world: of(|times| times.render_world),
        frame: of(|times| times.frame),
    }
}

/// Measures `frames` of each motion, and each event `events` times. The renderers take turns, so that a slowdown of the
/// machine affects all of them alike.
pub fn measure(
    meshes: usize,
    contenders: &[Contender],
    size: UVec2,
    frames: usize,
    events: usize,
    followed: bool,
) -> Vec<(Measurement, Picture)> {
    let mut stages: Vec<Stage> = contenders
        .iter()
        .map(|contender| Stage::new(meshes, *contender, size, followed))
        .collect();
    let pictures: Vec<Picture> = stages
        .iter_mut()
        .map(|stage| {
            stage.headless.settle();
            stage.headless.capture()
        })
        .collect();

    let mut steady = vec![Vec::new(); stages.len()];
    for motion in Motion::ALL {
        let mut times = vec![Vec::new(); stages.len()];
        for stage in &mut stages {
            stage.headless.world().insert_resource(motion);
            stage.frames(4);
        }
        for _ in 0..TURNS {
            for (stage, times) in stages.iter_mut().zip(&mut times) {
                stage.frames(2);
                times.extend(stage.frames(frames.div_ceil(TURNS)));
            }
        }
        for (steady, times) in steady.iter_mut().zip(&times) {
            steady.push(median(times));
        }
    }

    let mut seen = vec![Events::default(); stages.len()];
    for stage in &mut stages {
        stage.headless.world().insert_resource(Motion::Nothing);
        stage.frames(4);
    }
    // The first of each compiles shaders and is not counted.
    for time in 0..=events {
        for (stage, seen) in stages.iter_mut().zip(&mut seen) {
            let [emissive, expiry] = stage.show_lamp_for_a_while();
            if time > 0 {
                seen.emissive.push(emissive);
                seen.expiry.push(expiry);
            }
        }
    }
    // A turn takes either of two times, one twice the other, depending on the core that it runs on. So there are more
    // of them.
    for time in 0..=events * TURNS_AN_EVENT {
        for (stage, seen) in stages.iter_mut().zip(&mut seen) {
            let (turn, stages) = stage.turn();
            if time > 0 {
                seen.turn.push(turn);
                seen.stages.extend(stages);
            }
        }
    }

    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let measured = stages.into_iter().zip(contenders).zip(steady).zip(seen);
    measured
        .zip(pictures)
        .map(|((((stage, contender), steady), seen), picture)| {
            let measurement = Measurement {
                device: stage.headless.adapter_and_driver(),
                size: Some(size.to_array()),
                frames: Some(frames),
                cores,
                meshes,
                contender: contender.name().into(),
                steady,
                emissive: median(&seen.emissive),
                expiry: median(&seen.expiry),
                turn: median(&seen.turn),
                turn_stages: stages::medians(&seen.stages),
                psnr: None,
                flip: None,
            };
            (measurement, picture)
        })
        .collect()
}

/// Number of camera turns per other event.
const TURNS_AN_EVENT: usize = 6;
/// Number of turns that the renderers take.
const TURNS: usize = 6;

/// Costs of the events so far.
#[derive(Clone, Default)]
struct Events {
    emissive: Vec<Times>,
    expiry: Vec<Times>,
    turn: Vec<Times>,
    stages: Vec<stages::StageTimes>,
}
