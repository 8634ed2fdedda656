//! Numbers as options on the command line.

use core::str::FromStr;

/// Parses a finite number that satisfies `holds`; the error says what was `expected`.
fn number_where(text: &str, expected: &str, holds: fn(f32) -> bool) -> Result<f32, String> {
    let number = f32::from_str(text).map_err(|error| format!("{text}: {error}"))?;
    if number.is_finite() && holds(number) {
        Ok(number)
    } else {
        Err(format!("{text}: expected {expected}"))
    }
}

pub fn finite(text: &str) -> Result<f32, String> {
    number_where(text, "a number", |_| true)
}

pub fn positive(text: &str) -> Result<f32, String> {
    number_where(text, "more than 0", |x| x > 0.0)
}
