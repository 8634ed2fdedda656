use core::ops::RangeInclusive;

use bevy::{prelude::*, render::extract_component::ExtractComponent};

use crate::view::{
    CameraCuts,
    overrides::{CameraEffect, Need},
};

/// Meters the luminance of the image and adapts the exposure to it over time.
///
/// For 3D and 2D cameras, with or without [`LeanDeferred`](crate::LeanDeferred). `Hdr` is added with the component, and removed
/// with it unless something else needs it. The camera's viewport is metered after anti-aliasing and before bloom and other
/// post-processing. Tonemapping applies the exposure, as it applies that of Bevy's `AutoExposure`: use one of the two. It needs a
/// [`Tonemapping`](bevy::core_pipeline::tonemapping::Tonemapping) other than `None`, the default of `Camera2d`; with `None` the
/// exposure is metered but not applied, and a warning is logged. The first frame that shows light starts adapted. Add
/// [`MeteredExposure`] to read the metered values.
///
/// ```
/// # use bevy::prelude::*;
/// use bevy_lean_deferred::{effects::auto_exposure::MeteringPattern, prelude::*};
///
/// fn spawn_camera(mut commands: Commands) {
///     commands.spawn((
///         Camera3d::default(),
///         LeanAutoExposure {
///             pattern: MeteringPattern::CenterWeighted,
///             // One stop darker than middle grey.
///             compensation: -1.0,
///             range: -4.0..=4.0,
///             ..default()
///         },
///     ));
/// }
/// ```
///
/// NaN pixels are ignored; luminance is clamped to 0..65504. A black view gets the largest exposure; a view without pixels to meter
/// keeps its target. At the start and after a [`CameraCut`](crate::CameraCut), adaptation waits for light: black frames, as of a
/// scene that is loading, are skipped, and the first frame with a mean luminance above 2^-13.9 starts adapted. NaN settings fall
/// back to their defaults.
#[doc(alias = "eye adaptation")]
#[derive(Component, ExtractComponent, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CameraCuts, crate::view::LeanStatus)]
pub struct LeanAutoExposure {
    /// Smallest and largest exposure in stops, before compensation. Both -64 to 64; if the smallest is larger, the largest counts.
    /// Default -8 to 8.
    pub range: RangeInclusive<f32>,
    /// Speed at which the exposure falls when the scene becomes brighter, in stops per second, 0 to 65504. Default 3, as in Bevy: eyes
    /// adapt faster to light than to darkness.
    pub speed_brighten: f32,
    /// Speed at which the exposure rises when the scene becomes darker, in stops per second, 0 to 65504. Default 1.
    pub speed_darken: f32,
    /// Luminance that the metered mean is exposed to, before tonemapping. More than 0, up to 65504. Default 0.18, middle grey (1 in
    /// Bevy's `AutoExposure`).
    pub target: f32,
    /// Mean of the luminance. Default [`Metering::LogAverage`].
    pub metering: Metering,
    /// Weights of the pixels. Default [`MeteringPattern::Average`].
    pub pattern: MeteringPattern,
    /// Leaves out the darkest and brightest pixels. Default `None`, since trimming costs a histogram.
    pub trim: Option<LuminanceTrim>,
    /// Added to the exposure, in stops, -64 to 64. Default 0.
    pub compensation: f32,
    /// Curve added to the exposure: points of (metered luminance as base-2 logarithm, stops), both -64 to 64, in ascending order, with
    /// linear interpolation. The first 16 are used. Default empty.
    pub compensation_curve: Vec<Vec2>,
    /// Clock that exposure adapts by. Default [`ExposureClock::Real`].
    pub clock: ExposureClock,
    /// Settings that few games change.
    pub advanced: LeanAutoExposureAdvanced,
}

// Handles are not `Unpin`, so that types with handles may have templates of their own. This one is its own template, as the components
// of the other effects are: `bsn!` starts with its defaults, and `MeteringPattern::Mask` takes a handle, and no path.
impl Unpin for LeanAutoExposure {}

impl CameraEffect for LeanAutoExposure {
    const NAME: &'static str = "LeanAutoExposure";
    const NEEDS: &'static [Need] = &[Need::Hdr];
}

impl Default for LeanAutoExposure {
    fn default() -> Self {
        Self {
            range: -8.0..=8.0,
            speed_brighten: 3.0,
            speed_darken: 1.0,
            target: 0.18,
            metering: default(),
            pattern: default(),
            trim: None,
            compensation: 0.0,
            compensation_curve: Vec::new(),
            clock: default(),
            advanced: default(),
        }
    }
}

/// Settings of [`LeanAutoExposure`] that few games change.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct LeanAutoExposureAdvanced {
    /// Distance to the target, in stops, below which the exposure approaches it exponentially, for a smooth end. 0 to 65504; 0 keeps
    /// the speed constant to the end. Default 1.5.
    pub transition: f32,
    /// Disables adaptation: each frame has its own exposure. Default false.
    pub instant: bool,
    /// Method by which a workgroup sums its pixels. Default [`ReductionPath::Auto`].
    pub reduction: ReductionPath,
}

impl Default for LeanAutoExposureAdvanced {
    fn default() -> Self {
        Self {
            transition: 1.5,
            instant: false,
            reduction: default(),
        }
    }
}

/// Clock that exposure adapts by.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum ExposureClock {
    /// `Time<Real>`: exposure belongs to the viewer's eye. It keeps adapting while the game is paused, and keeps its speed in slow
    /// motion.
    #[default]
    Real,
    /// `Time<Virtual>`: exposure belongs to the game's world. It pauses with the game, as the rest of a photo mode or of a film rendered
    /// frame by frame.
    Virtual,
}

/// Mean over the pixels' luminance Y = 0.2126 R + 0.7152 G + 0.0722 B (ITU-R BT.709).
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum Metering {
    /// Geometric mean, robust against few bright pixels (Reinhard, Stark, Shirley and Ferwerda 2002, "Photographic Tone
    /// Reproduction for Digital Images"). Luminance below 2^-14 is clamped to that.
    #[default]
    LogAverage,
    /// Arithmetic mean, as in a light meter.
    LinearAverage,
}

/// Weights of the metered pixels.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub enum MeteringPattern {
    /// All pixels equally.
    #[default]
    Average,
    /// Full weight in the centre, with a Gaussian falloff whose standard deviation is a quarter of the viewport's height.
    CenterWeighted,
    /// A disc in the centre.
    Spot {
        /// Radius as a share of the viewport's height, more than 0.
        radius: f32,
    },
    /// Red channel of a texture stretched over the viewport, of any size and filtered by its sampler. A plain 2D image of a format
    /// that the device filters. While it is loading, or if the image is not of that kind, all pixels count.
    Mask(Handle<Image>),
}

/// Shares of the metered weight, 0 to 1, that are left out. The rest is metered by a histogram of 256 bins, 1/8.5 of a stop
/// wide: exact to half a bin. If nothing remains, nothing is metered.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Clone, PartialEq)]
pub struct LuminanceTrim {
    /// Share of the darkest pixels.
    pub low: f32,
    /// Share of the brightest pixels.
    pub high: f32,
}

/// Method by which a workgroup sums its pixels.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum ReductionPath {
    /// Subgroups if the device has them, with at least 4 invocations; otherwise, and for the histogram of
    /// [`LeanAutoExposure::trim`], shared memory.
    #[default]
    Auto,
    /// Subgroup arithmetic, if the device has it. For the histogram, a subgroup whose pixels share a bin counts them with one atomic.
    Subgroup,
    /// Tree reduction in shared memory.
    SharedMemory,
}

/// Metered values of the camera's [`LeanAutoExposure`], a few frames old: they are read back from the GPU without waiting. Only
/// cameras with this component are read back. All zero until the first values arrive, and without [`LeanAutoExposure`].
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
    /// Mean luminance before exposure, by the camera's metering, in the units of the HDR image.
    pub luminance: f32,
    /// Exposure of that frame, in stops.
    pub exposure: f32,
    /// Target that the exposure adapts to, in stops.
    pub target_exposure: f32,
}
