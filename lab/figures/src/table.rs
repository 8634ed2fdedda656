//! Tables of figures, for Markdown and HTML.

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
    pub fn new(columns: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Self {
        Self {
            columns: columns.iter().map(|title| (*title).into()).collect(),
            rows: rows.into_iter().collect(),
            ..Self::default()
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_markdown() {
        let rows = [["A", "1.2 ms"], ["B", ""]].map(|row| row.map(String::from).into());
        let mut table = Table::new(&["", "t"], rows);
        let text = "| | t |\n|---|---|\n| A | 1.2 ms |\n| B | |\n";
        assert_eq!(table.markdown(), text);
        table.notes.push("a note".into());
        let titled = table.titled("**T**").markdown();
        assert_eq!(titled, format!("**T**\n\n{text}\n- a note\n"));
    }
}
