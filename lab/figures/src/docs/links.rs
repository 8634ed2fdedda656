//! Links of pages to files, and to headings of pages.

use std::{collections::BTreeMap, path::Path};

use super::FOLDER;

/// Links of a page to headings that the linked page lacks, and to files that are neither in the repository nor among the `plots`, which
/// may not be written yet.
pub fn dead(root: &Path, name: &str, page: &str, plots: &BTreeMap<String, String>) -> Vec<String> {
    let folder = root.join(name).parent().unwrap_or(root).to_owned();
    let is_plot = |file: &str| {
        let (_, file) = file.rsplit_once('/').unwrap_or(("", file));
        plots.contains_key(&format!("{FOLDER}/{file}"))
    };
    let mut dead = Vec::new();
    for target in targets(page) {
        let (file, heading) = target.split_once('#').unwrap_or((target, ""));
        let path = folder.join(file);
        if !file.is_empty() && !path.exists() && !is_plot(file) {
            dead.push(format!("{name}: links to {file}, which is not there"));
            continue;
        }
        let has_heading = match (heading, file) {
            ("", _) => true,
            (_, "") => has_heading(page, heading),
            _ if !file.ends_with(".md") => true,
            _ => std::fs::read_to_string(path).is_ok_and(|other| has_heading(&other, heading)),
        };
        if !has_heading {
            dead.push(format!("{name}: links to {target}, which is no heading"));
        }
    }
    dead
}

/// Targets of links, without those to other sites and without text that only looks like a link.
fn targets(page: &str) -> impl Iterator<Item = &str> {
    let targets = page.split("](").skip(1);
    let targets = targets.filter_map(|rest| Some(rest.split_once(')')?.0));
    targets.filter(|target| {
        !target.is_empty() && !target.contains(|c: char| c == ':' || c.is_whitespace())
    })
}

/// True if `page` has a heading with this anchor.
fn has_heading(page: &str, anchor: &str) -> bool {
    let mut is_code = false;
    page.lines().any(|line| {
        is_code ^= line.starts_with("```");
        !is_code && line.starts_with('#') && anchor_of(line) == anchor
    })
}

/// The anchor that GitHub gives a heading.
fn anchor_of(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    text.chars()
        .filter(kept)
        .collect::<String>()
        .replace(' ', "-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_lead_somewhere() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let page =
            "[a](src/lib.rs) [b](src/lib.rs#x) [c](https://example.org) `a[i](b c)` ![e](none.svg)";
        let plots = BTreeMap::from([(format!("{FOLDER}/plot.svg"), String::new())]);
        let dead = |name, page| super::dead(root, name, page, &plots);
        assert_eq!(
            dead("README.md", page),
            ["README.md: links to none.svg, which is not there"]
        );
        let page = "[a](../lib.rs) ![b](../figures/plot.svg)";
        assert!(dead("src/docs/page.md", page).is_empty());
    }

    #[test]
    fn links_lead_to_headings() {
        let root = &crate::report::root();
        let page = "[a](#one-two) [b](#comment)\n\n```sh\n# comment\n```\n\n## One: `two`?\n\n[c](docs/limits.md#cameras) [d](docs/limits.md#none)";
        assert_eq!(
            dead(root, "README.md", page, &BTreeMap::new()),
            [
                "README.md: links to #comment, which is no heading",
                "README.md: links to docs/limits.md#none, which is no heading"
            ]
        );
    }
}
