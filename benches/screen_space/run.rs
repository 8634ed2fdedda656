//! Measures one contender at one size.

use bevy::{
    camera::Hdr,
    light::AmbientLight,
    prelude::*,
    render::{RenderApp, diagnostic::RenderDiagnosticsPlugin},
};
use bevy_lean_deferred::{
    effects::{LeanScreenSpaceGiAdvanced, TimesEachDispatch},
    prelude::*,
};
use figures::benches::screen_space::{KnownError, Measurement};
use kit::{
    analytic_light::{self, Errors},
    analytic_mirrors, analytic_slabs,
    bench_spans::{CAMERA, add_camera_span},
    gpu_time::Samples,
    headless::Headless,
    scenes::boxes::{self, Boxes},
};

use crate::{
    Args,
    contender::{Contender, Share},
};

fn known_error(scene: &str, errors: Errors) -> KnownError {
    KnownError {
        scene: scene.into(),
        rmse: errors.rmse,
        bias: errors.bias,
    }
}

/// Size of the pictures that errors are measured on, for times at `size`. Texels of reflections are larger in large
/// pictures.
pub fn size_of_errors(contender: Contender, size: UVec2) -> UVec2 {
    match contender {
        Contender::Gi(..) => UVec2::splat(512),
        Contender::Scattering(..) => UVec2::new(320, 192),
        _ if size.y < 1440 => UVec2::new(480, 360),
        _ => UVec2::splat(1440),
    }
}

/// Errors of effects whose light is known, in pictures of this size.
pub fn errors(contender: Contender, size: UVec2) -> Vec<KnownError> {
    match contender {
        Contender::Gi(quality, resolution) => {
            let effect = LeanScreenSpaceGi {
                radius: 100.0,
                quality,
                resolution,
                advanced: LeanScreenSpaceGiAdvanced {
                    falloff: 0.1,
                    ..default()
                },
                ..default()
            };
            [
                ("groove", analytic_light::groove(size, 0.5, effect)),
                ("wall", analytic_light::wall(size, effect)),
                ("sphere", analytic_light::sphere(size, effect)),
            ]
            .map(|(scene, errors)| known_error(scene, errors))
            .into()
        }
        Contender::Reflections(..) | Contender::BevysReflections => {
            let mirror = analytic_mirrors::mirror(size, |camera| contender.dress(camera));
            let rough = [("0.1", 0.1), ("0.3", 0.3), ("0.5", 0.5)].map(|(scene, roughness)| {
                let dress = |camera: &mut EntityWorldMut| contender.dress(camera);
                let (_, errors) = analytic_mirrors::rough_floor(size, roughness, dress);
                known_error(scene, errors)
            });
            [
                known_error("mirror", mirror.everywhere),
                known_error("inside", mirror.inside),
            ]
            .into_iter()
            .chain(rough)
            .collect()
        }
        Contender::Scattering(quality, Share::All) => {
            let edge = |color, path| match quality {
                Some(quality) => {
                    let effect = LeanSubsurfaceScattering {
                        quality,
                        ..default()
                    };
                    analytic_slabs::edge(size, color, path, effect)
                }
                None => analytic_slabs::edge(size, color, path, ()),
            };
            let white = edge(LinearRgba::WHITE, 0.08)[0];
            let skin = edge(analytic_slabs::SKIN, 0.2);
            let scenes = ["white", "skin, red", "green", "blue"];
            let errors = [white, skin[0], skin[1], skin[2]];
            let errors = scenes.into_iter().zip(errors);
            errors
                .map(|(scene, errors)| known_error(scene, errors))
                .collect()
        }
        _ => Vec::new(),
    }
}

pub fn measure(
    contender: Contender,
    size: UVec2,
    args: &Args,
    errors: Vec<KnownError>,
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
    let samples = Samples::of_frames(&mut headless, args.warm_up, args.frames);
    if let Some(folder) = &args.pictures {
        let name = contender.name().replace([' ', ','], "_");
        let file = format!("{name}_{}x{}.png", size.x, size.y);
        headless
            .capture()
            .save(std::path::Path::new(folder).join(file));
    }
    let stages = if contender.stages().is_empty() {
        Samples::default()
    } else {
        let render_app = headless.app.sub_app_mut(RenderApp);
        render_app.insert_resource(TimesEachDispatch);
        Samples::of_frames(&mut headless, args.warm_up, args.frames)
    };
    let times = |samples: &Samples, spans: &[&str]| {
        let times = spans.iter().filter_map(|name| samples.time(name));
        times.collect()
    };
    Measurement {
        device: headless.adapter_and_driver(),
        frames: Some(args.frames),
        size: size.to_array(),
        contender: contender.name(),
        passes: times(&samples, contender.spans()),
        stages: times(&stages, contender.stages()),
        lighting: samples.time("lean_deferred/lighting"),
        camera: samples.time(CAMERA),
        bytes: contender.bytes(size.y),
        errors,
    }
}
