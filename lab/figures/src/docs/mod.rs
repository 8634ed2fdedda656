//! Updates README and docs from figures, or checks them.
//!
//! Three things are made: tables ([`tables`]), plots ([`plots`]), and small pictures as text ([`thumbs`]). Links that lead nowhere are reported ([`links`]), and names of
//! tests that are not there ([`names`]).

mod links;
mod names;
mod plots;
pub mod tables;
mod thumbs;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use crate::{json::read_text, store::Store};

/// Folder of the figures in the repository.
pub const FOLDER: &str = "docs/figures";

/// A file before and after.
struct Page {
    name: String,
    before: String,
    text: String,
}

/// The made pages and files, and their errors.
pub struct Docs {
    root: PathBuf,
    pages: Vec<Page>,
    /// Plots and small pictures, by their paths.
    files: BTreeMap<String, String>,
    pub wrong: Vec<String>,
}

impl Docs {
    /// Makes the docs of the repository at `root` from their figures.
    pub fn new(root: &Path) -> Result<Self, String> {
        let store = Store::of_machines(&root.join(FOLDER))?;
        let mut files = plots::drawn(&store);
        files.extend(thumbs::encoded(root)?);
        let mut docs = Self {
            root: root.into(),
            pages: pages(root)?,
            files,
            wrong: Vec::new(),
        };
        let mut missing: Vec<&str> = tables::TABLES.iter().map(|(name, _)| *name).collect();
        for Page { name, text, .. } in &mut docs.pages {
            let made = tables::fill(text, |table| {
                missing.retain(|missing| *missing != table);
                tables::table(table, &store)
            });
            match made {
                Ok(made) => *text = plots::fill(&made, name),
                Err(error) => docs.wrong.push(format!("{name}: {error}")),
            }
            (docs.wrong).extend(links::dead(root, name, text, &docs.files));
            (docs.wrong).extend(names::dead(root, name, text));
        }
        let missing = missing.iter();
        (docs.wrong).extend(missing.map(|table| format!("no page has the table {table}")));
        Ok(docs)
    }

    /// Differences between the files and the made ones.
    pub fn differences(&self) -> Vec<String> {
        let mut differences = Vec::new();
        for page in &self.pages {
            let before: Vec<&str> = page.before.lines().collect();
            let after: Vec<&str> = page.text.lines().collect();
            let name = &page.name;
            if before.len() == after.len() {
                for (number, (is, should)) in (1..).zip(before.iter().zip(&after)) {
                    if is != should {
                        differences.push(format!(
                            "{name}:{number}\n  is        {is}\n  should be {should}"
                        ));
                    }
                }
            } else {
                // Rows were added or removed.
                let more = after.iter().filter(|line| !before.contains(line));
                differences.extend(more.map(|line| format!("{name}: lacks {line}")));
                let fewer = before.iter().filter(|line| !after.contains(line));
                differences.extend(fewer.map(|line| format!("{name}: has   {line}")));
            }
        }
        for (file, text) in &self.files {
            if std::fs::read_to_string(self.root.join(file)).ok().as_ref() != Some(text) {
                differences.push(format!("{file}: is not made from the figures or pictures"));
            }
        }
        differences
    }

    pub fn write(&self) -> Result<(), String> {
        let pages = self.pages.iter().map(|page| (&page.name, &page.text));
        for (name, text) in pages.chain(&self.files) {
            let path = self.root.join(name);
            if std::fs::read_to_string(&path).ok().as_ref() != Some(text) {
                std::fs::write(&path, text).map_err(|error| format!("{name}: {error}"))?;
            }
        }
        Ok(())
    }
}

/// The pages at the root, and those of the docs.
fn pages(root: &Path) -> Result<Vec<Page>, String> {
    let says = |error: std::io::Error| format!("docs: {error}");
    let mut names = vec!["README.md".to_owned(), "CONTRIBUTING.md".to_owned()];
    for folder in ["docs", "docs/internals", FOLDER] {
        for entry in std::fs::read_dir(root.join(folder)).map_err(says)? {
            let name = entry.map_err(says)?.file_name();
            let name = name.to_string_lossy();
            if name.ends_with(".md") {
                names.push(format!("{folder}/{name}"));
            }
        }
    }
    names.sort();
    let page = |name: String| {
        let text = read_text(&root.join(&name))?;
        let before = text.clone();
        Ok(Page { name, before, text })
    };
    names.into_iter().map(page).collect()
}
