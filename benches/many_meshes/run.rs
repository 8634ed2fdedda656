//! One number of meshes through one renderer.

use std::{
    sync::{Arc, Mutex},
    time::Instant,
};

use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    render::{
        RenderApp,
        render_resource::PollType,
        renderer::{RenderAdapterInfo, RenderDevice},
    },
};
use bevy_lean_deferred::LeanDeferred;
use serde::Serialize;

use crate::{
    Motion,
    common::{
        headless::{Headless, Picture},
        metrics,
    },
    scene,
};

/// A way to render the scene.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Contender {
    Forward,
    BevyDeferred,
    Lean,
}

impl Contender {
    /// Forward first: its picture is the reference.
    pub const ALL: [Self; 3] = [Self::Forward, Self::BevyDeferred, Self::Lean];

    pub fn name(self) -> &'static str {
        match self {
            Self::Forward => "Bevy forward",
            Self::BevyDeferred => "Bevy deferred",
            Self::Lean => "lean",
        }
    }
}

/// Milliseconds of CPU time.
#[derive(Serialize, Clone, Copy, Default)]
pub struct Times {
    pub render_world: f64,
    pub frame: f64,
}

#[derive(Serialize)]
pub struct Measurement {
    pub adapter: String,
    pub cores: usize,
    pub meshes: usize,
    pub contender: String,
    /// Medians while nothing, a tenth and everything moves.
    pub steady: Vec<Times>,
    /// The dearest of the frames after the emissive mesh appeared, after it went and its target expired, and after the
    /// camera turned around: medians over the events.
    pub emissive: Times,
    pub expiry: Times,
    pub turn: Times,
    /// Against forward.
    pub psnr: f64,
    pub flip: f64,
}

impl Measurement {
    pub fn compare(&mut self, reference: &Picture, picture: &Picture) {
        let difference = metrics::difference(reference, picture);
        self.psnr = difference.psnr;
        self.flip = difference.flip;
    }
}

/// When extraction began.
type Began = Arc<Mutex<Option<Instant>>>;

struct Stage {
    headless: Headless,
    began: Began,
}

impl Stage {
    fn new(meshes: usize, contender: Contender, size: UVec2) -> Self {
        let mut headless = Headless::with(size, |app| {
            if contender == Contender::BevyDeferred {
                app.insert_resource(DefaultOpaqueRendererMethod::deferred());
            }
            app.add_systems(Update, scene::move_meshes);
        });
        match contender {
            Contender::Forward => scene::spawn(&mut headless, meshes, ()),
            Contender::BevyDeferred => {
                scene::spawn(&mut headless, meshes, (DepthPrepass, DeferredPrepass));
            }
            Contender::Lean => scene::spawn(&mut headless, meshes, LeanDeferred::default()),
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
        Self { headless, began }
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

    /// The dearest of the frames in which something may follow from `event`.
    fn event(&mut self, event: impl FnOnce(&mut World)) -> Times {
        event(self.headless.world());
        dearest(&self.frames(EVENT_FRAMES))
    }
}

/// Long enough for new targets to be made and filled.
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

/// Measures `frames` of each motion, and each event `events` times.
pub fn measure(
    meshes: usize,
    contender: Contender,
    size: UVec2,
    frames: usize,
    events: usize,
) -> (Measurement, Picture) {
    let mut stage = Stage::new(meshes, contender, size);
    stage.headless.settle();
    let picture = stage.headless.capture();

    let steady = Motion::ALL.map(|motion| {
        stage.headless.world().insert_resource(motion);
        stage.frames(frames / 4 + 2);
        median(&stage.frames(frames))
    });
    stage.headless.world().insert_resource(Motion::Nothing);
    stage.frames(4);

    let (mut emissive, mut expiry, mut turn) = (Vec::new(), Vec::new(), Vec::new());
    // The first of each compiles shaders and is not counted.
    for _ in 0..=events {
        emissive.push(stage.event(|world| scene::show_lamp(world, true)));
        scene::show_lamp(stage.headless.world(), false);
        stage.frames(4);
        expiry.push(dearest(&stage.frames(EXPIRY_FRAMES)));
    }
    for _ in 0..=events {
        turn.push(stage.event(scene::turn_around));
        stage.frames(2);
    }
    let info = stage
        .headless
        .app
        .sub_app(RenderApp)
        .world()
        .resource::<RenderAdapterInfo>();
    let measurement = Measurement {
        adapter: info.name.clone(),
        cores: std::thread::available_parallelism().map_or(0, usize::from),
        meshes,
        contender: contender.name().into(),
        steady: steady.to_vec(),
        emissive: median(&emissive[1..]),
        expiry: median(&expiry[1..]),
        turn: median(&turn[1..]),
        psnr: f64::NAN,
        flip: f64::NAN,
    };
    (measurement, picture)
}
