//! Text with figures in it: `{lean | lighting.median :.3} ms, {a / b :.1} times as long`.
//!
//! Braces contain an expression and, after ` :`, a format. An expression consists of numbers and references, with ` + `,
//! ` - `, ` * ` and ` / ` between spaces; ` * ` and ` / ` bind tighter. A reference has parts separated by ` | `: keys of a
//! record, and last the path of a value in it. The first part may be a source, `h200/frame_times`.
//!
//! | format | 1234.5 becomes |
//! |---|---|
//! | `.2` | 1234.50 |
//! | `.1e` | 1.2e3 |
//! | `,` | 1,235 |
//! | `.1%` | 123450.0% |
//! | `time`, `us` | for a time: median (10th–90th percentile), in ms with three digits, in µs with one |
//! | none | the value as it is, words too |
//!
//! `+` before one of these also writes the sign of positive numbers, `abs ` writes no sign. A value that was not measured
//! is a dash.

mod expression;
mod format;

pub use expression::{Expression, Reference};
pub use format::Format;

use serde_json::Value;

/// Resolves references to values; `None` is a value that was not measured.
pub trait Resolve {
    fn resolve(&self, reference: &Reference) -> Result<Option<Value>, String>;
}

pub enum Part {
    Text(String),
    Figure(Expression, Format),
}

/// See [the module](self).
pub struct Template {
    pub parts: Vec<Part>,
}

impl Template {
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut parts = Vec::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('{') {
            let (inside, after) = after
                .split_once('}')
                .ok_or(format!("a brace is not closed: {text}"))?;
            let (expression, format) = inside.rsplit_once(" :").unwrap_or((inside, ""));
            if !before.is_empty() {
                parts.push(Part::Text(before.into()));
            }
            let says = |error: String| format!("{{{inside}}}: {error}");
            parts.push(Part::Figure(
                Expression::parse(expression).map_err(says)?,
                Format::parse(format).map_err(says)?,
            ));
            rest = after;
        }
        if !rest.is_empty() {
            parts.push(Part::Text(rest.into()));
        }
        Ok(Self { parts })
    }

    /// The text with its figures. All of it is a dash if all of its figures are.
    pub fn render(&self, from: &dyn Resolve) -> Result<String, String> {
        let mut text = String::new();
        let (mut figures, mut missing) = (0, 0);
        for part in &self.parts {
            match part {
                Part::Text(part) => text.push_str(part),
                Part::Figure(expression, format) => {
                    figures += 1;
                    let value = expression.value(from)?;
                    missing += usize::from(value.is_none());
                    text.push_str(&format.text(value.as_ref())?);
                }
            }
        }
        if figures > 0 && figures == missing {
            return Ok("–".into());
        }
        Ok(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// Resolves a few names.
    struct Names;

    impl Resolve for Names {
        fn resolve(&self, reference: &Reference) -> Result<Option<Value>, String> {
            match reference.path() {
                "a" => Ok(Some(json!(12.0))),
                "b" => Ok(Some(json!(5.0))),
                "share" => Ok(Some(json!(0.00008))),
                "time" => Ok(Some(json!({"median": 1.0, "low": 0.5, "high": 1.23456}))),
                "many" => Ok(Some(json!(1_234_567))),
                "word" => Ok(Some(json!("not measured"))),
                "missing" => Ok(None),
                name => Err(format!("no {name}")),
            }
        }
    }

    fn render(text: &str) -> Result<String, String> {
        Template::parse(text)?.render(&Names)
    }

    #[track_caller]
    fn shows(text: &str, shown: &str) {
        assert_eq!(render(text).as_deref(), Ok(shown), "{text}");
    }

    #[test]
    fn figures_stand_in_the_text() {
        shows("from {a :.1} to {b :.0}%", "from 12.0 to 5%");
        shows("no figures", "no figures");
    }

    #[test]
    fn arithmetic_keeps_its_order() {
        shows("{a + b * 2}", "22");
        shows("{a - b - 1}", "6");
        shows("{a / b / 2 :.2}", "1.20");
        shows("{1000 * share :.3}", "0.080");
    }

    #[test]
    fn formats() {
        shows("{b - a :+.1} {b - a :abs .1} {a :+.1}", "-7.0 7.0 +12.0");
        shows(
            "{share :.1e} {share :+.1e} {share - 1 :+.1%}",
            "8.0e-5 +8.0e-5 -100.0%",
        );
        shows("{share :.3%}", "0.008%");
        shows("{many :,}", "1,234,567");
        shows("{b :,}", "5");
        shows("{time :time}", "1.000 (0.500–1.235)");
        shows("{time :us}", "1000.0 (500.0–1234.6)");
        shows("{word :.3}", "not measured");
        shows("{many}", "1234567");
    }

    #[test]
    fn what_was_not_measured_is_a_dash() {
        shows("{missing :.3} ({missing :+.3})", "–");
        shows("{a :.0} / {missing :.0}", "12 / –");
        shows("{a / missing :.1}", "–");
        shows("{missing :time}", "–");
    }

    #[test]
    fn mistakes_are_told() {
        for text in [
            "{a",
            "{}",
            "{c}",
            "{a :.x}",
            "{a + }",
            "{word + 1}",
            "{a :time}",
            "{a |}",
        ] {
            assert!(render(text).is_err(), "{text}");
        }
    }
}
