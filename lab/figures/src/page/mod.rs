//! One HTML file with all figures, which opens from disk.

mod pictures;

use std::{fmt::Write, path::Path};

use crate::{
    benches::{Bench, Figures},
    store::{Run, benches_in},
    table::Table,
};

const STYLE: &str = "
body { font: 15px/1.45 system-ui, sans-serif; color: #1a1a1a; background: #fff; max-width: 1280px; margin: 2em auto; padding: 0 1em }
h1 { font-size: 1.7em } h2 { margin-top: 2.5em; border-bottom: 1px solid #ccc }
figure { margin: 1.5em 0 } svg, img { max-width: 100%; height: auto }
.table { overflow-x: auto; margin: .8em 0 } table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums }
th, td { border: 1px solid #ddd; padding: 3px 8px; text-align: left; white-space: nowrap } th { background: #f4f4f4 }
.pictures { display: flex; flex-wrap: wrap; gap: 12px } .pictures figure { margin: 0; width: 400px } .pictures img { width: 400px; image-rendering: auto }
figcaption { font-size: 13px; color: #444 } summary { cursor: pointer; margin: .8em 0; font-weight: 600 }
";

/// The title of a bench, and an introduction to its figures.
fn heading(bench: &str) -> (&'static str, &'static str) {
    match bench {
        "frame_times" => (
            "Frames",
            "A frame by Bevy forward, Bevy deferred and this crate. Error is what a picture differs from forward's.",
        ),
        "levels" => (
            "Levels",
            "Frames of glTF levels by Bevy forward, Bevy deferred and this crate, without and with effects.",
        ),
        "ambient_occlusion" => (
            "Ambient occlusion",
            "Each preset beside Bevy's and a naive version; the error is to a closed form.",
        ),
        "screen_space" => (
            "Diffuse GI, reflections, scattering",
            "Errors are to what is known of small scenes, in closed form or by integrals.",
        ),
        "motion" => (
            "Motion",
            "Reflections and GI while the camera and things move, beside Bevy's, and beneath small bright lamps.",
        ),
        "auto_exposure" => (
            "Auto exposure",
            "Errors are to the mean in double precision. Those below 1e-9 are shown as that.",
        ),
        "light_scaling" => (
            "Cost over the number of lights",
            "The boxes scene under more and more point lights. Lines end where a stage took too long.",
        ),
        "stutter" => (
            "Hitches",
            "A walk through a level in which features come and go one at a time.",
        ),
        "isa" => (
            "Shaders by their compilers",
            "Registers, occupancy and estimated cycles on GPUs that are not there.",
        ),
        _ => (
            "Cost over the number of meshes",
            "Time of the CPU: the GPU is waited for outside of it.",
        ),
    }
}

/// The page of the figures in `folder`, with the pictures in `pictures`: a folder for each bench.
pub fn page(folder: &Path, pictures: Option<&Path>) -> Result<String, String> {
    let benches = benches_in(folder)?;
    if benches.is_empty() {
        return Err(format!("{}: there are no figures", folder.display()));
    }
    let run = Run::of(folder)?;
    let mut html = String::new();
    let _ = write!(
        html,
        "<!doctype html>\n<html lang=en><meta charset=utf-8>\n<meta name=viewport content=\"width=device-width\">\n\
         <title>bevy_lean_deferred: figures</title>\n<style>{STYLE}</style>\n<h1>bevy_lean_deferred: figures</h1>\n"
    );
    html.push_str(&about(&benches, &run));
    let mut shown: Vec<&Bench> = benches.iter().collect();
    shown.sort_by_key(|bench| Bench::NAMES.iter().position(|name| *name == bench.name()));
    html.push_str("<nav>");
    for bench in &shown {
        let (name, (title, _)) = (bench.name(), heading(bench.name()));
        let _ = write!(html, "<a href=\"#{name}\">{title}</a> · ");
    }
    html.push_str("</nav>\n");
    for bench in shown {
        section(&mut html, bench.name(), bench.figures(), pictures)?;
    }
    Ok(html)
}

/// Adapters, date and commit.
fn about(benches: &[Bench], run: &Run) -> String {
    let mut devices: Vec<String> = Vec::new();
    for bench in benches {
        let device = bench.figures().device().to_string();
        if !devices.contains(&device) {
            devices.push(device);
        }
    }
    let mut lines = vec![("adapter (driver)", devices.join("; "))];
    let told = [
        ("date", &run.date),
        ("commit", &run.commit),
        ("run", &run.note),
    ];
    lines.extend(
        told.into_iter()
            .filter(|(_, text)| !text.is_empty())
            .map(|(name, text)| (name, text.clone())),
    );
    let rows = lines
        .iter()
        .map(|(name, text)| format!("<tr><th>{name}<td>{}", escape(text)));
    format!(
        "<div class=table><table>{}</table></div>\n<p>Times hold on this adapter only; bytes hold everywhere. On a software \
         renderer times are those of the CPU.</p>\n",
        rows.collect::<String>()
    )
}

fn section(
    html: &mut String,
    name: &str,
    figures: &dyn Figures,
    pictures: Option<&Path>,
) -> Result<(), String> {
    let (title, about) = heading(name);
    let _ = writeln!(html, "<h2 id={name}>{title}</h2>\n<p>{about}</p>");
    for plot in figures.plots() {
        let _ = writeln!(html, "<figure>{}</figure>", plot.svg);
    }
    if let Some(folder) = pictures
        .map(|folder| folder.join(name))
        .filter(|folder| folder.is_dir())
    {
        html.push_str(&pictures::section(name, &folder)?);
    }
    let _ = writeln!(
        html,
        "<details open><summary>Tables</summary>\n<p>{}.</p>",
        escape(&figures.legend())
    );
    for own in figures.tables() {
        html.push_str(&table(&own));
    }
    html.push_str("</details>\n");
    Ok(())
}

fn table(table: &Table) -> String {
    let mut html = String::new();
    if !table.title.is_empty() {
        let _ = writeln!(html, "<h3>{}</h3>", escape(&table.title.replace("**", "")));
    }
    let row = |kind: &str, cells: &[String]| {
        let cells = cells.iter().map(|cell| format!("<{kind}>{}", escape(cell)));
        format!("<tr>{}\n", cells.collect::<String>())
    };
    html.push_str("<div class=table><table>\n");
    html.push_str(&row("th", &table.columns));
    for cells in &table.rows {
        html.push_str(&row("td", cells));
    }
    html.push_str("</table></div>\n");
    let notes = table
        .notes
        .iter()
        .map(|note| format!("<li>{}\n", escape(note)));
    let notes: String = notes.collect();
    if !notes.is_empty() {
        let _ = writeln!(html, "<ul>{notes}</ul>");
    }
    html
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
