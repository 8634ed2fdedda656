//! Pictures and a table of their costs, without a window.

use std::path::{Path, PathBuf};

use bevy::{camera::Exposure, prelude::*};
use bevy_lean_deferred::gbuffer::GBufferUsage;
use figures::{table::Table, time::Time};
use indicatif::{ProgressBar, ProgressStyle};
use kit::{
    bench_spans,
    example::{panel::PanelCamera, run},
    gpu,
    gpu_time::Samples,
    headless::{Headless, Picture},
    metrics::difference,
    renderer::Renderer,
};

use crate::{
    effects::Effect,
    settings::{Place, Settings},
};

/// Frames until light has bounced and exposure has adapted.
const FRAMES_OF_EFFECTS: usize = 10;

/// Writes `path` and, beside it, a picture of each effect; prints the tables. Times are medians of `frames`.
pub fn write(headless: Headless, path: &str, frames: usize) -> AppExit {
    let mut report = Report {
        headless,
        path: path.into(),
        frames,
        bar: bar(),
        exposure: Exposure::default(),
        settings: Settings {
            renderer: Renderer::Forward,
            effects: Vec::new(),
            place: Place::Street,
            exposure: Exposure::default(),
        },
    };
    match report.write() {
        Ok(()) => AppExit::Success,
        Err(exit) => exit,
    }
}

fn bar() -> ProgressBar {
    // Each renderer, all effects together, and each of them off and on.
    let pictures = Renderer::ALL.len() + 1 + 2 * Effect::ALL.len();
    let bar = ProgressBar::new(pictures as u64 + 1);
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} {msg}");
    bar.with_style(style.expect("it is constant"))
}

struct Report {
    headless: Headless,
    path: PathBuf,
    frames: usize,
    bar: ProgressBar,
    /// The scene's.
    exposure: Exposure,
    /// Of the last picture.
    settings: Settings,
}

/// A picture, and the times of its frames.
struct Shot {
    picture: Picture,
    samples: Samples,
}

impl Report {
    fn write(&mut self) -> Result<(), AppExit> {
        self.step("the scene");
        run::make_ready(&mut self.headless)?;
        let world = self.headless.world();
        let mut exposures = world.query_filtered::<&Exposure, With<PanelCamera>>();
        self.exposure = exposures.iter(world).next().copied().unwrap_or_default();
        self.settings.exposure = self.exposure;
        let forward = self.shoot_without_effects(Renderer::Forward);
        self.write_all_effects(&forward.picture)?;
        let renderers = self.renderers(&forward)?;
        let effects = self.effects()?;
        self.bar.finish_and_clear();
        println!("{}\n{}", renderers.markdown(), effects.markdown());
        Ok(())
    }

    /// Reports the current step.
    fn step(&self, what: &str) {
        self.bar.set_message(what.to_owned());
        if self.bar.is_hidden() {
            let (at, of) = (self.bar.position() + 1, self.bar.length().unwrap_or(0));
            eprintln!("[{at}/{of}] {what}");
        }
        self.bar.inc(1);
    }

    fn shoot_without_effects(&mut self, renderer: Renderer) -> Shot {
        self.shoot(renderer.name(), |settings| {
            settings.renderer = renderer;
            settings.effects.clear();
        })
    }

    /// Writes lean with all effects beside forward: the first picture, because it is the one that was asked for.
    fn write_all_effects(&mut self, forward: &Picture) -> Result<(), AppExit> {
        let all = self.shoot("all effects", |settings| {
            settings.renderer = Renderer::Lean;
            settings.effects = Effect::ALL.into();
            // Off, because GI replaces it.
            settings.toggle(Effect::AmbientOcclusion);
            settings.toggle(Effect::AutoExposure);
        });
        let path = self.save("", &forward.split(&all.picture))?;
        self.bar.suspend(|| println!("{path}"));
        Ok(())
    }

    /// Measures each renderer without effects. Writes lean beside `forward`.
    fn renderers(&mut self, forward: &Shot) -> Result<Table, AppExit> {
        let reference = &forward.picture;
        let mut rows = vec![self.row(Renderer::Forward, forward, reference)];
        for renderer in [Renderer::BevyDeferred, Renderer::Lean] {
            let shot = self.shoot_without_effects(renderer);
            rows.push(self.row(renderer, &shot, reference));
            if renderer == Renderer::Lean {
                self.save("parity", &reference.split(&shot.picture))?;
            }
        }
        let (size, device) = (self.headless.size, self.headless.adapter_and_driver());
        let lights = self.lights();
        let mut notes = vec![
            "Lean is without effects here, as forward has none of them.".into(),
            "Camera: all passes, those of shadow maps and post-processing too.".into(),
            "FLIP: mean perceived difference; 0 is equal. Bevy deferred leaves out anisotropy, which the shutters have.".into(),
        ];
        if !gpu::is_there() {
            notes.push(
                "There is no GPU here: times of a software renderer say little of a GPU's.".into(),
            );
        }
        let columns = [
            "renderer", "geometry", "lighting", "camera", "bytes", "PSNR dB", "FLIP",
        ];
        Ok(Table {
            title: format!(
                "{}×{}, {lights} point and spot lights, {device}: median (10th–90th percentile) of {} frames in ms; \
                 bytes a pixel written by geometry / moved by geometry and lighting; errors against forward",
                size.x, size.y, self.frames
            ),
            columns: columns.map(Into::into).into(),
            rows,
            notes,
        })
    }

    fn row(&mut self, renderer: Renderer, shot: &Shot, reference: &Picture) -> Vec<String> {
        let world = self.headless.world();
        let mut usage = world.query::<&GBufferUsage>();
        let gbuffer = usage.iter(world).map(GBufferUsage::bytes_per_pixel).sum();
        let (written, moved) = renderer.bytes_per_pixel(gbuffer);
        let (geometry, lighting) = renderer.spans();
        let time = |span| Time::text(shot.samples.time(span));
        let mut row = vec![
            renderer.name().into(),
            time(geometry),
            lighting.map_or("–".into(), time),
            time(bench_spans::CAMERA),
            format!("{written} / {moved}"),
        ];
        if renderer == Renderer::Forward {
            row.extend(["–".into(), "–".into()]);
        } else {
            let difference = difference(reference, &shot.picture);
            row.extend([
                format!("{:.1}", difference.psnr),
                format!("{:.4}", difference.flip),
            ]);
        }
        row
    }

    /// Measures each effect, off and on.
    fn effects(&mut self) -> Result<Table, AppExit> {
        let mut rows = Vec::new();
        for effect in Effect::ALL {
            let exposure = effect.exposure().unwrap_or(self.exposure);
            let show = |is_on: bool| {
                move |settings: &mut Settings| {
                    settings.place = effect.place();
                    settings.exposure = exposure;
                    settings.effects = if is_on { vec![effect] } else { Vec::new() };
                }
            };
            let off = self.shoot(&format!("{} off", effect.component()), show(false));
            let on = self.shoot(effect.component(), show(true));
            let file = self.save(effect.name(), &off.picture.beside(&on.picture))?;
            let time = on.samples.sum(|span| effect.owns(span));
            rows.push(vec![
                format!("`{}`", effect.component()),
                Time::text(time),
                file,
            ]);
        }
        Ok(Table {
            title: "Effects, each alone on a lean camera: left off, right on".into(),
            columns: ["effect", "its passes", "picture"].map(Into::into).into(),
            rows,
            notes: vec!["Auto exposure is shown on a camera with the exposure of daylight.".into()],
        })
    }

    fn shoot(&mut self, what: &str, change: impl FnOnce(&mut Settings)) -> Shot {
        self.step(what);
        change(&mut self.settings);
        self.settings.apply(self.headless.world());
        // New settings take effect in the frame after.
        self.headless.frames(2);
        self.headless.settle();
        if !self.settings.effects.is_empty() {
            self.headless.frames(FRAMES_OF_EFFECTS);
        }
        let samples = Samples::of_frames(&mut self.headless, 0, self.frames);
        Shot {
            picture: self.headless.capture(),
            samples,
        }
    }

    /// Saves a picture beside the first one, with `more` in its name; returns its path.
    fn save(&self, more: &str, picture: &Picture) -> Result<String, AppExit> {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let name = match more {
            "" => format!("{stem}.png"),
            more => format!("{stem}_{more}.png"),
        };
        let path = self.path.parent().unwrap_or(Path::new("")).join(name);
        let path = path.to_string_lossy().into_owned();
        picture.try_save(&path).map_err(|error| {
            eprintln!("error: cannot write {path}: {error}");
            AppExit::error()
        })?;
        Ok(path)
    }

    fn lights(&mut self) -> usize {
        let world = self.headless.world();
        let mut lights = world.query_filtered::<(), Or<(With<PointLight>, With<SpotLight>)>>();
        lights.iter(world).count()
    }
}
