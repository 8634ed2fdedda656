//! Formats of values.

use serde_json::Value;

/// See [the module above](super).
#[derive(Debug, Clone, Copy)]
pub struct Format {
    sign: Sign,
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Sign {
    /// A sign for negative numbers.
    Minus,
    /// A sign for all numbers.
    Always,
    Never,
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    AsItIs,
    Digits(usize),
    Exponent(usize),
    Percent(usize),
    Grouped,
    Milliseconds,
    Microseconds,
}

/// Pattern of a number in a text.
pub const NUMBER: &str = r"[-+]?\d+(?:,\d{3})*(?:\.\d+)?(?:e-?\d+)?";

impl Format {
    pub fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let (sign, rest) = match (text.strip_prefix("abs "), text.strip_prefix('+')) {
            (Some(rest), _) => (Sign::Never, rest),
            (_, Some(rest)) => (Sign::Always, rest),
            _ => (Sign::Minus, text),
        };
        let digits = |text: &str| {
            let digits = text.strip_prefix('.').and_then(|text| text.parse().ok());
            digits.ok_or(format!("`{text}` is no number of digits"))
        };
        let kind = match rest {
            "" => Kind::AsItIs,
            "," => Kind::Grouped,
            "time" => Kind::Milliseconds,
            "us" => Kind::Microseconds,
            _ => {
                if let Some(rest) = rest.strip_suffix('e') {
                    Kind::Exponent(digits(rest)?)
                } else if let Some(rest) = rest.strip_suffix('%') {
                    Kind::Percent(digits(rest)?)
                } else {
                    Kind::Digits(digits(rest)?)
                }
            }
        };
        Ok(Self { sign, kind })
    }

    pub fn text(self, value: Option<&Value>) -> Result<String, String> {
        let Some(value) = value else {
            return Ok("–".into());
        };
        if let Value::String(words) = value {
            return Ok(words.clone());
        }
        match self.kind {
            Kind::Milliseconds => return time(value, 1.0, 3),
            Kind::Microseconds => return time(value, 1e3, 1),
            _ => {}
        }
        let number = value.as_f64().ok_or(format!("{value} is no number"))?;
        let number = match self.sign {
            Sign::Never => number.abs(),
            _ => number,
        };
        let text = match self.kind {
            Kind::AsItIs if value.is_f64() => format!("{number}"),
            Kind::AsItIs => value.to_string(),
            Kind::Exponent(digits) => format!("{number:.digits$e}"),
            Kind::Percent(digits) => format!("{:.digits$}%", number * 100.0),
            Kind::Grouped => grouped(number),
            Kind::Digits(digits) => format!("{number:.digits$}"),
            Kind::Milliseconds | Kind::Microseconds => unreachable!("done above"),
        };
        Ok(match self.sign {
            Sign::Always if !text.starts_with('-') => format!("+{text}"),
            _ => text,
        })
    }

    /// Pattern of the formatted text, as a regular expression.
    pub fn pattern(self) -> String {
        match self.kind {
            Kind::Milliseconds | Kind::Microseconds => {
                format!(r"{NUMBER} \({NUMBER}–{NUMBER}\)")
            }
            Kind::Percent(_) => format!("{NUMBER}%"),
            _ => NUMBER.into(),
        }
    }
}

fn time(value: &Value, scale: f64, digits: usize) -> Result<String, String> {
    let part = |name: &str| {
        let part = value.get(name).and_then(Value::as_f64);
        part.map(|part| format!("{:.digits$}", part * scale))
            .ok_or(format!("{value} is no time"))
    };
    let [median, low, high] = [part("median")?, part("low")?, part("high")?];
    Ok(format!("{median} ({low}–{high})"))
}

/// Rounded, with a comma between thousands.
fn grouped(number: f64) -> String {
    let digits = format!("{:.0}", number.abs());
    let mut text = String::new();
    if number <= -0.5 {
        text.push('-');
    }
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
