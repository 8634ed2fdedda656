//! Measurements as tables and sentences refer to them: by keys, and by the path of a value.

use serde_json::{Map, Value};

/// One measurement.
#[derive(Clone, Debug)]
pub struct Record {
    /// Keys that references name: scene, contender, size and the like.
    pub keys: Vec<String>,
    /// Values as the bench wrote them, and derived ones.
    values: Value,
}

impl Record {
    pub fn new(
        keys: impl IntoIterator<Item = String>,
        measurement: &impl serde::Serialize,
    ) -> Self {
        Self {
            keys: keys.into_iter().collect(),
            values: serde_json::to_value(measurement).expect("plain figures serialise"),
        }
    }

    /// Adds a derived value.
    pub fn with(mut self, name: &str, value: impl Into<Value>) -> Self {
        match &mut self.values {
            Value::Object(values) => {
                values.insert(name.into(), value.into());
            }
            values => *values = Value::Object(Map::from_iter([(name.into(), value.into())])),
        }
        self
    }

    pub fn has(&self, key: &str) -> bool {
        self.keys.iter().any(|own| own == key)
    }

    /// The value at a path of names and indices, separated by dots: `lighting.median`, `passes.0.median`.
    pub fn value(&self, path: &str) -> Option<&Value> {
        at(&self.values, path)
    }
}

fn at<'a>(value: &'a Value, path: &str) -> Option<&'a Value> {
    if path.is_empty() {
        return Some(value);
    }
    match value {
        // Names may contain dots.
        Value::Object(values) => values.iter().find_map(|(name, value)| {
            let rest = path.strip_prefix(name.as_str())?;
            let rest = match rest.strip_prefix('.') {
                Some(rest) => rest,
                None if rest.is_empty() => rest,
                None => return None,
            };
            at(value, rest)
        }),
        Value::Array(values) => {
            let (index, rest) = path.split_once('.').unwrap_or((path, ""));
            at(values.get(index.parse::<usize>().ok()?)?, rest)
        }
        // Any path into a value that was not measured is not measured.
        Value::Null => Some(value),
        _ => None,
    }
}

/// The only one of `records` that has all of `keys`.
pub fn find<'a>(records: &'a [Record], keys: &[&str]) -> Result<&'a Record, String> {
    let mut found = records.iter().filter(|r| keys.iter().all(|key| r.has(key)));
    match (found.next(), found.count()) {
        (Some(record), 0) => Ok(record),
        (None, _) => Err(format!("nothing was measured of {}", keys.join(" | "))),
        (Some(_), more) => Err(format!("{} stands for {}", keys.join(" | "), more + 1)),
    }
}

/// `1920x1080`.
pub fn size_key([width, height]: [u32; 2]) -> String {
    format!("{width}x{height}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn record(keys: &[&str], value: Value) -> Record {
        Record::new(keys.iter().map(|key| (*key).into()), &value)
    }

    #[test]
    fn paths_go_through_names_and_numbers() {
        let values =
            json!({"a": {"b": [1, {"c": 2}]}, "errors": {"0.1": 3, "0.12": 4}, "none": null});
        let record = record(&[], values);
        assert_eq!(record.value("a.b.0"), Some(&json!(1)));
        assert_eq!(record.value("a.b.1.c"), Some(&json!(2)));
        assert_eq!(record.value("errors.0.1"), Some(&json!(3)));
        assert_eq!(record.value("errors.0.12"), Some(&json!(4)));
        assert_eq!(record.value("a.d"), None);
        assert_eq!(record.value("a.b.2"), None);
        assert_eq!(record.value("none.median"), Some(&Value::Null));
    }

    #[test]
    fn keys_must_mean_one_record() {
        let records = [
            record(&["boxes", "lean"], json!(1)),
            record(&["boxes", "Bevy"], json!(2)),
        ];
        assert!(find(&records, &["lean", "boxes"]).is_ok());
        assert!(find(&records, &["boxes"]).is_err());
        assert!(find(&records, &["helmet"]).is_err());
    }
}
