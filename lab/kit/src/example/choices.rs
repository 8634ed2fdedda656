//! Enums as options on the command line.

use core::fmt::Debug;

use super::fields::kebab_case;

/// Parses one of `all` from its name in kebab case.
pub fn parse<T: Copy + Debug>(all: &[T], text: &str) -> Result<T, String> {
    let name = |choice: &T| kebab_case(&format!("{choice:?}"));
    let wanted = text.to_lowercase();
    all.iter()
        .copied()
        .find(|choice| name(choice) == wanted)
        .ok_or_else(|| {
            let names: Vec<String> = all.iter().map(name).collect();
            format!("{text}: expected one of {}", names.join(", "))
        })
}
