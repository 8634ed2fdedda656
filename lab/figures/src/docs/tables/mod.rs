//! Tables between `<!-- table: NAME -->` and `<!-- /table -->`, a function for each of them.
//!
//! A table ends the program if its figures are missing, and says what was not measured.

mod compilers;
mod effects;
mod frames;
mod summary;

use crate::{store::Store, table::Table};

/// The tables of all pages by name.
pub const TABLES: &[(&str, fn(&Store) -> Table)] = &[
    ("summary", summary::summary),
    ("frame times", frames::frame_times),
    ("levels", frames::levels),
    ("levels times", frames::levels_times),
    ("levels masks", frames::levels_masks),
    ("many meshes", frames::many_meshes),
    ("stutter", frames::stutter),
    ("light scaling", frames::light_scaling),
    ("light culling", frames::light_culling),
    ("optional targets", frames::optional_targets),
    ("blended", frames::blended),
    ("light probes", frames::light_probes),
    ("occlusion", effects::occlusion),
    (
        "occlusion at other sizes",
        effects::occlusion_at_other_sizes,
    ),
    ("exposure", effects::exposure),
    ("exposure at other sizes", effects::exposure_at_other_sizes),
    ("diffuse GI", effects::diffuse_gi),
    ("reflections", effects::reflections),
    ("reflections_1920", effects::reflections_1920),
    ("scattering", effects::scattering),
    ("presets", effects::presets),
    ("isa amd", compilers::amd),
    ("isa intel", compilers::intel),
    ("expected", compilers::expected),
    ("crates", |store| store.compat("llvmpipe").table()),
];

const HD: [u32; 2] = [1920, 1080];
const UHD: [u32; 2] = [3840, 2160];

/// The table with this name.
pub fn table(name: &str, store: &Store) -> Option<Table> {
    let (_, make) = TABLES.iter().find(|(own, _)| *own == name)?;
    Some(make(store))
}

/// Makes a row for each of `rows`: its first cell, and `cells` of its second part.
fn rows_of<T: Copy>(
    columns: &[&str],
    rows: &[(&str, T)],
    cells: impl Fn(T) -> Vec<String>,
) -> Table {
    let row = |(label, of): &(&str, T)| [vec![(*label).into()], cells(*of)].concat();
    Table::new(columns, rows.iter().map(row))
}

const BEGIN: &str = "\n<!-- table: ";
const CLOSE: &str = " -->\n";
const END: &str = "<!-- /table -->";

/// `page` with its tables, which `make` makes by name.
pub fn fill(page: &str, mut make: impl FnMut(&str) -> Option<Table>) -> Result<String, String> {
    let mut made = String::new();
    let mut rest = page;
    while let Some((before, after)) = rest.split_once(BEGIN) {
        let (name, after) = after.split_once(CLOSE).ok_or("a marker is not closed")?;
        let says = |what: &str| format!("table {name}: {what}");
        let (_, after) = after.split_once(END).ok_or(says("it has no end"))?;
        let table = make(name).ok_or(says("no function makes it"))?.markdown();
        made.push_str(&format!("{before}{BEGIN}{name}{CLOSE}\n{table}\n{END}"));
        rest = after;
    }
    Ok(made + rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn make(name: &str) -> Option<Table> {
        (name == "t").then(|| Table::new(&["ms"], [vec!["0.25".into()]]))
    }

    #[test]
    fn the_table_takes_the_place_of_the_old_one() {
        let page = "before\n<!-- table: t -->\nold\n<!-- /table -->\nafter\n";
        let made = fill(page, make).unwrap();
        let new =
            "before\n<!-- table: t -->\n\n| ms |\n|---|\n| 0.25 |\n\n<!-- /table -->\nafter\n";
        assert_eq!(made, new);
        assert_eq!(fill(&made, make).as_deref(), Ok(new));
    }

    #[test]
    fn what_is_not_there_is_told() {
        let says = |page: &str| fill(page, make).unwrap_err();
        assert!(says("\n<!-- table: u -->\n<!-- /table -->").contains("no function"));
        assert!(says("\n<!-- table: t -->\n").contains("no end"));
        assert!(says("\n<!-- table: t").contains("not closed"));
    }
}
