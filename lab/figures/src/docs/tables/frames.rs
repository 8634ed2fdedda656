//! Tables of whole frames.

use super::{UHD, rows_of};
use crate::{
    benches::frame_times::Measurement,
    numbers::{fixed, median},
    store::Store,
    table::Table,
    time::Time,
};

pub fn frame_times(store: &Store) -> Table {
    let scenes = [
        "boxes_1",
        "boxes_64",
        "boxes_512",
        "FlightHelmet",
        "crowd_64",
        "crowd_512",
    ];
    let without = [
        "lean culling by subgroups",
        "lean writing diffuse light",
        "lean taking indirect light",
        // Gone; the files still have them.
        "lean 5-tap normal",
        "lean 3-tap normal",
    ];
    let figures = store.frame_times("h200");
    let measured = scenes.into_iter().flat_map(|scene| figures.of_scene(scene));
    figures.table(measured.filter(|m| !without.contains(&m.contender.as_str())))
}

pub fn levels(store: &Store) -> Table {
    store.levels("llvmpipe").views()
}

pub fn levels_times(store: &Store) -> Table {
    store.levels("h200").cameras(UHD)
}

pub fn levels_masks(store: &Store) -> Table {
    store.levels("h200").masks()
}

pub fn many_meshes(store: &Store) -> Table {
    store.many_meshes("h200").table(|times| times.render_world)
}

pub fn stutter(store: &Store) -> Table {
    store.stutter("h200").table()
}

pub fn light_scaling(store: &Store) -> Table {
    store.light_scaling("h200").table()
}

pub fn light_culling(store: &Store) -> Table {
    let figures = store.light_scaling("h200_more");
    let columns = [
        "lights of 5 m range",
        "spread: per pixel",
        "subgroups",
        "shared memory",
        "heaped: per pixel",
        "subgroups",
        "shared memory",
    ];
    let rows = [
        ("64", 64),
        ("256", 256),
        ("1,024", 1024),
        ("4,096", 4096),
        ("16,384", 16384),
    ];
    rows_of(&columns, &rows, |lights| {
        let mut cells = Vec::new();
        for arrangement in ["spread", "heaped"] {
            for culling in [
                "per pixel",
                "culling by subgroups",
                "culling in shared memory",
            ] {
                let point = figures.at((UHD, arrangement, lights), &format!("lean {culling}"));
                cells.push(median(point.stage, 2));
            }
        }
        cells
    })
}

pub fn optional_targets(store: &Store) -> Table {
    let columns = [
        "boxes",
        "geometry",
        "lighting",
        "camera",
        "bytes of lean",
        "PSNR dB",
    ];
    let rows = [
        ("plain: base only", "targets_none"),
        ("emissive", "targets_emissive"),
        ("emissive, 1 in 16", "targets_emissive_few"),
        ("reflectance", "targets_reflectance"),
        ("clearcoat", "targets_clearcoat"),
        ("anisotropy", "targets_anisotropy"),
        ("diffuse transmission", "targets_backlight"),
        ("unlit", "targets_unlit"),
        ("all of these by turns", "targets_materials"),
        ("plain, motion vectors, nothing moves", "targets_rest"),
        ("all move", "targets_motion"),
        ("all on layers", "targets_layers"),
        ("all targets", "targets_all"),
        ("all targets, 1 in 16", "targets_all_few"),
    ];
    let figures = store.frame_times("h100_more");
    rows_of(&columns, &rows, |scene| {
        let [lean, bevy] = ["lean", "Bevy deferred"].map(|name| figures.at(scene, name));
        let both = |of: fn(&Measurement) -> Option<Time>, digits: [usize; 2]| {
            let [lean, bevy] =
                [(lean, digits[0]), (bevy, digits[1])].map(|(m, digits)| median(of(m), digits));
            format!("{lean} / {bevy}")
        };
        vec![
            both(|m| m.geometry, [2, 2]),
            both(|m| m.lighting, [3, 2]),
            both(|m| m.camera, [2, 2]),
            lean.bytes_text(),
            format!("{} / {}", lean.psnr_text(), bevy.psnr_text()),
        ]
    })
}

pub fn blended(store: &Store) -> Table {
    let rows = [
        ("1600 boxes", "glass"),
        ("100 of 1600 boxes", "glass_few"),
        ("three cards among solids, all lamps near", "glass_cards"),
    ];
    beside(store, "blended", "Bevy forward", &rows, |m| m.blended)
}

pub fn light_probes(store: &Store) -> Table {
    let rows = [
        ("two reflection probes", "probes"),
        ("an irradiance volume too", "probes_volume"),
    ];
    beside(store, "light probes", "Bevy deferred", &rows, |m| {
        m.lighting
    })
}

/// Times of a stage of scenes that show the cost of one kind of mesh or light, beside a renderer of Bevy's.
fn beside(
    store: &Store,
    what: &str,
    bevys: &str,
    rows: &[(&str, &str)],
    stage: fn(&Measurement) -> Option<Time>,
) -> Table {
    let figures = store.frame_times("h200");
    rows_of(&[what, bevys, "lean", "×", "PSNR dB"], rows, |scene| {
        let [lean, bevy] = ["lean", bevys].map(|name| figures.at(scene, name));
        let times = stage(lean).zip(stage(bevy));
        let ratio = times.map(|(lean, bevy)| lean.median / bevy.median);
        vec![
            Time::text(stage(bevy)),
            Time::text(stage(lean)),
            fixed(ratio, 3),
            lean.psnr_text(),
        ]
    })
}
