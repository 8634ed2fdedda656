//! Enums as options on the command line and behind keys.

use core::fmt::Debug;

/// Parses one of `all` from its [`name`].
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

/// Kebab case: `GeometricNormal` becomes `geometric-normal`.
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

/// The choice after `current`, wrapping around.
pub fn next<T: Copy + PartialEq>(all: &[T], current: T) -> T {
    let index = all.iter().position(|x| *x == current).unwrap_or(0);
    all[(index + 1) % all.len()]
}

/// The choice after `current` in the cycle of none and each of `all`.
pub fn next_or_none<T: Copy + PartialEq>(all: &[T], current: Option<T>) -> Option<T> {
    let index = match current {
        None => 0,
        Some(current) => all.iter().position(|x| *x == current)? + 1,
    };
    all.get(index).copied()
}
