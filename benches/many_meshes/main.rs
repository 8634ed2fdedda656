//! CPU time of a frame with many meshes: Bevy forward, the same with this crate's plugins but no component, Bevy deferred,
//! this crate.
//!
//! `cargo bench --profile dev --bench many_meshes -- --help`
//!
//! Prints Markdown tables; `--json FILE` writes the same figures. Each frame has two times: that of the whole frame, and
//! that of the render world alone, from the start of extraction to the end of its schedule. The bench waits for the GPU
//! between frames, outside both.

mod run;
mod scene;
mod stages;

use bevy::math::UVec2;
use figures::benches::{Figures, ManyMeshes};
use kit::{bench_args::list, figures::write_json, size::parse_size};
use run::Contender;
use scene::Motion;

kit::bench_args! {
    /// CPU time of a frame with many meshes: Bevy forward, Bevy deferred, this crate.
    struct Args {
        /// numbers of meshes, comma-separated, default 1000,10000,100000
        #[argh(option, default = "String::from(\"1000,10000,100000\")")]
        meshes: String,

        /// only contenders whose name contains this, beside forward, the reference of the pictures
        #[argh(option, default = "String::new()")]
        contender: String,

        /// width x height of the picture, default 640x360
        #[argh(option, default = "UVec2::new(640, 360)", from_str_fn(parse_size))]
        size: UVec2,

        /// measured frames, default 60
        #[argh(option, default = "60")]
        frames: usize,

        /// how often each event is measured, default 3
        #[argh(option, default = "3")]
        events: usize,

        /// give all meshes render layers and NotShadowReceiver, and the camera motion vectors
        #[argh(switch)]
        followed: bool,

        /// write each picture into this folder
        #[argh(option)]
        pictures: Option<String>,
    }
}

fn main() {
    let args: Args = argh::from_env();
    let numbers = list(&args.meshes, str::parse::<usize>);
    let contenders: Vec<Contender> = Contender::ALL
        .into_iter()
        .filter(|contender| {
            *contender == Contender::Forward || contender.name().contains(&args.contender)
        })
        .collect();
    let mut measurements = ManyMeshes::default();
    let total = numbers.len();
    for (number, meshes) in numbers.into_iter().enumerate() {
        eprintln!("[{}/{total}] {meshes} meshes", number + 1);
        let measured = run::measure(
            meshes,
            &contenders,
            args.size,
            args.frames,
            args.events,
            args.followed,
        );
        let mut reference = None;
        for (contender, (mut measurement, picture)) in contenders.iter().zip(measured) {
            if let Some(folder) = &args.pictures {
                let file = format!("{meshes}_{}.png", contender.name().replace(' ', "_"));
                picture.save(std::path::Path::new(folder).join(file));
            }
            let reference = reference.get_or_insert(picture.clone());
            run::compare(&mut measurement, reference, &picture);
            eprintln!("{}: {:.2?}", contender.name(), measurement.turn_stages);
            measurements.0.push(measurement);
        }
        // After each contender, so that an interrupted run keeps its results.
        if let Some(path) = &args.json {
            write_json(path, &measurements);
        }
    }
    println!("{}", measurements.markdown());
}
