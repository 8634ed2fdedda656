//! Runs the benches, one after the other, and estimates how long that takes.

mod plan;
mod programs;
mod progress;

use std::{
    fs::{self, File},
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

pub use plan::Mode;
use plan::Step;
pub use programs::Programs;
use progress::Progress;

use crate::{
    json::write_json,
    page::page,
    store::{Bundle, Run},
};

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
        // Before any of them is timed.
        let targets: Vec<_> = steps.iter().map(|step| ("bench", step.bench)).collect();
        let command = [&["bench", "--no-run"], self.mode.profile()].concat();
        let programs = Programs::build(&command, &targets)?;
        let run = Run {
            date: output("date", &["-u", "+%Y-%m-%d"]),
            commit: output("git", &["describe", "--always", "--dirty"]),
            note: self.mode.note().into(),
            bandwidth: None,
        };
        write_json(&text(&figures.join(Run::FILE)), &run);
        let mut progress = Progress::new(&steps);
        let deadline = self.mode.limit().map(|limit| Instant::now() + limit);
        let mut failed = Vec::new();
        for step in &steps {
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                eprintln!("{}: left out, the time is up", step.bench);
                continue;
            }
            progress.begin(step);
            let pictures = pictures.join(step.bench);
            fs::create_dir_all(&pictures)
                .map_err(|error| format!("{}: {error}", pictures.display()))?;
            let program = programs.path(step.bench)?;
            let folders = [&*figures, &pictures, &logs];
            let ran = run_bench(step, program, folders, &mut progress, deadline)?;
            progress.end(step);
            if !ran {
                failed.push(step.bench);
            }
        }
        progress.finish();
        let bundle = self.folder.join("figures.json");
        write_json(&text(&bundle), &Bundle::of(&figures)?);
        let path = self.folder.join("index.html");
        let html = page(&figures, Some(&pictures))?;
        fs::write(&path, html).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok((path, failed))
    }
}

/// Runs a bench with its output in a log, until the deadline. Returns true if it succeeded.
fn run_bench(
    step: &Step,
    program: &Path,
    [figures, pictures, logs]: [&Path; 3],
    progress: &mut Progress,
    deadline: Option<Instant>,
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
    let ended = std::thread::scope(|scope| {
        scope.spawn(|| {
            for line in lines.map_while(Result::ok) {
                let line = String::from_utf8_lossy(&line);
                let _ = writeln!(log, "{line}");
                progress.line(step, &line);
            }
        });
        wait(&mut child, deadline)
    });
    let ended = ended.map_err(|error| format!("{}: {error}", step.bench))?;
    if ended.is_none() {
        eprintln!("{}: cut short, the time is up", step.bench);
    }
    Ok(ended.unwrap_or(true))
}

/// Waits for a program, and ends it at the deadline: benches write their figures after each contender. Returns true if it succeeded,
/// `None` if the deadline ended it.
fn wait(child: &mut Child, deadline: Option<Instant>) -> std::io::Result<Option<bool>> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status.success()));
        }
        if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Root of the repository.
pub fn root() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().nth(2).unwrap_or(package).into()
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
