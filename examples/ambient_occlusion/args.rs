//! The command line.

use argh::FromArgs;
use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;

use crate::settings::{self, ExampleSettings, Mode};
use kit::{
    example::{
        choices,
        model::Viewpoint,
        numbers::{finite, not_negative, number_where, positive},
    },
    size::parse_size,
};

/// A courtyard, or a glTF or GLB file, without ambient occlusion, with LeanAmbientOcclusion, or with Bevy's.
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
    #[argh(option, default = "default()", from_str_fn(preset))]
    preset: OcclusionQuality,

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

    /// how far occluders extend back, 0 to 1; below 1 (the default), horizons sink again behind thin parts
    #[argh(option, default = "1.0", from_str_fn(share))]
    thickness: f32,

    /// auto (the default), multiplicative-blend or indirect
    #[argh(option, default = "default()", from_str_fn(application))]
    application: OcclusionApplication,

    /// hbao (the default) or hdao
    #[argh(option, default = "default()", from_str_fn(kernel))]
    kernel: OcclusionKernel,

    /// full (the default) or half
    #[argh(option, default = "default()", from_str_fn(resolution))]
    resolution: OcclusionResolution,

    /// binomial, wide, binomial-edge-aware (the default) or wide-edge-aware
    #[argh(option, default = "default()", from_str_fn(filter))]
    filter: OcclusionFilter,

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
            occlusion: LeanAmbientOcclusion {
                radius: self.radius,
                intensity: self.intensity,
                bias: self.bias,
                falloff: self.falloff,
                thickness: self.thickness,
                kernel: self.kernel,
                quality: self.preset,
                normals: self.normals,
                resolution: self.resolution,
                filter: self.filter,
                application: self.application,
                multibounce: !self.no_multibounce,
                direct_light_affect: self.direct_light,
                debug_view: self.debug,
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

fn preset(text: &str) -> Result<OcclusionQuality, String> {
    choices::parse(&OcclusionQuality::PRESETS, text)
}

fn application(text: &str) -> Result<OcclusionApplication, String> {
    choices::parse(&settings::APPLICATIONS, text)
}

fn kernel(text: &str) -> Result<OcclusionKernel, String> {
    choices::parse(&settings::KERNELS, text)
}

fn resolution(text: &str) -> Result<OcclusionResolution, String> {
    choices::parse(&settings::RESOLUTIONS, text)
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

fn share(text: &str) -> Result<f32, String> {
    number_where(text, "0 to 1", |x| (0.0..=1.0).contains(&x))
}
