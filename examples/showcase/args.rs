//! The command line.

use argh::FromArgs;
use bevy::prelude::*;
use kit::{example::choices, renderer::Renderer, size::parse_size};
use street::Detail;

use crate::settings::Place;

/// A street by night, or a glTF or GLB file, through everything the crate has.
#[derive(FromArgs)]
pub struct Args {
    /// glTF or GLB file in place of the street
    #[argh(option)]
    model: Option<String>,

    /// glTF or GLB file whose first figure, a fox say, walks among the people of the street
    #[argh(option)]
    figure: Option<String>,

    /// render without a window, write this PNG and others beside it, print a table and quit
    #[argh(option)]
    headless: Option<String>,

    /// street, stall, puddle or cats: write one picture from there, with the effects of --set, and no table
    #[argh(option, from_str_fn(place))]
    place: Option<Place>,

    /// forward, deferred or lean (the default), with --place or in a window
    #[argh(option, default = "Renderer::Lean")]
    renderer: Renderer,

    /// width x height of the pictures or the window, default 1280x720, 640x360 without a GPU
    #[argh(option, from_str_fn(parse_size))]
    size: Option<UVec2>,

    /// frames per measurement, whose median is printed, default 20, 3 without a GPU
    #[argh(option)]
    frames: Option<usize>,

    /// point lights on strings, default 3000, 200 without a GPU
    #[argh(option)]
    bulbs: Option<usize>,

    /// people, default 36
    #[argh(option)]
    figures: Option<usize>,

    /// half of the street, with fewer lights and people and coarser textures: the scene of the web page, and the default
    /// without a GPU
    #[argh(switch)]
    small: bool,

    /// the whole street in large pictures, even without a GPU
    #[argh(switch)]
    full: bool,

    /// a setting of the camera, such as LeanScreenSpaceGi.quality=high; Component=on inserts it, Component=off removes it; any
    /// number of these
    #[argh(option)]
    set: Vec<String>,
}

fn place(text: &str) -> Result<Place, String> {
    choices::parse(&Place::ALL, text)
}

impl Args {
    /// Fills in defaults, which depend on the GPU: without one, everything takes a hundred times as long.
    pub fn fill_in(self, has_gpu: bool) -> Wanted {
        let is_fast = has_gpu || self.full;
        let detail = match (is_fast, self.small) {
            (true, false) => Detail::FULL,
            (true, true) => Detail::SMALL,
            (false, _) => Detail {
                bulbs: 200,
                ..Detail::SMALL
            },
        };
        let (size, frames) = match is_fast {
            true => ([1280, 720], 20),
            false => ([640, 360], 3),
        };
        Wanted {
            model: self.model,
            figure: self.figure,
            headless: self.headless,
            set: self.set,
            place: self.place,
            renderer: self.renderer,
            size: self.size.unwrap_or(size.into()),
            frames: self.frames.unwrap_or(frames),
            detail: Detail {
                bulbs: self.bulbs.unwrap_or(detail.bulbs),
                figures: self.figures.unwrap_or(detail.figures),
                ..detail
            },
        }
    }
}

/// The contents of the showcase, and its mode.
pub struct Wanted {
    pub model: Option<String>,
    pub figure: Option<String>,
    pub headless: Option<String>,
    pub set: Vec<String>,
    /// The viewpoint of the only picture.
    pub place: Option<Place>,
    pub renderer: Renderer,
    pub size: UVec2,
    pub frames: usize,
    pub detail: Detail,
}
