//! Files as the benches write them, old and new: reading them, and making tables and plots of them.

use std::{fs, path::PathBuf};

use bevy_lean_deferred_figures::{
    benches::{Bench, Figures},
    docs::tables::TABLES,
    page,
    store::{Bundle, Store, benches_in},
};

/// A folder that is deleted after the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("figures_{name}_{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn write(&self, file: &str, text: &str) {
        fs::write(self.0.join(file), text).unwrap();
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn read(file: &str, json: &str) -> Bench {
    let folder = Folder::new(file);
    folder.write(file, json);
    let mut benches = benches_in(&folder.0).unwrap();
    assert_eq!(benches.len(), 1);
    benches.remove(0)
}

#[track_caller]
fn has_rows(bench: &Bench, rows: &[&str]) {
    let markdown = bench.figures().markdown();
    for row in rows {
        assert!(markdown.contains(row), "{row}\n{markdown}");
    }
    for plot in bench.figures().plots() {
        assert!(
            plot.svg.starts_with("<svg") && plot.svg.trim().ends_with("</svg>"),
            "{}",
            plot.name
        );
    }
}

const FRAME_TIMES: &str = r#"[
    {"adapter": "GPU", "scene": "s", "contender": "Bevy forward", "geometry": {"median": 8, "low": 7, "high": 9},
     "lighting": null, "camera": {"median": 10, "low": 9, "high": 11}, "bytes_written_by_geometry": 12, "bytes_in_all": 12,
     "psnr": null, "flip": null, "off_by_8": null},
    {"adapter": "GPU", "scene": "s", "contender": "Bevy depth prepass", "geometry": null,
     "lighting": null, "camera": null, "bytes_written_by_geometry": 4, "bytes_in_all": 12,
     "psnr": null, "flip": 0.0, "off_by_8": 0.0},
    {"adapter": "GPU", "scene": "s", "contender": "Bevy deferred", "geometry": {"median": 4, "low": 4, "high": 4},
     "lighting": {"median": 2, "low": 2, "high": 2}, "camera": {"median": 9, "low": 9, "high": 9},
     "bytes_written_by_geometry": 21, "bytes_in_all": 62, "psnr": 58.04, "flip": 0.01, "off_by_8": 0.00008},
    {"adapter": "GPU", "driver": "D 1", "size": [64, 32], "frames": 4, "scene": "s", "contender": "lean",
     "geometry": {"median": 1, "low": 1, "high": 1}, "lighting": {"median": 0.5, "low": 0.25, "high": 1},
     "camera": {"median": 3, "low": 3, "high": 3}, "bytes_written_by_geometry": 12, "bytes_in_all": 32,
     "psnr": 52.0, "flip": null, "off_by_8": 0.5}
]"#;

#[test]
fn frame_times() {
    let without_sizes =
        FRAME_TIMES.replace(r#""driver": "D 1", "size": [64, 32], "frames": 4, "#, "");
    let bench = read("frame_times.json", &without_sizes);
    has_rows(
        &bench,
        &[
            "| s | Bevy forward | 8.000 (7.000–9.000) | 2.00 | – | – | 10.000 (9.000–11.000) | 12 / 12 | – | – | – |",
            "| s | Bevy depth prepass | – | – | – | – | – | 4 / 12 | ∞ | 0.0000 | 0.000% |",
            "| s | lean | 1.000 (1.000–1.000) | 0.25 | 0.500 (0.250–1.000) | 0.250 | 3.000 (3.000–3.000) | 12 / 32 | 52.0 | – \
             | 50.000% |",
        ],
    );
    let names: Vec<String> = bench
        .figures()
        .plots()
        .into_iter()
        .map(|plot| plot.name)
        .collect();
    assert_eq!(names, ["speed_s", "stages", "bytes"]);
    let Bench::FrameTimes(figures) = read("frame_times.json", FRAME_TIMES) else {
        panic!("the file has the name of another bench");
    };
    assert_eq!(figures.0[3].size, Some([64, 32]));
}

#[test]
fn ambient_occlusion() {
    let bench = read(
        "ambient_occlusion.json",
        r#"[
        {"adapter": "GPU", "size": [1000, 1000], "contender": "lean camera, none", "lean": true, "passes": [],
         "lighting": {"median": 0.25, "low": 0, "high": 1}, "prepass": null, "camera": null,
         "bytes": {"compulsory": 0, "compulsory_with_depth": 0, "fetched": 0}, "occluded": 0, "wall": null, "plane": null},
        {"adapter": "GPU", "size": [1000, 1000], "contender": "Low, indirect", "lean": true,
         "passes": [{"median": 0.5, "low": 0.25, "high": 1}], "lighting": {"median": 0.375, "low": 0, "high": 1},
         "prepass": null, "camera": null, "bytes": {"compulsory": 2, "compulsory_with_depth": 14, "fetched": 145},
         "occluded": 0.1, "wall": [0.0384, -0.016], "plane": 0}
    ]"#,
    );
    has_rows(
        &bench,
        &[
            "**1000×1000**",
            "| Low, indirect | 0.500 (0.250–1.000) | – | 0.125 | – | 0.625 | 2.0 / 14.0 / 145 | 2.0 | 0.038 (-0.016) | 0.0000 |",
        ],
    );
}

#[test]
fn screen_space() {
    let bench = read(
        "screen_space.json",
        r#"[
        {"adapter": "GPU", "size": [64, 32], "contender": "none", "passes": [],
         "lighting": {"median": 0.25, "low": 0, "high": 1}, "camera": null, "bytes": 0, "errors": []},
        {"adapter": "GPU", "size": [64, 32], "contender": "Bevy's reflections",
         "passes": [{"median": 2, "low": 2, "high": 2}], "lighting": null, "camera": null, "bytes": 40,
         "errors": [{"scene": "inside", "rmse": 0.167, "bias": -0.044}, {"scene": "0.3", "rmse": 0.25, "bias": 0.5}]},
        {"adapter": "GPU", "size": [64, 32], "contender": "reflections, Low, Half",
         "passes": [{"median": 0.5, "low": 0, "high": 1}, {"median": 0.25, "low": 0, "high": 1}],
         "stages": [{"median": 0.5, "low": 0, "high": 1}, {"median": 0.375, "low": 0, "high": 1}],
         "lighting": {"median": 0.5, "low": 0, "high": 1}, "camera": null, "bytes": 49.7, "errors": []}
    ]"#,
    );
    has_rows(
        &bench,
        &[
            "**64×32**, reflections\n\n| contender | stages | lighting | all | camera | bytes | inside | 0.3 |",
            "| Bevy's reflections | 2.000 | – | 2.000 | – | 40.0 | 0.167 (-0.044) | 0.250 (+0.500) |",
            "| reflections, Low, Half | 0.500 + 0.375 | 0.250 | 1.000 | – | 49.7 | – | – |",
        ],
    );
    assert!(!bench.figures().markdown().contains("scattering"));
}

#[test]
fn motion() {
    let path = |path: &str, contender: &str, lag: &str| {
        format!(
            r#"{{"adapter": "GPU", "size": [64, 32], "subject": "reflections", "contender": "{contender}", "path": "{path}",
            "frames": [1, 2], "rmse": [0.25, 0.5], "rest": [0.25, 0.25], "flip": [0.125, 0.25], "flicker": 0.5,
            "flicker_at_rest": 0, "trail": 3, "lag": {lag}}}"#
        )
    };
    let paths = [
        path("walk", "lean", "null"),
        path("lamp", "lean", "5"),
        path("walk", "Bevy's SSR + TAA", "null"),
    ];
    let lamp = |roughness: &str| {
        format!(
            r#"{{"adapter": "GPU", "size": [64, 32], "subject": "reflections", "contender": "lean", "light": 200,
            "roughness": {roughness}, "frames": 32, "rmse": 0.125, "bias": -0.25, "rotation": 12}}"#
        )
    };
    let json = format!(
        r#"{{"paths": [{}], "lamps": [{}, {}]}}"#,
        paths.join(","),
        lamp("0.3"),
        lamp("null")
    );
    has_rows(
        &read("motion.json", &json),
        &[
            "**64×32**, reflections\n",
            "| walk | lean | 0.3750 | 0.5000 | 0.2500 | 1.50 | 0.1875 | 0.2500 | 0.5000 | 0.0000 | 3 | – |\n| walk | Bevy's SSR + TAA |",
            "| 0.0000 | 3 | 5 |",
            "**64×32**, reflections, beneath a lamp",
            "| 0.3 | 200 | lean | 32 | 0.125 (-0.250) | 12.00 |",
            "| diffuse | 200 | lean |",
        ],
    );
}

#[test]
fn auto_exposure() {
    let bench = read(
        "auto_exposure.json",
        r#"[{"adapter": "GPU", "size": [1000, 1000], "pictures": 4, "measurements": [
        {"group": "Copy", "contender": "copy", "passes": [{"median": 0.016, "low": 0.015, "high": 0.02}],
         "whole": {"median": 0.016, "low": 0.015, "high": 0.02}, "bytes": 16000000, "luminance": null, "error": null},
        {"group": "Lean", "contender": "LogAverage", "passes": [{"median": 0.016, "low": 0.016, "high": 0.016}],
         "whole": {"median": 0.02, "low": 0.02, "high": 0.02}, "bytes": 8000000, "luminance": 1, "error": -0.5}
    ]}]"#,
    );
    has_rows(
        &bench,
        &[
            "**1000×1000**, the picture in 4 textures",
            "| copy | 16.0 (15.0–20.0) | – | – | 16.0 (15.0–20.0) | 1000.0 | 100.0 | – |",
            "| 500.0 | 50.0 | -5.0e-1 (-1.000 stops) |",
        ],
    );
}

#[test]
fn many_meshes() {
    let measurement = |contender: &str, time: f64, psnr: &str| {
        let times = format!(r#"{{"render_world": {time}, "frame": {}}}"#, 2.0 * time);
        format!(
            r#"{{"adapter": "GPU", "cores": 2, "meshes": 1000, "contender": "{contender}",
            "steady": [{times}, {times}, {times}], "emissive": {times}, "expiry": {times}, "turn": {times},
            "turn_stages": [["queue", 0.5]], "psnr": {psnr}, "flip": 0.0}}"#
        )
    };
    let all = [
        ("Bevy forward", 2.0, "null"),
        ("Bevy deferred", 4.0, "67.3"),
        ("lean", 3.0, "64.7"),
    ];
    let all = all.map(|(contender, time, psnr)| measurement(contender, time, psnr));
    let bench = read("many_meshes.json", &format!("[{}]", all.join(",")));
    has_rows(
        &bench,
        &[
            "| 1,000 | lean | 3.00 (× 0.75) | 3.00 (× 0.75) |",
            "| 1,000 | lean | 6.00 (× 0.75) |",
            "| 1,000 | Bevy forward | 2.00 (× 0.50) | 2.00 (× 0.50) | 2.00 (× 0.50) | 2.00 (× 0.50) | 2.00 (× 0.50) \
             | 2.00 (× 0.50) | – | – |",
        ],
    );
}

#[test]
fn light_scaling() {
    let point = |lights: u32, contender: &str, stage: &str, left_out: &str| {
        format!(
            r#"{{"size": [64, 32], "arrangement": "spread", "lights": {lights}, "contender": "{contender}",
            "left_out": {left_out}, "frames": 4, "stage": {stage}, "camera": null, "frame": null, "psnr": null,
            "grids": [], "longest_list": {lights}, "lists_grew": false}}"#
        )
    };
    let points = [
        point(
            16,
            "Bevy deferred",
            r#"{"median": 2, "low": 1, "high": 3}"#,
            "null",
        ),
        point(64, "Bevy deferred", "null", r#""16 lights took 500 ms""#),
        point(
            16,
            "lean",
            r#"{"median": 0.5, "low": 0.5, "high": 0.5}"#,
            "null",
        ),
        point(
            64,
            "lean",
            r#"{"median": 0.75, "low": 0.5, "high": 1}"#,
            "null",
        ),
    ];
    let json = format!(r#"{{"adapter": "GPU", "points": [{}]}}"#, points.join(","));
    has_rows(
        &read("light_scaling.json", &json),
        &[
            "| 64×32 | spread | 16 | 2.000 (1.000–3.000) | 0.500 (0.500–0.500) | 0.250 | – | – | – | 16 |",
            "| 64×32 | spread | 64 | not measured | 0.750 (0.500–1.000) | – | – | – | – | 64 |",
            "- 64x32 spread 64 Bevy deferred: not measured, 16 lights took 500 ms.",
        ],
    );
}

#[test]
fn stutter() {
    let walk = |contender: &str, synchronous: bool, pipelines: &str, counts: [&str; 3]| {
        let [not_lean, waiting, lost] = counts;
        format!(
            r#"{{"adapter": "GPU", "cores": 2, "size": [64, 32], "frames": 600, "contender": "{contender}",
            "synchronous": {synchronous}, "pipelines": [{pipelines}], "not_lean": {not_lean}, "waiting_meshes": {waiting},
            "lost_history": {lost}, "median": 2.0, "longest": 100.25, "hitches": 480.0, "events": [{{"name": "fog comes",
            "not_lean": 3, "waiting_meshes": 0, "lost_history": 1, "hitches": 96.25}}]}}"#
        )
    };
    let label = |label: &str, loading: usize, walk: usize| {
        format!(r#"{{"label": "{label}", "loading": {loading}, "walk": {walk}}}"#)
    };
    let bevys = label("opaque_mesh_pipeline", 4, 40);
    let own = [
        label("lean_deferred/lighting", 2, 70),
        label("lean_deferred/gbuffer", 3, 9),
        label("lean_deferred/gbuffer/resolve_motion", 1, 0),
        bevys.clone(),
    ];
    let walks = [
        walk("Bevy forward", false, &bevys, ["null"; 3]),
        walk("lean", false, &own.join(","), ["3", "0", "null"]),
        walk("lean", true, &own.join(","), ["0", "0", "null"]),
    ];
    has_rows(
        &read("stutter.json", &format!("[{}]", walks.join(","))),
        &[
            "| Bevy forward | asynchronous | – | – | – | 4 + 40 | – | – | – | 2.00 | 100.2 | 480 |",
            "| lean | asynchronous | 2 + 70 | 4 + 9 | – | 4 + 40 | 3 | 0 | – | 2.00 | 100.2 | 480 |",
            "| lean | synchronous | 2 + 70 |",
            "| label | Bevy forward | lean |",
            "| lean_deferred/lighting | – | 2 + 70 |",
            "| lean | asynchronous | fog comes | 3 | 0 | 1 | 96 |",
        ],
    );
}

#[test]
fn levels() {
    let measurement = |contender: &str, camera: f64, rest: &str| {
        format!(
            r#"{{"adapter": "GPU", "size": [64, 32], "frames": 4, "level": "room", "view": 3, "contender": "{contender}",
            "meshes": 9, "lights": 313, "lightmapped": 7, "geometry": {{"median": 1.5, "low": 1, "high": 2}},
            "lighting": null, "effects": null, "blended": {{"median": 0.5, "low": 0, "high": 1}},
            "camera": {{"median": {camera}, "low": 1, "high": 9}}, "spans": [["bench/camera", {camera}]],
            "bytes_written_by_geometry": 12, "bytes_in_all": 32, {rest}}}"#
        )
    };
    let forward = measurement(
        "Bevy forward",
        8.0,
        r#""psnr": null, "off_by_8": null, "memory": [], "forward": []"#,
    );
    let lean = measurement(
        "lean",
        2.0,
        r#""psnr": 52.04, "off_by_8": 0.5, "memory": [["gbuffer", 3145728], ["history", 0], ["lighting", 1048576]],
        "forward": [{"reason": "it is blended", "meshes": 2, "materials": ["glass", "water"]}]"#,
    );
    let bench = read("levels.json", &format!("[{forward},{lean}]"));
    has_rows(
        &bench,
        &[
            "64×32, medians of 4 frames in ms.",
            "| room | 3 | Bevy forward | 1.500 | – | – | 0.500 | 8.000 | 1.00 | 12 / 32 | – | – |",
            "| room | 3 | lean | 1.500 | – | – | 0.500 | 2.000 | 0.25 | 12 / 32 | 52.0 | 50.000% |",
            "| level | view | renderer | gbuffer | lighting | all |\n|---|---|---|---|---|---|\n| room | 3 | lean | 3.0 | 1.0 | 4.0 |",
            "| room | 3 | lean | 9 | 2 | it is blended | glass, water |",
        ],
    );
    assert_eq!(bench.figures().plots().len(), 1);
}

#[test]
fn isa() {
    let shader = |family: &str, name: &str, beside: &str, cycles: u32| {
        format!(
            r#"{{"family": "{family}", "name": "{name}", "beside": {beside}, "subgroup": 64, "registers": 96, "demand": 82,
            "waves": 5, "shared": 2048, "instructions": 2753, "code": 15360, "latency": 40900, "inverse_throughput": {cycles}}}"#
        )
    };
    let shaders = [
        shader("vangogh", "own", r#""Bevy's""#, 1000),
        shader("vangogh", "Bevy's", "null", 4000),
        shader("navi31", "own", r#""Bevy's""#, 500),
        shader("navi31", "Bevy's", "null", 1000),
        r#"{"family": "tgl", "name": "own", "subgroup": 8, "registers": 120, "spills": 3, "scratch": 1024, "latency": 9}"#.into(),
    ];
    let json = format!(
        r#"{{"compiler": "Mesa 1", "shaders": [{}]}}"#,
        shaders.join(",")
    );
    has_rows(
        &read("isa.json", &json),
        &[
            "| own | 96 | 82 | 5 | 2,048 | 0 | 2,753 | 15.0 | 40,900 | 1,000 / 500 | 0.25 / 0.50 |",
            "| Bevy's | 96 | 82 | 5 | 2,048 | 0 | 2,753 | 15.0 | 40,900 | 4,000 / 1,000 | – |",
            "| own | 8 | 120 | 3 | 1,024 | 0 | 0 | 9 |",
        ],
    );
}

#[test]
fn a_bundle_becomes_the_folder_again() {
    let [from, to] = ["bundle_from", "bundle_to"].map(Folder::new);
    from.write("frame_times.json", FRAME_TIMES);
    from.write("run.json", r#"{"note": "five minutes"}"#);
    let json = serde_json::to_string(&Bundle::of(&from.0).unwrap()).unwrap();
    let bundle: Bundle = serde_json::from_str(&json).unwrap();
    bundle.unpack(&to.0).unwrap();
    assert_eq!(benches_in(&to.0).unwrap().len(), 1);
    let hostile: Bundle = serde_json::from_str(r#"{"../run.json": {}}"#).unwrap();
    assert!(hostile.unpack(&to.0).is_err());
}

#[test]
fn a_folder_makes_a_page() {
    let folder = Folder::new("page");
    folder.write("frame_times.json", FRAME_TIMES);
    let more = FRAME_TIMES.replace(r#""scene": "s""#, r#""scene": "t <b>""#);
    folder.write("frame_times_more.json", &more);
    folder.write("other.json", "{");
    folder.write("run.json", r#"{"date": "2026-01-02", "commit": "abcdef"}"#);
    let html = page::page(&folder.0, None).unwrap();
    for part in [
        "2026-01-02",
        "abcdef",
        "GPU",
        "<td>s<",
        "<td>t &lt;b&gt;<",
        "<svg",
    ] {
        assert!(html.contains(part), "{part}");
    }
    folder.write("frame_times.json", "{");
    assert!(page::page(&folder.0, None).is_err());
}

/// The repository's own figures, of which `docs` makes tables and plots.
#[test]
fn figures_of_the_docs() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/figures");
    let store = Store::of_machines(&folder).unwrap();
    let lights = store.light_scaling("h200");
    assert!(lights.plots()[0].svg.contains("4.3 TB/s"));
    for (name, make) in TABLES {
        let table = make(&store);
        assert!(!table.rows.is_empty(), "{name}");
        for row in &table.rows {
            assert_eq!(row.len(), table.columns.len(), "{name}: {row:?}");
        }
    }
}
