//! Passes, pipelines, textures and GPU times are found in a capture by the folder that makes them.

use std::{
    fs,
    path::{Path, PathBuf},
};

const PREFIX: &str = "\"lean_deferred/";

/// All files below `folder` whose names end in `.rs`.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("it is a folder");
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.expect("it can be read").path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

#[test]
fn labels_are_the_paths_of_their_folders() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut labels = 0;
    for path in files(&src) {
        let file = path.strip_prefix(&src).expect("it is below src");
        let folder = file.parent().expect("it is in a folder").to_string_lossy();
        let text = fs::read_to_string(&path).expect("it is text");
        for after in text.split(PREFIX).skip(1) {
            let label = after.split('"').next().unwrap_or_default();
            // `gpu/pipeline_watch.rs` looks for all of them.
            if label.is_empty() {
                continue;
            }
            labels += 1;
            let in_folder = label.strip_prefix(&*folder);
            assert!(
                in_folder.is_some_and(|rest| rest.is_empty() || rest.starts_with('/')),
                "{}: lean_deferred/{label}",
                file.display()
            );
        }
    }
    assert!(labels > 50, "{labels} labels were found");
}
