use bevy::{prelude::*, render::extract_component::ExtractComponent};

use crate::view::{
    CameraCuts,
    overrides::{CameraEffect, Need},
};

/// Measures the luminance of the picture and adapts the exposure to it over time.
///
/// For cameras, 3D or 2D, with or without [`LeanDeferred`](crate::LeanDeferred). `Hdr` is added with the component, and
/// removed with it unless something else needs it. Measured is the camera's own viewport, after anti-aliasing and before
/// bloom and other post-processing; applied is the exposure in tonemapping, where Bevy's `AutoExposure` applies it too: use
/// one of the two, and a [`Tonemapping`](bevy::core_pipeline::tonemapping::Tonemapping) other than `None`, the default of
/// `Camera2d`: without one the exposure is measured but not applied, and a warning says so. The first frame that shows light
/// starts adapted. To read what was measured, add [`MeteredExposure`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn_camera(mut commands: Commands) {
///     commands.spawn((
///         Camera3d::default(),
///         LeanAutoExposure {
///             pattern: MeteringPattern::CenterWeighted,
///             // One stop darker than middle grey.
///             compensation: -1.0,
///             min_exposure: -4.0,
///             max_exposure: 4.0,
///             ..default()
///         },
///     ));
/// }
/// ```
///
/// Pixels that are NaN are left out; negative luminance counts as 0, and everything above 65504 as that. A black view
/// has the largest exposure; one that has nothing to be metered keeps the target that it had. Adaptation does not begin in the
/// black of a scene that is still loading, nor in that after a [`CameraCut`](crate::CameraCut): it begins, adapted, with the first
/// frame whose mean luminance is more than 2^-13.9. Settings that are NaN count as their defaults.
#[derive(Component, ExtractComponent, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CameraCuts)]
pub struct LeanAutoExposure {
    /// Which mean is taken. Default [`Metering::LogAverage`].
    pub metering: Metering,
    /// Which pixels count how much. Default [`MeteringPattern::Average`].
    pub pattern: MeteringPattern,
    /// Leaves the darkest and the brightest pixels out. Default none: it costs a histogram.
    pub trim: Option<LuminanceTrim>,
    /// The luminance that the metered one is brought to, before tonemapping. More than 0, up to 65504. Default 0.18, middle grey
    /// (Bevy's `AutoExposure` has 1).
    pub target: f32,
    /// Added to the exposure, in stops, -64 to 64. Default 0.
    pub compensation: f32,
    /// Added to the exposure too: points of (metered luminance as its base-2 logarithm, stops), both -64 to 64, in rising
    /// order and connected by straight lines; the first 16 count. Default none.
    pub compensation_curve: Vec<Vec2>,
    /// Least exposure in stops, without the compensation: -64 to 64, and never more than the largest. Default -8.
    pub min_exposure: f32,
    /// Largest exposure in stops, without the compensation, -64 to 64. Default 8.
    pub max_exposure: f32,
    /// How fast the exposure falls when the scene becomes brighter, in stops a second, 0 to 65504. Default 3, as Bevy's and as eyes:
    /// they take to light sooner than to the dark.
    pub speed_brighten: f32,
    /// How fast it rises when the scene becomes darker, in stops a second, 0 to 65504. Default 1.
    pub speed_darken: f32,
    /// Nearer to its target than this many stops, the exposure approaches it exponentially, so that it comes to rest
    /// without a jerk; 0 keeps the speed to the end; up to 65504. Default 1.5.
    pub transition: f32,
    /// No adaptation: each frame has its own exposure. Default false.
    pub instant: bool,
    /// The time in which exposure adapts. Default [`ExposureClock::Real`].
    pub clock: ExposureClock,
    /// How many pixels are read. Default [`ExposureSampling::All`].
    pub sampling: ExposureSampling,
    /// How a workgroup adds its pixels up. Default [`ReductionPath::Auto`].
    pub reduction: ReductionPath,
    /// Shows over the tonemapped picture how much each pixel counts, and on a scale of stops the exposure (white) and where it
    /// is heading (green). Default false.
    pub overlay: bool,
}

impl CameraEffect for LeanAutoExposure {
    const NAME: &'static str = "LeanAutoExposure";
    const NEEDS: &'static [Need] = &[Need::Hdr];
}

impl Default for LeanAutoExposure {
    fn default() -> Self {
        Self {
            metering: default(),
            pattern: default(),
            trim: None,
            target: 0.18,
            compensation: 0.0,
            compensation_curve: Vec::new(),
            min_exposure: -8.0,
            max_exposure: 8.0,
            speed_brighten: 3.0,
            speed_darken: 1.0,
            transition: 1.5,
            instant: false,
            clock: default(),
            sampling: default(),
            reduction: default(),
            overlay: false,
        }
    }
}

/// The time in which exposure adapts.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum ExposureClock {
    /// `Time<Real>`: exposure is part of the viewer's eye. It comes to rest while the game is paused, and keeps its speed in slow
    /// motion.
    #[default]
    Real,
    /// `Time<Virtual>`: exposure is part of the game's world. It stands still while the game is paused, as the rest of a photo mode
    /// or of a film rendered frame by frame.
    Virtual,
}

/// The mean over the pixels' luminance Y = 0.2126 R + 0.7152 G + 0.0722 B (ITU-R BT.709).
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum Metering {
    /// The geometric mean, which few bright pixels hardly move (Reinhard, Stark, Shirley and Ferwerda 2002, "Photographic
    /// Tone Reproduction for Digital Images"). Luminance below 2^-14 counts as that.
    #[default]
    LogAverage,
    /// The arithmetic mean, as a light meter takes it.
    LinearAverage,
}

/// Which pixels count how much.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub enum MeteringPattern {
    /// All alike.
    #[default]
    Average,
    /// Fully in the centre, falling off as a Gaussian with a deviation of a quarter of the viewport's height.
    CenterWeighted,
    /// Only a disc in the centre.
    Spot {
        /// As a share of the viewport's height, more than 0.
        radius: f32,
    },
    /// The red channel of a texture stretched over the viewport, of any size and filtered as its sampler says. A plain 2D
    /// image of a format that the device filters. While it is loading, and where it is no such image, all pixels count.
    Mask(Handle<Image>),
}

/// Shares of the metered weight, 0 to 1, that are left out. The others count by a histogram of 256 bins, 1/8.5 of a stop
/// wide: metered luminance is exact to half a bin. If they leave nothing, nothing is metered.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Clone, PartialEq)]
pub struct LuminanceTrim {
    /// Of the darkest pixels.
    pub low: f32,
    /// Of the brightest pixels.
    pub high: f32,
}

/// How many pixels are read: 4×4 blocks of them, in staggered rows.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum ExposureSampling {
    /// Each one, once.
    #[default]
    All,
    /// One of four. Lights smaller than a block may be missed, or come and go as they move.
    Quarter,
    /// One of sixteen.
    Sixteenth,
}

impl ExposureSampling {
    /// Distance of the blocks that are read, in blocks.
    pub(super) fn stride(self) -> u32 {
        match self {
            Self::All => 1,
            Self::Quarter => 2,
            Self::Sixteenth => 4,
        }
    }
}

/// How a workgroup adds its pixels up.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum ReductionPath {
    /// By subgroups where the device has them, of at least 4 invocations; else, and for the histogram that
    /// [`LeanAutoExposure::trim`] takes, in shared memory.
    #[default]
    Auto,
    /// By subgroup arithmetic, if the device has any; in the histogram, invocations of a subgroup that agree count once.
    Subgroup,
    /// By a tree in shared memory.
    SharedMemory,
}

/// What a camera's [`LeanAutoExposure`] has measured, a few frames ago: it comes from the GPU without waiting. Put it on
/// cameras whose exposure you want to read; of others nothing is read back. All zero until the first frame has come back,
/// and without [`LeanAutoExposure`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn_camera(mut commands: Commands) {
///     commands.spawn((
///         Camera3d::default(),
///         LeanAutoExposure::default(),
///         MeteredExposure::default(),
///     ));
/// }
///
/// fn print_exposures(cameras: Query<(Entity, &MeteredExposure), Changed<MeteredExposure>>) {
///     for (camera, metered) in &cameras {
///         info!("{camera}: {:+.1} stops", metered.exposure);
///     }
/// }
/// ```
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct MeteredExposure {
    /// Mean luminance before the exposure, by the camera's metering, in the units of the HDR picture.
    pub luminance: f32,
    /// The exposure in stops that the picture had.
    pub exposure: f32,
    /// Where it is heading, in stops.
    pub target_exposure: f32,
}
