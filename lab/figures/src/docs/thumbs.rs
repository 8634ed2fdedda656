//! Small pictures as base64, for the pages of rustdoc, which copies no files.

use std::{collections::BTreeMap, path::Path};

use base64::{Engine, prelude::BASE64_STANDARD};

const FOLDER: &str = "docs/pictures/thumbs";

/// The text of each picture, by the path of its file.
pub fn encoded(root: &Path) -> Result<BTreeMap<String, String>, String> {
    let says = |error: std::io::Error| format!("{FOLDER}: {error}");
    let mut texts = BTreeMap::new();
    for entry in std::fs::read_dir(root.join(FOLDER)).map_err(says)? {
        let path = entry.map_err(says)?.path();
        if path.extension().is_some_and(|extension| extension == "jpg") {
            let picture = std::fs::read(&path).map_err(says)?;
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let text = BASE64_STANDARD.encode(picture);
            texts.insert(format!("{FOLDER}/{name}.base64"), text);
        }
    }
    Ok(texts)
}
