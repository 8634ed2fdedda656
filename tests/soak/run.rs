//! A run, and its shrinking.

use std::{
    ops::Range,
    process::{Command, Stdio},
};

use kit::{gpu_usage::GpuUsage, log_watch, random::Random, stalled_pipelines::StalledPipelines};

use crate::{cameras, checks, held::assert_it_does_not_climb, scene, stage::Stage, surroundings};

/// Frames between two checks for NaN and infinities.
const NUMBERS: usize = 16;
/// Frames between two comparisons with forward, mesh by mesh.
const TWINS: usize = 64;
/// Frames after which everything is removed and created again.
const EPOCH: usize = 64;
/// Frames per process: llvmpipe keeps up to 35 MB of each until the process ends. Two epochs, so that the second shows what the first has
/// left.
const LEG: usize = 2 * EPOCH;

/// Names the requested frames: `500`, or `128..256`.
pub const FRAMES: &str = "SOAK_FRAMES";

/// Settings from the environment: `SOAK_SEED`, [`SOAK_FRAMES`](FRAMES) (128), `SOAK_ONLY` (numbers of frames that change anything,
/// separated by commas), `SOAK_FORWARD` (Bevy alone), `SOAK_VERBOSE` (each change is printed).
pub struct Run {
    pub seed: u64,
    frames: Range<usize>,
    only: Option<Vec<usize>>,
    is_lean: bool,
    is_verbose: bool,
}

fn number(name: &str, text: &str) -> usize {
    let number = text.parse();
    number.unwrap_or_else(|_| panic!("{name}: {text} is no number"))
}

fn frames() -> Range<usize> {
    let text = std::env::var(FRAMES).unwrap_or_else(|_| LEG.to_string());
    let (start, end) = text.split_once("..").unwrap_or(("0", &text));
    number(FRAMES, start)..number(FRAMES, end)
}

fn legs_of(frames: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let end = frames.end;
    frames
        .step_by(LEG)
        .map(move |start| start..(start + LEG).min(end))
}

fn text(frames: &Range<usize>) -> String {
    format!("{}..{}", frames.start, frames.end)
}

/// The requested frames in parts, each for a process of its own. The parts are independent: each starts from the beginning.
pub fn legs() -> impl Iterator<Item = String> {
    legs_of(frames()).map(|leg| text(&leg))
}

impl Run {
    pub fn of_environment(seed: u64) -> Self {
        let only = std::env::var("SOAK_ONLY").ok();
        let asked = std::env::var("SOAK_SEED").ok();
        Self {
            seed: asked.map_or(seed, |asked| number("SOAK_SEED", &asked) as u64),
            frames: frames(),
            only: only.map(|only| only.split(',').filter_map(|f| f.parse().ok()).collect()),
            is_lean: std::env::var_os("SOAK_FORWARD").is_none(),
            is_verbose: std::env::var_os("SOAK_VERBOSE").is_some(),
        }
    }

    fn changes_in(&self, frame: usize) -> bool {
        self.only.as_ref().is_none_or(|only| only.contains(&frame))
    }
}

pub fn run(run: &Run) {
    let is_synchronous = run.seed % 3 != 2;
    let mut stage = Stage::new(run.is_lean, is_synchronous);
    let mut held: Vec<GpuUsage> = Vec::new();
    let mut stalled_pipelines: Option<(StalledPipelines, usize)> = None;
    for frame in run.frames.clone() {
        let mut random = Random::new((run.seed << 32) + frame as u64);
        if !is_synchronous {
            match &mut stalled_pipelines {
                Some((_, frames)) if *frames > 0 => *frames -= 1,
                Some(_) => stalled_pipelines = None,
                None if random.below(12) == 0 => {
                    stalled_pipelines = Some((StalledPipelines::new(), 10))
                }
                None => {}
            }
        }
        if run.changes_in(frame) {
            for _ in 0..random.below(3) {
                let change = match random.below(5) {
                    0 | 1 => scene::change(&mut stage, &mut random),
                    2 | 3 => cameras::change(&mut stage, &mut random),
                    _ => surroundings::change(&mut stage, &mut random),
                };
                if run.is_verbose {
                    println!("frame {frame}: {change}");
                }
            }
        }
        stage.headless.frame();
        let errors = log_watch::messages_with("Caught rendering error");
        assert!(errors.is_empty(), "frame {frame}: {}", errors.join("\n"));
        if run.is_lean && frame % NUMBERS == NUMBERS - 1 {
            drop(stalled_pipelines.take());
            checks::check(&mut stage, frame, frame % TWINS == TWINS - 1);
        }
        if frame % EPOCH == EPOCH - 1 || frame + 1 == run.frames.end {
            drop(stalled_pipelines.take());
            stage.clear();
            held.push(GpuUsage::once_settled(&mut stage.headless));
            println!("frame {frame}: {:?}", held.last());
            stage.fill();
        }
    }
    assert_it_does_not_climb(&held);
    log_watch::assert_validation_layer_silent();
}

/// True if a run with changes in these frames fails, in a process of its own.
fn fails(seed: u64, frames: &Range<usize>, only: &[usize], is_lean: bool) -> bool {
    let only: Vec<String> = only.iter().map(usize::to_string).collect();
    let mut command = Command::new(std::env::current_exe().expect("a test is a program"));
    command
        .args(["first_seed", "--exact"])
        .env("SOAK_SEED", seed.to_string())
        .env(FRAMES, text(frames))
        .env("SOAK_ONLY", only.join(","))
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    if !is_lean {
        command.env("SOAK_FORWARD", "1");
    }
    !command.status().expect("it runs again").success()
}

/// Removes ever smaller parts of the frames while the run still fails (Zeller and Hildebrandt 2002, "Simplifying and Isolating
/// Failure-Inducing Input").
pub fn shrink(seed: u64) {
    let run = Run::of_environment(seed);
    let seed = run.seed;
    let changing = |frames: &Range<usize>| -> Vec<usize> {
        frames.clone().filter(|f| run.changes_in(*f)).collect()
    };
    let failing = legs_of(run.frames.clone()).find(|leg| fails(seed, leg, &changing(leg), true));
    let Some(mut frames) = failing else {
        println!(
            "seed {seed} does not fail in the frames {}",
            text(&run.frames)
        );
        return;
    };
    let mut only = changing(&frames);
    // Searches the first frame after which it fails.
    let mut fine = frames.start;
    while fine + 1 < frames.end {
        let middle = fine.midpoint(frames.end);
        if fails(seed, &(frames.start..middle), &only, true) {
            frames.end = middle;
        } else {
            fine = middle;
        }
    }
    only.retain(|frame| frames.contains(frame));
    let mut part = only.len().div_ceil(2);
    while part > 0 {
        let mut at = 0;
        while at < only.len() {
            let mut fewer = only.clone();
            fewer.drain(at..(at + part).min(only.len()));
            if fails(seed, &frames, &fewer, true) {
                only = fewer;
                println!("{} frames with changes left", only.len());
            } else {
                at += part;
            }
        }
        part /= 2;
    }
    let list: Vec<String> = only.iter().map(usize::to_string).collect();
    println!(
        "SOAK_SEED={seed} {FRAMES}={} SOAK_ONLY={} SOAK_VERBOSE=1 cargo test --test soak first_seed -- --nocapture",
        text(&frames),
        list.join(",")
    );
    if fails(seed, &frames, &only, false) {
        println!("Bevy alone fails there too (SOAK_FORWARD=1)");
    }
}
