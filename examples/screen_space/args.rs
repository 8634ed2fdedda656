//! The command line.

use argh::FromArgs;
use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;

use crate::settings::{self, Effect, ExampleSettings, Mirrors};
use kit::{
    example::{
        choices,
        debug_view::DebugChoice,
        model::Viewpoint,
        numbers::{finite, positive, share},
    },
    size::parse_size,
};

/// Diffuse GI and reflections in a room with coloured walls, or in a glTF or GLB file.
#[derive(FromArgs)]
pub struct Args {
    /// the file to show; a room when left out
    #[argh(positional)]
    pub file: Option<String>,

    /// none, occlusion or gi (the default)
    #[argh(option, default = "Effect::Gi", from_str_fn(effect))]
    effect: Effect,

    /// low, medium (the default), high or ultra
    #[argh(option, default = "default()")]
    quality: LeanQuality,

    /// reflections: off, low, medium (the default), high, ultra, or bevy for Bevy's
    #[argh(option, default = "Mirrors::Medium", from_str_fn(mirrors))]
    mirrors: Mirrors,

    /// data of an effect to show instead of the picture: gi-light, gi-visibility, reflection-light,
    /// reflection-confidence or reflection-hit
    #[argh(option, from_str_fn(debug_view))]
    debug_view: Option<DebugView>,

    /// share of the width, from the left, that shows the debug view, 0 to 1 (the default)
    #[argh(option, default = "1.0", from_str_fn(share))]
    split: f32,

    /// full or half (the default)
    #[argh(option, default = "default()")]
    resolution: LeanResolution,

    /// metres, default 4
    #[argh(option, default = "4.0", from_str_fn(positive))]
    radius: f32,

    /// leave lamp and sun out
    #[argh(switch)]
    dark: bool,

    /// render without a window, write this PNG and quit
    #[argh(option)]
    pub headless: Option<String>,

    /// width x height of the picture or window, default 1280x720
    #[argh(option, default = "UVec2::new(1280, 720)", from_str_fn(parse_size))]
    pub size: UVec2,

    /// frames before the picture is taken, default 16: light bounces once per frame
    #[argh(option, default = "16")]
    pub frames: usize,

    /// show the text in the picture of --headless too
    #[argh(switch)]
    pub text: bool,

    /// direction of the camera in degrees, default 0
    #[argh(option, default = "0.0", from_str_fn(finite))]
    yaw: f32,

    /// height of the camera in degrees, default 5
    #[argh(option, default = "5.0", from_str_fn(finite))]
    pitch: f32,

    /// zoom factor of the camera, default 1
    #[argh(option, default = "1.0", from_str_fn(positive))]
    zoom: f32,
}

impl Args {
    pub fn settings(&self) -> ExampleSettings {
        ExampleSettings {
            effect: self.effect,
            gi: LeanScreenSpaceGi {
                quality: self.quality,
                resolution: self.resolution,
                radius: self.radius,
                ..default()
            },
            mirrors: self.mirrors,
            debug: DebugChoice {
                view: self.debug_view,
                split: self.split,
            },
            lights: !self.dark,
            text: true,
        }
    }

    pub fn viewpoint(&self) -> Viewpoint {
        Viewpoint {
            yaw: self.yaw.to_radians(),
            pitch: self.pitch.to_radians(),
            zoom: self.zoom,
        }
    }
}

fn effect(text: &str) -> Result<Effect, String> {
    choices::parse(&settings::EFFECTS, text)
}

fn mirrors(text: &str) -> Result<Mirrors, String> {
    choices::parse(&settings::MIRRORS, text)
}

fn debug_view(text: &str) -> Result<DebugView, String> {
    choices::parse(&settings::DEBUG_VIEWS, text)
}
