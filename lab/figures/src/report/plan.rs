//! The benches to run, and how long they are expected to take.

use std::time::Duration;

use crate::arguments::arguments;

/// Extent of the measurements.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Mode {
    /// Small scenes and few frames, for a software renderer.
    Quick,
    /// Five minutes on any GPU: the most important figures first.
    Gpu,
    /// The figures in the docs. Needs a GPU.
    Full,
}

impl Mode {
    /// Cargo's arguments. GPU times do not depend on the profile, and that of the tests takes a fraction of the time to build.
    pub fn profile(self) -> &'static [&'static str] {
        match self {
            Self::Quick | Self::Gpu => &["--profile", "dev"],
            Self::Full => &[],
        }
    }

    /// After this time the benches are cut short.
    pub fn limit(self) -> Option<Duration> {
        (self == Self::Gpu).then_some(Duration::from_secs(300))
    }

    pub fn note(self) -> &'static str {
        match self {
            Self::Quick => "quick: small scenes, few frames",
            Self::Gpu => "five minutes on a GPU",
            Self::Full => "full",
        }
    }
}

/// A bench with its arguments.
pub struct Step {
    pub bench: &'static str,
    pub args: Vec<String>,
    pub has_pictures: bool,
    /// In seconds, on two cores without a GPU (quick) or on a large GPU (full). Once some steps are done, only the
    /// ratios matter.
    pub expected: f64,
}

/// All benches; with a glTF file, also frames of it. Levels only in quick runs, which measure a room that the bench writes: others have to
/// be fetched.
pub fn steps(mode: Mode, gltf: Option<&str>) -> Vec<Step> {
    let step = |bench, args, expected| Step {
        bench,
        args: arguments(args),
        // Pictures of GPUs are not sent.
        has_pictures: mode != Mode::Gpu && !matches!(bench, "auto_exposure" | "stutter"),
        expected,
    };
    let mut steps = match mode {
        Mode::Quick => vec![
            step(
                "frame_times",
                "--scene small_ --size 480x270 --frames 6 --warm-up 3 \
                 --contender Bevy forward,Bevy deferred,lean",
                45.0,
            ),
            step("levels", "--quick", 60.0),
            step(
                "ambient_occlusion",
                "--small --size 320x180 --frames 6 --warm-up 3 \
                 --contender =Medium, indirect;=Medium, indirect, half;Low;High;Ultra;HDAO;=Medium, blend;naive;=Bevy Medium",
                200.0,
            ),
            step(
                "screen_space",
                "--small --size 320x180 --frames 6 --warm-up 3 \
                 --contender ambient;Half;Bevy;scattering, Low, All;scattering, High, All",
                240.0,
            ),
            step("motion", "--quick --no-lamps --path walk,lamp", 200.0),
            step(
                "auto_exposure",
                "--size 1280x720 --frames 12 --warm-up 3 --ring-mb 16",
                60.0,
            ),
            step(
                "light_scaling",
                "--small --sizes 320x180 --lights 16,64,256,1024 --frames 4 --warm-up 4 \
                 --limit-ms 1000",
                60.0,
            ),
            step(
                "many_meshes",
                "--meshes 1000,10000 --size 320x180 --frames 12 --events 1",
                90.0,
            ),
            step("stutter", "--quick --contender Bevy forward,lean", 300.0),
        ],
        Mode::Gpu => vec![
            step(
                "frame_times",
                "--scene boxes_1,boxes_64,targets_materials --size 1920x1080 --frames 30 \
                 --warm-up 10 --no-flip \
                 --contender Bevy forward,Bevy depth prepass,Bevy deferred,lean",
                90.0,
            ),
            step(
                "screen_space",
                "--size 1920x1080 --frames 30 --warm-up 10 --no-errors \
                 --contender GI, Medium, Half;reflections, Medium, Half;Bevy;scattering, High, Tenth",
                60.0,
            ),
            step(
                "auto_exposure",
                "--size 1920x1080 --frames 20 --warm-up 5 --ring-mb 64 --contender in an app",
                20.0,
            ),
            // Last: the closed forms that it compares with take the CPU long.
            step(
                "ambient_occlusion",
                "--size 1920x1080 --frames 30 --warm-up 10 \
                 --contender =Medium, indirect;=High, indirect;=Bevy High;=Bevy Ultra",
                90.0,
            ),
        ],
        Mode::Full => vec![
            step(
                "frame_times",
                "--scene boxes_1,boxes_64,boxes_512,boxes_4096,targets_,glass,probes",
                400.0,
            ),
            step("ambient_occlusion", "", 300.0),
            step("screen_space", "", 240.0),
            step("motion", "", 900.0),
            step("auto_exposure", "", 60.0),
            step(
                "light_scaling",
                "--contender Bevy forward,Bevy deferred,lean,lean per pixel,lean culling by subgroups,lean culling in shared memory",
                300.0,
            ),
            step("many_meshes", "", 120.0),
            step("stutter", "", 240.0),
        ],
    };
    if let Some(file) = gltf {
        let frames = &mut steps[0];
        let stem = std::path::Path::new(file).file_stem().unwrap_or_default();
        let mut scenes = frames.args[1].clone();
        scenes.push_str(&format!(",{},crowd", stem.to_string_lossy()));
        frames.args[1] = scenes;
        frames.args.extend(["--gltf".into(), file.into()]);
        if mode == Mode::Full {
            frames.args.extend(["--crowd".into(), file.into()]);
        }
    }
    steps
}
