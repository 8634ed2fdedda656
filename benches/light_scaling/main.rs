//! Cost of lighting over the number of lights: Bevy forward, Bevy deferred, this crate.
//!
//! `cargo bench --profile dev --bench light_scaling -- --help`
//!
//! Prints a Markdown table; `--json FILE` writes the same figures. Times come from GPU timestamp queries.

mod contender;
mod plan;
mod run;
mod scene;

use contender::Contender;
use figures::benches::{Figures, LightScaling};
use kit::{bench_args::list, figures::write_json, size::parse_size};
use plan::Plan;
use run::References;

kit::bench_args! {
    /// Cost of lighting over the number of lights: Bevy forward, Bevy deferred, this crate.
    struct Args {
        /// numbers of lights, comma-separated, default 16,64,256,1024,4096,16384
        #[argh(option, default = "String::from(\"16,64,256,1024,4096,16384\")")]
        lights: String,

        /// sizes of the picture, comma-separated, default 1920x1080,3840x2160
        #[argh(option, default = "String::from(\"1920x1080,3840x2160\")")]
        sizes: String,

        /// contenders with these names, comma-separated, default Bevy forward, Bevy deferred and lean; others are lean per
        /// pixel, lean culling by subgroups and lean culling in shared memory
        #[argh(option)]
        contender: Option<String>,

        /// most frames to measure, default 16; fewer if they are slow, at least 4; always even
        #[argh(option, default = "16")]
        frames: usize,

        /// warm-up frames, default 8; fewer if they are slow, at least 4
        #[argh(option, default = "8")]
        warm_up: usize,

        /// once the median of a stage takes more milliseconds than this, larger numbers of lights are left out, default 400
        #[argh(option, default = "400.0")]
        limit_ms: f64,

        /// reduce the scene to a quarter each way, for software renderers
        #[argh(switch)]
        small: bool,

        /// keep the resolution of Bevy's grid of clusters, however long its lists of lights are
        #[argh(switch)]
        fixed_grid: bool,

        /// memory bandwidth of the GPU in TB/s, for the bandwidth limit in plots
        #[argh(option)]
        bandwidth: Option<f64>,

        /// write each picture into this folder
        #[argh(option)]
        pictures: Option<String>,
    }
}

fn main() {
    let args: Args = argh::from_env();
    println!("{}", measure(&args).markdown());
}

fn measure(args: &Args) -> LightScaling {
    let sizes = list(&args.sizes, parse_size);
    let mut lights = list(&args.lights, |text| {
        let number = text.parse::<u32>().ok().filter(|number| *number > 0);
        number.ok_or(format!("not a number of lights: {text}"))
    });
    lights.sort_unstable();
    let mut contenders = match &args.contender {
        None => Contender::ALL[..Contender::BY_DEFAULT].to_vec(),
        Some(names) => list(names, |name| {
            Contender::named(name).ok_or(format!("no contender has the name {name}"))
        }),
    };
    contenders.sort_by_key(|c| c.index());
    let plan = Plan {
        lights,
        frames: args.frames,
        warm_up: args.warm_up,
        limit: args.limit_ms,
        small: args.small,
        fixed_grid: args.fixed_grid,
        pictures: args.pictures.clone(),
    };

    let mut figures = LightScaling {
        bandwidth: args.bandwidth,
        ..LightScaling::default()
    };
    let mut steps = 1..;
    let total = sizes.len() * contenders.len();
    for size in sizes {
        let mut references = References::default();
        for (contender, step) in contenders.iter().zip(&mut steps) {
            eprintln!(
                "[{step}/{total}] {}×{}: {}",
                size.x,
                size.y,
                contender.name()
            );
            run::measure(*contender, size, &plan, &mut references, &mut figures);
            // After each point, so that an interrupted run keeps its results.
            if let Some(path) = &args.json {
                write_json(path, &figures);
            }
        }
    }
    figures
}
