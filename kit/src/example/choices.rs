//! Enums as options on the command line and behind keys.

use core::fmt::Debug;

/// Reads the name of one of `all`, as [`name`] writes it.
pub fn parse<T: Copy + Debug>(all: &[T], text: &str) -> Result<T, String> {
    let wanted = text.to_lowercase();
    all.iter()
        .copied()
        .find(|choice| name(choice) == wanted)
        .ok_or_else(|| {
            let names: Vec<String> = all.iter().map(name).collect();
            format!("{text}: expected one of {}", names.join(", "))
        })
}

/// `GeometricNormal` is `geometric-normal` on the command line.
fn name(choice: &impl Debug) -> String {
    let mut name = String::new();
    for letter in format!("{choice:?}").chars() {
        if letter.is_uppercase() && !name.is_empty() {
            name.push('-');
        }
        name.extend(letter.to_lowercase());
    }
    name
}

/// The one after `current`; after the last, the first.
pub fn next<T: Copy + PartialEq>(all: &[T], current: T) -> T {
    let index = all.iter().position(|x| *x == current).unwrap_or(0);
    all[(index + 1) % all.len()]
}

/// None, then each of `all`, then none again.
pub fn next_or_none<T: Copy + PartialEq>(all: &[T], current: Option<T>) -> Option<T> {
    let index = match current {
        None => 0,
        Some(current) => all.iter().position(|x| *x == current)? + 1,
    };
    all.get(index).copied()
}
