//! Tables between `<!-- table: NAME -->` and `<!-- /table -->`.
//!
//! ```toml
//! [[table]]                               # the bench's own table, for some of its scenes
//! name = "frame times"
//! from = "h200/frame_times"
//! only = ["boxes_64", "FlightHelmet"]
//! without = ["lean writing diffuse light"]
//!
//! [[table]]                               # custom rows and columns
//! name = "occlusion"
//! from = "h200/ambient_occlusion | 3840x2160"
//! head = "preset"
//! columns = [["gather", "{passes.0.median :.3}"], ["all", "{all :.3}"]]
//! rows = [["Low", "Low, indirect"], ["**Medium** (default)", "Medium, indirect"]]
//! ```
//!
//! Columns have a title and a [template](crate::template), rows a first cell and keys.

use std::ops::Range;

use regex::Regex;
use serde::Deserialize;

use super::{Origin, unless_waiting};
use crate::{store::Store, table::Table, template::Template};

/// See [the module](self).
#[derive(Deserialize, Clone, Debug)]
#[serde(deny_unknown_fields)]
pub struct TableOfDocs {
    pub name: String,
    #[serde(default)]
    pub waiting: bool,
    #[serde(default)]
    from: String,
    /// Rows of a bench's own table with these first cells, in this order; all rows if it is empty.
    #[serde(default)]
    only: Vec<String>,
    /// Rows of a bench's own table with one of these cells are left out.
    #[serde(default)]
    without: Vec<String>,
    /// Index among the bench's own tables.
    #[serde(default)]
    number: usize,
    #[serde(default)]
    head: String,
    #[serde(default)]
    columns: Vec<(String, String)>,
    #[serde(default)]
    rows: Vec<(String, String)>,
}

impl TableOfDocs {
    pub fn markdown(&self, store: &Store) -> Result<String, String> {
        let table = match self.columns.is_empty() {
            true => self.of_bench(store)?,
            false => self.as_wanted(store)?,
        };
        Ok(table.markdown())
    }

    fn of_bench(&self, store: &Store) -> Result<Table, String> {
        let mut tables = store.bench(&self.from)?.figures().tables();
        if self.number >= tables.len() {
            return Err(format!("{} has no table {}", self.from, self.number));
        }
        let mut table = tables.swap_remove(self.number);
        table.title.clear();
        (table.rows).retain(|row| !row.iter().any(|cell| self.without.contains(cell)));
        if !self.only.is_empty() {
            let rows = core::mem::take(&mut table.rows);
            for only in &self.only {
                let own = rows.iter().filter(|row| row.first() == Some(only));
                let before = table.rows.len();
                table.rows.extend(own.cloned());
                if table.rows.len() == before {
                    return Err(format!("{} has no rows {only}", self.from));
                }
            }
        }
        Ok(table)
    }

    fn as_wanted(&self, store: &Store) -> Result<Table, String> {
        let from = Origin::new(store, &self.from);
        let mut table = Table {
            columns: vec![self.head.clone()],
            ..Table::default()
        };
        let mut cells = Vec::new();
        for (title, cell) in &self.columns {
            table.columns.push(title.clone());
            cells.push(Template::parse(cell)?);
        }
        for (label, keys) in &self.rows {
            let from = from.and(keys);
            let figures = cells.iter().map(|cell| cell.render(&from));
            let row: Result<Vec<String>, String> =
                core::iter::once(Ok(label.clone())).chain(figures).collect();
            table.rows.push(row?);
        }
        Ok(table)
    }
}

const END: &str = "<!-- /table -->";

fn begin() -> Regex {
    Regex::new("<!-- table: (.+?) -->\n").expect("it is constant")
}

/// Ranges of the made tables in `page`.
pub fn places(page: &str) -> Vec<Range<usize>> {
    let begin = begin();
    let places = begin.find_iter(page).filter_map(|begin| {
        let length = page[begin.end()..].find(END)?;
        Some(begin.end()..begin.end() + length)
    });
    places.collect()
}

/// `page` with its tables; records in `used` which of `tables` it has.
pub fn fill(
    page: &str,
    tables: &[TableOfDocs],
    store: &Store,
    used: &mut [bool],
) -> Result<String, String> {
    let mut made = String::new();
    let mut rest = page;
    while let Some(captures) = begin().captures(rest) {
        let (marker, name) = (captures.get(0).expect("all of it"), &captures[1]);
        let place = tables.iter().position(|table| table.name == name);
        let place = place.ok_or(format!("the table {name} is not in tables.toml"))?;
        let says = |error: String| format!("table {name}: {error}");
        let table = unless_waiting(tables[place].waiting, tables[place].markdown(store));
        let table = table.map_err(says)?;
        used[place] = true;
        let body = &rest[marker.end()..];
        let end = body
            .find(END)
            .ok_or(format!("table {name}: it has no end"))?;
        made.push_str(&rest[..marker.end()]);
        match table {
            Some(table) => made.push_str(&format!("\n{table}\n")),
            None => made.push_str(&body[..end]),
        }
        rest = &body[end..];
    }
    made.push_str(rest);
    Ok(made)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benches::{Bench, LightScaling};

    fn store() -> Store {
        let json = r#"{"adapter": "GPU", "points": [
            {"size": [64, 32], "arrangement": "spread", "lights": 16, "contender": "lean", "left_out": null, "frames": 4,
             "stage": {"median": 0.25, "low": 0.2, "high": 0.3}, "camera": null, "frame": null, "psnr": null, "grids": [],
             "longest_list": 7, "lists_grew": false}]}"#;
        let mut store = Store::default();
        let figures: LightScaling = serde_json::from_str(json).unwrap();
        store.insert("gpu/light_scaling", Bench::LightScaling(figures));
        store
    }

    fn table(rows: &str) -> TableOfDocs {
        let text = format!(
            r#"name = "t"
            from = "gpu/light_scaling | 64x32"
            columns = [["ms", "{{stage.median :.2}}"]]
            rows = {rows}"#
        );
        toml::from_str(&text).unwrap()
    }

    const PAGE: &str = "before\n<!-- table: t -->\nold\n<!-- /table -->\nafter\n";

    #[test]
    fn the_table_takes_the_place_of_the_old_one() {
        let tables = [table(r#"[["16 lights", "16 | lean"]]"#)];
        let mut used = [false];
        let made = fill(PAGE, &tables, &store(), &mut used).unwrap();
        let new = "before\n<!-- table: t -->\n\n| | ms |\n|---|---|\n| 16 lights | 0.25 |\n\n<!-- /table -->\nafter\n";
        assert_eq!(made, new);
        assert_eq!(used, [true]);
        assert_eq!(
            fill(&made, &tables, &store(), &mut used).as_deref(),
            Ok(new)
        );
        assert_eq!(&made[places(&made)[0].clone()][..5], "\n| | ");
    }

    #[test]
    fn what_is_not_there_is_told() {
        let says = |page: &str, rows: &str| {
            fill(page, &[table(rows)], &store(), &mut [false]).unwrap_err()
        };
        let good = r#"[["16 lights", "16 | lean"]]"#;
        assert!(says(PAGE, r#"[["many", "17 | lean"]]"#).contains("nothing was measured"));
        assert!(says("<!-- table: u -->\n<!-- /table -->", good).contains("not in tables.toml"));
        assert!(says("<!-- table: t -->\n", good).contains("no end"));
    }

    #[test]
    fn what_waits_for_its_figures_stays_as_it_is() {
        let waiting = |rows| TableOfDocs {
            waiting: true,
            ..table(rows)
        };
        let tables = [waiting(r#"[["many", "17 | lean"]]"#)];
        assert_eq!(
            fill(PAGE, &tables, &store(), &mut [false]).as_deref(),
            Ok(PAGE)
        );
        let tables = [waiting(r#"[["16 lights", "16 | lean"]]"#)];
        let error = fill(PAGE, &tables, &store(), &mut [false]).unwrap_err();
        assert!(error.contains("waits no longer"), "{error}");
    }

    #[test]
    fn a_benchs_own_table() {
        let text = r#"name = "t"
            from = "gpu/light_scaling"
            only = ["64×32"]"#;
        let table: TableOfDocs = toml::from_str(text).unwrap();
        let markdown = table.markdown(&store()).unwrap();
        assert!(
            markdown.contains("| 64×32 | spread | 16 | 0.250 (0.200–0.300) |"),
            "{markdown}"
        );
    }
}
