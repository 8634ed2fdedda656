//! The command line.

use argh::FromArgs;
use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;

use crate::settings::{self, ExampleSettings, Shown};
use kit::{
    example::{
        choices,
        debug_view::{DebugChoice, debug_view},
        numbers::share,
    },
    size::parse_size,
};

/// Balls of every shading model that the G-buffer carries: lean beside forward.
#[derive(FromArgs)]
pub struct Args {
    /// both (the default), lean or forward
    #[argh(option, default = "Shown::Both", from_str_fn(shown))]
    shown: Shown,

    /// data to show instead of the lit picture, such as shading-model
    #[argh(option, from_str_fn(debug_view))]
    debug_view: Option<DebugView>,

    /// share of the width of the lean picture, from the left, that shows them, 0 to 1 (the default)
    #[argh(option, default = "1.0", from_str_fn(share))]
    split: f32,

    /// leave the sun out
    #[argh(switch)]
    no_sun: bool,

    /// leave the environment map out
    #[argh(switch)]
    no_environment: bool,

    /// switch subsurface scattering off
    #[argh(switch)]
    no_scattering: bool,

    /// render without a window, write this PNG and quit
    #[argh(option)]
    pub headless: Option<String>,

    /// width x height of the picture or window, default 1280x860
    #[argh(option, default = "UVec2::new(1280, 860)", from_str_fn(parse_size))]
    pub size: UVec2,

    /// frames before the picture is taken, default 8
    #[argh(option, default = "8")]
    pub frames: usize,

    /// show the text in the picture of --headless too
    #[argh(switch)]
    pub text: bool,
}

impl Args {
    pub fn settings(&self) -> ExampleSettings {
        ExampleSettings {
            shown: self.shown,
            debug: DebugChoice {
                view: self.debug_view,
                split: self.split,
            },
            sun: !self.no_sun,
            environment: !self.no_environment,
            scattering: !self.no_scattering,
            text: true,
            picture: self.size,
        }
    }

    /// Tells if both halves of the picture should look the same.
    pub fn compares(&self) -> bool {
        self.shown == Shown::Both && self.debug_view.is_none() && !self.text
    }
}

fn shown(text: &str) -> Result<Shown, String> {
    choices::parse(&settings::SHOWN, text)
}
