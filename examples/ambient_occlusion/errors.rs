//! Errors of each occlusion technique, for the text on screen.
//!
//! The figures are root mean squares of (occlusion − closed form) over the pixels within the radius of a tall wall on a
//! floor, 0 being open and 1 closed. They are copies of results of this crate's accuracy tests (`tests/ambient_occlusion`;
//! the closed forms are in `lab/kit/src/occlusion/closed_forms.rs`) with a radius of 0.5 m, the default falloff of 0.1 and all
//! other settings at their defaults.

use bevy_lean_deferred::{effects::ambient_occlusion::OcclusionKernel, prelude::*};

use crate::Mode;

const HBAO_LOW_RMSE: f32 = 0.040;
const HBAO_MEDIUM_RMSE: f32 = 0.024;
const HBAO_HIGH_RMSE: f32 = 0.018;
const HBAO_ULTRA_RMSE: f32 = 0.013;
const HDAO_RMSE: f32 = 0.080;
/// RMSE of Bevy's `ScreenSpaceAmbientOcclusion` at its level `High`, on planes where nothing occludes.
const BEVY_HIGH_RMSE_ON_PLANES: f32 = 0.17;
/// The same on the wall, as a range: it depends on the distance.
const BEVY_HIGH_RMSE_ON_WALL: (f32, f32) = (0.12, 0.19);

/// Error of the technique that is shown.
pub fn text(mode: Mode, occlusion: Option<&LeanScreenSpaceAmbientOcclusion>) -> String {
    if mode == Mode::Bevy {
        let (low, high) = BEVY_HIGH_RMSE_ON_WALL;
        return format!(
            "RMSE {low:.2} to {high:.2} (tall wall), {BEVY_HIGH_RMSE_ON_PLANES:.2} (open planes), at High"
        );
    }
    let Some(occlusion) = occlusion else {
        return "RMSE -".into();
    };
    let rmse = match (occlusion.advanced.kernel, occlusion.quality) {
        (OcclusionKernel::Hdao, _) => HDAO_RMSE,
        (OcclusionKernel::Hbao, LeanQuality::Low) => HBAO_LOW_RMSE,
        (OcclusionKernel::Hbao, LeanQuality::Medium) => HBAO_MEDIUM_RMSE,
        (OcclusionKernel::Hbao, LeanQuality::High) => HBAO_HIGH_RMSE,
        (OcclusionKernel::Hbao, LeanQuality::Ultra) => HBAO_ULTRA_RMSE,
    };
    format!("RMSE {rmse:.3} (tall wall), at default settings")
}
