//! Labels of passes, pipelines, textures and GPU times name the source folder that creates them.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

/// All `.rs` files below `folder`.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("it is a folder") {
        let path = entry.expect("it can be read").path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

/// Labels in the files below `folder`, with the folder of each file relative to it.
fn labels(folder: &str) -> BTreeSet<(PathBuf, String)> {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut found = BTreeSet::new();
    for path in files(&top) {
        let file = path.strip_prefix(&top).expect("it is below");
        let text = fs::read_to_string(&path).expect("it is text");
        for after in text.split("\"lean_deferred/").skip(1) {
            let label = after.split('"').next().unwrap_or_default();
            // Some code matches all labels by this prefix.
            if !label.is_empty() {
                found.insert((file.parent().expect("it is a file").into(), label.into()));
            }
        }
    }
    found
}

#[test]
fn labels_are_the_paths_of_their_folders() {
    let labels = labels("src");
    for (folder, label) in &labels {
        // Folders named `bevy` belong to the stage above them.
        let parts = folder.iter().filter(|part| *part != "bevy");
        let folder: PathBuf = parts.collect();
        assert!(
            Path::new(label).starts_with(&folder),
            "lean_deferred/{label} in {}",
            folder.display()
        );
    }
    assert!(labels.len() > 50, "{} labels were found", labels.len());
}

/// Every GPU time that is shown has a label in `src`: an unknown label would silently show a dash.
#[test]
fn times_that_are_shown_are_taken() {
    let taken: BTreeSet<String> = labels("src").into_iter().map(|(_, label)| label).collect();
    for shown in ["benches", "examples", "lab/kit"].map(labels) {
        for (folder, label) in shown {
            // A folder stands for all labels in it.
            let is_folder = label.ends_with('/');
            assert!(
                taken.contains(&label)
                    || is_folder && taken.iter().any(|other| other.starts_with(&label)),
                "{}: nothing has the label lean_deferred/{label}",
                folder.display()
            );
        }
    }
}
