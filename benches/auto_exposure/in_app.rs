//! This crate's auto exposure and Bevy's in an app, on a camera that shows the picture at one texel per pixel.

use bevy::{
    asset::RenderAssetUsages,
    camera::{Hdr, ScalingMode},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    image::{ImageSampler, ToExtents},
    post_process::auto_exposure::{AutoExposure, AutoExposurePlugin},
    prelude::*,
    render::{
        RenderApp,
        diagnostic::RenderDiagnosticsPlugin,
        render_resource::{
            BufferDescriptor, BufferUsages, CommandEncoderDescriptor, MapMode, PollType,
            TextureDimension, TextureFormat, encase::UniformBuffer,
        },
        renderer::{RenderDevice, RenderQueue},
        view::{ViewUniform, ViewUniformOffset, ViewUniforms},
    },
};
use bevy_lean_deferred::{effects::auto_exposure::LeanAutoExposure, prelude::*};
use figures::benches::auto_exposure::{Group, Measurement};

use crate::{
    Args,
    picture::{Picture, TEXEL, TRIM, Truth},
    timing::Measured,
};
use kit::{
    gpu_time::Samples,
    headless::{FRAME_TIME, Headless},
    lean::instant_exposure,
};

#[derive(Clone)]
enum Kind {
    Lean(LeanAutoExposure),
    Bevy(AutoExposure),
}

fn contenders() -> [(&'static str, Kind); 4] {
    let lean = instant_exposure();
    // As fast as possible: the whole distance in one frame.
    let transition = 1000.0;
    let speed = transition / FRAME_TIME.as_secs_f32();
    let bevy = AutoExposure {
        speed_brighten: speed,
        speed_darken: speed,
        exponential_transition_distance: transition,
        ..default()
    };
    [
        ("in an app: LogAverage", Kind::Lean(lean.clone())),
        (
            "in an app: LogAverage, trim",
            Kind::Lean(LeanAutoExposure {
                trim: Some(TRIM),
                ..lean
            }),
        ),
        (
            "in an app: Bevy, filter 0..=1",
            Kind::Bevy(AutoExposure {
                filter: 0.0..=1.0,
                ..bevy.clone()
            }),
        ),
        (
            "in an app: Bevy, filter 0.1..=0.9",
            Kind::Bevy(AutoExposure {
                filter: TRIM.low..=1.0 - TRIM.high,
                ..bevy
            }),
        ),
    ]
}

/// Times the contenders that `args` selects.
pub fn measure(picture: Picture, truth: &Truth, args: &Args) -> Vec<Measurement> {
    let contenders: Vec<_> = contenders()
        .into_iter()
        .filter(|(name, _)| args.wants(name))
        .collect();
    if contenders.is_empty() {
        return Vec::new();
    }
    let bytes = picture.size.as_dvec2().element_product() * TEXEL as f64;
    let mut headless = app(picture);
    contenders
        .into_iter()
        .map(|(name, kind)| {
            eprintln!("{name}");
            let expected = match &kind {
                Kind::Lean(settings) => truth.of(settings),
                Kind::Bevy(settings) => {
                    let trim = (*settings.filter.start() > 0.0).then_some(TRIM);
                    truth.of(&LeanAutoExposure { trim, ..default() })
                }
            };
            let measured = run(&mut headless, &kind, args);
            Measurement {
                group: Group::InApp,
                contender: name.into(),
                passes: measured.passes,
                whole: measured.whole,
                bytes,
                luminance: Some(measured.luminance),
                error: Some(measured.luminance / expected - 1.0),
            }
        })
        .collect()
}

/// Times the passes, and reads the metered luminance.
fn run(headless: &mut Headless, kind: &Kind, args: &Args) -> Measured {
    let camera = spawn_camera(headless, kind);
    headless.settle();
    let samples = Samples::of_frames(headless, args.warm_up, args.frames);
    let span = match kind {
        Kind::Lean(_) => "lean_deferred/effects/auto_exposure",
        Kind::Bevy(_) => "auto_exposure",
    };
    let luminance = match kind {
        Kind::Lean(_) => headless
            .world()
            .get::<MeteredExposure>(camera)
            .expect("it was spawned with one")
            .luminance
            .into(),
        // Bevy's exposure brings the metered luminance to 1.
        Kind::Bevy(_) => (-f64::from(exposure(headless))).exp2(),
    };
    headless.world().despawn(camera);
    Measured {
        passes: Vec::new(),
        whole: samples.time(span),
        luminance,
    }
}

fn app(picture: Picture) -> Headless {
    let size = picture.size;
    let mut headless = Headless::with(size, |app| {
        app.add_plugins((RenderDiagnosticsPlugin, AutoExposurePlugin));
    });
    // The first frame creates the uniforms. This usage applies from the next frame on, and lets `exposure` read them.
    headless.frames(1);
    headless
        .app
        .sub_app_mut(RenderApp)
        .world_mut()
        .resource_mut::<ViewUniforms>()
        .uniforms
        .add_usages(BufferUsages::COPY_SRC);

    let world = headless.world();
    let mut image = Image::new(
        size.to_extents(),
        TextureDimension::D2,
        picture.bytes,
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.sampler = ImageSampler::nearest();
    let image = world.resource_mut::<Assets<Image>>().add(image);
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            base_color_texture: Some(image),
            unlit: true,
            ..default()
        });
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Rectangle::from_size(size.as_vec2()));
    world.spawn((Mesh3d(mesh), MeshMaterial3d(material)));
    headless
}

/// Spawns a camera at one unit per pixel.
fn spawn_camera(headless: &mut Headless, kind: &Kind) -> Entity {
    let target = headless.render_target();
    let mut camera = headless.world().spawn((
        Camera3d::default(),
        Projection::Orthographic(OrthographicProjection {
            scaling_mode: ScalingMode::WindowSize,
            ..OrthographicProjection::default_3d()
        }),
        Transform::from_xyz(0.0, 0.0, 1.0),
        (
            Hdr,
            Msaa::Off,
            Tonemapping::Reinhard,
            DebandDither::Disabled,
        ),
        target,
    ));
    match kind {
        Kind::Lean(settings) => camera.insert((settings.clone(), MeteredExposure::default())),
        Kind::Bevy(settings) => camera.insert(settings.clone()),
    };
    camera.id()
}

/// Exposure of the last frame's colour grading, in stops: auto exposure adds to it on the GPU.
fn exposure(headless: &mut Headless) -> f32 {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let offset = world
        .query::<&ViewUniformOffset>()
        .single(world)
        .expect("one camera")
        .offset;
    let size = <ViewUniform as bevy::render::render_resource::ShaderType>::min_size().get();
    let (device, queue) = (
        world.resource::<RenderDevice>(),
        world.resource::<RenderQueue>(),
    );
    let uniforms = &world.resource::<ViewUniforms>().uniforms;
    let readback = device.create_buffer(&BufferDescriptor {
        label: None,
        size,
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    let source = uniforms.buffer().expect("the view was rendered");
    encoder.copy_buffer_to_buffer(source, offset.into(), &readback, 0, size);
    queue.submit([encoder.finish()]);
    let slice = readback.slice(..);
    slice.map_async(MapMode::Read, |mapped| mapped.expect("it can be read"));
    device
        .poll(PollType::wait_indefinitely())
        .expect("the device finishes");
    let bytes = slice.get_mapped_range();
    let view: ViewUniform = UniformBuffer::new(&bytes[..])
        .create()
        .expect("it has its size");
    view.color_grading.exposure
}
