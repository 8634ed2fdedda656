//! The summary of gains and costs in `docs/frame_times.md`.

use super::UHD;
use crate::{
    benches::{frame_times, screen_space},
    numbers::{fixed, median, size_of_error},
    store::Store,
    table::Table,
};

type Row = [String; 5];

pub fn summary(store: &Store) -> Table {
    let columns = ["what", "lean", "Bevy", "error: lean", "error: Bevy"];
    let effects = [occlusion, gi, reflections, scattering, exposure].map(|row| row(store));
    let rows = frames(store).into_iter().chain(effects);
    Table::new(&columns, rows.map(Into::into))
}

fn frames(store: &Store) -> [Row; 5] {
    let figures = store.frame_times("h200");
    let contenders = ["lean", "Bevy forward", "Bevy deferred"];
    let [lean, forward, deferred] = contenders.map(|name| figures.at("FlightHelmet", name));
    let camera = |m: &frame_times::Measurement| median(m.camera, 2);
    let helmet = [
        "frame, FlightHelmet under a sun".into(),
        format!("{} ms", camera(lean)),
        format!(
            "forward {}, deferred {} ms",
            camera(forward),
            camera(deferred)
        ),
        format!("{} dB from forward", lean.psnr_text()),
        format!("deferred {} dB", deferred.psnr_text()),
    ];
    let [lean, forward, deferred] = contenders.map(|name| figures.at("boxes_64", name));
    let boxes = [
        "frame, 1600 boxes under 64 lights".into(),
        format!("{} ms", camera(lean)),
        format!(
            "forward {}, deferred {} ms",
            camera(forward),
            camera(deferred)
        ),
        format!("{} dB", lean.psnr_text()),
        format!("{} dB", deferred.psnr_text()),
    ];
    let lighting = [
        "of that lighting".into(),
        format!("{} ms", median(lean.lighting, 3)),
        format!("deferred {} ms", median(deferred.lighting, 2)),
        String::new(),
        String::new(),
    ];
    let [forward, deferred] = [forward, deferred].map(frame_times::Measurement::bytes_text);
    let bytes = [
        "bytes a pixel, written by geometry / moved with lighting".into(),
        lean.bytes_text(),
        format!("forward {forward} (where nothing is overdrawn), deferred {deferred}"),
        String::new(),
        String::new(),
    ];
    let many = (UHD, "spread", 4096);
    let [lean, deferred] =
        ["lean", "Bevy deferred"].map(|name| store.light_scaling("h200").at(many, name));
    let lights = [
        "[lighting, 4,096 lights](light_scaling.md)".into(),
        format!("{} ms", median(lean.stage, 1)),
        format!("deferred {} ms", median(deferred.stage, 0)),
        format!("{} dB", fixed(lean.psnr, 1)),
        format!("{} dB", fixed(deferred.psnr, 1)),
    ];
    [helmet, boxes, lighting, bytes, lights]
}

fn occlusion(store: &Store) -> Row {
    let figures = store.ambient_occlusion("h200");
    let [lean, bevy] = ["Medium, indirect", "Bevy Medium"].map(|name| figures.at(UHD, name));
    let [own, prepass] = [Some(bevy.own()), figures.more_prepass(bevy)].map(|time| fixed(time, 3));
    let [lean_rmse, bevy_rmse] = [lean, bevy].map(|m| fixed(m.wall.map(|(rmse, _)| rmse), 3));
    [
        "[occlusion](internals/ambient_occlusion.md)".into(),
        format!(
            "{:.3} ms, {:.1} bytes",
            figures.all(lean),
            lean.bytes.compulsory
        ),
        format!(
            "{own} + {prepass} for its prepass, {:.1} bytes",
            bevy.bytes.compulsory
        ),
        format!("RMSE {lean_rmse}"),
        bevy_rmse,
    ]
}

fn gi(store: &Store) -> Row {
    let figures = store.screen_space("h200");
    let m = figures.at(UHD, "GI, Medium, Half");
    let [least, most] = ["wall", "groove"].map(|scene| rmse(m, scene));
    [
        "[diffuse GI](internals/diffuse_gi.md), occlusion included".into(),
        format!("{:.3} ms, {:.1} bytes", figures.all(m), m.bytes),
        "–".into(),
        format!("RMSE {least} to {most} (radius 100 m, timed with 4 m)"),
        "–".into(),
    ]
}

fn reflections(store: &Store) -> Row {
    let figures = store.screen_space("h200");
    let [lean, bevy] =
        ["reflections, Medium, Half", "Bevy's reflections"].map(|name| figures.at(UHD, name));
    let errors =
        |m: &screen_space::Measurement| ["mirror", "inside", "0.3"].map(|scene| rmse(m, scene));
    let ([mirror, inside, rough], bevys) = (errors(lean), errors(bevy).join(", "));
    [
        "[reflections](internals/reflections.md)".into(),
        format!("{:.3} ms, {:.1} bytes", figures.all(lean), lean.bytes),
        format!("{:.2} ms, {:.1} bytes", figures.all(bevy), bevy.bytes),
        format!("RMSE (1440×1440) {mirror} in a mirror, {inside} without outlines, {rough} rough"),
        format!("{bevys}; one frame, no TAA"),
    ]
}

fn scattering(store: &Store) -> Row {
    let figures = store.screen_space("h200_more");
    let [tenth, all] =
        ["Tenth", "All"].map(|share| figures.at(UHD, &format!("scattering, High, {share}")));
    let [least, most] = ["white", "skin, red"].map(|scene| rmse(all, scene));
    [
        "[scattering](internals/subsurface.md), a tenth of the picture".into(),
        format!("{:.3} ms, {:.1} bytes", figures.all(tenth), tenth.bytes),
        "–".into(),
        format!("RMSE {least} to {most}"),
        "–".into(),
    ]
}

fn rmse(m: &screen_space::Measurement, scene: &str) -> String {
    fixed(m.error(scene).map(|(rmse, _)| rmse), 3)
}

fn exposure(store: &Store) -> Row {
    let figures = store.auto_exposure("h200").at(UHD);
    let [lean, bevy] =
        ["LogAverage", "Bevy, filter 0..=1"].map(|name| figures.at(&format!("in an app: {name}")));
    let [lean_time, bevy_time] = [lean, bevy].map(|m| format!("{} ms", median(m.whole, 3)));
    [
        "[exposure](internals/auto_exposure.md)".into(),
        lean_time,
        bevy_time,
        // Above the errors at all sizes, of which the largest is 2.2e-8: less than the precision of a float.
        "relative, under 1e-7".into(),
        size_of_error(bevy.error),
    ]
}
