//! Measures the views of one level with one renderer.

use core::any::TypeId;
use std::path::Path;

use bevy::{
    camera::{Hdr, visibility::VisibleEntities},
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    reflect::structs::Struct,
    render::{RenderApp, diagnostic::RenderDiagnosticsPlugin},
};
use bevy_lean_deferred::{
    gbuffer::{GBufferUsage, MaskedPipelines},
    prelude::*,
};
use figures::benches::levels::{ForwardMeshes, Measurement};
use kit::{
    bench_spans::{BLENDED, CAMERA, add_bench_spans},
    gpu_time::Samples,
    headless::{Headless, Picture},
    levels::{Level, LoadedLevel, View, evenly_spread},
    metrics::pixel_difference,
};

use crate::{Extent, contender::Contender};

/// Prefix of the spans of effects.
const EFFECTS: &str = "lean_deferred/effects/";

/// A measured view.
pub struct Shot {
    pub figures: Measurement,
    picture: Picture,
    /// Frames of the walk from this view.
    walk: Vec<Picture>,
}

impl Shot {
    /// Writes the pictures into `folder`.
    pub fn save(&self, folder: &Path) {
        let Measurement {
            level,
            view,
            contender,
            ..
        } = &self.figures;
        let stem = format!("{level}_{view}_{}", contender.replace(' ', "_"));
        self.picture.save(folder.join(format!("{stem}.png")));
        for (frame, picture) in self.walk.iter().enumerate() {
            picture.save(folder.join(format!("{stem}_walk_{frame:02}.png")));
        }
    }

    /// Notes the errors against `reference`, a shot of the same view.
    pub fn compare_with(&mut self, reference: &Self) {
        let difference = pixel_difference(&reference.picture, &self.picture);
        self.figures.psnr = finite(difference.psnr);
        self.figures.off_by_8 = Some(difference.off_by_8);
        let frames = reference.walk.iter().zip(&self.walk);
        let worst = frames.map(|(theirs, own)| pixel_difference(theirs, own).psnr);
        self.figures.walk_psnr = worst.min_by(f64::total_cmp).and_then(finite);
    }
}

/// `None` for equal pictures: JSON cannot express infinity.
fn finite(psnr: f64) -> Option<f64> {
    psnr.is_finite().then_some(psnr)
}

/// Measures the views of `path` or, without it, those of the level.
pub fn measure(
    level: &Level,
    contender: Contender,
    path: Option<&[View]>,
    extent: Extent,
) -> Result<Vec<Shot>, String> {
    let mut headless = Headless::with(extent.size, |app| {
        app.add_plugins(RenderDiagnosticsPlugin);
        if contender == Contender::BevyDeferred {
            app.insert_resource(DefaultOpaqueRendererMethod::deferred());
        }
        add_bench_spans(app);
        if contender == Contender::LeanOneDraw {
            app.sub_app_mut(RenderApp)
                .insert_resource(MaskedPipelines::off());
        }
    });
    let loaded = level.spawn(&mut headless)?;
    let camera = spawn_camera(&mut headless, level, contender, extent);
    let views = path.unwrap_or(&loaded.views);
    let mut shots = Vec::new();
    for view in evenly_spread(views.len(), extent.views) {
        let place = (views[view].transform(), CameraCut);
        headless.world().entity_mut(camera).insert(place);
        headless.settle();
        let samples = Samples::of_frames(&mut headless, extent.warm_up, extent.frames);
        if contender.is_lean() && usage(&headless, camera).is_none() {
            return Err(format!("{}: the lean camera was drawn forward", level.name));
        }
        let figures = Measurement {
            view,
            ..figures(
                &headless,
                camera,
                (level, &loaded),
                contender,
                extent,
                &samples,
            )
        };
        let picture = headless.capture();
        let walk = headless.film(extent.walk, |world, frame| {
            let place = views[view].walked(frame + 1);
            world.entity_mut(camera).insert(place);
        });
        shots.push(Shot {
            figures,
            picture,
            walk,
        });
    }
    Ok(shots)
}

fn spawn_camera(
    headless: &mut Headless,
    level: &Level,
    contender: Contender,
    extent: Extent,
) -> Entity {
    let target = headless.render_target();
    let world = headless.world();
    let mut commands = world.commands();
    let mut camera = commands.spawn((
        Camera3d::default(),
        Hdr,
        Msaa::Off,
        target,
        level.exposure(),
    ));
    contender.dress(extent.preset, &mut camera);
    let camera = camera.id();
    world.flush();
    camera
}

/// Targets of a lean camera's G-buffer; `None` while it has none.
fn usage(headless: &Headless, camera: Entity) -> Option<GBufferUsage> {
    let usage = headless.app.world().get::<GBufferUsage>(camera)?;
    usage.is_active().then_some(*usage)
}

fn figures(
    headless: &Headless,
    camera: Entity,
    (level, loaded): (&Level, &LoadedLevel),
    contender: Contender,
    extent: Extent,
    samples: &Samples,
) -> Measurement {
    let world = headless.app.world();
    let renderer = contender.renderer();
    let (geometry, lighting) = renderer.spans();
    let gbuffer = usage(headless, camera).map_or(0, |usage| usage.bytes_per_pixel());
    let (bytes_written_by_geometry, bytes_in_all) = renderer.bytes_per_pixel(gbuffer);
    let visible = world.get::<VisibleEntities>(camera);
    Measurement {
        device: headless.adapter_and_driver(),
        size: extent.size.to_array(),
        frames: extent.frames,
        level: level.name.clone(),
        view: 0,
        contender: contender.name().into(),
        meshes: visible.map_or(0, |visible| visible.len(TypeId::of::<Mesh3d>())),
        lights: loaded.lights,
        lightmapped: loaded.lightmapped,
        geometry: samples.time(geometry),
        fragments: (samples.fragments(geometry))
            .map(|count| count / f64::from(extent.size.element_product())),
        lighting: lighting.and_then(|name| samples.time(name)),
        effects: samples.sum_within(EFFECTS),
        blended: samples.time(BLENDED),
        camera: samples.time(CAMERA),
        spans: samples.medians(),
        bytes_written_by_geometry,
        bytes_in_all,
        psnr: None,
        off_by_8: None,
        walk_psnr: None,
        memory: (world.get::<LeanMemory>(camera)).map_or(Vec::new(), bytes_by_field),
        forward: forward_meshes(world.get(camera), loaded),
    }
}

fn bytes_by_field(memory: &LeanMemory) -> Vec<(String, u64)> {
    let fields = (0..memory.field_len()).filter_map(|index| {
        let bytes = memory.field_at(index)?.try_downcast_ref::<u64>()?;
        Some((memory.name_at(index)?.to_owned(), *bytes))
    });
    fields.collect()
}

/// The reasons for which forward draws meshes of a lean camera, with the names of some materials.
fn forward_meshes(report: Option<&LeanForwardMeshes>, loaded: &LoadedLevel) -> Vec<ForwardMeshes> {
    let Some(report) = report else {
        return Vec::new();
    };
    let reasons = report.counts.iter().map(|(reason, meshes)| {
        let materials = report.first.iter().filter(|(_, other)| other == reason);
        let names = materials.filter_map(|(material, _)| loaded.material_names.get(material));
        ForwardMeshes {
            reason: reason.to_string(),
            meshes: *meshes,
            materials: names.cloned().collect(),
        }
    });
    reasons.collect()
}
