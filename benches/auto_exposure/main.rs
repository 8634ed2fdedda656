//! GPU time, bandwidth and error of auto exposure: this crate's, a pyramid of three passes, and Bevy's.
//!
//! `cargo bench --profile dev --bench auto_exposure -- --help`
//!
//! All contenders meter the same picture. The table also has the times to copy it and to read it, and the error against its
//! mean in double precision. Times cover:
//!
//! - Outside an app: one compute pass of one dispatch from begin to end, by the timestamps of the pass. The begin waits for
//!   all earlier commands, so gaps, barriers before the pass and other passes do not count. On software renderers: from
//!   submitting the pass until it has finished, by the CPU's clock. Copies of the picture in many textures take turns, so
//!   that caches do not hold it.
//! - In an app: a span of the command encoder around the pass, with its barriers. There the frame has just drawn the
//!   picture, and caches may hold a part of it.

mod bounds;
mod in_app;
mod kernel;
mod lean;
mod picture;
mod pyramid;
mod ring;
mod timing;

use bevy::math::UVec2;
use figures::benches::{
    AutoExposure, Figures,
    auto_exposure::{Group, Measurement, Size},
};
use kit::{
    bench_args::list, exposure_gpu::ExposureGpu, figures::write_json, gpu::device_of,
    size::parse_size,
};
use picture::{Picture, Truth};
use ring::Ring;

kit::bench_args! {
    /// GPU time, bandwidth and error of auto exposure.
    struct Args {
        /// only contenders whose name contains one of these, separated by semicolons, beside the copies
        #[argh(option, default = "String::new()")]
        contender: String,

        /// sizes of the picture, comma-separated, default 1920x1080,3840x2160,7680x4320
        #[argh(option, default = "String::from(\"1920x1080,3840x2160,7680x4320\")")]
        size: String,

        /// measured frames, default 100
        #[argh(option, default = "100")]
        frames: usize,

        /// warm-up frames, default 50
        #[argh(option, default = "50")]
        warm_up: usize,

        /// megabytes of pictures that take turns, default 256 (at least 2 pictures, at most 16); 0 is one picture
        #[argh(option, default = "256")]
        ring_mb: u64,

        /// meter a single grey instead of gradients, noise and lights
        #[argh(switch)]
        flat: bool,
    }
}

impl Args {
    fn wants(&self, contender: &str) -> bool {
        self.contender
            .split(';')
            .any(|word| contender.contains(word))
    }
}

fn main() {
    let args: Args = argh::from_env();
    let fail = |text: String| -> ! {
        eprintln!("{text}");
        std::process::exit(1);
    };
    let sizes = list(&args.size, parse_size);
    if args.frames == 0 {
        fail("--frames: at least 1".into());
    }
    let mut figures = AutoExposure::default();
    let total = sizes.len();
    for (number, size) in sizes.into_iter().enumerate() {
        eprintln!("[{}/{total}] {}×{}", number + 1, size.x, size.y);
        let measured = measure(size, &args).unwrap_or_else(|error| fail(error));
        figures.0.push(measured);
        // After each contender, so that an interrupted run keeps its results.
        if let Some(path) = &args.json {
            write_json(path, &figures);
        }
    }
    println!("{}", figures.markdown());
}

/// Measures all contenders at one size.
fn measure(size: UVec2, args: &Args) -> Result<Size, String> {
    let gpu = ExposureGpu::new();
    if !gpu.has(wgpu::Features::TIMESTAMP_QUERY) {
        return Err(format!("{} has no timestamps", gpu.adapter.name));
    }
    let picture = if args.flat {
        Picture::flat(size)
    } else {
        Picture::new(size)
    };
    let truth = Truth::new(&picture, &picture::mask());
    let ring = Ring::new(&gpu, &picture, args.ring_mb);
    let pictures = ring.0.len();
    let mut measurements = bounds::measure(&gpu, &ring, args);
    measurements.extend(outside(&gpu, &ring, size, &truth, args));
    let device = device_of(&gpu.adapter);
    // The app creates a device of its own.
    drop((ring, gpu));
    measurements.extend(in_app::measure(picture, &truth, args));
    Ok(Size {
        device,
        frames: Some(args.frames),
        size: size.to_array(),
        pictures,
        measurements,
    })
}

/// Measures the contenders outside an app.
fn outside(
    gpu: &ExposureGpu,
    ring: &Ring,
    size: UVec2,
    truth: &Truth,
    args: &Args,
) -> Vec<Measurement> {
    let paths = [(true, "subgroups"), (false, "shared memory")];
    let paths = paths
        .into_iter()
        .filter(|(subgroups, _)| !subgroups || gpu.has_subgroups());
    let bytes = size.as_dvec2().element_product() * picture::TEXEL as f64;
    let mut measurements = Vec::new();
    for (settings_name, settings) in lean::contenders() {
        for (subgroups, path) in paths.clone() {
            let contender = format!("{settings_name}, {path}");
            if !args.wants(&contender) {
                continue;
            }
            eprintln!("{contender}");
            let measured = lean::measure(gpu, ring, &settings, subgroups, args);
            measurements.push(Measurement {
                group: Group::Lean,
                contender,
                passes: measured.passes,
                whole: measured.whole,
                bytes,
                luminance: Some(measured.luminance),
                error: Some(measured.luminance / truth.of(&settings) - 1.0),
            });
        }
    }
    for (subgroups, path) in paths {
        let contender = format!("pyramid, {path}");
        if !args.wants(&contender) {
            continue;
        }
        eprintln!("{contender}");
        let measured = pyramid::measure(gpu, ring, subgroups, args);
        let expected = truth.of(&Default::default());
        measurements.push(Measurement {
            group: Group::Pyramid,
            contender,
            passes: measured.passes,
            whole: measured.whole,
            bytes,
            luminance: Some(measured.luminance),
            error: Some(measured.luminance / expected - 1.0),
        });
    }
    measurements
}
