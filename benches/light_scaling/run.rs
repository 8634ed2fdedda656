//! Measures one renderer at one size, through all arrangements and numbers of lights.

use std::time::{Duration, Instant};

use bevy::{
    diagnostic::DiagnosticsStore, light::cluster::Clusters, platform::collections::HashMap,
    prelude::*, render::diagnostic::RenderDiagnosticsPlugin,
};
use figures::benches::light_scaling::{LightScaling, Point};
use kit::{
    bench_spans::{self, add_bench_spans},
    gpu_time::{Samples, Time},
    headless::{Headless, Picture},
    log_watch::messages_with,
    metrics,
};

use crate::{
    contender::Contender,
    plan::Plan,
    scene::{self, Arrangement},
};

/// Forward's pictures at one size.
pub type References = HashMap<(Arrangement, u32), Picture>;

/// Least number of measured frames, and of warm-up frames: GPU times arrive a frame late.
const LEAST_FRAMES: usize = 4;
/// Frames are neither measured nor warmed up with beyond this time.
const LONGEST: Duration = Duration::from_secs(3);
/// Points whose stage is expected to take longer than this, in milliseconds, are not tried: drivers abort work that
/// takes seconds.
const NOT_TRIED: f64 = 2000.0;

struct Stage {
    headless: Headless,
    camera: Entity,
}

/// Adds a point to `figures` for each arrangement and number of lights.
pub fn measure(
    contender: Contender,
    size: UVec2,
    plan: &Plan,
    references: &mut References,
    figures: &mut LightScaling,
) {
    let mut headless = Headless::with(size, |app| {
        app.add_plugins(RenderDiagnosticsPlugin);
        contender.prepare_app(app);
        add_bench_spans(app);
    });
    let camera = scene::spawn(&mut headless, contender, plan);
    let mut stage = Stage { headless, camera };
    let first = plan.lights.first().copied().unwrap_or_default();
    scene::replace_lights(stage.headless.world(), Arrangement::Spread, first, plan);
    stage.headless.settle();
    figures.device = stage.headless.adapter_and_driver();

    for arrangement in Arrangement::ALL {
        let mut last: Option<(u32, f64)> = None;
        for &lights in &plan.lights {
            let mut point = Point {
                size: size.to_array(),
                arrangement: arrangement.name().into(),
                lights,
                contender: contender.name().into(),
                ..default()
            };
            point.left_out = last.and_then(|last| reason_to_leave_out(last, lights, plan.limit));
            if point.left_out.is_none() {
                let picture = stage.measure(&mut point, contender, arrangement, lights, plan);
                if let Some(time) = point.stage {
                    last = Some((lights, time.median));
                }
                if let Some(folder) = &plan.pictures {
                    let file = point.label().replace(' ', "_") + ".png";
                    picture.save(std::path::Path::new(folder).join(file));
                }
                if contender == Contender::Forward {
                    references.insert((arrangement, lights), picture);
                } else if let Some(reference) = references.get(&(arrangement, lights)) {
                    point.psnr = Some(metrics::pixel_difference(reference, &picture).psnr);
                }
            }
            eprintln!("{}", point.progress());
            figures.points.push(point);
        }
    }
}

/// Reason to leave out a point with `next` lights, after one with `lights` whose stage took `median` milliseconds.
fn reason_to_leave_out((lights, median): (u32, f64), next: u32, limit: f64) -> Option<String> {
    let expected = median * f64::from(next) / f64::from(lights);
    if median > limit {
        Some(format!("{lights} lights took {median:.0} ms"))
    } else if expected > NOT_TRIED {
        Some(format!("{expected:.0} ms are to be expected"))
    } else {
        None
    }
}

impl Stage {
    fn measure(
        &mut self,
        point: &mut Point,
        contender: Contender,
        arrangement: Arrangement,
        lights: u32,
        plan: &Plan,
    ) -> Picture {
        scene::replace_lights(self.headless.world(), arrangement, lights, plan);
        let began = Instant::now();
        let mut warm = 0;
        while warm < LEAST_FRAMES || (warm < plan.warm_up && began.elapsed() < LONGEST) {
            self.headless.frame();
            warm += 1;
        }

        let grown = list_growths();
        let mut samples = Samples::default();
        let mut frame_times = Vec::new();
        let began = Instant::now();
        // An even number of frames. With many lights Bevy's cluster grid changes from frame to frame, mostly between
        // two sizes: `dynamic_resizing` acts on the length of the last frame's lists, whatever its grid was. The median
        // of an even number is always that of the more expensive grid.
        while frame_times.len() < LEAST_FRAMES
            || frame_times.len() % 2 == 1
            || (frame_times.len() < plan.frames && began.elapsed() < LONGEST)
        {
            let start = Instant::now();
            self.headless.frame();
            frame_times.push(start.elapsed().as_secs_f64() * 1e3);
            samples.take(self.headless.app.world().resource::<DiagnosticsStore>());
            self.note_clusters(point);
        }
        let picture = self.headless.capture();

        point.frames = frame_times.len();
        point.stage = samples.time(contender.span());
        point.camera = samples.time(bench_spans::CAMERA);
        point.frame = Some(Time::of(frame_times));
        point.lists_grew = list_growths() > grown;
        picture
    }

    /// Records Bevy's clusters of this frame.
    fn note_clusters(&self, point: &mut Point) {
        let Some(clusters) = self.headless.app.world().get::<Clusters>(self.camera) else {
            return;
        };
        let grid = clusters.dimensions.to_array();
        if !point.grids.contains(&grid) {
            point.grids.push(grid);
        }
        let indices = clusters.last_frame_total_cluster_index_count.unwrap_or(0);
        point.longest_list = point.longest_list.max(indices);
    }
}

/// Number of times that Bevy has found its light lists too short so far.
fn list_growths() -> usize {
    messages_with("Resizing the view clustering").len()
}
