//! The table of lighting's parts in `docs/compiling.md` has all definitions that its keys set.

use std::collections::BTreeSet;

use super::factors::LIGHTING;

/// Definitions that the device, Bevy's features or other definitions decide, whatever a view has.
const OF_NO_KEY: [&str; 5] = [
    "IRRADIANCE_VOLUMES_ARE_USABLE",
    "BLUE_NOISE_TEXTURE",
    "DFG_LUT",
    "MULTIPLE_LIGHT_PROBES_IN_ARRAY",
    "PCSS_SAMPLERS_AVAILABLE",
];

/// Cells of the rows of the table below this heading.
fn rows(page: &str, heading: &str) -> Vec<Vec<String>> {
    let mut lines = page.lines().skip_while(|line| *line != heading);
    lines.next();
    let lines = lines
        .take_while(|line| !line.starts_with('#'))
        .filter(|line| line.starts_with('|'));
    // Without the head and the line below it.
    let rows = lines.skip(2).map(|line| {
        let cells = line.trim_matches('|').split('|');
        cells.map(|cell| cell.trim().to_string()).collect()
    });
    rows.collect()
}

#[test]
fn the_table_of_keys_has_every_definition() {
    let page = include_str!("../../../docs/compiling.md");
    let rows = rows(page, "## The parts of lighting");
    assert!(rows.len() > 15, "{} rows", rows.len());
    let mut named = BTreeSet::new();
    for row in &rows {
        for name in row[2].split('`').skip(1).step_by(2) {
            assert!(named.insert(name), "{name} is named twice");
        }
    }
    let choices = LIGHTING.iter().copied().flatten().copied().flatten();
    let set: BTreeSet<&str> = choices
        .copied()
        .filter(|name| !name.starts_with("DEBUG_") && !OF_NO_KEY.contains(name))
        .filter(|name| *name != "GBUFFER_MOTION")
        .collect();
    assert_eq!(named, set);
}
