//! Runs all benches, one after the other, and says how long that takes.

mod plan;
mod progress;

use std::{
    fs::{self, File},
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

pub use plan::Mode;
use plan::Step;
use progress::Progress;

use crate::{json::write_json, page::page, store::Run};

/// What is run, and where what it makes goes.
pub struct Report {
    pub mode: Mode,
    pub gltf: Option<String>,
    /// Only benches with these words in their names; all without any.
    pub only: Vec<String>,
    pub folder: PathBuf,
}

impl Report {
    /// Runs the benches and writes the page; its path, and which benches failed.
    pub fn make(&self) -> Result<(PathBuf, Vec<&'static str>), String> {
        let steps: Vec<Step> = plan::steps(self.mode, self.gltf.as_deref())
            .into_iter()
            .filter(|step| {
                self.only.is_empty() || self.only.iter().any(|word| step.bench.contains(word))
            })
            .collect();
        let [figures, pictures, logs] =
            ["figures", "pictures", "logs"].map(|name| self.folder.join(name));
        for folder in [&figures, &pictures, &logs] {
            fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        }
        self.build(&steps)?;
        let run = Run {
            date: output("date", &["-u", "+%Y-%m-%d"]),
            commit: output("git", &["describe", "--always", "--dirty"]),
            note: self.mode.note().into(),
            bandwidth: None,
        };
        write_json(&text(&figures.join(Run::FILE)), &run);
        let mut progress = Progress::new(&steps);
        let mut failed = Vec::new();
        for step in &steps {
            progress.begin(step);
            let pictures = pictures.join(step.bench);
            fs::create_dir_all(&pictures)
                .map_err(|error| format!("{}: {error}", pictures.display()))?;
            let ran = self.run(step, &figures, &pictures, &logs, &mut progress)?;
            progress.end(step);
            if !ran {
                failed.push(step.bench);
            }
        }
        progress.finish();
        let path = self.folder.join("index.html");
        let html = page(&figures, Some(&pictures))?;
        fs::write(&path, html).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok((path, failed))
    }

    /// Before any of them is timed; cargo shows how far it is.
    fn build(&self, steps: &[Step]) -> Result<(), String> {
        let mut cargo = self.cargo();
        cargo.arg("--no-run");
        for step in steps {
            cargo.args(["--bench", step.bench]);
        }
        let status = cargo.status().map_err(|error| format!("cargo: {error}"))?;
        status
            .success()
            .then_some(())
            .ok_or("the benches do not build".into())
    }

    fn cargo(&self) -> Command {
        let mut cargo = Command::new(std::env::var("CARGO").unwrap_or("cargo".into()));
        cargo.args(["bench", "--package", "bevy_lean_deferred"]);
        cargo.args(self.mode.profile());
        cargo
    }

    /// Whether the bench ended well. What it says goes into its log.
    fn run(
        &self,
        step: &Step,
        figures: &Path,
        pictures: &Path,
        logs: &Path,
        progress: &mut Progress,
    ) -> Result<bool, String> {
        let log = |suffix: &str| {
            let path = logs.join(format!("{}.{suffix}", step.bench));
            File::create(&path).map_err(|error| format!("{}: {error}", path.display()))
        };
        let json = text(&figures.join(format!("{}.json", step.bench)));
        let mut cargo = self.cargo();
        cargo.args(["--quiet", "--bench", step.bench, "--"]);
        cargo.args(&step.args).args(["--json", &absolute(&json)?]);
        if step.has_pictures {
            cargo.args(["--pictures", &absolute(&text(pictures))?]);
        }
        let mut child = cargo
            .stdin(Stdio::null())
            .stdout(log("md")?)
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| format!("cargo: {error}"))?;
        let mut log = log("log")?;
        let lines = BufReader::new(child.stderr.take().expect("it is piped")).split(b'\n');
        for line in lines.map_while(Result::ok) {
            let line = String::from_utf8_lossy(&line);
            let _ = writeln!(log, "{line}");
            progress.line(step, &line);
        }
        let status = child
            .wait()
            .map_err(|error| format!("{}: {error}", step.bench))?;
        Ok(status.success())
    }
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// Cargo runs benches in their package's folder.
fn absolute(path: &str) -> Result<String, String> {
    let path = std::path::absolute(path).map_err(|error| format!("{path}: {error}"))?;
    Ok(text(&path))
}

/// What a command says, or nothing where it cannot.
fn output(command: &str, args: &[&str]) -> String {
    let output = Command::new(command)
        .args(args)
        .stderr(Stdio::null())
        .output();
    let output = output.map(|output| output.stdout).unwrap_or_default();
    String::from_utf8_lossy(&output).trim().into()
}
