//! Numbers as options on the command line.

use core::{fmt::Display, str::FromStr};

/// Parses a finite number that satisfies `holds`; the error says what was `expected`.
pub fn number_where(
    text: &str,
    expected: impl Display,
    holds: fn(f32) -> bool,
) -> Result<f32, String> {
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

pub fn share(text: &str) -> Result<f32, String> {
    number_where(text, "0 to 1", |x| (0.0..=1.0).contains(&x))
}

pub fn not_negative(text: &str) -> Result<f32, String> {
    number_where(text, "0 or more", |x| x >= 0.0)
}
