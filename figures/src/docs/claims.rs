//! Numbers in sentences.
//!
//! ```toml
//! [[claim]]
//! file = "README.md"
//! from = "h200/frame_times | boxes_64"
//! text = "{lean | camera.median :.2} ms, forward {Bevy forward | camera.median :.2}"
//! ```
//!
//! The [template](crate::template), with any number in place of each figure, must occur in the file exactly once. White
//! space may differ. The numbers in the file must be those of the figures.

use std::ops::Range;

use regex::Regex;
use serde::Deserialize;

use super::Origin;
use crate::{
    store::Store,
    template::{Part, Template},
};

/// See [the module](self).
#[derive(Deserialize, Clone, Debug)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    pub file: String,
    #[serde(default)]
    pub from: String,
    pub text: String,
    #[serde(default)]
    pub waiting: bool,
}

impl Claim {
    /// The text as a regular expression, with a group for each figure.
    fn pattern(&self, template: &Template) -> Regex {
        let mut pattern = String::new();
        for part in &template.parts {
            match part {
                Part::Text(text) => pattern.push_str(&literal(text)),
                Part::Figure(_, format) => {
                    pattern.push('(');
                    pattern.push_str(&format.pattern());
                    pattern.push(')');
                }
            }
        }
        Regex::new(pattern.trim()).expect("all of it is escaped")
    }

    /// Its matches in `page`.
    pub fn places(&self, page: &str) -> Vec<Range<usize>> {
        let Ok(template) = Template::parse(self.text.trim()) else {
            return Vec::new();
        };
        let pattern = self.pattern(&template);
        pattern.find_iter(page).map(|found| found.range()).collect()
    }

    /// `page` with its numbers replaced by those of the figures.
    pub fn make(&self, page: &str, store: &Store) -> Result<String, String> {
        let template = Template::parse(self.text.trim())?;
        let from = Origin::new(store, &self.from);
        let mut numbers = Vec::new();
        for part in &template.parts {
            if let Part::Figure(expression, format) = part {
                let value = expression.value(&from)?;
                let value = value.ok_or("something of it was not measured")?;
                numbers.push(format.text(Some(&value))?);
            }
        }
        if numbers.is_empty() {
            return Err("it has no figure".into());
        }
        let pattern = self.pattern(&template);
        let mut found = pattern.captures_iter(page);
        let captures = found.next().ok_or("the page does not say so")?;
        if found.next().is_some() {
            return Err("the page says so more than once".into());
        }
        let mut made = page.to_owned();
        // From the last to the first, so that ranges stay valid.
        for (index, number) in numbers.iter().enumerate().rev() {
            let group = captures.get(index + 1).expect("a group for each figure");
            made.replace_range(group.range(), number);
        }
        Ok(made)
    }
}

/// A pattern for `text` that matches any white space where it has some.
fn literal(text: &str) -> String {
    let mut pattern = String::new();
    let mut in_space = false;
    for character in text.chars() {
        if character.is_whitespace() {
            if !in_space {
                pattern.push_str(r"\s+");
            }
            in_space = true;
        } else {
            in_space = false;
            pattern.push_str(&regex::escape(character.encode_utf8(&mut [0; 4])));
        }
    }
    pattern
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benches::{Bench, FrameTimes};

    fn store() -> Store {
        let json = r#"[
            {"adapter": "GPU", "scene": "boxes", "contender": "lean", "geometry": null, "lighting": null,
             "camera": {"median": 7.8519, "low": 7.0, "high": 8.0}, "bytes_written_by_geometry": 12,
             "bytes_in_all": 32, "psnr": 46.94, "flip": 0.0, "off_by_8": 0.0},
            {"adapter": "GPU", "scene": "boxes", "contender": "Bevy forward", "geometry": null, "lighting": null,
             "camera": {"median": 11.911, "low": 11.0, "high": 12.0}, "bytes_written_by_geometry": 12,
             "bytes_in_all": 12, "psnr": null, "flip": null, "off_by_8": null}
        ]"#;
        let mut store = Store::default();
        let figures: FrameTimes = serde_json::from_str(json).unwrap();
        store.insert("gpu/frame_times", Bench::FrameTimes(figures));
        store
    }

    fn claim(text: &str) -> Claim {
        Claim {
            file: String::new(),
            from: "gpu/frame_times | boxes".into(),
            text: text.into(),
            waiting: false,
        }
    }

    const PAGE: &str =
        "A frame takes 9.99 ms\n(forward:   1,234.5 ms), 3 times.\n| a | 9.99 ms |\n";

    #[test]
    fn numbers_become_those_of_the_figures() {
        let claim = claim(
            "takes {lean | camera.median :.2} ms (forward: {Bevy forward | camera.median :.1} ms), \
             {Bevy forward | camera.median / lean | camera.median :.1} times",
        );
        let made = claim.make(PAGE, &store()).unwrap();
        assert_eq!(
            made,
            "A frame takes 7.85 ms\n(forward:   11.9 ms), 1.5 times.\n| a | 9.99 ms |\n"
        );
        // Correct numbers stay.
        assert_eq!(claim.make(&made, &store()).as_deref(), Ok(&made[..]));
    }

    #[test]
    fn a_source_may_stand_in_the_reference() {
        let claim = Claim {
            from: String::new(),
            ..claim("takes {gpu/frame_times | lean | camera.median :.2} ms")
        };
        assert!(
            claim
                .make(PAGE, &store())
                .unwrap()
                .contains("takes 7.85 ms")
        );
    }

    #[track_caller]
    fn fails(text: &str, page: &str, why: &str) {
        let error = claim(text).make(page, &store()).unwrap_err();
        assert!(error.contains(why), "{error}");
    }

    #[test]
    fn it_must_be_said_exactly_once() {
        fails("{lean | camera.median :.2} ms", PAGE, "more than once");
        fails(
            "took {lean | camera.median :.2} ms",
            PAGE,
            "does not say so",
        );
        // A word in place of a number.
        fails(
            "A frame {lean | camera.median :.2} ms",
            PAGE,
            "does not say so",
        );
    }

    #[test]
    fn it_must_have_been_measured() {
        fails(
            "takes {lean | lighting.median :.2} ms",
            PAGE,
            "not measured",
        );
        fails("takes {lean | geometry :.2} ms", PAGE, "not measured");
        fails(
            "takes {fat | camera.median :.2} ms",
            PAGE,
            "nothing was measured",
        );
        fails("takes {camera.median :.2} ms", PAGE, "stands for 2");
        fails("A frame takes", PAGE, "no figure");
    }
}
