//! The command line.

use argh::FromArgs;
use bevy::{camera::Viewport, prelude::*};
use kit::{
    example::{choices, keys::Technique},
    scenes::boxes::Boxes,
    size::parse_size,
};

/// Frame times of cameras with auto exposure.
#[derive(FromArgs, Resource, Clone)]
pub struct Args {
    /// cameras side by side, default 1
    #[argh(option, default = "1", from_str_fn(at_least_one))]
    pub cameras: u32,

    /// none, lean (the default) or bevy
    #[argh(option, default = "Effect::Lean", from_str_fn(effect))]
    pub effect: Effect,

    /// a setting of the cameras, such as LeanAutoExposure.trim=some; LeanDeferred=on inserts it; any number of these
    #[argh(option)]
    pub set: Vec<String>,

    /// show a sky alone instead of the boxes, so that auto exposure is much of the frame
    #[argh(switch)]
    pub sky: bool,

    /// point lights, default 32
    #[argh(option, default = "32")]
    pub lights: u32,

    /// a grid of 10 by 10 meshes in place of 40 by 40, for software renderers
    #[argh(switch)]
    pub small: bool,

    /// width x height of the picture or window in pixels, default 1920x1080
    #[argh(option, default = "UVec2::new(1920, 1080)", from_str_fn(parse_size))]
    pub size: UVec2,

    /// render without a window, and quit after --frames
    #[argh(switch)]
    pub headless: bool,

    /// measured frames, with --headless, default 1000
    #[argh(option, default = "1000", from_str_fn(at_least_one))]
    pub frames: u32,
}

/// The auto exposure on the cameras.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    None,
    Lean,
    Bevy,
}

impl Technique for Effect {
    const CHOICES: [Self; 3] = [Self::None, Self::Lean, Self::Bevy];

    fn title(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Lean => "LeanAutoExposure",
            Self::Bevy => "Bevy's AutoExposure",
        }
    }
}

impl Args {
    pub fn boxes(&self) -> Boxes {
        if self.small {
            Boxes::small(self.lights)
        } else {
            Boxes::full(self.lights)
        }
    }

    /// Columns and rows of viewports, as square as possible.
    pub fn grid(&self) -> UVec2 {
        let columns = f64::from(self.cameras).sqrt().ceil() as u32;
        UVec2::new(columns, self.cameras.div_ceil(columns))
    }

    /// The viewport of the camera with this index.
    pub fn viewport(&self, camera: u32) -> Viewport {
        let grid = self.grid();
        let cell = UVec2::new(camera % grid.x, camera / grid.x);
        let low = self.size * cell / grid;
        let high = self.size * (cell + 1) / grid;
        Viewport {
            physical_position: low,
            physical_size: high - low,
            ..default()
        }
    }
}

fn effect(text: &str) -> Result<Effect, String> {
    choices::parse(&Effect::CHOICES, text)
}

fn at_least_one(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(number) if number > 0 => Ok(number),
        _ => Err(format!("{text}: expected a whole number, at least 1")),
    }
}
