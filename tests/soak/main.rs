//! Apps that change at random for as long as one likes: nothing fails, no mesh is lost, no number is wrong, and nothing is held for
//! ever.
//!
//! A run follows from its seed and the number of its frame alone, so frames can be left out: that is how a run that fails is
//! shrunk. See [`run`] for what the environment may ask for.

mod cameras;
mod checks;
mod held;
mod run;
mod scene;
mod stage;
mod surroundings;

use held::{Coming, left_by};
use kit::own_process::{in_own_process, in_own_processes};
use run::{FRAMES, Run, legs, run};

/// Seeds that every run of the tests has. One of them compiles shaders while frames go on, as apps do.
const SEEDS: [u64; 3] = [1, 2, 3];

fn check(seed: u64) {
    run(&Run::of_environment(seed));
}

#[test]
fn first_seed() {
    in_own_processes(FRAMES, legs(), || check(SEEDS[0]));
}

#[test]
fn second_seed() {
    in_own_processes(FRAMES, legs(), || check(SEEDS[1]));
}

#[test]
fn third_seed() {
    in_own_processes(FRAMES, legs(), || check(SEEDS[2]));
}

/// Bevy 0.19.1 never gives back the bind groups that it made for the phases of a view: 30 for a camera, 16 for a light with shadows.
/// Lean cameras with all effects leave no more than that, whatever comes and goes.
#[test]
fn what_comes_and_goes_leaves_what_bevy_leaves() {
    in_own_process(|| {
        for what in Coming::ALL {
            let [forward, mut lean] = [false, true].map(|is_lean| left_by(what, is_lean));
            println!("{what:?}: {forward:?}, lean {lean:?}");
            // Where buffers for all of the app lie is chance, and with it what is kept of their blocks.
            assert!(lean.bytes <= forward.bytes + BYTES_OF_CHANCE, "{what:?}");
            lean.bytes = forward.bytes;
            assert_eq!(forward, lean, "{what:?}");
        }
    });
}

/// Less than a texture of the smallest target that comes and goes.
const BYTES_OF_CHANCE: usize = 4096;

/// `SOAK_SEED=7 cargo test --test soak shrink -- --ignored`: runs a seed, and where it fails finds few frames that make it fail.
#[test]
#[ignore = "by hand, for a seed that fails"]
fn shrink() {
    run::shrink(SEEDS[0]);
}
