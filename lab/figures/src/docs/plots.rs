//! Plots in pages: after a line `<!-- plot: FILE, WORDS -->` comes a line with the plot, a file of the folder of figures.

use std::collections::BTreeMap;

use super::FOLDER;
use crate::{benches::Figures, plots::Plot, store::Store};

/// The plots by their paths in the repository.
pub fn drawn(store: &Store) -> BTreeMap<String, String> {
    let frames = store.frame_times("h200").plots();
    let occlusion = store.ambient_occlusion("h200").plots();
    let effects = store.screen_space("h200").plots();
    let scattering = store.screen_space("h200_more").plots();
    let exposure = store.auto_exposure("h200").plots();
    let lights = store.light_scaling("h200").plots();
    let meshes = store.many_meshes("h200").plots();
    let compiled = store.isa("mesa25").plots();
    let plots = [
        ("frame.svg", &frames, "stages"),
        ("frame_bytes.svg", &frames, "bytes"),
        ("frame_error.svg", &frames, "speed_boxes_64"),
        ("ambient_occlusion.svg", &occlusion, "speed"),
        ("ambient_occlusion_stages.svg", &occlusion, "stages"),
        ("diffuse_gi.svg", &effects, "speed_gi"),
        (
            "reflections_mirror.svg",
            &effects,
            "speed_reflections_in_a_mirror",
        ),
        (
            "reflections.svg",
            &effects,
            "speed_reflections_on_a_rough_floor",
        ),
        (
            "subsurface_scattering.svg",
            &scattering,
            "stages_scattering",
        ),
        ("auto_exposure.svg", &exposure, "speed"),
        ("light_scaling.svg", &lights, "lights"),
        ("many_meshes.svg", &meshes, "meshes"),
        ("isa.svg", &compiled, "throughput"),
    ];
    let draw = |(file, plots, name): (&str, &Vec<Plot>, &str)| {
        let plot = plots.iter().find(|plot| plot.name == name);
        let plot = plot.unwrap_or_else(|| panic!("there is no plot {name} for {file}"));
        (format!("{FOLDER}/{file}"), plot.svg.clone())
    };
    plots.into_iter().map(draw).collect()
}

/// Puts plots into the page `name`.
pub fn fill(page: &str, name: &str) -> String {
    // The path from the page to the figures.
    let folder = match name.strip_prefix("docs/") {
        Some(name) => format!("{}figures/", "../".repeat(name.matches('/').count())),
        None => format!("{FOLDER}/"),
    };
    let mut made = String::new();
    let mut lines = page.split_inclusive('\n').peekable();
    while let Some(line) = lines.next() {
        made.push_str(line);
        let marker = line.trim_end().strip_prefix("<!-- plot: ");
        let plot = marker.and_then(|marker| marker.strip_suffix(" -->")?.split_once(", "));
        if let Some((file, words)) = plot {
            lines.next_if(|line| line.starts_with("!["));
            made.push_str(&format!("![{words}]({folder}{file})\n"));
        }
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plots_stand_behind_their_markers() {
        let page = "a\n<!-- plot: p.svg, A plot, drawn -->\nb\n";
        for (name, folder) in [
            ("README.md", "docs/figures"),
            ("docs/a.md", "figures"),
            ("docs/internals/a.md", "../figures"),
        ] {
            let drawn = page.replace("b\n", &format!("![A plot, drawn]({folder}/p.svg)\nb\n"));
            assert_eq!(fill(page, name), drawn);
            assert_eq!(fill(&drawn, name), drawn);
        }
    }
}
