//! Tables of effects.

use super::{HD, UHD, rows_of};
use crate::{
    numbers::{fixed, median, median_us, size_of_error, sum_text},
    store::Store,
    table::Table,
};

pub fn occlusion(store: &Store) -> Table {
    let figures = store.ambient_occlusion("h200");
    let columns = [
        "", "gather", "merge", "lighting", "prepass", "all", "bytes", "MB", "wall", "plane",
    ];
    let rows = [
        ("Low, indirect", "Low, indirect"),
        ("**Medium, indirect** (default)", "Medium, indirect"),
        ("High, indirect", "High, indirect"),
        ("Ultra, indirect", "Ultra, indirect"),
        (
            "Medium, geometric normals",
            "Medium, indirect, geometric normals",
        ),
        ("Medium, binomial (no edges)", "Medium, indirect, binomial"),
        ("Medium, wide", "Medium, indirect, wide"),
        ("Medium, half", "Medium, indirect, half"),
        ("HDAO, indirect", "HDAO, indirect"),
        ("Medium, blend, on forward", "Medium, blend"),
        ("Medium, blend, half", "Medium, blend, half"),
        ("naive, on forward", "naive"),
        ("Bevy Low", "Bevy Low"),
        ("Bevy Medium", "Bevy Medium"),
        ("Bevy High", "Bevy High"),
        ("Bevy Ultra", "Bevy Ultra"),
    ];
    rows_of(&columns, &rows, |contender| {
        let m = figures.at(UHD, contender);
        let passes = [0, 1].map(|pass| median(m.passes.get(pass).copied(), 3));
        [passes.into(), figures.costs(m)].concat()
    })
}

pub fn occlusion_at_other_sizes(store: &Store) -> Table {
    let figures = store.ambient_occlusion("h200");
    let columns = ["", "1920×1080", "MB", "1400×1050", "MB"];
    let rows = [
        ("Low, indirect", "Low, indirect"),
        ("**Medium, indirect** (default)", "Medium, indirect"),
        ("High, indirect", "High, indirect"),
        ("Ultra, indirect", "Ultra, indirect"),
        ("Medium, wide", "Medium, indirect, wide"),
        ("Medium, half", "Medium, indirect, half"),
        ("HDAO, indirect", "HDAO, indirect"),
        ("Medium, blend, on forward", "Medium, blend"),
        ("naive, on forward", "naive"),
        ("Bevy Low", "Bevy Low"),
        ("Bevy Medium", "Bevy Medium"),
        ("Bevy High", "Bevy High"),
        ("Bevy Ultra", "Bevy Ultra"),
    ];
    rows_of(&columns, &rows, |contender| {
        let cells = [HD, [1400, 1050]].map(|size| {
            let m = figures.at(size, contender);
            // Without the prepass that Bevy's needs.
            let time = m.own() + figures.more_lighting(m).unwrap_or(0.0);
            [fixed(time, 3), fixed(m.megabytes(), 1)]
        });
        cells.concat()
    })
}

pub fn exposure(store: &Store) -> Table {
    let figures = store.auto_exposure("h200").at(UHD);
    let columns = ["", "meter", "adapt", "both", "GB/s", "% of copy", "error"];
    let rows = [
        ("a copy, by a compute shader", "copy, by a compute shader"),
        ("a read, nothing else", "read, nothing else"),
        ("an idle workgroup", "dispatch of one idle workgroup"),
        (
            "**log average** (default), subgroups",
            "LogAverage, subgroups",
        ),
        ("log average, shared memory", "LogAverage, shared memory"),
        ("linear average, subgroups", "LinearAverage, subgroups"),
        (
            "centre-weighted, subgroups",
            "LogAverage, CenterWeighted, subgroups",
        ),
        ("mask, subgroups", "LogAverage, Mask, subgroups"),
        (
            "trim (histogram), shared memory",
            "LogAverage, trim, shared memory",
        ),
        ("trim (histogram), subgroups", "LogAverage, trim, subgroups"),
        ("pyramid of three passes, subgroups", "pyramid, subgroups"),
        (
            "pyramid of three passes, shared memory",
            "pyramid, shared memory",
        ),
        ("in an app: log average", "in an app: LogAverage"),
        ("in an app: trim", "in an app: LogAverage, trim"),
        (
            "in an app: Bevy's `AutoExposure`, of all pixels",
            "in an app: Bevy, filter 0..=1",
        ),
        (
            "in an app: Bevy's `AutoExposure`, 0.1 to 0.9",
            "in an app: Bevy, filter 0.1..=0.9",
        ),
    ];
    rows_of(&columns, &rows, |contender| {
        let m = figures.at(contender);
        let adapt = m.passes.iter().skip(1).map(|time| time.median * 1e3);
        vec![
            median_us(m.passes.first().copied()),
            sum_text(&adapt.collect::<Vec<_>>(), 1),
            median_us(m.whole),
            fixed(m.gigabytes_per_second(), 0),
            fixed(figures.percent_of_copy(m), 0),
            size_of_error(m.error),
        ]
    })
}

pub fn exposure_at_other_sizes(store: &Store) -> Table {
    let figures = store.auto_exposure("h200");
    let columns = ["", "1920×1080", "error", "7680×4320", "error"];
    let rows = [
        (
            "**log average** (default), subgroups",
            "LogAverage, subgroups",
        ),
        ("log average, shared memory", "LogAverage, shared memory"),
        ("trim, shared memory", "LogAverage, trim, shared memory"),
        ("pyramid, subgroups", "pyramid, subgroups"),
        ("in an app: log average", "in an app: LogAverage"),
        ("in an app: Bevy's", "in an app: Bevy, filter 0..=1"),
    ];
    rows_of(&columns, &rows, |contender| {
        let cells = [HD, [7680, 4320]].map(|size| {
            let m = figures.at(size).at(contender);
            [median_us(m.whole), size_of_error(m.error)]
        });
        cells.concat()
    })
}

pub fn diffuse_gi(store: &Store) -> Table {
    let figures = store.screen_space("h200");
    let columns = [
        "",
        "levels + gather + filter, one by one",
        "together",
        "lighting",
        "all, 3840×2160",
        "all, 1920×1080",
        "bytes",
        "groove",
        "wall",
        "sphere",
    ];
    let rows = [
        ("ambient occlusion, Medium", "ambient occlusion, Medium"),
        ("Low", "GI, Low, Half"),
        ("**Medium** (default)", "GI, Medium, Half"),
        ("High", "GI, High, Half"),
        ("Ultra", "GI, Ultra, Half"),
        ("Low, full resolution", "GI, Low, Full"),
    ];
    rows_of(&columns, &rows, |contender| {
        let m = figures.at(UHD, contender);
        let times = [
            m.parts_text(),
            fixed(m.own(), 3),
            fixed(figures.more_lighting(m), 3),
            fixed(figures.all(m), 3),
            fixed(figures.all(figures.at(HD, contender)), 3),
            fixed(m.bytes, 1),
        ];
        let errors = ["groove", "wall", "sphere"].map(|scene| m.error_text(scene));
        [&times[..], &errors].concat()
    })
}

pub fn reflections(store: &Store) -> Table {
    reflections_of(store, UHD)
}

pub fn reflections_1920(store: &Store) -> Table {
    reflections_of(store, HD)
}

fn reflections_of(store: &Store, size: [u32; 2]) -> Table {
    let figures = store.screen_space("h200");
    let columns = [
        "",
        "history + hi-z + trace + spatial filter + resolve, one by one",
        "together",
        "lighting",
        "all",
        "bytes",
        "mirror",
        "without outlines",
        "0.1",
        "0.3",
        "0.5",
    ];
    let rows = [
        ("Low", "reflections, Low, Half"),
        ("**Medium** (default)", "reflections, Medium, Half"),
        ("High", "reflections, High, Half"),
        ("Medium, full resolution", "reflections, Medium, Full"),
        ("Bevy's", "Bevy's reflections"),
    ];
    rows_of(&columns, &rows, |contender| {
        let m = figures.at(size, contender);
        let times = [
            m.parts_text(),
            fixed(m.own(), 3),
            fixed(figures.more_lighting(m), 3),
            fixed(figures.all(m), 3),
            fixed(m.bytes, 1),
        ];
        let errors = ["mirror", "inside", "0.1", "0.3", "0.5"].map(|scene| m.error_text(scene));
        [&times[..], &errors].concat()
    })
}

/// Sums of effects that were measured one by one.
pub fn presets(store: &Store) -> Table {
    let occlusion = store.ambient_occlusion("h200");
    let light = store.screen_space("h200");
    let scattering = store.screen_space("h200_more");
    let columns = [
        "",
        "occlusion",
        "diffuse GI",
        "reflections",
        "scattering",
        "all, 3840×2160",
        "all, 1920×1080",
    ];
    let tenth = "scattering, High, Tenth";
    let rows = [
        ("`Low`", ["Medium, indirect, half", "", "", ""]),
        (
            "`Medium`",
            ["Medium, indirect", "", "", "scattering, Low, Tenth"],
        ),
        (
            "`High`",
            ["", "GI, Medium, Half", "reflections, Medium, Half", tenth],
        ),
        (
            "`Ultra`",
            ["", "GI, High, Half", "reflections, High, Full", tenth],
        ),
    ];
    rows_of(&columns, &rows, |contenders| {
        let times = |size| {
            let [ao, gi, reflections, subsurface] =
                contenders.map(|name| (!name.is_empty()).then_some(name));
            [
                ao.map(|name| occlusion.all(occlusion.at(size, name))),
                gi.map(|name| light.all(light.at(size, name))),
                reflections.map(|name| light.all(light.at(size, name))),
                subsurface.map(|name| scattering.all(scattering.at(size, name))),
            ]
        };
        let sum = |times: [Option<f64>; 4]| fixed(times.into_iter().flatten().sum::<f64>(), 3);
        let parts = times(UHD).map(|time| fixed(time, 3));
        [&parts[..], &[sum(times(UHD)), sum(times(HD))]].concat()
    })
}

pub fn scattering(store: &Store) -> Table {
    let figures = store.screen_space("h200_more");
    let columns = [
        "",
        "passes",
        "lighting",
        "all, 3840×2160",
        "all, 1920×1080",
        "bytes",
        "white",
        "skin: red",
        "green",
        "blue",
    ];
    let rows = [
        ("Low, all", "scattering, Low, All"),
        ("**High** (default), all", "scattering, High, All"),
        ("Low, a tenth", "scattering, Low, Tenth"),
        ("**High**, a tenth", "scattering, High, Tenth"),
    ];
    rows_of(&columns, &rows, |contender| {
        let m = figures.at(UHD, contender);
        let times = [
            m.parts_text(),
            fixed(figures.more_lighting(m), 3),
            fixed(figures.all(m), 3),
            fixed(figures.all(figures.at(HD, contender)), 3),
            fixed(m.bytes, 1),
        ];
        let errors = ["white", "skin, red", "green", "blue"].map(|scene| m.error_text(scene));
        [&times[..], &errors].concat()
    })
}
