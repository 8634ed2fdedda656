//! GPU time, bytes and error of ambient occlusion: this crate's presets, Bevy's, and the naive version.
//!
//! `cargo bench --profile dev --bench ambient_occlusion -- --help`
//!
//! Each contender runs in two scenes: `courtyard`, where every pixel has work to do, and `wall`, a floor before an endless
//! wall, whose occlusion has a closed form. One table has both time and error. To add a peer, add a [`Contender`].

mod contender;
mod naive;
mod radii;
mod run;
mod scene;
mod show;

use contender::Contender;
use figures::benches::{AmbientOcclusion, Figures};
use kit::{bench_args::list, figures::write_json, size::parse_size};

kit::bench_args! {
    /// GPU time, bytes and error of ambient occlusion.
    struct Args {
        /// only contenders whose name contains one of these, separated by semicolons, beside those without occlusion; a
        /// word after = is a whole name
        #[argh(option, default = "String::new()")]
        contender: String,

        /// sizes of the picture, comma-separated, default 1400x1050,1920x1080,3840x2160
        #[argh(option, default = "String::from(\"1400x1050,1920x1080,3840x2160\")")]
        size: String,

        /// measured frames, default 40
        #[argh(option, default = "40")]
        frames: usize,

        /// warm-up frames, default 15
        #[argh(option, default = "15")]
        warm_up: usize,

        /// write each picture of occlusion into this folder
        #[argh(option)]
        pictures: Option<String>,

        /// time a floor that fills the view, with mean radii of 58 to 922 pixels at 3840×2160 and in proportion at other
        /// sizes, in place of the scenes
        #[argh(switch)]
        radii: bool,

        /// time a scene of few meshes, for software renderers
        #[argh(switch)]
        small: bool,
    }
}

fn main() {
    let args: Args = argh::from_env();
    let sizes = list(&args.size, parse_size);
    let words: Vec<&str> = args.contender.split(';').collect();
    let contenders: Vec<Contender> = Contender::all()
        .into_iter()
        .filter(|c| c.occlusion.is_none() || words.iter().any(|word| is_meant(&c.name, word)))
        .collect();

    if args.radii {
        radii::measure(&contenders, &sizes, &args);
        return;
    }
    let mut measurements = AmbientOcclusion::default();
    let mut truths = run::Truths::new();
    let total = sizes.len() * contenders.len();
    // Not kept: GPUs raise their clocks only after a while.
    for first in contenders.iter().take(2) {
        run::measure(first, sizes[0], &args, &mut truths);
    }
    for size in sizes.iter().copied() {
        for contender in &contenders {
            eprintln!(
                "[{}/{total}] {}×{}: {}",
                measurements.0.len() + 1,
                size.x,
                size.y,
                contender.name
            );
            let measurement = run::measure(contender, size, &args, &mut truths);
            measurements.0.push(measurement);
            // After each contender, so that an interrupted run keeps its results.
            if let Some(path) = &args.json {
                write_json(path, &measurements);
            }
        }
    }
    println!("{}", measurements.markdown());
}

fn is_meant(name: &str, word: &str) -> bool {
    match word.strip_prefix('=') {
        Some(whole) => name == whole,
        None => name.contains(word),
    }
}
