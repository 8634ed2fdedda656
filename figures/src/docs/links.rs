//! Links of pages to files.

use std::{collections::BTreeMap, path::Path};

use super::FOLDER;

/// Links of a page to files that are neither in the repository nor among the `plots`, which may not be written yet.
pub fn dead(root: &Path, name: &str, page: &str, plots: &BTreeMap<String, String>) -> Vec<String> {
    let folder = root.join(name).parent().unwrap_or(root).to_owned();
    let is_plot = |target: &str| {
        let (_, file) = target.rsplit_once('/').unwrap_or(("", target));
        plots.contains_key(&format!("{FOLDER}/{file}"))
    };
    // Links into a page, to other sites, and what only looks like a link.
    let is_file = |target: &&str| {
        !target.is_empty() && !target.contains(|c: char| c == ':' || c.is_whitespace())
    };
    let targets = page.split("](").skip(1);
    let targets = targets.filter_map(|rest| rest.split_once(')')?.0.split('#').next());
    targets
        .filter(is_file)
        .filter(|target| !folder.join(target).exists() && !is_plot(target))
        .map(|target| format!("{name}: links to {target}, which is not there"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_lead_somewhere() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let page = "[a](src/lib.rs) [b](src/lib.rs#x) [c](https://example.org) [d](#here) `a[i](b c)` ![e](none.svg)";
        let plots = BTreeMap::from([(format!("{FOLDER}/plot.svg"), String::new())]);
        let dead = |name, page| super::dead(root, name, page, &plots);
        assert_eq!(
            dead("README.md", page),
            ["README.md: links to none.svg, which is not there"]
        );
        let page = "[a](../lib.rs) ![b](../figures/plot.svg)";
        assert!(dead("src/docs/page.md", page).is_empty());
    }
}
