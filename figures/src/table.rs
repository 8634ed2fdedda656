//! Tables of figures, for Markdown and HTML.

use serde_json::Value;

use crate::{
    record::{Record, find},
    template::{Reference, Resolve, Template},
};

/// A table of texts.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// Title before the table, in Markdown.
    pub title: String,
    pub columns: Vec<String>,
    pub rows: Vec<Vec<String>>,
    /// Notes below the table, in Markdown.
    pub notes: Vec<String>,
}

impl Table {
    /// Makes a row for each of `rows`, which are keys that references add theirs to. Columns are titles and templates.
    pub fn of(records: &[Record], rows: &[Vec<String>], columns: &[(&str, &str)]) -> Self {
        let cells = |keys: &Vec<String>| -> Vec<String> {
            let row = Row { records, keys };
            let cell = |(_, cell): &(&str, &str)| {
                let text = Template::parse(cell).and_then(|cell| cell.render(&row));
                text.unwrap_or_else(|error| panic!("{cell}: {error}"))
            };
            columns.iter().map(cell).collect()
        };
        Self {
            columns: columns.iter().map(|(title, _)| (*title).into()).collect(),
            rows: rows.iter().map(cells).collect(),
            ..Self::default()
        }
    }

    /// Makes a row for each of `records`, which differ in their keys.
    pub fn of_each(records: &[Record], columns: &[(&str, &str)]) -> Self {
        let rows: Vec<Vec<String>> = records.iter().map(|record| record.keys.clone()).collect();
        Self::of(records, &rows, columns)
    }

    pub fn titled(self, title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            ..self
        }
    }

    pub fn markdown(&self) -> String {
        let mut text = String::new();
        if !self.title.is_empty() {
            text.push_str(&self.title);
            text.push_str("\n\n");
        }
        let mut line = |cells: &[String]| {
            for cell in cells {
                text.push_str(if cell.is_empty() { "| " } else { "|" });
                if !cell.is_empty() {
                    text.push_str(&format!(" {cell} "));
                }
            }
            text.push_str("|\n");
        };
        line(&self.columns);
        line(&vec!["---".into(); self.columns.len()]);
        for row in &self.rows {
            line(row);
        }
        let text = text.replace("| --- ", "|---");
        let notes: String = self
            .notes
            .iter()
            .map(|note| format!("- {note}\n"))
            .collect();
        match notes.is_empty() {
            true => text,
            false => format!("{text}\n{notes}"),
        }
    }
}

/// A row of a bench's own table: references only need the keys that the row's leave open.
struct Row<'a> {
    records: &'a [Record],
    keys: &'a [String],
}

impl Resolve for Row<'_> {
    fn resolve(&self, reference: &Reference) -> Result<Option<Value>, String> {
        let keys = self.keys.iter().chain(reference.keys());
        let keys: Vec<&str> = keys.map(String::as_str).collect();
        // A renderer may have been left out.
        let record = find(self.records, &keys).ok();
        Ok(record.and_then(|record| record.value(reference.path()).cloned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn rows_are_records_and_what_is_missing_is_a_dash() {
        let records = [
            Record::new(["a".into(), "x".into()], &json!({"name": "A", "t": 1.25})),
            Record::new(["b".into(), "x".into()], &json!({"name": "B", "t": null})),
        ];
        let table = Table::of_each(&records, &[("", "{name}"), ("t", "{t :.1} ms")]);
        assert_eq!(
            table.markdown(),
            "| | t |\n|---|---|\n| A | 1.2 ms |\n| B | – |\n"
        );
        let across = Table::of(
            &records,
            &[vec!["x".into()]],
            &[("a", "{a | t :.2}"), ("c", "{c | t :.2}")],
        );
        assert_eq!(across.rows, [["1.25", "–"]]);
    }
}
