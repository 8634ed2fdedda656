//! Levels as glTF files: GPU time, bytes, error and memory of a frame by Bevy forward, Bevy deferred and this crate, and the meshes that
//! its cameras leave to forward.
//!
//! `cargo bench --bench levels -- [FILE…] [--help]`
//!
//! `fetch.sh` fetches and converts levels of free games. `docs/levels.md` has the conventions for the files beside a glTF file. Without a
//! file, the bench measures a small room that it writes itself.

mod contender;
mod run;

use std::path::Path;

use argh::FromArgs;
use bevy::math::UVec2;
use bevy_lean_deferred::LeanPreset;
use contender::Contender;
use figures::benches::{Figures, Levels};
use kit::{
    figures::write_json,
    levels::{Level, read_views, write_room},
    size::parse_size,
};
use run::Shot;

/// GPU time, bytes, error and memory of glTF levels: Bevy forward, Bevy deferred, this crate, this crate with effects.
#[derive(FromArgs)]
struct Args {
    /// glTF or GLB files; without one, a small room
    #[argh(positional)]
    files: Vec<String>,

    /// only the contenders with these names, comma-separated, or all; Bevy forward is the reference of the others
    #[argh(option)]
    contender: Option<String>,

    /// effects of "lean with effects": low, medium, high (the default) or ultra
    #[argh(option, default = "LeanPreset::High")]
    preset: LeanPreset,

    /// number of views, spread evenly over those of the level, default 3
    #[argh(option)]
    views: Option<usize>,

    /// file with a JSON list of views, as in level.json, in place of those of the levels
    #[argh(option)]
    path: Option<String>,

    /// frames of a walk from each view, with a turning camera, default 0
    #[argh(option, default = "0")]
    walk: usize,

    /// width x height of the picture, default 3840x2160
    #[argh(option, from_str_fn(parse_size))]
    size: Option<UVec2>,

    /// measured frames, default 40
    #[argh(option)]
    frames: Option<usize>,

    /// warm-up frames, default 32
    #[argh(option)]
    warm_up: Option<usize>,

    /// one view, a small picture and few frames, for software renderers
    #[argh(switch)]
    quick: bool,

    /// write the figures to this file
    #[argh(option)]
    json: Option<String>,

    /// write each picture into this folder, with the credits of the levels
    #[argh(option)]
    pictures: Option<String>,

    /// given by cargo
    #[argh(switch)]
    #[expect(dead_code, reason = "cargo bench passes it")]
    bench: bool,
}

/// Extent of the measurements.
#[derive(Clone, Copy)]
struct Extent {
    size: UVec2,
    views: usize,
    frames: usize,
    warm_up: usize,
    walk: usize,
    preset: LeanPreset,
}

impl Args {
    fn extent(&self) -> Extent {
        let (size, views, frames, warm_up) = match self.quick {
            true => (UVec2::new(320, 180), 1, 4, 4),
            false => (UVec2::new(3840, 2160), 3, 40, 32),
        };
        Extent {
            size: self.size.unwrap_or(size),
            views: self.views.unwrap_or(views),
            frames: self.frames.unwrap_or(frames),
            warm_up: self.warm_up.unwrap_or(warm_up),
            walk: self.walk,
            preset: self.preset,
        }
    }

    fn levels(&self) -> Result<Vec<Level>, String> {
        if self.files.is_empty() {
            let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("room");
            write_room(&folder)?;
            let file = folder.join("scene.gltf");
            return Ok(vec![Level::open(&file.to_string_lossy())?]);
        }
        self.files.iter().map(|file| Level::open(file)).collect()
    }

    fn contenders(&self) -> Result<Vec<Contender>, String> {
        let defaults = || Contender::ALL.into_iter().filter(|c| c.is_default());
        let names = self.contender.as_deref();
        names.map_or_else(|| Ok(defaults().collect()), Contender::named)
    }
}

fn main() {
    let args: Args = argh::from_env();
    if let Err(error) = measure(&args) {
        eprintln!("error: {error}");
        std::process::exit(1);
    }
}

fn measure(args: &Args) -> Result<(), String> {
    let path = args.path.as_ref();
    let path = path.map(|path| read_views(Path::new(path))).transpose()?;
    let (levels, contenders) = (args.levels()?, args.contenders()?);
    let total = levels.len() * contenders.len();
    let mut measurements = Levels::default();
    let mut done = 0;
    for level in &levels {
        // Forward's, in the order of the views.
        let mut references: Vec<Shot> = Vec::new();
        if let Some(folder) = &args.pictures {
            keep_credits(level, Path::new(folder))?;
        }
        for contender in &contenders {
            done += 1;
            eprintln!("[{done}/{total}] {}: {}", level.name, contender.name());
            let shots = run::measure(level, *contender, path.as_deref(), args.extent())?;
            for (index, mut shot) in shots.into_iter().enumerate() {
                if let Some(folder) = &args.pictures {
                    shot.save(Path::new(folder));
                }
                if let Some(reference) = references.get(index).filter(|_| contender.is_compared()) {
                    shot.compare_with(reference);
                }
                eprintln!("{}", Levels::row(&shot.figures));
                measurements.0.push(shot.figures.clone());
                if *contender == Contender::Forward {
                    references.push(shot);
                }
            }
            // After each contender, so that an interrupted run keeps its results.
            if let Some(path) = &args.json {
                write_json(path, &measurements);
            }
        }
    }
    println!("{}", measurements.markdown());
    Ok(())
}

/// Copies the file with a level's licence and credits, which its pictures need.
fn keep_credits(level: &Level, folder: &Path) -> Result<(), String> {
    let Some(credits) = level.credits() else {
        return Ok(());
    };
    let copy = folder.join(format!("{}_credits.json", level.name));
    std::fs::create_dir_all(folder)
        .and_then(|()| std::fs::copy(credits, &copy))
        .map_err(|error| format!("{}: {error}", copy.display()))?;
    Ok(())
}
