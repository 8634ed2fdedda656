//! GPU time, bytes and error of screen-space lighting effects.
//!
//! `cargo bench --profile dev --bench screen_space -- --help`
//!
//! Times are of the boxes of `frame_times`, errors of scenes whose light has a closed form. One table has both.

mod contender;
mod run;

use contender::Contender;
use figures::benches::{Figures, ScreenSpace};
use kit::{bench_args::list, figures::write_json, size::parse_size};

kit::bench_args! {
    /// GPU time, bytes and error of screen-space lighting effects.
    struct Args {
        /// only contenders whose name contains one of these, separated by semicolons, beside the one without effects
        #[argh(option, default = "String::new()")]
        contender: String,

        /// sizes of the picture, comma-separated, default 1920x1080,3840x2160
        #[argh(option, default = "String::from(\"1920x1080,3840x2160\")")]
        size: String,

        /// measured frames, default 40
        #[argh(option, default = "40")]
        frames: usize,

        /// warm-up frames, default 15
        #[argh(option, default = "15")]
        warm_up: usize,

        /// write each picture of the boxes into this folder
        #[argh(option)]
        pictures: Option<String>,

        /// time a scene of few meshes, for software renderers
        #[argh(switch)]
        small: bool,

        /// do not measure errors
        #[argh(switch)]
        no_errors: bool,
    }
}

fn main() {
    let args: Args = argh::from_env();
    let sizes = list(&args.size, parse_size);
    let words: Vec<&str> = args.contender.split(';').collect();
    let contenders: Vec<Contender> = Contender::all()
        .into_iter()
        .filter(|c| c.is_plain() || words.iter().any(|word| c.name().contains(word)))
        .collect();
    let total = contenders.len();
    let mut measurements = ScreenSpace::default();
    // Not kept: GPUs raise their clocks only after a while.
    if let [first, ..] = contenders[..] {
        run::measure(first, sizes[0], &args, Vec::new());
    }
    for (number, contender) in contenders.into_iter().enumerate() {
        eprintln!("[{}/{total}] {}", number + 1, contender.name());
        let mut known = None;
        for size in sizes.iter().copied() {
            let size_of_errors = run::size_of_errors(contender, size);
            let errors = match known.take().filter(|(of, _)| *of == size_of_errors) {
                Some((_, errors)) => errors,
                None if args.no_errors => Vec::new(),
                None => run::errors(contender, size_of_errors),
            };
            measurements
                .0
                .push(run::measure(contender, size, &args, errors.clone()));
            known = Some((size_of_errors, errors));
            // After each contender, so that an interrupted run keeps its results.
            if let Some(path) = &args.json {
                write_json(path, &measurements);
            }
        }
    }
    println!("{}", measurements.markdown());
}
