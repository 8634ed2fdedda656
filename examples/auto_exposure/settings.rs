//! Settings that the keys change, and the system that applies them to the camera.

use bevy::{
    asset::RenderAssetUsages,
    math::cubic_splines::LinearSpline,
    post_process::auto_exposure::{AutoExposure, AutoExposureCompensationCurve},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_lean_deferred::{
    effects::auto_exposure::{LuminanceTrim, Metering, MeteringPattern, ReductionPath},
    prelude::*,
};

use kit::example::{choices::next, debug_view::DebugChoice};

/// The auto exposure on the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    Off,
    Lean,
    Bevy,
}

/// [`MeteringPattern`] without the parameters of its variants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pattern {
    #[default]
    Average,
    CenterWeighted,
    Spot,
    Mask,
}

pub const MODES: [Mode; 3] = [Mode::Off, Mode::Lean, Mode::Bevy];
pub const METERINGS: [Metering; 2] = [Metering::LogAverage, Metering::LinearAverage];
pub const PATTERNS: [Pattern; 4] = [
    Pattern::Average,
    Pattern::CenterWeighted,
    Pattern::Spot,
    Pattern::Mask,
];
pub const REDUCTIONS: [ReductionPath; 3] = [
    ReductionPath::Auto,
    ReductionPath::Subgroup,
    ReductionPath::SharedMemory,
];

/// A tenth on each side, as in Bevy's default.
pub const TRIM: LuminanceTrim = LuminanceTrim {
    low: 0.1,
    high: 0.1,
};
/// Leaves dark places somewhat dark and bright ones somewhat bright, as the eye sees them.
pub const CURVE: [Vec2; 4] = [
    Vec2::new(-8.0, -1.5),
    Vec2::new(-3.0, 0.0),
    Vec2::new(2.0, 0.0),
    Vec2::new(6.0, 0.5),
];
/// Factor between two targets: a third of a stop.
const TARGET_STEP: f32 = 1.259_921;
/// Step of the compensation, in stops.
const COMPENSATION_STEP: f32 = 0.25;
/// Range of Bevy's histogram, in stops of luminance. Wider than its default, so that it includes the sky.
const BEVY_RANGE: core::ops::RangeInclusive<f32> = -10.0..=8.0;

#[derive(Resource, Clone)]
pub struct ExampleSettings {
    pub mode: Mode,
    pub lean_deferred: bool,
    /// All settings but the pattern and the compensation curve.
    pub exposure: LeanAutoExposure,
    pub pattern: Pattern,
    pub spot_radius: f32,
    pub curve: bool,
    /// Shows weights and the exposure.
    pub debug: DebugChoice,
    pub text: bool,
}

impl ExampleSettings {
    fn lean(&self, mask: &Handle<Image>) -> LeanAutoExposure {
        LeanAutoExposure {
            pattern: match self.pattern {
                Pattern::Average => MeteringPattern::Average,
                Pattern::CenterWeighted => MeteringPattern::CenterWeighted,
                Pattern::Spot => MeteringPattern::Spot {
                    radius: self.spot_radius,
                },
                Pattern::Mask => MeteringPattern::Mask(mask.clone()),
            },
            compensation_curve: if self.curve { CURVE.into() } else { Vec::new() },
            ..self.exposure.clone()
        }
    }

    fn bevy(
        &self,
        mask: &Handle<Image>,
        curves: &mut Assets<AutoExposureCompensationCurve>,
    ) -> AutoExposure {
        let exposure = &self.exposure;
        let trim = exposure.trim.unwrap_or(LuminanceTrim {
            low: 0.0,
            high: 0.0,
        });
        AutoExposure {
            range: BEVY_RANGE,
            filter: trim.low..=1.0 - trim.high,
            speed_brighten: exposure.speed_brighten,
            speed_darken: exposure.speed_darken,
            exponential_transition_distance: exposure.advanced.transition,
            metering_mask: match self.pattern {
                Pattern::Mask => mask.clone(),
                _ => default(),
            },
            compensation_curve: self
                .bevy_curve()
                .map_or_else(default, |curve| curves.add(curve)),
        }
    }

    /// The compensation curve for Bevy, whose target is 1 and which has no other compensation: the curve contains both.
    fn bevy_curve(&self) -> Option<AutoExposureCompensationCurve> {
        let stops = self.exposure.target.log2() + self.exposure.compensation;
        let flat = [Vec2::new(-8.0, 0.0), Vec2::new(8.0, 0.0)];
        let points: &[Vec2] = if self.curve { &CURVE } else { &flat };
        let points = points.iter().map(|point| point + stops * Vec2::Y);
        AutoExposureCompensationCurve::from_curve(LinearSpline::new(points)).ok()
    }
}

pub fn read_keys(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    camera: Single<Entity, With<Camera3d>>,
    mut settings: ResMut<ExampleSettings>,
    mut exit: MessageWriter<AppExit>,
) {
    for key in keys.get_just_pressed() {
        match key {
            KeyCode::Escape => {
                exit.write(AppExit::Success);
                continue;
            }
            KeyCode::KeyX if settings.mode == Mode::Lean => {
                commands.entity(*camera).insert(CameraCut);
                continue;
            }
            _ => {}
        }
        // Destructured only once a key is pressed: mutable access marks the settings as changed.
        let ExampleSettings {
            mode,
            lean_deferred,
            exposure,
            pattern,
            curve,
            debug,
            text,
            ..
        } = &mut *settings;
        match key {
            KeyCode::Digit1 => *mode = Mode::Off,
            KeyCode::Digit2 => *mode = Mode::Lean,
            KeyCode::Digit3 => *mode = Mode::Bevy,
            KeyCode::KeyG => *lean_deferred = !*lean_deferred,
            KeyCode::KeyM => exposure.metering = next(&METERINGS, exposure.metering),
            KeyCode::KeyP => *pattern = next(&PATTERNS, *pattern),
            KeyCode::KeyT => exposure.trim = exposure.trim.is_none().then_some(TRIM),
            KeyCode::ArrowUp => exposure.target = (exposure.target * TARGET_STEP).min(4.0),
            KeyCode::ArrowDown => exposure.target = (exposure.target / TARGET_STEP).max(0.01),
            KeyCode::ArrowRight => {
                exposure.compensation = (exposure.compensation + COMPENSATION_STEP).min(8.0);
            }
            KeyCode::ArrowLeft => {
                exposure.compensation = (exposure.compensation - COMPENSATION_STEP).max(-8.0);
            }
            KeyCode::KeyC => *curve = !*curve,
            KeyCode::PageUp => change_speeds(exposure, 2.0),
            KeyCode::PageDown => change_speeds(exposure, 0.5),
            KeyCode::KeyI => exposure.advanced.instant = !exposure.advanced.instant,
            KeyCode::KeyR => {
                exposure.advanced.reduction = next(&REDUCTIONS, exposure.advanced.reduction);
            }
            KeyCode::KeyD => debug.change_view(&[DebugView::ExposureWeights]),
            KeyCode::KeyB => debug.change_split(),
            KeyCode::KeyH => *text = !*text,
            _ => {}
        }
    }
}

fn change_speeds(exposure: &mut LeanAutoExposure, factor: f32) {
    for speed in [&mut exposure.speed_brighten, &mut exposure.speed_darken] {
        *speed = (*speed * factor).clamp(0.05, 100.0);
    }
}

/// The image of [`Pattern::Mask`].
#[derive(Resource)]
pub struct Mask(Handle<Image>);

/// Adds a mask of one column: full weight in the lower half, and less towards the top in the upper half.
pub fn add_mask(mut commands: Commands, mut images: ResMut<Assets<Image>>) {
    const HEIGHT: u32 = 64;
    let weight = |row: u32| (0.1 + 1.8 * (row as f32 + 0.5) / HEIGHT as f32).min(1.0);
    let mask = Image::new(
        Extent3d {
            width: 1,
            height: HEIGHT,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        (0..HEIGHT)
            .map(|row| (weight(row) * 255.0).round() as u8)
            .collect(),
        TextureFormat::R8Unorm,
        RenderAssetUsages::default(),
    );
    commands.insert_resource(Mask(images.add(mask)));
}

pub fn apply(
    mut commands: Commands,
    settings: Res<ExampleSettings>,
    camera: Single<Entity, With<Camera3d>>,
    mask: Res<Mask>,
    mut curves: ResMut<Assets<AutoExposureCompensationCurve>>,
) {
    let mut camera = commands.entity(*camera);
    if settings.lean_deferred {
        camera.insert_if_new(LeanDeferred::default());
    } else {
        camera.remove::<LeanDeferred>();
    }
    if settings.mode != Mode::Lean {
        camera.remove::<(LeanAutoExposure, MeteredExposure)>();
    }
    if settings.mode != Mode::Bevy {
        camera.remove::<AutoExposure>();
    }
    settings.debug.put_on(&mut camera);
    match settings.mode {
        Mode::Off => {}
        Mode::Lean => {
            camera.insert((settings.lean(&mask.0), MeteredExposure::default()));
        }
        Mode::Bevy => {
            camera.insert(settings.bevy(&mask.0, &mut curves));
        }
    }
}
