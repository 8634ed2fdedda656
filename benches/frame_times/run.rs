//! Measures one scene with one renderer.

use bevy::{
    camera::Hdr,
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    render::{RenderApp, diagnostic::RenderDiagnosticsPlugin},
};
use bevy_lean_deferred::{
    LightCulling,
    gbuffer::GBufferUsage,
    lighting::LightsByFragments,
    prelude::*,
    view::{
        IndirectDiffuse, IndirectSpecular, LeanDeferredAdvanced, LightingIo, ReadsDiffuseLight,
    },
};
use figures::benches::frame_times::Measurement;

use crate::{scenes::BenchScene, special};
use kit::{
    bench_spans::{self, add_bench_spans},
    gpu_time::Samples,
    hdr::{change_views, even_texture},
    headless::{Headless, Picture},
    metrics,
    renderer::Renderer,
};

/// A way to render the scene.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Contender {
    Forward,
    BevyDeferred,
    /// Forward with a depth prepass. The geometry column has the prepass alone: no G-buffer can be cheaper.
    DepthOnly,
    Lean,
    /// Lean, with lights culled per tile.
    LeanCulling(LightCulling),
    /// Lean, with lighting by a fragment shader.
    LeanFragment,
    /// Lean, with light that lighting exchanges with effects.
    LeanLightingIo(LightingIo),
}

impl Contender {
    /// Forward first: it is the reference of the others.
    pub const ALL: [Self; 9] = [
        Self::Forward,
        Self::DepthOnly,
        Self::BevyDeferred,
        Self::Lean,
        Self::LeanFragment,
        Self::LeanCulling(LightCulling::Subgroup),
        Self::LeanCulling(LightCulling::SharedMemory),
        Self::LeanLightingIo(LightingIo::DIFFUSE_LIGHT),
        Self::LeanLightingIo(LightingIo::INDIRECT),
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Forward => "Bevy forward",
            Self::DepthOnly => "Bevy depth prepass",
            Self::BevyDeferred => "Bevy deferred",
            Self::Lean => "lean",
            Self::LeanFragment => "lean lighting by fragments",
            Self::LeanCulling(LightCulling::Subgroup) => "lean culling by subgroups",
            Self::LeanCulling(_) => "lean culling in shared memory",
            Self::LeanLightingIo(LightingIo::DIFFUSE_LIGHT) => "lean writing diffuse light",
            Self::LeanLightingIo(_) => "lean taking indirect light",
        }
    }

    /// Tells if the contender is a renderer with its defaults.
    pub fn is_plain(self) -> bool {
        matches!(self, Self::Forward | Self::BevyDeferred | Self::Lean)
    }

    /// Bytes per pixel, as [`Renderer::bytes_per_pixel`]. Motion vectors have 4.
    fn bytes_per_pixel(self, gbuffer: u32, motion: bool) -> (u32, u32) {
        let motion = if motion { 4 } else { 0 };
        let (written, moved) = match self {
            Self::Forward => Renderer::Forward.bytes_per_pixel(gbuffer),
            Self::DepthOnly => (4, 4 + 8),
            Self::BevyDeferred => Renderer::BevyDeferred.bytes_per_pixel(gbuffer),
            // Resolving motion reads depth and normal; lighting also reads the target.
            _ => {
                let (written, moved) = Renderer::Lean.bytes_per_pixel(gbuffer);
                (written, moved + self.exchanged_bytes() + 2 * motion)
            }
        };
        (written + motion, moved + motion)
    }

    /// One word of diffuse light, or two times four half floats.
    fn exchanged_bytes(self) -> u32 {
        match self {
            Self::LeanLightingIo(LightingIo::DIFFUSE_LIGHT) => 4,
            Self::LeanLightingIo(_) => 16,
            _ => 0,
        }
    }

    /// Names of the GPU spans of the geometry stage and of the lighting stage.
    fn spans(self) -> (&'static str, Option<&'static str>) {
        match self {
            Self::Forward => Renderer::Forward.spans(),
            Self::DepthOnly => (bench_spans::PREPASS, None),
            Self::BevyDeferred => Renderer::BevyDeferred.spans(),
            _ => Renderer::Lean.spans(),
        }
    }
}

/// Difference between a picture and forward's.
pub struct Difference {
    pixels: metrics::Difference,
    flip: Option<f64>,
}

impl Difference {
    pub fn of(reference: &Picture, picture: &Picture, flip: bool) -> Self {
        Self {
            pixels: metrics::pixel_difference(reference, picture),
            flip: flip.then(|| metrics::flip(reference, picture)),
        }
    }

    pub fn write_into(&self, measurement: &mut Measurement) {
        measurement.psnr = Some(self.pixels.psnr);
        measurement.off_by_8 = Some(self.pixels.off_by_8);
        measurement.flip = self.flip;
    }
}

/// Renders `warm_up` frames, then measures `frames`.
pub fn measure(
    scene: &BenchScene,
    contender: Contender,
    size: UVec2,
    warm_up: usize,
    frames: usize,
) -> (Measurement, Picture) {
    let mut headless = Headless::with(size, |app| {
        app.add_plugins(RenderDiagnosticsPlugin);
        if contender == Contender::BevyDeferred {
            app.insert_resource(DefaultOpaqueRendererMethod::deferred());
        }
        add_bench_spans(app);
        app.add_systems(Update, special::move_boxes);
        if contender == Contender::LeanFragment {
            app.sub_app_mut(RenderApp)
                .init_resource::<LightsByFragments>();
        }
    });
    let transform = scene.spawn(&mut headless);
    let target = headless.render_target();
    let camera = headless
        .world()
        .spawn((Camera3d::default(), Hdr, Msaa::Off, target, transform))
        .id();
    let mut camera = headless.app.world_mut().entity_mut(camera);
    scene.special().prepare_camera(&mut camera);
    match contender {
        Contender::Forward => {}
        Contender::DepthOnly => {
            camera.insert(DepthPrepass);
        }
        Contender::BevyDeferred => {
            camera.insert((DepthPrepass, DeferredPrepass));
        }
        Contender::Lean | Contender::LeanFragment | Contender::LeanLightingIo(_) => {
            camera.insert(LeanDeferred::default());
        }
        Contender::LeanCulling(light_culling) => {
            camera.insert(LeanDeferred {
                advanced: LeanDeferredAdvanced {
                    light_culling,
                    ..default()
                },
                ..default()
            });
        }
    }

    headless.settle();
    if let Contender::LeanLightingIo(exchange) = contender {
        exchange_light(&mut headless, exchange);
        headless.settle();
    }
    let samples = Samples::of_frames(&mut headless, warm_up, frames);
    let (geometry, lighting) = contender.spans();
    let (bytes_written_by_geometry, bytes_in_all) =
        contender.bytes_per_pixel(gbuffer_bytes(&mut headless), scene.special().wants_motion());
    let measurement = Measurement {
        device: headless.adapter_and_driver(),
        size: Some(size.to_array()),
        frames: Some(frames),
        scene: scene.name.clone(),
        contender: contender.name().into(),
        geometry: samples.time(geometry),
        lighting: lighting.and_then(|name| samples.time(name)),
        blended: samples.time(bench_spans::BLENDED),
        camera: samples.time(bench_spans::CAMERA),
        bytes_written_by_geometry,
        bytes_in_all,
        psnr: None,
        flip: None,
        off_by_8: None,
    };
    (measurement, headless.capture())
}

/// Makes lighting write its diffuse light, or take indirect light from an effect, the same everywhere.
fn exchange_light(headless: &mut Headless, exchange: LightingIo) {
    let found = (exchange == LightingIo::INDIRECT)
        .then(|| even_texture(headless, headless.size, [0.1, 0.1, 0.1, 0.5]));
    change_views(headless, |view| match &found {
        Some(found) => {
            view.insert(IndirectSpecular(Some(found.clone())));
            view.insert(IndirectDiffuse {
                texture: Some(found.clone()),
                is_half: false,
            });
        }
        None => {
            view.insert(ReadsDiffuseLight);
        }
    });
}

/// Bytes per pixel of the lean camera's G-buffer; 0 if it has none.
fn gbuffer_bytes(headless: &mut Headless) -> u32 {
    let world = headless.world();
    let mut cameras = world.query::<&GBufferUsage>();
    cameras.iter(world).map(GBufferUsage::bytes_per_pixel).sum()
}
