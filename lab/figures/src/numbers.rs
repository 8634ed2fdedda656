//! Numbers as tables show them. A dash stands for a missing measurement.

use crate::time::Time;

const DASH: &str = "–";

fn finite(value: impl Into<Option<f64>>, text: impl FnOnce(f64) -> String) -> String {
    let value = value.into().filter(|value| value.is_finite());
    value.map_or(DASH.into(), text)
}

/// A number with this many digits after the point.
pub fn fixed(value: impl Into<Option<f64>>, digits: usize) -> String {
    finite(value, |value| format!("{value:.digits$}"))
}

/// A share as a percentage.
pub fn percent(value: impl Into<Option<f64>>, digits: usize) -> String {
    finite(value, |value| format!("{:.digits$}%", value * 100.0))
}

/// The size of a relative error.
pub fn size_of_error(value: impl Into<Option<f64>>) -> String {
    finite(value, |value| format!("{:.1e}", value.abs()))
}

/// Root mean square of an error, and its mean.
pub fn rmse_and_bias(error: Option<(f64, f64)>) -> String {
    error.map_or(DASH.into(), |(rmse, bias)| {
        format!("{rmse:.3} ({bias:+.3})")
    })
}

/// The median in ms.
pub fn median(time: Option<Time>, digits: usize) -> String {
    fixed(time.map(|time| time.median), digits)
}

/// The median in µs.
pub fn median_us(time: Option<Time>) -> String {
    fixed(time.map(|time| time.median * 1e3), 1)
}

/// Median and spread in µs.
pub fn time_us(time: Option<Time>) -> String {
    time.map_or(DASH.into(), |Time { median, low, high }| {
        format!("{:.1} ({:.1}–{:.1})", median * 1e3, low * 1e3, high * 1e3)
    })
}

/// Parts of a sum; a dash if there is none.
pub fn sum_text(parts: &[f64], digits: usize) -> String {
    match parts.is_empty() {
        true => DASH.into(),
        false => joined(parts.iter().map(|part| fixed(*part, digits)), " + "),
    }
}

/// Numbers beside one another; one dash if none of them was measured.
pub fn beside(numbers: impl IntoIterator<Item = String>) -> String {
    let numbers: Vec<String> = numbers.into_iter().collect();
    match numbers.iter().all(|number| number == DASH) {
        true => DASH.into(),
        false => joined(numbers, " / "),
    }
}

fn joined(parts: impl IntoIterator<Item = String>, between: &str) -> String {
    parts.into_iter().collect::<Vec<_>>().join(between)
}

/// A number with a comma between thousands.
pub fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_digits_and_signs() {
        assert_eq!(fixed(1234.5, 2), "1234.50");
        assert_eq!(percent(0.00008, 3), "0.008%");
        assert_eq!(size_of_error(-0.00008), "8.0e-5");
        assert_eq!(rmse_and_bias(Some((0.25, 0.5))), "0.250 (+0.500)");
        assert_eq!(sum_text(&[0.5, 0.25], 1), "0.5 + 0.2");
        assert_eq!(
            [5, 1000, 1_234_567].map(thousands),
            ["5", "1,000", "1,234,567"]
        );
        let time = Time {
            median: 1.0,
            low: 0.5,
            high: 1.23456,
        };
        assert_eq!(median(Some(time), 3), "1.000");
        assert_eq!(median_us(Some(time)), "1000.0");
        assert_eq!(time_us(Some(time)), "1000.0 (500.0–1234.6)");
    }

    #[test]
    fn what_was_not_measured_is_a_dash() {
        let dashes = [
            fixed(None, 1),
            fixed(f64::NAN, 1),
            percent(f64::INFINITY, 1),
            size_of_error(None),
            rmse_and_bias(None),
            median(None, 1),
            time_us(None),
            sum_text(&[], 1),
            beside([fixed(None, 1), fixed(None, 2)]),
        ];
        assert!(dashes.iter().all(|text| text == DASH), "{dashes:?}");
        assert_eq!(beside([fixed(None, 1), fixed(2.0, 0)]), "– / 2");
    }
}
