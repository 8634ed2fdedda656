//! GPU time, bytes and error of a frame: Bevy forward, Bevy deferred, this crate.
//!
//! `cargo bench --profile dev --bench frame_times -- --help`
//!
//! Prints a Markdown table; `--json FILE` writes the same figures. Times come from GPU timestamp queries; on a software
//! renderer they are CPU times. To measure a further effect, add a [`Contender`] or a [`BenchScene`].

mod run;
mod scenes;
mod special;

use std::{sync::Arc, thread::JoinHandle};

use bevy::math::UVec2;
use figures::benches::{Figures, FrameTimes};
use kit::{figures::write_json, headless::Picture, size::parse_size};
use run::{Contender, Difference};
use scenes::BenchScene;

kit::bench_args! {
    /// GPU time, bytes and error of a frame: Bevy forward, Bevy deferred, this crate.
    struct Args {
        /// only scenes whose name contains one of these words, comma-separated
        #[argh(option, default = "String::new()")]
        scene: String,

        /// only the contenders with these names, comma-separated; forward, the first, is the reference of the others
        #[argh(option)]
        contender: Option<String>,

        /// width x height of the picture, default 3840x2160
        #[argh(option, default = "UVec2::new(3840, 2160)", from_str_fn(parse_size))]
        size: UVec2,

        /// measured frames, default 40
        #[argh(option, default = "40")]
        frames: usize,

        /// warm-up frames, default 15
        #[argh(option, default = "15")]
        warm_up: usize,

        /// write each picture into this folder
        #[argh(option)]
        pictures: Option<String>,

        /// glTF or GLB files to measure beside the built-in scenes, comma-separated
        #[argh(option, default = "String::new()")]
        gltf: String,

        /// glTF or GLB file to measure as a crowd, with 64 and with 512 lights
        #[argh(option)]
        crowd: Option<String>,

        /// leave out FLIP, which takes seconds per picture at 4K
        #[argh(switch)]
        no_flip: bool,
    }
}

fn main() {
    let args: Args = argh::from_env();
    let scenes: Vec<BenchScene> = scenes::all(&args.gltf, args.crowd.as_deref())
        .into_iter()
        .filter(|scene| {
            let mut words = args.scene.split(',');
            words.any(|word| scene.name.contains(word))
        })
        .collect();
    let contenders: Vec<Contender> = Contender::ALL
        .into_iter()
        .filter(|c| {
            let names = args.contender.as_ref();
            names.is_none_or(|names| names.split(',').any(|name| name == c.name()))
        })
        .collect();

    let is_measured =
        |scene: &BenchScene, contender: Contender| !scene.is_special() || contender.is_plain();
    let total = scenes
        .iter()
        .map(|scene| {
            contenders
                .iter()
                .filter(|c| is_measured(scene, **c))
                .count()
        })
        .sum::<usize>();
    let mut measurements = FrameTimes::default();
    let mut comparisons = Comparisons::default();
    let keep = |measurements: &FrameTimes| {
        // After each contender, so that an interrupted run keeps its results.
        if let Some(path) = &args.json {
            write_json(path, measurements);
        }
    };
    for scene in &scenes {
        let mut reference = None;
        for contender in contenders.iter().filter(|c| is_measured(scene, **c)) {
            let number = measurements.0.len();
            eprintln!(
                "[{}/{total}] {}: {}",
                number + 1,
                scene.name,
                contender.name()
            );
            let (measurement, picture) =
                run::measure(scene, *contender, args.size, args.warm_up, args.frames);
            eprintln!("{}", FrameTimes::row(&measurement));
            measurements.0.push(measurement);
            if let Some(folder) = &args.pictures {
                let file = format!("{}_{}.png", scene.name, contender.name().replace(' ', "_"));
                picture.save(std::path::Path::new(folder).join(file));
            }
            let picture = Arc::new(picture);
            match &reference {
                None if *contender == Contender::Forward => reference = Some(picture),
                None => {}
                Some(reference) => {
                    comparisons.start(number, reference.clone(), picture, !args.no_flip);
                }
            }
            comparisons.take(&mut measurements, JoinHandle::is_finished);
            keep(&measurements);
        }
    }
    comparisons.take(&mut measurements, |_| true);
    keep(&measurements);
    println!("{}", measurements.markdown());
}

/// Comparisons of pictures that run while others are rendered: FLIP takes seconds at 4K, but no GPU time.
#[derive(Default)]
struct Comparisons(Vec<(usize, JoinHandle<Difference>)>);

impl Comparisons {
    fn start(&mut self, number: usize, reference: Arc<Picture>, picture: Arc<Picture>, flip: bool) {
        let compare = move || Difference::of(&reference, &picture, flip);
        self.0.push((number, std::thread::spawn(compare)));
    }

    /// Waits for the differences that `is_due` selects, and writes them into their measurements.
    fn take(
        &mut self,
        measurements: &mut FrameTimes,
        is_due: impl Fn(&JoinHandle<Difference>) -> bool,
    ) {
        for (number, comparison) in self.0.extract_if(.., |(_, comparison)| is_due(comparison)) {
            let difference = comparison.join().expect("pictures have one size");
            difference.write_into(&mut measurements.0[number]);
        }
    }
}
