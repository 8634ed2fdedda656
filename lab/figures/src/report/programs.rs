//! Programs of the workspace.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use serde_json::Value;

use super::root;

/// Benches, examples and test binaries by their names.
pub struct Programs(HashMap<String, PathBuf>);

impl Programs {
    /// Has cargo build `targets`, each a kind (`bench`, `example`, `test`) and a name, with cargo's progress.
    pub fn build(command: &[&str], targets: &[(&str, &str)]) -> Result<Self, String> {
        let mut cargo = Command::new(std::env::var("CARGO").unwrap_or("cargo".into()));
        cargo.current_dir(root()).args(command);
        cargo.args(["--package", "bevy_lean_deferred"]);
        cargo.arg("--message-format=json-render-diagnostics");
        for (kind, name) in targets {
            cargo.args([&format!("--{kind}"), *name]);
        }
        let output = cargo.stderr(Stdio::inherit()).output();
        let output = output.map_err(|error| format!("cargo: {error}"))?;
        if !output.status.success() {
            return Err("the programs do not build".into());
        }
        let messages = String::from_utf8_lossy(&output.stdout);
        let messages = messages
            .lines()
            .filter_map(|line| serde_json::from_str(line).ok());
        let programs = messages.filter_map(|message: Value| {
            let name = message.pointer("/target/name")?.as_str()?.to_owned();
            Some((name, message.get("executable")?.as_str()?.into()))
        });
        Ok(Self(programs.collect()))
    }

    /// Programs that were built before, in a folder.
    pub fn in_folder(folder: &Path) -> Result<Self, String> {
        let says = |error: std::io::Error| format!("{}: {error}", folder.display());
        let mut programs = HashMap::new();
        for entry in std::fs::read_dir(folder).map_err(says)? {
            let entry = entry.map_err(says)?;
            let path = std::path::absolute(entry.path()).map_err(says)?;
            programs.insert(entry.file_name().to_string_lossy().into_owned(), path);
        }
        Ok(Self(programs))
    }

    pub fn path(&self, name: &str) -> Result<&Path, String> {
        let path = self.0.get(name).map(PathBuf::as_path);
        path.ok_or(format!("there is no program {name}"))
    }
}
