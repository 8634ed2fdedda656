//! Quality levels and resolutions, which effects share.

use core::{error::Error, fmt, str::FromStr};

use bevy::prelude::*;

/// Quality level of an effect. The documentation of its component has the numbers of samples or steps, or the sizes of
/// texels, of each level.
///
/// `Display` writes `low`, `medium`, `high` or `ultra`, and `FromStr` reads these in upper or lower case. With the feature
/// `serialize`, serde stores the names of the variants.
///
/// ```
/// # use bevy_lean_deferred::prelude::*;
/// assert_eq!("High".parse(), Ok(LeanQuality::High));
/// let names = LeanQuality::ALL.map(|quality| quality.to_string());
/// assert_eq!(names, ["low", "medium", "high", "ultra"]);
/// ```
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[reflect(Default, Clone, PartialEq)]
#[cfg_attr(
    feature = "serialize",
    derive(serde::Serialize, serde::Deserialize),
    reflect(Serialize, Deserialize)
)]
pub enum LeanQuality {
    /// The shortest time, and the largest errors.
    Low,
    /// The default of all effects but subsurface scattering.
    #[default]
    Medium,
    /// Smaller errors than [`Medium`](Self::Medium), for more time.
    High,
    /// The smallest errors, whatever their cost: for stills, and GPUs with time to spare.
    Ultra,
}

impl LeanQuality {
    /// All levels, cheapest first.
    pub const ALL: [Self; 4] = [Self::Low, Self::Medium, Self::High, Self::Ultra];
}

impl fmt::Display for LeanQuality {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
            Self::Ultra => "ultra",
        })
    }
}

impl FromStr for LeanQuality {
    type Err = ParseLevelError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        parse_level(&Self::ALL, text)
    }
}

/// Resolution of an effect.
///
/// `Display` writes `half` or `full`, and `FromStr` reads these in upper or lower case. With the feature `serialize`, serde stores
/// the names of the variants.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[reflect(Default, Clone, PartialEq)]
#[cfg_attr(
    feature = "serialize",
    derive(serde::Serialize, serde::Deserialize),
    reflect(Serialize, Deserialize)
)]
pub enum LeanResolution {
    /// One texel per 2×2 pixels, upsampled along depth edges. The default of all effects but ambient occlusion.
    #[default]
    Half,
    /// One texel per pixel.
    Full,
}

impl LeanResolution {
    /// All resolutions, cheapest first.
    pub const ALL: [Self; 2] = [Self::Half, Self::Full];

    /// Pixels per side of a texel.
    pub(crate) fn divisor(self) -> u32 {
        match self {
            Self::Half => 2,
            Self::Full => 1,
        }
    }
}

impl fmt::Display for LeanResolution {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Self::Half => "half",
            Self::Full => "full",
        })
    }
}

impl FromStr for LeanResolution {
    type Err = ParseLevelError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        parse_level(&Self::ALL, text)
    }
}

/// A text that is the name of no [`LeanQuality`], [`LeanResolution`] or [`LeanPreset`](crate::LeanPreset). Its own text lists the
/// names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParseLevelError {
    text: String,
    names: String,
}

impl fmt::Display for ParseLevelError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { text, names } = self;
        write!(f, "\"{text}\" is none of {names}")
    }
}

impl Error for ParseLevelError {}

/// The level in `all` that is written `text`, in upper or lower case.
pub(crate) fn parse_level<T: Copy + fmt::Display>(
    all: &[T],
    text: &str,
) -> Result<T, ParseLevelError> {
    let names: Vec<String> = all.iter().map(T::to_string).collect();
    let found = names
        .iter()
        .position(|name| name.eq_ignore_ascii_case(text));
    found
        .map(|index| all[index])
        .ok_or_else(|| ParseLevelError {
            text: text.into(),
            names: names.join(", "),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for quality in LeanQuality::ALL {
            for text in [quality.to_string(), format!("{quality:?}").to_uppercase()] {
                assert_eq!(text.parse(), Ok(quality));
            }
        }
        for resolution in LeanResolution::ALL {
            for text in [resolution.to_string(), format!("{resolution:?}")] {
                assert_eq!(text.parse(), Ok(resolution));
            }
        }
        assert_eq!(format!("{:>6}", LeanQuality::Low), "   low");
    }

    #[test]
    fn an_unknown_name_is_told_the_known_ones() {
        let error = "fast".parse::<LeanQuality>().unwrap_err();
        assert_eq!(
            error.to_string(),
            "\"fast\" is none of low, medium, high, ultra"
        );
        let error = "".parse::<LeanResolution>().unwrap_err();
        assert_eq!(error.to_string(), "\"\" is none of half, full");
    }

    #[cfg(feature = "serialize")]
    #[test]
    fn levels_are_stored_by_name() {
        let stored = serde_json::to_string(&(LeanQuality::High, LeanResolution::Full)).unwrap();
        assert_eq!(stored, "[\"High\",\"Full\"]");
        let read: (LeanQuality, LeanResolution) = serde_json::from_str(&stored).unwrap();
        assert_eq!(read, (LeanQuality::High, LeanResolution::Full));
    }
}
