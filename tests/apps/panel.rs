//! Settings of the examples: fields from text and by steps, `--set`, and the rows of the panel. Nothing is rendered.

use std::collections::BTreeSet;

use bevy::{
    diagnostic::DiagnosticsStore,
    pbr::{ScreenSpaceAmbientOcclusion, ScreenSpaceAmbientOcclusionQualityLevel},
    prelude::*,
    reflect::{ReflectRef, TypeRegistry},
};
use bevy_lean_deferred::{
    effects::auto_exposure::{
        LeanAutoExposureAdvanced, LuminanceTrim, Metering, MeteringPattern, ReductionPath,
    },
    prelude::*,
};
use kit::example::{
    fields,
    panel::{self, PanelCamera},
    set,
    text_panel::TextPanel,
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

fn stepped<T: Reflect>(mut field: T, forward: bool) -> T {
    fields::step(&mut field, forward, &TypeRegistry::new());
    field
}

#[test]
fn bounds_of_steps() {
    for (number, less, more) in [(1.0_f32, 0.8, 1.25), (0.0, -0.1, 0.1), (-1.0, -1.25, -0.8)] {
        assert_eq!(stepped(number, false), less, "{number}");
        assert_eq!(stepped(number, true), more, "{number}");
    }
    // Small numbers become 0.
    assert_eq!(stepped(0.01_f32, false), 0.0);
    assert_eq!(stepped(-0.01_f32, true), 0.0);

    for (count, less, more) in [
        (6_u32, 3, 12),
        (1, 0, 2),
        (0, 0, 1),
        (u32::MAX, u32::MAX / 2, u32::MAX),
    ] {
        assert_eq!(stepped(count, false), less, "{count}");
        assert_eq!(stepped(count, true), more, "{count}");
    }

    assert!(stepped(false, true) && !stepped(true, true));
    assert_eq!(stepped(1.0_f32..=2.0, true), 1.0..=2.0);

    // A handle has no first value: its variant is skipped.
    let spot = MeteringPattern::Spot { radius: 0.1 };
    assert_eq!(stepped(MeteringPattern::Average, false), spot);
    assert_eq!(stepped(spot, true), MeteringPattern::Average);
}

fn text(world: &mut World) -> String {
    panel::write_text(world);
    let mut texts = world.query::<&Text>();
    texts.single(world).expect("there is one text").0.clone()
}

#[test]
fn rows_of_the_panel() {
    let (mut app, camera) = app();
    app.init_resource::<DiagnosticsStore>();
    let world = app.world_mut();
    world.spawn((TextPanel, Text::default()));
    let mut occlusion = LeanScreenSpaceAmbientOcclusion {
        quality: LeanQuality::Low,
        ..default()
    };
    let mut camera_mut = world.entity_mut(camera);
    camera_mut.insert((occlusion, LeanAutoExposure::default()));

    // The first title, off and on.
    panel::change(world, true);
    let off = world.get::<LeanScreenSpaceAmbientOcclusion>(camera);
    assert_eq!(off, None);
    assert!(text(world).contains("[occlusion: off]"), "{}", text(world));
    panel::change(world, true);
    let on = world.get::<LeanScreenSpaceAmbientOcclusion>(camera);
    assert_eq!(on, Some(&occlusion));

    panel::choose_row(world, true);
    panel::change(world, true);
    panel::change_all(world, "quality", false);
    occlusion.radius *= 1.25;
    occlusion.quality = LeanQuality::Ultra;
    let changed = world.get::<LeanScreenSpaceAmbientOcclusion>(camera);
    assert_eq!(changed, Some(&occlusion));
    for line in ["[radius: 0.625]", "quality: ultra", "Bevy's occlusion: off"] {
        assert!(text(world).contains(line), "{line}\n{}", text(world));
    }

    // Up past the first title and past the last section, which has no rows: the last row of the exposure.
    for _ in 0..3 {
        panel::choose_row(world, false);
    }
    let chosen = "[advanced.reduction: auto]";
    assert!(text(world).contains(chosen), "{}", text(world));
    panel::change(world, true);
    let exposure = world.get::<LeanAutoExposure>(camera);
    let reduction = exposure.map(|exposure| exposure.advanced.reduction);
    assert_eq!(reduction, Some(ReductionPath::Subgroup));

    panel::choose_row(world, true);
    panel::choose_row(world, true);
    panel::choose_section(world, false);
    panel::change(world, true);
    let inserted = world.get::<ScreenSpaceAmbientOcclusion>(camera);
    assert_eq!(inserted, Some(&ScreenSpaceAmbientOcclusion::default()));
}
