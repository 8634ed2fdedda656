//! Updates README and docs from figures, or checks them.
//!
//! Three things are made: tables between `<!-- table: NAME -->` and `<!-- /table -->` ([`tables`]), numbers in sentences
//! ([`claims`]), and plots ([`links`]). Dead links are reported. An entry with `waiting = true` has no figures in the folder
//! yet: it stays as it is, and is reported until they are there. [`elsewhere`] lists figures that no bench measures; all
//! others must be made.

pub mod claims;
pub mod elsewhere;
mod links;
pub mod tables;

use std::{
    collections::BTreeMap,
    ops::Range,
    path::{Path, PathBuf},
};

use serde::{Deserialize, de::DeserializeOwned};
use serde_json::Value;

use crate::{
    json::read_text,
    store::Store,
    template::{Reference, Resolve},
};
use claims::Claim;
use elsewhere::Elsewhere;
use tables::TableOfDocs;

/// Folder of the figures in the repository.
pub const FOLDER: &str = "docs/figures";

/// `claims.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Claims {
    claim: Vec<Claim>,
}

/// `tables.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    table: Vec<TableOfDocs>,
    plot: Vec<PlotOfDocs>,
}

/// `elsewhere.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Others {
    elsewhere: Vec<Elsewhere>,
}

/// The made text, or the reason why there is none. `None` for an entry that is `waiting` and has no figures yet.
fn unless_waiting<T>(waiting: bool, made: Result<T, String>) -> Result<Option<T>, String> {
    match (waiting, made) {
        (false, made) => made.map(Some),
        (true, Err(_)) => Ok(None),
        (true, Ok(_)) => Err("its figures are there: it waits no longer".into()),
    }
}

/// A plot of a bench, in a file of [`FOLDER`].
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlotOfDocs {
    file: String,
    from: String,
    plot: String,
    #[serde(default)]
    waiting: bool,
}

/// A file before and after.
pub struct Page {
    pub name: String,
    before: String,
    pub text: String,
}

/// The made pages and plots, and their errors.
pub struct Docs {
    root: PathBuf,
    pages: Vec<Page>,
    plots: BTreeMap<String, String>,
    pub wrong: Vec<String>,
    /// Entries that wait for their figures.
    pub waiting: Vec<String>,
}

impl Docs {
    /// Makes the docs of the repository at `root` from their figures.
    pub fn new(root: &Path) -> Result<Self, String> {
        let folder = root.join(FOLDER);
        let store = Store::of_machines(&folder)?;
        let tables: Tables = read_toml(&folder.join("tables.toml"))?;
        let claims: Claims = read_toml(&folder.join("claims.toml"))?;
        let others: Others = read_toml(&folder.join("elsewhere.toml"))?;
        let mut docs = Self {
            root: root.into(),
            pages: pages(root)?,
            plots: BTreeMap::new(),
            wrong: Vec::new(),
            waiting: Vec::new(),
        };
        let waits = tables.table.iter().filter(|table| table.waiting);
        docs.waiting
            .extend(waits.map(|table| format!("table {}", table.name)));
        let waits = claims.claim.iter().filter(|claim| claim.waiting);
        docs.waiting
            .extend(waits.map(|claim| format!("{}: {}", claim.file, claim.text.trim())));
        let waits = tables.plot.iter().filter(|plot| plot.waiting);
        docs.waiting
            .extend(waits.map(|plot| format!("plot {}", plot.file)));
        docs.make_tables(&tables.table, &store);
        docs.make_claims(&claims.claim, &store);
        docs.draw_plots(&tables.plot, &store);
        docs.show_plots();
        let made = |page: &Page| -> Vec<Range<usize>> {
            let own = claims.claim.iter().filter(|claim| claim.file == page.name);
            let claims = own.flat_map(|claim| claim.places(&page.text));
            tables::places(&page.text)
                .into_iter()
                .chain(claims)
                .collect()
        };
        for page in &docs.pages {
            docs.wrong
                .extend(elsewhere::unaccounted(page, &made(page), &others.elsewhere));
        }
        docs.wrong
            .extend(elsewhere::not_found(&docs.pages, &others.elsewhere));
        Ok(docs)
    }

    fn make_tables(&mut self, tables: &[TableOfDocs], store: &Store) {
        let mut used = vec![false; tables.len()];
        for page in &mut self.pages {
            match tables::fill(&page.text, tables, store, &mut used) {
                Ok(text) => page.text = text,
                Err(error) => self.wrong.push(format!("{}: {error}", page.name)),
            }
        }
        for (table, used) in tables.iter().zip(used) {
            if !used {
                self.wrong
                    .push(format!("no page has the table {}", table.name));
            }
        }
    }

    fn make_claims(&mut self, claims: &[Claim], store: &Store) {
        for claim in claims {
            let page = self.pages.iter_mut().find(|page| page.name == claim.file);
            let made = match page {
                Some(page) if claim.waiting && claim.places(&page.text).len() != 1 => {
                    Err("the page does not say so exactly once".into())
                }
                Some(page) => unless_waiting(claim.waiting, claim.make(&page.text, store))
                    .map(|text| page.text = text.unwrap_or(page.text.clone())),
                None => Err("there is no such page".into()),
            };
            if let Err(error) = made {
                self.wrong
                    .push(format!("{}: `{}`: {error}", claim.file, claim.text.trim()));
            }
        }
    }

    fn draw_plots(&mut self, plots: &[PlotOfDocs], store: &Store) {
        for plot in plots {
            let svg = store.bench(&plot.from).and_then(|bench| {
                let mut plots = bench.figures().plots().into_iter();
                let found = plots.find(|own| own.name == plot.plot);
                Ok(found
                    .ok_or(format!("{} has no plot {}", plot.from, plot.plot))?
                    .svg)
            });
            match unless_waiting(plot.waiting, svg) {
                Ok(Some(svg)) => {
                    self.plots.insert(format!("{FOLDER}/{}", plot.file), svg);
                }
                Ok(None) => {}
                Err(error) => self.wrong.push(format!("{}: {error}", plot.file)),
            }
        }
    }

    /// Puts plots into pages, and reports dead links.
    fn show_plots(&mut self) {
        for page in &mut self.pages {
            let folder = match page.name.starts_with("docs/") {
                true => "figures/",
                false => "docs/figures/",
            };
            let is_drawn = |file: &str| self.plots.contains_key(&format!("{FOLDER}/{file}"));
            page.text = links::fill(&page.text, folder, is_drawn);
            let is_made = |file: &str| self.plots.contains_key(file);
            let dead = links::dead(&self.root, &page.name, &page.text, is_made);
            self.wrong.extend(dead);
        }
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
        for (file, svg) in &self.plots {
            if std::fs::read_to_string(self.root.join(file)).ok().as_ref() != Some(svg) {
                differences.push(format!("{file}: is not the plot of the figures"));
            }
        }
        differences
    }

    pub fn write(&self) -> Result<(), String> {
        let pages = self.pages.iter().map(|page| (&page.name, &page.text));
        for (name, text) in pages.chain(&self.plots) {
            let path = self.root.join(name);
            if std::fs::read_to_string(&path).ok().as_ref() != Some(text) {
                std::fs::write(&path, text).map_err(|error| format!("{name}: {error}"))?;
            }
        }
        Ok(())
    }
}

fn read_toml<T: DeserializeOwned>(path: &Path) -> Result<T, String> {
    toml::from_str(&read_text(path)?).map_err(|error| format!("{}: {error}", path.display()))
}

/// README and docs.
fn pages(root: &Path) -> Result<Vec<Page>, String> {
    let says = |error: std::io::Error| format!("docs: {error}");
    let mut names = vec!["README.md".to_owned()];
    for entry in std::fs::read_dir(root.join("docs")).map_err(says)? {
        let name = entry
            .map_err(says)?
            .file_name()
            .to_string_lossy()
            .into_owned();
        if name.ends_with(".md") {
            names.push(format!("docs/{name}"));
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

/// Resolves references below a source and keys: `h200/frame_times | boxes_64`.
pub struct Origin<'a> {
    store: &'a Store,
    parts: Vec<String>,
}

impl<'a> Origin<'a> {
    pub fn new(store: &'a Store, from: &str) -> Self {
        let parts = from.split('|').map(|part| part.trim().to_owned());
        let parts = parts.filter(|part| !part.is_empty()).collect();
        Self { store, parts }
    }

    pub fn and(&self, more: &str) -> Self {
        let mut from = Self::new(self.store, more);
        if !from
            .parts
            .first()
            .is_some_and(|part| self.store.contains(part))
        {
            from.parts.splice(0..0, self.parts.iter().cloned());
        }
        from
    }
}

impl Resolve for Origin<'_> {
    fn resolve(&self, reference: &Reference) -> Result<Option<Value>, String> {
        let from = self.and(&reference.keys().join(" | "));
        let (source, keys) = from.parts.split_first().ok_or("there is no source")?;
        let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
        let record = self.store.record(source, &keys)?;
        let value = record.value(reference.path());
        let says = || {
            format!(
                "{}: there is no {}",
                from.parts.join(" | "),
                reference.path()
            )
        };
        Ok(Some(value.ok_or_else(says)?.clone()).filter(|value| !value.is_null()))
    }
}
