//! What the shaders are compiled by.

use bevy::shader::ShaderDefVal;

use super::settings::SubsurfaceScatteringQuality;
use crate::shader_library::reconstruction::position::ProjectionKind;

/// How light is scattered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Method {
    Separable,
    /// With so many samples.
    Sampled(u32),
}

/// What all passes are compiled by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct SubsurfaceKey {
    pub(super) method: Method,
    pub(super) projection: ProjectionKind,
}

/// Samples of pixels beside one another are at so many different radii.
const SETS: u32 = 4;

impl Method {
    /// `None` if nothing scatters.
    pub(super) fn of(quality: SubsurfaceScatteringQuality) -> Option<Self> {
        match quality {
            SubsurfaceScatteringQuality::Off => None,
            SubsurfaceScatteringQuality::Separable => Some(Self::Separable),
            SubsurfaceScatteringQuality::Low => Some(Self::Sampled(9)),
            SubsurfaceScatteringQuality::Medium => Some(Self::Sampled(15)),
            SubsurfaceScatteringQuality::High => Some(Self::Sampled(30)),
        }
    }
}

impl SubsurfaceKey {
    pub(super) fn shader_defs(self) -> Vec<ShaderDefVal> {
        let samples = match self.method {
            Method::Separable => None,
            Method::Sampled(samples) => Some(samples),
        };
        let counts = samples.into_iter().flat_map(|samples| {
            [
                ShaderDefVal::UInt("SAMPLES".into(), samples),
                ShaderDefVal::UInt("SAMPLES_OF_SETS".into(), samples * SETS),
            ]
        });
        let projection = self.projection.shader_def().map(ShaderDefVal::from);
        counts.chain(projection).collect()
    }
}
