//! The command line.

use argh::FromArgs;
use bevy::prelude::*;
use bevy_lean_deferred::{
    effects::ambient_occlusion::{
        LeanScreenSpaceAmbientOcclusionAdvanced, OcclusionApplication, OcclusionFilter,
        OcclusionKernel, OcclusionNormals,
    },
    prelude::*,
};

use crate::settings::{self, ExampleSettings, Mode};
use kit::{
    example::{
        choices,
        debug_view::DebugChoice,
        model::Viewpoint,
        numbers::{finite, not_negative, number_where, positive, share},
    },
    size::parse_size,
};

/// A courtyard, or a glTF or GLB file, without ambient occlusion, with LeanScreenSpaceAmbientOcclusion, or with Bevy's.
#[derive(FromArgs)]
pub struct Args {
    /// the file to show; a courtyard when left out
    #[argh(positional)]
    pub file: Option<String>,

    /// off, lean (the default) or bevy
    #[argh(option, default = "Mode::Lean", from_str_fn(mode))]
    mode: Mode,

    /// put LeanDeferred on the camera
    #[argh(switch)]
    deferred: bool,

    /// low, medium (the default), high or ultra; of Bevy's occlusion too
    #[argh(option, default = "default()")]
    quality: LeanQuality,

    /// metres, default 0.5
    #[argh(option, default = "0.5", from_str_fn(positive))]
    radius: f32,

    /// factor on the occlusion, default 1
    #[argh(option, default = "1.0", from_str_fn(not_negative))]
    intensity: f32,

    /// angle above the surface in radians below which nothing occludes, 0 to 0.5, default 0.02
    #[argh(option, default = "0.02", from_str_fn(up_to_half))]
    bias: f32,

    /// share of the squared radius over which occluders fade out, 0 to 1, default 0.1
    #[argh(option, default = "0.1", from_str_fn(share))]
    falloff: f32,

    /// metres that occluders extend back; without it (the default) they do so without end
    #[argh(option, from_str_fn(not_negative))]
    thickness: Option<f32>,

    /// auto (the default), multiplicative-blend or indirect
    #[argh(option, default = "default()", from_str_fn(application))]
    application: OcclusionApplication,

    /// hbao (the default) or hdao
    #[argh(option, default = "default()", from_str_fn(kernel))]
    kernel: OcclusionKernel,

    /// full (the default) or half
    #[argh(option, default = "LeanResolution::Full")]
    resolution: LeanResolution,

    /// narrow (the default) or wide
    #[argh(option, default = "default()", from_str_fn(filter))]
    filter: OcclusionFilter,

    /// let the filter average across depth steps
    #[argh(switch)]
    not_edge_aware: bool,

    /// shading (the default) or geometric
    #[argh(option, default = "default()", from_str_fn(normals))]
    normals: OcclusionNormals,

    /// leave out light that bounces between bright walls
    #[argh(switch)]
    no_multibounce: bool,

    /// strength of the occlusion of direct light, 0 (the default) to 1
    #[argh(option, default = "0.0", from_str_fn(share))]
    direct_light: f32,

    /// show the occlusion alone
    #[argh(switch)]
    debug: bool,

    /// share of the width, from the left, that --debug is for, 0 to 1 (the default)
    #[argh(option, default = "1.0", from_str_fn(share))]
    split: f32,

    /// leave the sun out
    #[argh(switch)]
    no_sun: bool,

    /// render without a window, write this PNG and quit
    #[argh(option)]
    pub headless: Option<String>,

    /// width x height of the picture or window, default 1280x720
    #[argh(option, default = "UVec2::new(1280, 720)", from_str_fn(parse_size))]
    pub size: UVec2,

    /// frames before the picture is taken, default 8
    #[argh(option, default = "8")]
    pub frames: usize,

    /// show the text in the picture of --headless too
    #[argh(switch)]
    pub text: bool,

    /// direction of the camera in degrees, default 30
    #[argh(option, default = "30.0", from_str_fn(finite))]
    yaw: f32,

    /// height of the camera in degrees, default 15
    #[argh(option, default = "15.0", from_str_fn(finite))]
    pitch: f32,

    /// zoom factor of the camera, default 1
    #[argh(option, default = "1.0", from_str_fn(positive))]
    zoom: f32,
}

impl Args {
    pub fn settings(&self) -> ExampleSettings {
        ExampleSettings {
            mode: self.mode,
            lean_deferred: self.deferred,
            occlusion: LeanScreenSpaceAmbientOcclusion {
                radius: self.radius,
                intensity: self.intensity,
                quality: self.quality,
                resolution: self.resolution,
                application: self.application,
                direct_light: self.direct_light,
                thickness: self.thickness,
                advanced: LeanScreenSpaceAmbientOcclusionAdvanced {
                    kernel: self.kernel,
                    bias: self.bias,
                    falloff: self.falloff,
                    normals: self.normals,
                    filter: self.filter,
                    edge_aware: !self.not_edge_aware,
                    multibounce: !self.no_multibounce,
                },
            },
            debug: DebugChoice {
                view: self.debug.then_some(DebugView::AmbientOcclusion),
                split: self.split,
            },
            sun: !self.no_sun,
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

fn mode(text: &str) -> Result<Mode, String> {
    choices::parse(&settings::MODES, text)
}

fn application(text: &str) -> Result<OcclusionApplication, String> {
    choices::parse(&settings::APPLICATIONS, text)
}

fn kernel(text: &str) -> Result<OcclusionKernel, String> {
    choices::parse(&settings::KERNELS, text)
}

fn filter(text: &str) -> Result<OcclusionFilter, String> {
    choices::parse(&OcclusionFilter::ALL, text)
}

fn normals(text: &str) -> Result<OcclusionNormals, String> {
    choices::parse(&settings::NORMALS, text)
}

fn up_to_half(text: &str) -> Result<f32, String> {
    number_where(text, "0 to 0.5", |x| (0.0..=0.5).contains(&x))
}
