//! What lies in front replaces all that what lies behind has left in the targets, in whatever order they are drawn.

use bevy::{
    camera::ScalingMode, core_pipeline::tonemapping::Tonemapping, prelude::*,
    render::batching::NoAutomaticBatching,
};

use kit::{
    headless::Headless,
    lean::{build, judge, report, set_lean, settled},
    own_process::in_own_process,
    scenes::{LEAST_PSNR, SceneBuilder, build::material},
};

/// Pixels of a pair.
const CELL: UVec2 = UVec2::new(28, 24);

struct Kind {
    name: &'static str,
    change: fn(&mut StandardMaterial),
    unbatchable: bool,
}

impl Kind {
    const fn new(name: &'static str, change: fn(&mut StandardMaterial)) -> Self {
        Self {
            name,
            change,
            unbatchable: false,
        }
    }

    const fn unbatchable(self) -> Self {
        Self {
            unbatchable: true,
            ..self
        }
    }
}

const GLOW: LinearRgba = LinearRgba::rgb(0.0, 0.3, 0.1);

fn emissive(material: &mut StandardMaterial) {
    material.emissive = GLOW;
}

fn masked(material: &mut StandardMaterial) {
    material.alpha_mode = AlphaMode::Mask(0.5);
}

fn clearcoat(material: &mut StandardMaterial) {
    material.clearcoat = 1.0;
}

const KINDS: [Kind; 11] = [
    Kind::new("plain", |_| {}),
    Kind::new("emissive", emissive),
    Kind::new("unlit", |material| material.unlit = true),
    Kind::new("clearcoat", clearcoat),
    Kind::new("emissive clearcoat", |material| {
        emissive(material);
        clearcoat(material);
    }),
    Kind::new("masked", masked),
    Kind::new("masked emissive", |material| {
        masked(material);
        emissive(material);
    }),
    Kind::new("masked clearcoat", |material| {
        masked(material);
        clearcoat(material);
    }),
    Kind::new("unbatchable plain", |_| {}).unbatchable(),
    Kind::new("unbatchable emissive", emissive).unbatchable(),
    Kind::new("unbatchable clearcoat", clearcoat).unbatchable(),
];

/// A card behind, and a smaller one in front of it, for each pair of kinds.
fn pairs(s: &mut SceneBuilder) {
    for (row, behind) in KINDS.iter().enumerate() {
        for (column, front) in KINDS.iter().enumerate() {
            for (kind, size, z) in [(behind, 0.9, 0.0), (front, 0.5, 0.2)] {
                let mut sample = material((0.6, 0.4, 0.3), 0.0, 0.5);
                (kind.change)(&mut sample);
                let card = s.mesh(
                    Rectangle::new(size, size),
                    sample,
                    Transform::from_xyz(column as f32, -(row as f32), z),
                );
                if kind.unbatchable {
                    s.world().entity_mut(card).insert(NoAutomaticBatching);
                }
            }
        }
    }
    s.sun(false);
}

fn camera(s: &mut SceneBuilder, extra: impl Bundle) {
    let target = s.headless.render_target();
    let middle = (KINDS.len() - 1) as f32 / 2.0;
    s.spawn((
        Camera3d::default(),
        bevy::camera::Hdr,
        Msaa::Off,
        target,
        Tonemapping::Reinhard,
        Projection::Orthographic(OrthographicProjection {
            scaling_mode: ScalingMode::Fixed {
                width: KINDS.len() as f32,
                height: KINDS.len() as f32,
            },
            ..OrthographicProjection::default_3d()
        }),
        Transform::from_xyz(middle, -middle, 5.0),
        extra,
    ));
}

fn compare(headless: &mut Headless) {
    let forward = settled(headless);
    set_lean(headless, true);
    let lean = settled(headless);
    let mut results = vec![judge("overlaps", &forward, &lean, LEAST_PSNR)];
    for (row, behind) in KINDS.iter().enumerate() {
        for (column, front) in KINDS.iter().enumerate() {
            let min = UVec2::new(column as u32, row as u32) * CELL;
            let rect = URect::from_corners(min, min + CELL);
            let name = format!("{} on {}", front.name, behind.name);
            let [forward, lean] = [&forward, &lean].map(|picture| picture.crop(rect));
            results.push(judge(&name, &forward, &lean, LEAST_PSNR));
        }
    }
    report(results);
}

#[test]
fn what_lies_in_front_replaces_all_words() {
    in_own_process(|| {
        let mut headless = build(CELL * KINDS.len() as u32, |s| {
            pairs(s);
            camera(s, ());
        });
        compare(&mut headless);
    });
}

/// Nothing is multi-drawn there.
#[test]
fn without_indirect_drawing() {
    in_own_process(|| {
        let mut headless = build(CELL * KINDS.len() as u32, |s| {
            pairs(s);
            camera(s, bevy::render::view::NoIndirectDrawing);
        });
        compare(&mut headless);
    });
}
