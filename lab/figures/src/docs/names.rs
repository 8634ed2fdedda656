//! Names of tests in pages: `` `tests/FILE.rs::FUNCTION` ``.

use std::path::Path;

/// Functions that a page names and that are not in their file.
pub fn dead(root: &Path, name: &str, page: &str) -> Vec<String> {
    let spans = page.split('`').skip(1).step_by(2);
    let named = spans.filter_map(|span| span.split_once(".rs::"));
    named
        .filter(|(file, function)| {
            let text = std::fs::read_to_string(root.join(format!("{file}.rs")));
            !text.is_ok_and(|text| text.contains(&format!("fn {function}(")))
        })
        .map(|(file, function)| format!("{name}: {file}.rs has no function {function}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_functions_are_there() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let page = "`src/main.rs::main`, `src/main.rs::none`, `src/none.rs::main` and `path/`";
        assert_eq!(
            dead(root, "page.md", page),
            [
                "page.md: src/main.rs has no function none",
                "page.md: src/none.rs has no function main"
            ]
        );
    }
}
