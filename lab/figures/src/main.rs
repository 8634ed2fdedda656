//! Tables, plots and pages of figures. `figures --help` lists the commands.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use argh::FromArgs;
use bevy_lean_deferred_figures::{
    benches::Figures,
    docs::{Docs, FOLDER},
    isa::{self, Recording},
    json::read_json,
    page,
    report::{Mode, Report, root},
    store::{Bundle, benches_in},
    wipe,
};

/// Figures of the benches, as tables, plots, pages and in the docs.
#[derive(FromArgs)]
struct Args {
    #[argh(subcommand)]
    command: Command,
}

#[derive(FromArgs)]
#[argh(subcommand)]
enum Command {
    Run(RunArgs),
    Page(PageArgs),
    Tables(TablesArgs),
    Add(AddArgs),
    Docs(DocsArgs),
    Isa(IsaArgs),
    Wipe(WipeArgs),
}

/// Runs all benches, and makes a page of their figures.
#[derive(FromArgs)]
#[argh(subcommand, name = "run")]
struct RunArgs {
    /// small scenes and few frames, for software renderers (the default)
    #[argh(switch)]
    quick: bool,

    /// five minutes on a GPU, once built; the figures are in one file, figures.json
    #[argh(switch)]
    gpu: bool,

    /// the scenes of the figures in the docs; needs a GPU
    #[argh(switch)]
    full: bool,

    /// a glTF file to measure frames of, too
    #[argh(option)]
    gltf: Option<String>,

    /// only benches with one of these words in their names, comma-separated
    #[argh(option, default = "String::new()")]
    only: String,

    /// output folder, default report
    #[argh(option, default = "String::from(\"report\")")]
    out: String,
}

/// Makes a page of figures.
#[derive(FromArgs)]
#[argh(subcommand, name = "page")]
struct PageArgs {
    /// the folder with the files of the benches
    #[argh(option)]
    from: PathBuf,

    /// the page, default report/index.html
    #[argh(option, default = "PathBuf::from(\"report/index.html\")")]
    out: PathBuf,

    /// a folder with a folder of pictures for each bench
    #[argh(option)]
    pictures: Option<PathBuf>,
}

/// Prints the tables of figures, as the benches print them.
#[derive(FromArgs)]
#[argh(subcommand, name = "tables")]
struct TablesArgs {
    /// the folder with the files of the benches
    #[argh(option)]
    from: PathBuf,
}

/// Adds the figures of another machine to docs/figures.
#[derive(FromArgs)]
#[argh(subcommand, name = "add")]
struct AddArgs {
    /// figures.json, as `run` wrote it
    #[argh(positional)]
    file: PathBuf,

    /// name of the machine: the folder in docs/figures
    #[argh(positional)]
    machine: String,
}

/// Updates README and docs from docs/figures.
#[derive(FromArgs)]
#[argh(subcommand, name = "docs")]
struct DocsArgs {
    /// change nothing, and print the differences
    #[argh(switch)]
    check: bool,
}

/// Compiles the benches' shaders for GPUs that are not there, by Mesa's compilers (`benches/isa/`), and updates
/// docs/figures/mesa25/isa.json.
#[derive(FromArgs)]
#[argh(subcommand, name = "isa")]
struct IsaArgs {
    /// change nothing, and fail if a shader has fewer waves, more spills or more scratch memory than recorded
    #[argh(switch)]
    check: bool,

    /// folder of programs that were built before, with the names of the benches, `showcase` and `pictures`
    #[argh(option)]
    programs: Option<PathBuf>,

    /// run no app, and compile what an earlier run has left in the output folder
    #[argh(switch)]
    reuse: bool,

    /// only runs with one of these words in their names, comma-separated; prints the tables and updates nothing
    #[argh(option, default = "String::new()")]
    only: String,

    /// folder of pipelines, statistics and logs, default report/isa
    #[argh(option, default = "PathBuf::from(\"report/isa\")")]
    out: PathBuf,
}

/// Writes a JPEG file of several pictures, from left to right: a vertical strip of each, or all of each.
#[derive(FromArgs)]
#[argh(subcommand, name = "wipe")]
struct WipeArgs {
    /// the JPEG file
    #[argh(positional)]
    out: PathBuf,

    /// PNG files of one size
    #[argh(positional)]
    pictures: Vec<PathBuf>,

    /// whole pictures side by side, in place of strips
    #[argh(switch)]
    beside: bool,

    /// part of each picture: left, top, width and height in percent, such as 50,20,25,25
    #[argh(option, from_str_fn(percents))]
    crop: Option<[u32; 4]>,

    /// width in pixels to which the file's picture is shrunk
    #[argh(option)]
    width: Option<u32>,

    /// most kilobytes of the file, whose quality is lowered until it fits
    #[argh(option)]
    kilobytes: Option<usize>,
}

fn percents(text: &str) -> Result<[u32; 4], String> {
    let numbers = text
        .split(',')
        .map(str::parse)
        .collect::<Result<Vec<_>, _>>();
    let numbers = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or_else(|| "expected four whole numbers".into())
}

fn main() -> ExitCode {
    let args: Args = argh::from_env();
    let done = match args.command {
        Command::Run(args) => run(args),
        Command::Page(args) => make_page(&args),
        Command::Tables(args) => tables(&args.from),
        Command::Add(args) => add(&args),
        Command::Docs(args) => docs(args.check),
        Command::Isa(args) => compile(args),
        Command::Wipe(args) => join(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: RunArgs) -> Result<(), String> {
    let mode = match (args.quick, args.gpu, args.full) {
        (_, false, false) => Mode::Quick,
        (false, true, false) => Mode::Gpu,
        (false, false, true) => Mode::Full,
        _ => return Err("--quick, --gpu or --full: one of them".into()),
    };
    let absolute =
        |path: &str| std::path::absolute(path).map_err(|error| format!("{path}: {error}"));
    let gltf = args.gltf.as_deref().map(absolute).transpose()?;
    let words = args.only.split(',').filter(|word| !word.is_empty());
    let report = Report {
        mode,
        gltf: gltf.map(|path| path.to_string_lossy().into_owned()),
        only: words.map(Into::into).collect(),
        folder: absolute(&args.out)?,
    };
    let (path, failed) = report.make()?;
    println!("{}", path.display());
    if mode == Mode::Gpu {
        println!("{}", report.folder.join("figures.json").display());
    }
    if failed.is_empty() {
        return Ok(());
    }
    let logs = report.folder.join("logs");
    Err(format!(
        "failed: {} (see {})",
        failed.join(", "),
        logs.display()
    ))
}

fn make_page(args: &PageArgs) -> Result<(), String> {
    let html = page::page(&args.from, args.pictures.as_deref())?;
    let says = |error: std::io::Error| format!("{}: {error}", args.out.display());
    if let Some(folder) = args.out.parent() {
        std::fs::create_dir_all(folder).map_err(says)?;
    }
    std::fs::write(&args.out, html).map_err(says)?;
    println!("{}", args.out.display());
    Ok(())
}

fn tables(folder: &Path) -> Result<(), String> {
    for bench in benches_in(folder)? {
        println!("## {}\n\n{}", bench.name(), bench.figures().markdown());
    }
    Ok(())
}

fn add(args: &AddArgs) -> Result<(), String> {
    let bundle: Bundle = read_json(&args.file)?;
    bundle.unpack(&root().join(FOLDER).join(&args.machine))
}

fn docs(check: bool) -> Result<(), String> {
    let docs = Docs::new(&root())?;
    let differences = docs.differences();
    if !check {
        docs.write()?;
    }
    let mut wrong = docs.wrong;
    if check {
        wrong.extend(differences);
    } else {
        println!("{} lines and plots changed", differences.len());
    }
    match wrong.is_empty() {
        true => Ok(()),
        false => Err(format!(
            "{}\n\n{} things are wrong",
            wrong.join("\n"),
            wrong.len()
        )),
    }
}

fn join(args: &WipeArgs) -> Result<(), String> {
    let layout = wipe::Layout {
        beside: args.beside,
        crop: args.crop,
        width: args.width,
        kilobytes: args.kilobytes,
    };
    wipe::write(&args.pictures, &args.out, layout)
}

fn compile(args: IsaArgs) -> Result<(), String> {
    let folder = std::path::absolute(&args.out);
    let words = args.only.split(',').filter(|word| !word.is_empty());
    let recording = Recording {
        folder: folder.map_err(|error| format!("{}: {error}", args.out.display()))?,
        programs: args.programs,
        only: words.map(Into::into).collect(),
        reuse: args.reuse,
    };
    let shaders = recording.make()?;
    if args.check {
        return isa::check(&shaders);
    }
    println!("{}", shaders.markdown());
    if recording.only.is_empty() {
        isa::write(&shaders);
    }
    Ok(())
}
