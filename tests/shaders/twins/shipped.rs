//! Declarations of all shipped WGSL under any definitions, read from its text.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

/// Place of a declaration: its file below `src`, and its name.
pub type Place = (String, String);

/// Files below `root` with this `extension`, relative to it, and their texts without comments.
fn files(root: &str, extension: &str) -> BTreeMap<String, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(root);
    files_below(&root, &root, extension)
}

fn files_below(root: &Path, folder: &Path, extension: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("it is a folder") {
        let path = entry.expect("it can be read").path();
        if path.is_dir() {
            found.extend(files_below(root, &path, extension));
        } else if path.extension().is_some_and(|found| found == extension) {
            let text = fs::read_to_string(&path).expect("it is text");
            let lines = text.lines();
            let code: Vec<&str> = lines
                .map(|line| line.split("//").next().unwrap_or_default())
                .collect();
            let name = path.strip_prefix(root).expect("it is below the root");
            found.insert(name.display().to_string(), code.join("\n"));
        }
    }
    found
}

pub fn wgsl() -> BTreeMap<String, String> {
    files("src", "wgsl")
}

/// Files by the paths under which others import them.
pub fn import_paths() -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for (file, text) in wgsl() {
        let mut lines = text.lines();
        if let Some(path) = lines.find_map(|line| line.strip_prefix("#define_import_path ")) {
            found.insert(path.trim().to_string(), file);
        }
    }
    found
}

/// The identifier at the beginning of `text`.
fn name_at(text: &str) -> String {
    let text = text.trim_start();
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
    text[..end.unwrap_or(text.len())].to_string()
}

/// All bound variables.
pub fn bindings() -> BTreeSet<Place> {
    let mut found = BTreeSet::new();
    for (file, text) in wgsl() {
        for after in text.split("@binding(").skip(1) {
            let (_, after) = after.split_once("var").expect("a binding is a variable's");
            // Skips its address space, if it has one.
            let name = match after.strip_prefix('<') {
                Some(space) => space.split_once('>').expect("brackets are closed").1,
                None => after,
            };
            found.insert((file.clone(), name_at(name)));
        }
    }
    found
}

/// Declarations of all constants, as written.
pub fn constants() -> BTreeMap<Place, String> {
    let mut found = BTreeMap::new();
    for (file, text) in wgsl() {
        for after in format!("\n{text}").split("\nconst ").skip(1) {
            let (declaration, _) = after.split_once(';').expect("declarations end");
            let place = (file.clone(), name_at(after));
            found.insert(place, format!("const {declaration};"));
        }
    }
    found
}

/// Names of Rust constants, by the folder of their file. The folders of `reference` are those of `src`.
pub fn rust_constants() -> BTreeSet<Place> {
    let mut found = BTreeSet::new();
    let reference = files("lab/kit/src/reference", "rs");
    for (file, text) in files("src", "rs").into_iter().chain(reference) {
        for line in text.lines() {
            let visible = line.split_once("const ");
            if let Some((before, after)) = visible
                && (before.is_empty() || (before.starts_with("pub") && !before.contains("fn")))
            {
                found.insert((folder_of(&file), name_at(after)));
            }
        }
    }
    found
}

pub fn folder_of(file: &str) -> String {
    let parent = Path::new(file).parent().expect("it is in a folder");
    parent.display().to_string()
}
