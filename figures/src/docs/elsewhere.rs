//! Figures that no bench measures.
//!
//! ```toml
//! [[elsewhere]]
//! file = "docs/accuracy.md"
//! source = "tests/shaders/layout.rs"
//! begins = "What packing costs"           # of the paragraph or table; without it, all of the file
//! ```
//!
//! [`unaccounted`] reports all other figures without a source: numbers before a unit of measurement, and decimal numbers
//! in tables.

use std::ops::Range;

use regex::Regex;
use serde::Deserialize;

use super::Page;

/// See [the module](self).
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub struct Elsewhere {
    file: String,
    /// The source of these figures: a test, or the reason why there is none.
    #[expect(dead_code, reason = "for those who read the file")]
    source: String,
    #[serde(default)]
    begins: String,
}

/// Ranges of the paragraphs of `page`.
fn paragraphs(page: &str) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    page.split("\n\n").map(move |paragraph| {
        let range = start..start + paragraph.len();
        start = range.end + 2;
        range
    })
}

/// Figures of `page` that are neither made nor from elsewhere.
pub fn unaccounted(page: &Page, made: &[Range<usize>], others: &[Elsewhere]) -> Vec<String> {
    let own = || others.iter().filter(|other| other.file == page.name);
    if own().any(|other| other.begins.is_empty()) {
        return Vec::new();
    }
    let with_unit = Regex::new(r"\d(?: ms| µs| dB| GB/s| TB/s)\b").expect("it is constant");
    let broken = Regex::new(r"\d\.\d").expect("it is constant");
    let mut found = Vec::new();
    let mut in_code = false;
    for paragraph in paragraphs(&page.text) {
        let text = &page.text[paragraph.clone()];
        let fences = text.matches("```").count();
        let is_code = in_code || fences > 0;
        in_code ^= fences % 2 == 1;
        if is_code || own().any(|other| text.trim_start().starts_with(&other.begins)) {
            continue;
        }
        let mut start = paragraph.start;
        for line in text.split_inclusive('\n') {
            let figures = match line.starts_with('|') {
                true => &broken,
                false => &with_unit,
            };
            for figure in figures.find_iter(line) {
                let place = start + figure.start();
                if !made.iter().any(|made| made.contains(&place)) {
                    let number = page.text[..place].matches('\n').count() + 1;
                    let name = &page.name;
                    found.push(format!(
                        "{name}:{number}: nothing says where this is from: {}",
                        line.trim()
                    ));
                    break;
                }
            }
            start += line.len();
        }
    }
    found
}

/// Entries of `others` that no page has.
pub fn not_found(pages: &[Page], others: &[Elsewhere]) -> Vec<String> {
    let is_there = |other: &&Elsewhere| {
        let page = pages.iter().find(|page| page.name == other.file);
        page.is_some_and(|page| {
            paragraphs(&page.text).any(|p| page.text[p].trim_start().starts_with(&other.begins))
        })
    };
    let missing = others.iter().filter(|other| !is_there(other));
    missing
        .map(|other| {
            format!(
                "{}: no paragraph begins with `{}`",
                other.file, other.begins
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(text: &str) -> Page {
        Page {
            name: "page.md".into(),
            before: String::new(),
            text: text.into(),
        }
    }

    fn other(begins: &str) -> Elsewhere {
        Elsewhere {
            file: "page.md".into(),
            source: "a test".into(),
            begins: begins.into(),
        }
    }

    const TEXT: &str = "It takes 3.2 ms.\n\n| a | 0.5 |\n|---|---|\n| b | 7 |\n\n```\n9 ms\n\n8 ms\n```\n\nIn 2025, 5 m, 1.5 s.\n";

    #[test]
    fn figures_are_accounted_for() {
        let found = unaccounted(&page(TEXT), &[], &[]);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].starts_with("page.md:1:") && found[1].starts_with("page.md:3:"));
        let ms = TEXT.find("3.2").unwrap();
        let made = core::iter::repeat_n(ms..ms + 3, 1).collect::<Vec<_>>();
        assert_eq!(unaccounted(&page(TEXT), &made, &[]).len(), 1);
        assert_eq!(unaccounted(&page(TEXT), &[], &[other("| a |")]).len(), 1);
        assert_eq!(unaccounted(&page(TEXT), &[], &[other("")]).len(), 0);
    }

    #[test]
    fn paragraphs_that_are_gone_are_told() {
        assert_eq!(not_found(&[page(TEXT)], &[other("It takes")]).len(), 0);
        assert_eq!(not_found(&[page(TEXT)], &[other("It took")]).len(), 1);
    }
}
