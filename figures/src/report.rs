//! Runs all benches, one after the other, and estimates how long that takes.

mod plan;
mod progress;

use std::{
    collections::HashMap,
    fs::{self, File},
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

pub use plan::Mode;
use plan::Step;
use progress::Progress;
use serde_json::Value;

use crate::{json::write_json, page::page, store::Run};

/// The benches to run, and the folders of their results.
pub struct Report {
    pub mode: Mode,
    pub gltf: Option<String>,
    /// Only benches with these words in their names; all if it is empty.
    pub only: Vec<String>,
    pub folder: PathBuf,
}

impl Report {
    /// Runs the benches and writes the page. Returns its path, and the benches that failed.
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
        let programs = self.build(&steps)?;
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
            let program = programs.get(step.bench);
            let program = program.ok_or(format!("cargo has not built {}", step.bench))?;
            let ran = run_bench(step, program, [&figures, &pictures, &logs], &mut progress)?;
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

    /// Builds the benches before any of them is timed, with cargo's progress. Returns the programs by the names of
    /// their benches.
    fn build(&self, steps: &[Step]) -> Result<HashMap<String, PathBuf>, String> {
        let mut cargo = Command::new(std::env::var("CARGO").unwrap_or("cargo".into()));
        cargo.current_dir(root());
        cargo.args(["bench", "--package", "bevy_lean_deferred", "--no-run"]);
        cargo.args(self.mode.profile());
        cargo.arg("--message-format=json-render-diagnostics");
        for step in steps {
            cargo.args(["--bench", step.bench]);
        }
        let output = cargo.stderr(Stdio::inherit()).output();
        let output = output.map_err(|error| format!("cargo: {error}"))?;
        if !output.status.success() {
            return Err("the benches do not build".into());
        }
        let messages = String::from_utf8_lossy(&output.stdout);
        let messages = messages
            .lines()
            .filter_map(|line| serde_json::from_str(line).ok());
        let programs = messages.filter_map(|message: Value| {
            let name = message.pointer("/target/name")?.as_str()?.to_owned();
            Some((name, message.get("executable")?.as_str()?.into()))
        });
        Ok(programs.collect())
    }
}

/// Runs a bench with its output in a log. Returns true if it succeeded.
fn run_bench(
    step: &Step,
    program: &Path,
    [figures, pictures, logs]: [&Path; 3],
    progress: &mut Progress,
) -> Result<bool, String> {
    let log = |suffix: &str| {
        let path = logs.join(format!("{}.{suffix}", step.bench));
        File::create(&path).map_err(|error| format!("{}: {error}", path.display()))
    };
    let mut bench = Command::new(program);
    bench
        .args(&step.args)
        .arg("--json")
        .arg(figures.join(format!("{}.json", step.bench)));
    if step.has_pictures {
        bench.arg("--pictures").arg(pictures);
    }
    // The environment that cargo gives it: assets are loaded from there.
    bench.current_dir(root()).env("CARGO_MANIFEST_DIR", root());
    let mut child = bench
        .stdin(Stdio::null())
        .stdout(log("md")?)
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| format!("{}: {error}", program.display()))?;
    let mut log = log("log")?;
    let lines = BufReader::new(child.stderr.take().expect("it is piped")).split(b'\n');
    for line in lines.map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line);
        let _ = writeln!(log, "{line}");
        progress.line(step, &line);
    }
    let status = child.wait();
    let status = status.map_err(|error| format!("{}: {error}", step.bench))?;
    Ok(status.success())
}

/// Root of the repository.
pub fn root() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().unwrap_or(package).into()
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// Output of a command; empty if it fails.
fn output(command: &str, args: &[&str]) -> String {
    let output = Command::new(command)
        .args(args)
        .current_dir(root())
        .stderr(Stdio::null())
        .output();
    let output = output.map(|output| output.stdout).unwrap_or_default();
    String::from_utf8_lossy(&output).trim().into()
}
