//! The headless viewer reports errors of a file by a message and its exit code.

use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

/// Path of the example, which cargo builds beside the tests.
fn viewer() -> PathBuf {
    let test = std::env::current_exe().expect("a test knows its own path");
    let folder = test.ancestors().nth(2).expect("tests lie in target/*/deps");
    let viewer = folder
        .join("examples/viewer")
        .with_extension(std::env::consts::EXE_EXTENSION);
    assert!(
        viewer.exists(),
        "{viewer:?} is not built: `cargo test` does that, `cargo test --test` needs `cargo build --example viewer` before"
    );
    viewer
}

/// A new empty folder for files of the test `name`.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("an old folder can be removed");
    }
    std::fs::create_dir_all(&folder).expect("a folder can be made");
    folder
}

/// Runs the viewer in `folder` on `file`.
fn show(folder: &Path, file: &str, picture: &str) -> Output {
    Command::new(viewer())
        .args([
            file,
            "--headless",
            picture,
            "--size",
            "32x32",
            "--frames",
            "1",
        ])
        .current_dir(folder)
        .output()
        .expect("the viewer can be run")
}

/// Asserts that the viewer fails with one line that names `file` and says `why`, and writes no picture.
fn assert_fails(folder: &Path, file: &str, why: &str) {
    let output = show(folder, file, "out.png");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    let line = text
        .lines()
        .find(|line| line.starts_with(&format!("error: {file}: ")));
    assert!(line.is_some_and(|line| line.contains(why)), "{text}");
    assert!(!folder.join("out.png").exists());
}

/// A glTF triangle with the first of `materials`.
pub(crate) fn gltf(materials: &str) -> String {
    format!(
        r#"{{
    "asset": {{ "version": "2.0" }},
    "scenes": [{{ "nodes": [0] }}],
    "nodes": [{{ "mesh": 0 }}],
    "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }}, "material": 0 }}] }}],
    "materials": {materials},
    "accessors": [{{
        "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]
    }}],
    "bufferViews": [{{ "buffer": 0, "byteLength": 36 }}],
    "buffers": [{{
        "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA",
        "byteLength": 36
    }}]
}}"#
    )
}

pub(crate) fn write(folder: &Path, file: &str, content: &str) {
    std::fs::write(folder.join(file), content).expect("a file can be written");
}

#[test]
fn missing_file() {
    assert_fails(&folder("missing_file"), "nowhere.glb", "os error 2");
}

#[test]
fn file_of_another_kind() {
    let folder = folder("file_of_another_kind");
    write(&folder, "model.obj", "");
    assert_fails(&folder, "model.obj", "not a .gltf or .glb file");
}

#[test]
fn broken_file() {
    let folder = folder("broken_file");
    write(&folder, "broken.glb", "glTF, but then something else");
    assert_fails(&folder, "broken.glb", "invalid glTF file");
}

#[test]
fn file_without_a_mesh() {
    let folder = folder("file_without_a_mesh");
    write(
        &folder,
        "empty.gltf",
        r#"{ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "nodes": [{}] }"#,
    );
    assert_fails(&folder, "empty.gltf", "holds no mesh");
}

#[test]
fn missing_texture() {
    let folder = folder("missing_texture");
    let text = gltf(
        r#"[{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
    "textures": [{ "source": 0 }],
    "images": [{ "uri": "nowhere.png" }]"#,
    );
    write(&folder, "model.gltf", &text);
    assert_fails(&folder, "model.gltf", "nowhere.png");
}

#[test]
fn good_file() {
    let folder = folder("good_file");
    write(&folder, "model.gltf", &gltf("[{}]"));
    let output = show(&folder, "model.gltf", "out.png");
    assert!(output.status.success(), "{output:?}");
    assert!(folder.join("out.png").exists());
}

#[test]
fn picture_that_cannot_be_written() {
    let folder = folder("picture_that_cannot_be_written");
    write(&folder, "model.gltf", &gltf("[{}]"));
    let output = show(&folder, "model.gltf", "nowhere/out.png");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(
        text.contains("error: cannot write nowhere/out.png"),
        "{text}"
    );
}
