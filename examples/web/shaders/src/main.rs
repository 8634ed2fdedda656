//! Writes every shader of the crate as a browser gets it: composed under all definitions that `tests/shaders` tries,
//! validated by naga with no more than WebGPU's capabilities, and written as the WGSL that `wgpu` hands to the browser.
//!
//! `bevy_lean_deferred_web_shaders OUT FOLDER…`: the folders hold Bevy's crates. `../shaders.sh` passes them.

extern crate self as kit;

#[path = "../../../../tests/shaders/permutations/covering.rs"]
mod covering;
#[path = "../../../../tests/shaders/permutations/factors.rs"]
mod factors;
#[path = "../../../../src/lighting/implied.rs"]
mod implied;
mod modules;
#[path = "../../../../lab/kit/src/random.rs"]
pub mod random;
mod shaders;

use std::{collections::HashMap, fs, path::Path, process::ExitCode};

use modules::Modules;
use naga_oil::compose::ShaderDefValue;

pub type Definitions = HashMap<String, ShaderDefValue>;

/// Root of the shaders' paths.
const SOURCES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../src");

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let out = arguments.next().expect("the folder to write into is named");
    let bevy: Vec<String> = arguments.collect();
    fs::create_dir_all(&out).expect("the folder can be made");

    let mut failed = 0;
    for (path, permutations) in shaders::all() {
        let mut modules = Modules::new(&bevy);
        let mut written: HashMap<String, String> = HashMap::new();
        let count = permutations.len();
        for definitions in permutations {
            let names = shaders::describe(&definitions);
            match modules.as_browsers_get_it(path, definitions) {
                // Many definitions compile to the same source.
                Ok(source) => {
                    written.entry(source).or_insert(names);
                }
                Err(error) => {
                    failed += 1;
                    eprintln!("{path} with {names}:\n{error}");
                }
            }
        }
        println!("{path}: {count} permutations, {} different", written.len());
        for (number, (source, names)) in written.iter().enumerate() {
            let name = path.replace('/', "-").replace(".wgsl", "");
            let file = Path::new(&out).join(format!("{name}-{number}.wgsl"));
            fs::write(file, format!("// {path}: {names}\n{source}")).expect("it can be written");
        }
    }
    println!("{failed} failed");
    ExitCode::from(u8::from(failed > 0))
}
