//! Sizes on the command line.

use bevy::math::UVec2;

/// Parses `WIDTHxHEIGHT`, neither of them 0.
pub fn parse_size(text: &str) -> Result<UVec2, String> {
    let (x, y) = text.split_once('x').ok_or("expected WIDTHxHEIGHT")?;
    let number = |s: &str| s.parse::<u32>().map_err(|error| format!("{s}: {error}"));
    let size = UVec2::new(number(x)?, number(y)?);
    if size.min_element() == 0 {
        return Err("both sides must be at least 1".into());
    }
    Ok(size)
}
