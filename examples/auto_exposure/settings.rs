//! The technique, the settings that the panel has beside those of the components, and Bevy's settings that correspond.

use bevy::{
    asset::RenderAssetUsages,
    math::cubic_splines::LinearSpline,
    post_process::auto_exposure::{AutoExposure, AutoExposureCompensationCurve},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_lean_deferred::{
    effects::auto_exposure::{LuminanceTrim, MeteringPattern},
    prelude::*,
};

use crate::walk::Place;
use kit::example::{keys::Technique, panel::PanelCamera, switch::switch};

/// The auto exposure on the camera.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    Off,
    Lean,
    Bevy,
}

impl Technique for Mode {
    const CHOICES: [Self; 3] = [Self::Off, Self::Lean, Self::Bevy];

    fn title(self) -> &'static str {
        match self {
            Self::Off => "no auto exposure",
            Self::Lean => "LeanAutoExposure",
            Self::Bevy => "Bevy's AutoExposure",
        }
    }
}

/// Settings of the panel.
#[derive(Component, Reflect, Default)]
#[reflect(Component, Default)]
pub struct House {
    /// The place where the camera is, or that it moves to.
    pub place: Place,
    /// Leaves dark views somewhat dark and bright ones somewhat bright.
    pub curve: bool,
}

/// Leaves dark places somewhat dark and bright ones somewhat bright, as the eye sees them.
const CURVE: [Vec2; 4] = [
    Vec2::new(-8.0, -1.5),
    Vec2::new(-3.0, 0.0),
    Vec2::new(2.0, 0.0),
    Vec2::new(6.0, 0.5),
];
/// Range of Bevy's histogram, in stops of luminance. Wider than its default, so that it includes the sky.
const BEVY_RANGE: core::ops::RangeInclusive<f32> = -10.0..=8.0;

/// The mask of [`MeteringPattern::Mask`] in this example.
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

/// Gives the exposure the curve and the mask that the panel asks for.
pub fn complete(camera: Single<(&House, &mut LeanAutoExposure)>, mask: Res<Mask>) {
    let (house, mut exposure) = camera.into_inner();
    let curve: &[Vec2] = if house.curve { &CURVE } else { &[] };
    if exposure.compensation_curve != curve {
        exposure.compensation_curve = curve.to_vec();
    }
    if exposure.pattern == MeteringPattern::Mask(Handle::default()) {
        exposure.pattern = MeteringPattern::Mask(mask.0.clone());
    }
}

pub fn apply(
    mut commands: Commands,
    mode: Res<Mode>,
    camera: Single<(Entity, Option<&LeanAutoExposure>), With<PanelCamera>>,
    mut curves: ResMut<Assets<AutoExposureCompensationCurve>>,
    mut last: Local<LeanAutoExposure>,
) {
    let (camera, exposure) = *camera;
    if let Some(exposure) = exposure {
        *last = exposure.clone();
    }
    let mut camera = commands.entity(camera);
    switch::<LeanAutoExposure>(&mut camera, *mode == Mode::Lean);
    if *mode == Mode::Bevy {
        camera.insert(bevys(&last, &mut curves));
    } else {
        camera.remove::<AutoExposure>();
    }
}

/// Bevy's settings that correspond.
fn bevys(
    exposure: &LeanAutoExposure,
    curves: &mut Assets<AutoExposureCompensationCurve>,
) -> AutoExposure {
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
        metering_mask: match &exposure.pattern {
            MeteringPattern::Mask(mask) => mask.clone(),
            _ => default(),
        },
        compensation_curve: bevys_curve(exposure).map_or_else(default, |curve| curves.add(curve)),
    }
}

/// The compensation curve for Bevy, whose target is 1 and which has no other compensation: the curve contains both.
fn bevys_curve(exposure: &LeanAutoExposure) -> Option<AutoExposureCompensationCurve> {
    let stops = exposure.target.log2() + exposure.compensation;
    let flat = [Vec2::new(-8.0, 0.0), Vec2::new(8.0, 0.0)];
    let points: &[Vec2] = match exposure.compensation_curve.as_slice() {
        [] => &flat,
        points => points,
    };
    let points = points.iter().map(|point| point + stops * Vec2::Y);
    AutoExposureCompensationCurve::from_curve(LinearSpline::new(points)).ok()
}
