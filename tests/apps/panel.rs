//! Settings of the examples: fields from text and by steps, and `--set`. Nothing is rendered.

use std::collections::BTreeSet;

use bevy::{
    pbr::{ScreenSpaceAmbientOcclusion, ScreenSpaceAmbientOcclusionQualityLevel},
    prelude::*,
    reflect::{ReflectRef, TypeRegistry},
};
use bevy_lean_deferred::{
    effects::auto_exposure::{LeanAutoExposureAdvanced, LuminanceTrim, Metering, MeteringPattern},
    prelude::*,
};
use kit::example::{
    fields,
    panel::{self, PanelCamera},
    set,
};

/// A camera without settings, and a panel of three components.
fn app() -> (App, Entity) {
    let mut app = App::new();
    app.add_plugins((
        panel::panel::<LeanScreenSpaceAmbientOcclusion>("occlusion"),
        panel::panel::<LeanAutoExposure>("exposure"),
        panel::panel::<ScreenSpaceAmbientOcclusion>("Bevy's occlusion"),
    ));
    let camera = app.world_mut().spawn(PanelCamera).id();
    (app, camera)
}

#[test]
fn fields_from_text() {
    let (mut app, camera) = app();
    let world = app.world_mut();
    for setting in [
        "LeanAutoExposure.range=-4..6.5",
        "LeanAutoExposure.target=0.25",
        "LeanAutoExposure.metering=Linear-Average",
        "LeanAutoExposure.pattern=spot",
        "LeanAutoExposure.pattern.radius=0.2",
        "LeanAutoExposure.trim=some",
        "LeanAutoExposure.trim.0.high=0.05",
        "LeanAutoExposure.advanced.instant=on",
        "LeanScreenSpaceAmbientOcclusion.thickness=0.5",
        "ScreenSpaceAmbientOcclusion.quality_level=custom",
        "ScreenSpaceAmbientOcclusion.quality_level.slice_count=8",
    ] {
        assert_eq!(set::apply(world, setting), Ok(()), "{setting}");
    }
    let exposure = LeanAutoExposure {
        range: -4.0..=6.5,
        target: 0.25,
        metering: Metering::LinearAverage,
        pattern: MeteringPattern::Spot { radius: 0.2 },
        trim: Some(LuminanceTrim {
            low: 0.1,
            high: 0.05,
        }),
        advanced: LeanAutoExposureAdvanced {
            instant: true,
            ..default()
        },
        ..default()
    };
    assert_eq!(world.get::<LeanAutoExposure>(camera), Some(&exposure));
    assert_eq!(
        world.get::<LeanScreenSpaceAmbientOcclusion>(camera),
        Some(&LeanScreenSpaceAmbientOcclusion {
            thickness: Some(0.5),
            ..default()
        })
    );
    assert_eq!(
        world.get::<ScreenSpaceAmbientOcclusion>(camera),
        Some(&ScreenSpaceAmbientOcclusion {
            quality_level: ScreenSpaceAmbientOcclusionQualityLevel::Custom {
                slice_count: 8,
                samples_per_slice_side: 1,
            },
            ..default()
        })
    );

    // Round trip: the listed text of each field sets the same value.
    assert_eq!(set::apply(world, "LeanAutoExposure=off"), Ok(()));
    for (path, text) in fields::list(&exposure) {
        let setting = format!("LeanAutoExposure.{path}={text}");
        assert_eq!(set::apply(world, &setting), Ok(()), "{setting}");
    }
    assert_eq!(world.get::<LeanAutoExposure>(camera), Some(&exposure));
}

#[test]
fn components_on_and_off() {
    let (mut app, camera) = app();
    let world = app.world_mut();
    let changed = LeanAutoExposure {
        target: 0.5,
        ..default()
    };
    for (setting, expected) in [
        ("LeanAutoExposure=on", Some(LeanAutoExposure::default())),
        ("LeanAutoExposure.target=0.5", Some(changed.clone())),
        // It is on already.
        ("LeanAutoExposure=on", Some(changed.clone())),
        ("LeanAutoExposure=off", None),
        ("LeanAutoExposure=off", None),
        ("LeanAutoExposure.target=0.5", Some(changed)),
    ] {
        assert_eq!(set::apply(world, setting), Ok(()), "{setting}");
        let exposure = world.get::<LeanAutoExposure>(camera);
        assert_eq!(exposure, expected.as_ref(), "{setting}");
    }
}

#[test]
fn wrong_settings() {
    for (setting, why) in [
        (
            "LeanAutoExposur=on",
            "there is no component LeanAutoExposur",
        ),
        ("LeanQuality=on", "this is no component"),
        ("LeanAutoExposure", "expected Component.field=value"),
        (
            "LeanAutoExposure.targets=1",
            "expected one of range, speed_brighten, speed_darken, target,",
        ),
        ("LeanAutoExposure.target=much", "much: invalid float"),
        ("LeanAutoExposure.range=3", "expected LOW..HIGH"),
        (
            "LeanAutoExposure.metering=median",
            "median: expected one of log-average, linear-average",
        ),
        (
            "LeanAutoExposure.advanced.instant=yes",
            "yes: expected on or off",
        ),
        (
            "LeanAutoExposure.advanced=on",
            "this field cannot be set from text",
        ),
        (
            "LeanAutoExposure.pattern=mask",
            "Mask has a field without a default",
        ),
    ] {
        let (mut app, camera) = app();
        let exposure = LeanAutoExposure::default();
        let world = app.world_mut();
        world.entity_mut(camera).insert(exposure.clone());
        let error = set::apply(world, setting).expect_err(setting);
        assert!(error.starts_with(why), "{setting}: {error}");
        let unchanged = world.get::<LeanAutoExposure>(camera);
        assert_eq!(unchanged, Some(&exposure), "{setting}");

        set::apply_all(world, &[setting.into()]);
        let exit = app.should_exit();
        assert!(exit.is_some_and(|exit| exit.is_error()), "{setting}");
    }
}

/// Steps each enum through all of its variants and back to that of the default.
fn step_around(mut settings: impl Reflect, registry: &TypeRegistry) {
    let listed = fields::list(&settings);
    for (path, start) in &listed {
        let field = settings.reflect_path_mut(path.as_str());
        let field = field.expect("it is listed");
        let ReflectRef::Enum(value) = field.reflect_ref() else {
            continue;
        };
        let info = value.get_represented_enum_info();
        let count = info.expect("it is no dynamic enum").variant_len();
        for forward in [true, false] {
            let mut texts = Vec::new();
            for _ in 0..count {
                fields::step(field, forward, registry);
                texts.extend(fields::list(field).into_iter().next());
            }
            let last = texts.last().map(|(_, text)| text);
            assert_eq!(last, Some(start), "{path}: {texts:?}");
            let different: BTreeSet<_> = texts.iter().collect();
            assert_eq!(different.len(), count, "{path}: {texts:?}");
        }
    }
    assert_eq!(fields::list(&settings), listed);
}

#[test]
fn steps_around_each_enum() {
    let mut registry = TypeRegistry::new();
    registry.register::<LeanAutoExposure>();
    // As in the example of auto exposure.
    registry.register_type_data::<Handle<Image>, ReflectDefault>();
    step_around(LeanDeferred::default(), &registry);
    step_around(LeanDebugView::default(), &registry);
    step_around(LeanScreenSpaceAmbientOcclusion::default(), &registry);
    step_around(LeanScreenSpaceGi::default(), &registry);
    step_around(LeanScreenSpaceReflections::default(), &registry);
    step_around(LeanSubsurfaceScattering::default(), &registry);
    step_around(LeanAutoExposure::default(), &registry);
    step_around(ScreenSpaceAmbientOcclusion::default(), &registry);
}
