//! Hitches of a walk through a level in which features come and go one at a time: Bevy forward, Bevy deferred, this crate.
//!
//! `cargo bench --profile dev --bench stutter -- --help`
//!
//! Prints Markdown tables; `--json FILE` writes the same figures. Each renderer walks twice: with asynchronous compilation of pipelines, and
//! with synchronous compilation, which is the only one on macOS, on the web and without Bevy's feature `multi_threaded`. Each walk is a
//! process of its own, without the driver's cache on disk, so that no walk finds what another has compiled.

mod run;

use std::process::{Command, Stdio};

use bevy::math::UVec2;
use figures::benches::{Figures, Stutter, stutter::Measurement};
use kit::{figures::write_json, size::parse_size};
use run::{Contender, Extent};

kit::bench_args! {
    /// Hitches of a walk through a level in which features come and go: Bevy forward, Bevy deferred, this crate.
    struct Args {
        /// only the contenders with these names, comma-separated
        #[argh(option)]
        contender: Option<String>,

        /// only asynchronous or only synchronous compilation
        #[argh(option, default = "String::new()")]
        compilation: String,

        /// width x height of the picture, default 1920x1080
        #[argh(option, from_str_fn(parse_size))]
        size: Option<UVec2>,

        /// frames of a walk, default 600
        #[argh(option)]
        frames: Option<usize>,

        /// most frames per second, default 60; 0 for no limit
        #[argh(option, default = "60.0")]
        fps: f64,

        /// a small picture and few frames, for software renderers
        #[argh(switch)]
        quick: bool,

        /// run only the walk with this number and print its figures as JSON; the bench starts itself with it
        #[argh(option)]
        walk: Option<usize>,
    }
}

impl Args {
    fn extent(&self) -> Extent {
        let (size, frames) = match self.quick {
            true => (UVec2::new(160, 96), 144),
            false => (UVec2::new(1920, 1080), 600),
        };
        Extent {
            size: self.size.unwrap_or(size),
            frames: self.frames.unwrap_or(frames),
            fps: self.fps,
        }
    }

    fn chooses(&self, walk: Walk) -> bool {
        let names = self.contender.as_ref();
        names.is_none_or(|names| names.split(',').any(|name| name == walk.contender.name()))
            && walk.compilation().starts_with(&self.compilation)
    }
}

/// One contender with one kind of compilation.
#[derive(Clone, Copy)]
struct Walk {
    contender: Contender,
    synchronous: bool,
}

impl Walk {
    fn all() -> Vec<Self> {
        let compilations = [false, true].into_iter();
        let walks = compilations.flat_map(|synchronous| {
            Contender::ALL.map(|contender| Self {
                contender,
                synchronous,
            })
        });
        walks.collect()
    }

    fn compilation(self) -> &'static str {
        match self.synchronous {
            true => "synchronous",
            false => "asynchronous",
        }
    }
}

fn main() {
    let args: Args = argh::from_env();
    let walks = Walk::all();
    if let Some(walk) = args.walk {
        let Walk {
            contender,
            synchronous,
        } = walks[walk];
        let measurement = run::measure(contender, synchronous, args.extent());
        let json = serde_json::to_string(&measurement).expect("plain figures serialise");
        println!("{json}");
        return;
    }
    let chosen: Vec<_> = (walks.into_iter().enumerate())
        .filter(|(_, walk)| args.chooses(*walk))
        .collect();
    let total = chosen.len();
    let mut measurements = Stutter::default();
    for (done, (number, walk)) in chosen.into_iter().enumerate() {
        let (contender, compilation) = (walk.contender.name(), walk.compilation());
        eprintln!("[{}/{total}] {contender}, {compilation}", done + 1);
        let measurement = measure_alone(number).unwrap_or_else(|error| {
            eprintln!("{contender}, {compilation}: {error}");
            std::process::exit(1)
        });
        eprintln!("{:.0} ms of hitches", measurement.hitches);
        measurements.0.push(measurement);
        // After each walk, so that an interrupted run keeps its results.
        if let Some(path) = &args.json {
            write_json(path, &measurements);
        }
    }
    println!("{}", measurements.markdown());
}

/// Runs a walk in a process of its own, with the arguments of this one. The figures count, and not how the process ends: some drivers
/// fail if a process ends while they compile.
fn measure_alone(walk: usize) -> Result<Measurement, String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let output = Command::new(program)
        .args(std::env::args().skip(1))
        .args(["--walk", &walk.to_string()])
        .envs([
            ("MESA_SHADER_CACHE_DISABLE", "true"),
            ("__GL_SHADER_DISK_CACHE", "0"),
        ])
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout);
    let json = text.lines().last().unwrap_or_default();
    serde_json::from_str(json).map_err(|error| format!("{}, {error}", output.status))
}
