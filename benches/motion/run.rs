//! Films a contender on paths, and compares its frames with those at rest.

use figures::benches::motion::PathMeasurement;
use kit::{
    metrics::flip,
    motion::{
        film::{Shot, Shown, flicker, lag, rmse, strip, trail},
        paths::{Path, Pose},
        yard::{Subject, Yard},
    },
};

use crate::{Args, contender::Contender};

/// A pose at rest.
struct Still {
    pose: Pose,
    /// The contender, in two consecutive frames.
    rest: [Shown; 2],
    /// Its effect at its best, converged.
    truth: Shown,
}

/// Films `contender` on all `paths`.
pub fn measure(
    subject: Subject,
    contender: Contender,
    paths: &[Path],
    args: &Args,
    mut measured: impl FnMut(PathMeasurement),
) {
    if paths.is_empty() {
        return;
    }
    let yard = |at_best: bool| {
        Yard::new(args.size, subject, |camera| {
            contender.dress(subject, at_best, camera);
        })
    };
    let (mut own, mut best) = (yard(false), yard(true));
    for path in paths {
        eprintln!(
            "{}, {}, {}",
            subject.name(),
            contender.name(subject),
            path.name()
        );
        measured(film(subject, contender, *path, args, &mut own, &mut best));
    }
}

fn film(
    subject: Subject,
    contender: Contender,
    path: Path,
    args: &Args,
    own: &mut Yard,
    best: &mut Yard,
) -> PathMeasurement {
    let poses: Vec<Pose> = (0..=args.frames)
        .map(|frame| path.pose(frame, args.frames))
        .collect();
    own.rest(&poses[0], args.rest);
    let pictures: Vec<Shown> = poses
        .iter()
        .map(|pose| {
            own.pose(pose);
            Shown::of(&own.frame())
        })
        .collect();
    let compared: Vec<usize> = (args.every..=args.frames).step_by(args.every).collect();
    let switches = path.switches(args.frames);
    let around = switches
        .into_iter()
        .flatten()
        .flat_map(|switch| [switch - 1, switch]);
    let mut stills: Vec<Still> = Vec::new();
    for frame in compared.iter().copied().chain(around) {
        let pose = poses[frame];
        if stills.iter().all(|still| still.pose != pose) {
            stills.push(Still {
                pose,
                rest: own.rest(&pose, args.rest).map(|light| Shown::of(&light)),
                truth: Shown::of(&best.converged(&pose, args.rest)),
            });
        }
    }
    let still = |frame: usize| {
        let found = stills.iter().find(|still| still.pose == poses[frame]);
        found.expect("its pose was held")
    };
    let shots: Vec<Shot> = compared
        .iter()
        .map(|frame| Shot {
            picture: &pictures[*frame],
            rest: &still(*frame).rest[1],
            truth: &still(*frame).truth,
        })
        .collect();
    let source = own.lamp_pixels();
    let lags = switches.map(|[on, off]| {
        [(on, off), (off, pictures.len())].map(|(from, to)| {
            let [before, after] = [from - 1, from].map(|frame| &still(frame).rest[1]);
            lag(&pictures[from..to], before, after, &source)
        })
    });
    if let Some(folder) = &args.pictures {
        let name = format!(
            "{}_{}_{}.png",
            subject.name(),
            path.name(),
            contender.name(subject)
        );
        let file = name.replace([' ', ','], "_");
        strip_of(&shots).save(std::path::Path::new(folder).join(file));
    }
    let at_rest: Vec<f32> = stills
        .iter()
        .map(|still| rmse(&still.rest[0], &still.rest[1]))
        .collect();
    PathMeasurement {
        device: own.headless().adapter_and_driver(),
        size: args.size.to_array(),
        subject: subject.name().into(),
        contender: contender.name(subject).into(),
        path: path.name().into(),
        frames: compared,
        rmse: shots
            .iter()
            .map(|shot| rmse(shot.picture, shot.truth))
            .collect(),
        rest: shots
            .iter()
            .map(|shot| rmse(shot.rest, shot.truth))
            .collect(),
        flip: shots
            .iter()
            .map(|shot| flip(&shot.truth.picture(), &shot.picture.picture()) as f32)
            .collect(),
        flicker: flicker(&shots),
        flicker_at_rest: at_rest.into_iter().fold(0.0, f32::max),
        trail: trail(&shots) * args.every,
        lag: lags.map(|[on, off]| on.max(off)),
    }
}

/// Shots of a strip.
const STRIP: usize = 6;

/// Pictures of evenly spaced shots, their truths, and differences.
fn strip_of(shots: &[Shot]) -> kit::headless::Picture {
    let step = shots.len().div_ceil(STRIP).max(1);
    let shown = || shots.iter().step_by(step);
    strip(&[
        shown()
            .map(|shot| shot.picture.picture())
            .collect::<Vec<_>>(),
        shown().map(|shot| shot.truth.picture()).collect(),
        shown()
            .map(|shot| shot.picture.difference(shot.truth).picture())
            .collect(),
    ])
}
