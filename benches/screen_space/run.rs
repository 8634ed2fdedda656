//! One contender at one size.

use bevy::{
    camera::Hdr, diagnostic::DiagnosticsStore, light::AmbientLight, prelude::*,
    render::diagnostic::RenderDiagnosticsPlugin,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    bench_spans::{CAMERA, add_camera_span},
    gpu_time::{Samples, Time},
    headless::Headless,
    known_light::{self, Errors},
    scenes::boxes::{self, Boxes},
};
use serde::Serialize;

use crate::{Args, contender::Contender};

#[derive(Serialize)]
pub struct Measurement {
    pub adapter: String,
    pub size: UVec2,
    pub contender: String,
    /// Of the passes that only the effect has, in order.
    pub passes: Vec<Time>,
    pub lighting: Option<Time>,
    pub camera: Option<Time>,
    pub bytes: f64,
    pub errors: Option<KnownErrors>,
}

/// Root of the mean square, and mean, against closed forms.
#[derive(Serialize, Clone, Copy)]
pub struct KnownErrors {
    pub groove: [f32; 2],
    pub wall: [f32; 2],
    pub sphere: [f32; 2],
}

/// Of effects that find diffuse light.
pub fn errors(contender: Contender) -> Option<KnownErrors> {
    let Contender::Gi(quality, resolution) = contender else {
        return None;
    };
    let effect = LeanScreenSpaceGi {
        radius: 100.0,
        falloff: 0.1,
        quality,
        resolution,
        ..default()
    };
    let pair = |errors: Errors| [errors.rmse, errors.bias];
    let size = UVec2::splat(512);
    Some(KnownErrors {
        groove: pair(known_light::groove(size, 0.5, effect)),
        wall: pair(known_light::wall(size, effect)),
        sphere: pair(known_light::sphere(size, effect)),
    })
}

pub fn measure(
    contender: Contender,
    size: UVec2,
    args: &Args,
    errors: Option<KnownErrors>,
) -> Measurement {
    let boxes = if args.small {
        Boxes::small(32)
    } else {
        Boxes::full(64)
    };
    let mut headless = Headless::with(size, |app| {
        app.add_plugins(RenderDiagnosticsPlugin);
        add_camera_span(app);
    });
    boxes::spawn_into(headless.world(), boxes);
    let target = headless.render_target();
    let ambient = AmbientLight {
        brightness: 500.0,
        ..default()
    };
    let mut camera = headless.world().spawn((
        Camera3d::default(),
        Hdr,
        Msaa::Off,
        target,
        boxes::camera_transform(boxes),
        LeanDeferred::default(),
        ambient,
    ));
    contender.dress(&mut camera);
    headless.settle();
    headless.frames(args.warm_up);
    let mut samples = Samples::default();
    for _ in 0..args.frames {
        headless.frames(1);
        samples.take(headless.app.world().resource::<DiagnosticsStore>());
    }
    if let Some(folder) = &args.pictures {
        let name = contender.name().replace([' ', ','], "_");
        let file = format!("{name}_{}x{}.png", size.x, size.y);
        headless
            .capture()
            .save(std::path::Path::new(folder).join(file));
    }
    let spans = contender.spans().iter();
    Measurement {
        adapter: headless.adapter(),
        size,
        contender: contender.name(),
        passes: spans.filter_map(|name| samples.time(name)).collect(),
        lighting: samples.time("lean_deferred/lighting"),
        camera: samples.time(CAMERA),
        bytes: contender.bytes(),
        errors,
    }
}
