//! The command line.

use argh::FromArgs;
use bevy::prelude::*;
use bevy_lean_deferred::{
    effects::auto_exposure::{LeanAutoExposureAdvanced, Metering, ReductionPath},
    prelude::*,
};

use crate::{
    settings::{self, ExampleSettings, Mode, Pattern},
    walk::{self, Place},
};
use kit::{
    example::{
        choices,
        debug_view::DebugChoice,
        numbers::{finite, not_negative, positive, share},
    },
    size::parse_size,
};

/// Frames before the picture, for effects that adapt at once.
const FRAMES: usize = 8;
/// Frames before the picture, for Bevy's effect, which starts without exposure: 8 simulated seconds.
const BEVY_FRAMES: usize = 480;

/// A house with an open door, without auto exposure, with LeanAutoExposure, or with Bevy's.
#[derive(FromArgs)]
pub struct Args {
    /// off, lean (the default) or bevy
    #[argh(option, default = "Mode::Lean", from_str_fn(mode))]
    mode: Mode,

    /// viewpoint: dark (the default), room or door
    #[argh(option, default = "Place::Dark", from_str_fn(place))]
    pub view: Place,

    /// viewpoint to start at, with --headless, so that the picture shows the exposure on its way
    #[argh(option, from_str_fn(place))]
    from: Option<Place>,

    /// put LeanDeferred on the camera
    #[argh(switch)]
    deferred: bool,

    /// log-average (the default) or linear-average
    #[argh(option, default = "default()", from_str_fn(metering))]
    metering: Metering,

    /// average (the default), center-weighted, spot or mask
    #[argh(option, default = "default()", from_str_fn(pattern))]
    pattern: Pattern,

    /// radius of the spot, as a share of the picture's height, default 0.1
    #[argh(option, default = "0.1", from_str_fn(positive))]
    spot_radius: f32,

    /// leave out the darkest and the brightest tenth
    #[argh(switch)]
    trim: bool,

    /// target luminance, default 0.18
    #[argh(option, default = "0.18", from_str_fn(positive))]
    target: f32,

    /// compensation in stops, default 0
    #[argh(option, default = "0.0", from_str_fn(finite))]
    compensation: f32,

    /// leave dark views somewhat dark and bright ones somewhat bright
    #[argh(switch)]
    curve: bool,

    /// least exposure in stops, default -8
    #[argh(option, default = "-8.0", from_str_fn(finite))]
    min_exposure: f32,

    /// largest exposure in stops, default 8
    #[argh(option, default = "8.0", from_str_fn(finite))]
    max_exposure: f32,

    /// stops per second as the scene becomes brighter, default 3
    #[argh(option, default = "3.0", from_str_fn(not_negative))]
    speed_brighten: f32,

    /// stops per second as the scene becomes darker, default 1
    #[argh(option, default = "1.0", from_str_fn(not_negative))]
    speed_darken: f32,

    /// distance from the target in stops below which the exposure approaches it exponentially, default 1.5
    #[argh(option, default = "1.5", from_str_fn(not_negative))]
    transition: f32,

    /// adapt instantly
    #[argh(switch)]
    instant: bool,

    /// show the weight of each pixel, and the exposure on a scale
    #[argh(switch)]
    debug: bool,

    /// share of the width, from the left, that --debug is for, 0 to 1 (the default)
    #[argh(option, default = "1.0", from_str_fn(share))]
    split: f32,

    /// auto (the default), subgroup or shared-memory
    #[argh(option, default = "default()", from_str_fn(reduction))]
    reduction: ReductionPath,

    /// render without a window, write this PNG and quit
    #[argh(option)]
    pub headless: Option<String>,

    /// width x height of the picture or window, default 1280x720
    #[argh(option, default = "UVec2::new(1280, 720)", from_str_fn(parse_size))]
    pub size: UVec2,

    /// frames of 1/60 s before the picture is taken, default 8; 480 with Bevy's, which has to adapt first
    #[argh(option)]
    frames: Option<usize>,

    /// show the text in the picture of --headless too
    #[argh(switch)]
    pub text: bool,
}

impl Args {
    pub fn settings(&self) -> ExampleSettings {
        ExampleSettings {
            mode: self.mode,
            lean_deferred: self.deferred,
            exposure: LeanAutoExposure {
                range: self.min_exposure..=self.max_exposure,
                speed_brighten: self.speed_brighten,
                speed_darken: self.speed_darken,
                target: self.target,
                metering: self.metering,
                trim: self.trim.then_some(settings::TRIM),
                compensation: self.compensation,
                advanced: LeanAutoExposureAdvanced {
                    transition: self.transition,
                    instant: self.instant,
                    reduction: self.reduction,
                },
                ..default()
            },
            pattern: self.pattern,
            spot_radius: self.spot_radius,
            curve: self.curve,
            debug: DebugChoice {
                view: self.debug.then_some(DebugView::ExposureWeights),
                split: self.split,
            },
            text: true,
        }
    }

    /// The viewpoint at the start.
    pub fn start(&self) -> Place {
        match (&self.headless, self.from) {
            (Some(_), Some(from)) => from,
            _ => self.view,
        }
    }

    pub fn frames(&self) -> usize {
        self.frames.unwrap_or(if self.mode == Mode::Bevy {
            BEVY_FRAMES
        } else {
            FRAMES
        })
    }
}

fn mode(text: &str) -> Result<Mode, String> {
    choices::parse(&settings::MODES, text)
}

fn place(text: &str) -> Result<Place, String> {
    choices::parse(&walk::PLACES, text)
}

fn metering(text: &str) -> Result<Metering, String> {
    choices::parse(&settings::METERINGS, text)
}

fn pattern(text: &str) -> Result<Pattern, String> {
    choices::parse(&settings::PATTERNS, text)
}

fn reduction(text: &str) -> Result<ReductionPath, String> {
    choices::parse(&settings::REDUCTIONS, text)
}
