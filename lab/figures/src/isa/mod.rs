//! Compiles the shaders of the benches for GPUs that are not there, by Mesa's compilers: `benches/isa/`.
//!
//! Each run of [`plan`] is an app on a software driver. A layer records its pipelines, and a replayer compiles them for each family.

mod plan;
mod statistics;

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use crate::{
    arguments::arguments,
    benches::{Isa, isa::Shader},
    json::{read_json, read_text, write_json},
    report::{Programs, root},
};
use plan::{CASES, Case};
use statistics::Line;

pub use plan::FAMILIES;

/// The record, in the repository.
const RECORD: &str = "docs/figures/mesa25/isa.json";

/// A run of all apps.
pub struct Recording {
    /// Pipelines, statistics and logs.
    pub folder: PathBuf,
    /// Folder of programs that were built before; otherwise cargo builds them.
    pub programs: Option<PathBuf>,
    /// Only runs with one of these words in their names; all if it is empty.
    pub only: Vec<String>,
    /// Compiles the pipelines that an earlier run has left in the folder, and runs no app.
    pub reuse: bool,
}

impl Recording {
    /// Records and compiles. Returns what the compilers tell.
    pub fn make(&self) -> Result<Isa, String> {
        let wanted = |case: &&Case| {
            self.only.is_empty() || self.only.iter().any(|word| case.name.contains(word))
        };
        let cases: Vec<&Case> = CASES.iter().filter(wanted).collect();
        let programs = match (&self.programs, self.reuse) {
            (_, true) => None,
            (Some(folder), _) => Some(Programs::in_folder(folder)?),
            // As the tests are built.
            (None, _) => {
                let targets = cases.iter().map(|case| (case.kind(), case.program));
                Some(Programs::build(&["build"], &targets.collect::<Vec<_>>())?)
            }
        };
        let mut isa = Isa {
            compiler: compiler()?,
            shaders: Vec::new(),
        };
        for (number, case) in cases.iter().enumerate() {
            eprintln!("[{}/{}] {}", number + 1, cases.len(), case.name);
            let programs = programs.as_ref();
            let program = programs.map(|programs| programs.path(case.program));
            self.run(case, program.transpose()?)?;
            for (family, _) in FAMILIES {
                isa.shaders.extend(self.shaders(case, family)?);
            }
        }
        Ok(isa)
    }

    /// Runs the program of a case, and compiles what it leaves in the case's folder.
    fn run(&self, case: &Case, program: Option<&Path>) -> Result<(), String> {
        let folder = self.folder.join(case.name);
        if program.is_some() {
            let _ = fs::remove_dir_all(&folder);
        }
        fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let log_path = folder.join("log");
        let says = |error: std::io::Error| format!("{}: {error}", log_path.display());
        let log = File::create(&log_path).map_err(says)?;
        let mut isa = Command::new("sh");
        isa.arg(root().join("benches/isa/isa.sh"))
            // With binding arrays, as the drivers of these GPUs.
            .args(["--driver", "mesa25"])
            .args(["--families", &family_names(), "--only", &case.labels()])
            .arg("--out")
            .arg(&folder);
        if let Some(program) = program {
            isa.arg("--").arg(program).args(arguments(case.args));
        }
        let status = isa
            .env("PARITY_SCENE", case.parity_scene)
            // The environment that cargo gives it: assets are loaded from there.
            .env("CARGO_MANIFEST_DIR", root())
            .current_dir(&folder)
            .stdin(Stdio::null())
            .stdout(log.try_clone().map_err(says)?)
            .stderr(log)
            .status()
            .map_err(|error| format!("sh: {error}"))?;
        match status.success() {
            true => Ok(()),
            false => Err(format!("{}: see {}", case.name, log_path.display())),
        }
    }

    /// The shaders of a run that are wanted.
    fn shaders(&self, case: &Case, family: &str) -> Result<Vec<Shader>, String> {
        let path = self
            .folder
            .join(case.name)
            .join(format!("{family}.part.jsonl"));
        let lines = Line::all(&read_text(&path)?)?;
        let found = |wanted| {
            statistics::pick(&lines, wanted)
                .map(|line| line.shader(family, wanted))
                .map_err(|error| format!("{}: {error}", path.display()))
        };
        case.shaders.iter().map(found).collect()
    }
}

fn family_names() -> String {
    FAMILIES.map(|(family, _)| family).join(" ")
}

/// Fetches what is missing, and tells the version of the compilers.
fn compiler() -> Result<String, String> {
    let output = Command::new("sh")
        .arg(root().join("benches/isa/isa.sh"))
        .args(["--families", &family_names(), "--fetch"])
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("sh: {error}"))?;
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).trim().into()),
        false => Err("the compilers cannot be fetched".into()),
    }
}

/// Writes the record.
pub fn write(isa: &Isa) {
    let path = root().join(RECORD);
    if let Some(folder) = path.parent() {
        let _ = fs::create_dir_all(folder);
    }
    write_json(&path.to_string_lossy(), isa);
}

/// Compares with the record.
pub fn check(isa: &Isa) -> Result<(), String> {
    let mut recorded: Isa = read_json(&root().join(RECORD))?;
    // A part of the runs is compared with that part of the record.
    let names: Vec<&str> = CASES
        .iter()
        .filter(|case| {
            let mut shaders = case.shaders.iter();
            shaders.any(|wanted| isa.shader(FAMILIES[0].0, wanted.name).is_some())
        })
        .flat_map(|case| case.shaders)
        .map(|wanted| wanted.name)
        .collect();
    (recorded.shaders).retain(|shader| names.contains(&shader.name.as_str()));
    let worse = isa.worse_than(&recorded);
    if worse.is_empty() {
        println!("{} shaders are as recorded or better", isa.shaders.len());
        return Ok(());
    }
    let mut text = worse.join("\n");
    if recorded.compiler != isa.compiler {
        text.push_str(&format!(
            "\nrecorded with {}, compiled with {}",
            recorded.compiler, isa.compiler
        ));
    }
    Err(text)
}
