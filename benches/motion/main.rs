//! Screen-space reflections and GI in motion, beside Bevy's.
//!
//! `cargo bench --profile dev --bench motion -- --help`
//!
//! Renders paths of a camera and of things, and compares their frames with the converged effect at rest in the same pose. Then measures
//! the light of small bright lamps against integrals and closed forms. `docs/internals/motion.md` describes scenes and figures.

mod contender;
mod lamps;
mod run;

use bevy::math::UVec2;
use contender::Contender;
use figures::benches::{Figures, Motion};
use kit::{
    figures::write_json,
    motion::{paths::Path, yard::Subject},
    size::parse_size,
};

kit::bench_args! {
    /// Screen-space reflections and GI in motion, beside Bevy's.
    struct Args {
        /// only contenders whose name contains one of these, separated by semicolons
        #[argh(option, default = "String::new()")]
        contender: String,

        /// only these paths, comma-separated: walk, turn, strafe, look, car, door, lamp, flicker
        #[argh(option, default = "String::new()")]
        path: String,

        /// width x height of the picture, default 640x360
        #[argh(option, default = "UVec2::new(640, 360)", from_str_fn(parse_size))]
        size: UVec2,

        /// frames of a path, default 48
        #[argh(option, default = "48")]
        frames: usize,

        /// compare every so many frames with the truth, default 1
        #[argh(option, default = "1")]
        every: usize,

        /// frames at rest until the truth has converged, a multiple of 16, default 64
        #[argh(option, default = "64")]
        rest: usize,

        /// 192x144 pixels, 16 frames of a path, and 16 at rest: for software renderers
        #[argh(switch)]
        quick: bool,

        /// do not measure lamps
        #[argh(switch)]
        no_lamps: bool,

        /// write strips of frames into this folder: picture, truth and difference
        #[argh(option)]
        pictures: Option<String>,
    }
}

fn main() {
    let mut args: Args = argh::from_env();
    if args.quick {
        args.size = UVec2::new(192, 144);
        args.frames = 16;
        args.rest = 16;
    }
    // The lamp is on from a quarter of a path on.
    args.frames = args.frames.max(8);
    args.every = args.every.clamp(1, args.frames);
    let words: Vec<&str> = args.contender.split(';').collect();
    let paths: Vec<Path> = Path::ALL
        .into_iter()
        .filter(|path| args.path.is_empty() || args.path.split(',').any(|p| p == path.name()))
        .collect();
    let mut measured = Motion::default();
    for subject in Subject::ALL {
        for contender in Contender::ALL {
            let name = contender.name(subject);
            if !words.iter().any(|word| name.contains(word)) {
                continue;
            }
            run::measure(subject, contender, &paths, &args, |path| {
                measured.paths.push(path);
                write(&args, &measured);
            });
            if !args.no_lamps {
                lamps::measure(subject, contender, &args, |lamp| {
                    measured.lamps.push(lamp);
                    write(&args, &measured);
                });
            }
        }
    }
    println!("{}", measured.markdown());
}

/// Writes the figures after each measurement, so that an interrupted run keeps its results.
fn write(args: &Args, measured: &Motion) {
    if let Some(path) = &args.json {
        write_json(path, measured);
    }
}
