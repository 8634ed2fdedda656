//! Plots in pages, and links to files.
//!
//! After a line `<!-- plot: FILE, WORDS -->` comes a line with the plot, a file of the folder of figures. The line is left
//! out while the figures are missing.

use std::path::Path;

use regex::Regex;

/// Fills in the plots of `page` that are in `drawn`, by their path in the repository. `folder` is the path from the
/// page to them.
pub fn fill(page: &str, folder: &str, drawn: impl Fn(&str) -> bool) -> String {
    let marker = Regex::new("^<!-- plot: ([^,]+), (.+) -->$").expect("it is constant");
    let mut made = String::new();
    let mut lines = page.split_inclusive('\n').peekable();
    while let Some(line) = lines.next() {
        made.push_str(line);
        let Some(captures) = marker.captures(line.trim_end()) else {
            continue;
        };
        lines.next_if(|line| line.starts_with("!["));
        let (file, words) = (&captures[1], &captures[2]);
        if drawn(file) {
            made.push_str(&format!("![{words}]({folder}{file})\n"));
        }
    }
    made
}

/// Links of a page to missing files of the repository.
pub fn dead(root: &Path, name: &str, page: &str, made: impl Fn(&str) -> bool) -> Vec<String> {
    let link = Regex::new(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)").expect("it is constant");
    let folder = Path::new(name).parent().unwrap_or(Path::new(""));
    let is_dead = |target: &&str| {
        let path = folder.join(target);
        !made(&path.to_string_lossy()) && !root.join(path).exists()
    };
    link.captures_iter(page)
        .map(|captures| captures.get(1).expect("it is there").as_str())
        .filter(is_dead)
        .map(|target| format!("{name}: links to {target}, which is not there"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "a\n<!-- plot: p.svg, A plot -->\nb\n";
    const DRAWN: &str = "a\n<!-- plot: p.svg, A plot -->\n![A plot](figures/p.svg)\nb\n";

    #[test]
    fn plots_stand_behind_their_markers_once_they_are_there() {
        for page in [PAGE, DRAWN] {
            assert_eq!(fill(page, "figures/", |_| true), DRAWN);
            assert_eq!(fill(page, "figures/", |_| false), PAGE);
        }
    }

    #[test]
    fn links_lead_somewhere() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let page =
            "[a](src/lib.rs) [b](src/lib.rs#x) [c](https://example.org) [d](#here) ![e](none.svg)";
        let dead = dead(root, "README.md", page, |_| false);
        assert_eq!(dead, ["README.md: links to none.svg, which is not there"]);
    }
}
