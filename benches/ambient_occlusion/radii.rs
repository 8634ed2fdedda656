//! Times by the radius on the screen: of a floor that fills the view, from several heights.

use bevy::{prelude::*, render::RenderApp};
use bevy_lean_deferred::effects::TimesEachDispatch;
use kit::gpu_time::Samples;

use crate::{
    Args,
    contender::Contender,
    run,
    scene::{BenchScene, RADIUS},
};

/// Heights of the eye, in metres.
const EYES: [f64; 6] = [16.0, 8.0, 4.0, 2.735, 2.0, 1.0];
const SPARSE_DEPTH: &str = "lean_deferred/effects/ambient_occlusion/sparse_depth";
/// The span of both passes, unless each dispatch is timed.
const GATHER: &str = "lean_deferred/effects/ambient_occlusion/gather";
const LIGHTING: &str = "lean_deferred/lighting";

/// Prints a table: passes, the first of them alone, and what lighting takes more than without occlusion.
pub fn measure(contenders: &[Contender], sizes: &[UVec2], args: &Args) {
    println!("| | size | radius | passes | of it sparse depth | lighting |");
    println!("|---|---|---|---|---|---|");
    for (size, eye) in sizes.iter().flat_map(|size| EYES.map(|eye| (*size, eye))) {
        let radius = mean_radius(size, eye);
        let mut unoccluded = 0.0;
        for contender in contenders.iter().filter(|contender| contender.lean) {
            let samples = samples(contender, eye, size, args, false);
            let time = |name| samples.time(name).map_or(f64::NAN, |time| time.median);
            let lighting = time(LIGHTING);
            if contender.occlusion.is_none() {
                unoccluded = lighting;
                continue;
            }
            let one_by_one = self::samples(contender, eye, size, args, true);
            let sparse_depth = one_by_one.time(SPARSE_DEPTH);
            println!(
                "| {} | {}×{} | {radius:.0} | {:.3} | {:.3} | {:.3} |",
                contender.name,
                size.x,
                size.y,
                time(GATHER),
                sparse_depth.map_or(0.0, |time| time.median),
                lighting - unoccluded,
            );
        }
    }
}

/// Pixels of the radius in the middle of the picture. Effects may clamp it.
fn mean_radius(size: UVec2, eye: f64) -> f64 {
    let pixels_per_ray = 0.5 * f64::from(size.y) / (core::f64::consts::PI / 8.0).tan();
    let distance = eye * core::f64::consts::SQRT_2;
    RADIUS * pixels_per_ray / distance
}

/// Times of the measured frames. `one_by_one`: of each dispatch.
fn samples(contender: &Contender, eye: f64, size: UVec2, args: &Args, one_by_one: bool) -> Samples {
    let mut headless = run::app(contender, BenchScene::Floor(eye), size, false);
    if one_by_one {
        let render_app = headless.app.sub_app_mut(RenderApp);
        render_app.insert_resource(TimesEachDispatch);
    }
    headless.settle();
    Samples::of_frames(&mut headless, args.warm_up, args.frames)
}
