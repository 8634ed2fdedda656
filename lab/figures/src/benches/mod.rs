//! Figures that each bench writes, and their tables and plots.

pub mod ambient_occlusion;
pub mod auto_exposure;
pub mod compat;
pub mod frame_times;
pub mod isa;
pub mod levels;
pub mod light_scaling;
pub mod many_meshes;
pub mod motion;
pub mod screen_space;
pub mod stutter;

use std::path::Path;

use crate::{json::read_json, plots::Plot, store::Store, table::Table, time::Device};

pub use ambient_occlusion::AmbientOcclusion;
pub use auto_exposure::AutoExposure;
pub use compat::Compat;
pub use frame_times::FrameTimes;
pub use isa::Isa;
pub use levels::Levels;
pub use light_scaling::LightScaling;
pub use many_meshes::ManyMeshes;
pub use motion::Motion;
pub use screen_space::ScreenSpace;
pub use stutter::Stutter;

/// The figures of one bench.
pub trait Figures {
    fn device(&self) -> Device;
    /// Tables that the bench prints.
    fn tables(&self) -> Vec<Table>;
    fn plots(&self) -> Vec<Plot>;
    /// Explanation of the tables' columns.
    fn legend(&self) -> String;

    /// Markdown that the bench prints.
    fn markdown(&self) -> String {
        let tables: Vec<String> = self.tables().iter().map(Table::markdown).collect();
        format!(
            "{}. {}\n\n{}",
            self.device(),
            self.legend(),
            tables.join("\n")
        )
    }
}

macro_rules! benches {
    ($($name:ident $kind:ident,)*) => {
        /// The figures of any bench.
        pub enum Bench {
            $($kind($kind),)*
        }

        impl Bench {
            /// Names of the benches, in the order in which they are shown.
            pub const NAMES: &[&str] = &[$(stringify!($name)),*];

            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$kind(_) => stringify!($name),)*
                }
            }

            /// Reads the file of the bench with this name.
            pub fn read(name: &str, path: &Path) -> Result<Self, String> {
                $(if name == stringify!($name) {
                    return Ok(Self::$kind(read_json(path)?));
                })*
                Err(format!("there is no bench {name}"))
            }

            pub fn figures(&self) -> &dyn Figures {
                match self {
                    $(Self::$kind(figures) => figures,)*
                }
            }

            /// Adds the measurements of another run of the same bench.
            pub fn join(&mut self, other: Self) {
                match (self, other) {
                    $((Self::$kind(all), Self::$kind(more)) => all.join(more),)*
                    _ => unreachable!("files of one name are of one bench"),
                }
            }
        }

        impl Store {
            $(
                /// The figures of this bench from a machine.
                #[track_caller]
                pub fn $name(&self, machine: &str) -> &$kind {
                    match self.bench(machine, stringify!($name)) {
                        Bench::$kind(figures) => figures,
                        _ => unreachable!("it has another name"),
                    }
                }
            )*
        }
    };
}

benches! {
    frame_times FrameTimes,
    levels Levels,
    ambient_occlusion AmbientOcclusion,
    screen_space ScreenSpace,
    motion Motion,
    auto_exposure AutoExposure,
    light_scaling LightScaling,
    many_meshes ManyMeshes,
    stutter Stutter,
    isa Isa,
    compat Compat,
}

/// The only one of the measurements that are `found`: a table of the docs relies on it.
#[track_caller]
fn only<T>(found: impl IntoIterator<Item = T>, of: impl core::fmt::Debug) -> T {
    let mut found = found.into_iter();
    match (found.next(), found.next()) {
        (Some(measurement), None) => measurement,
        (None, _) => panic!("nothing was measured of {of:?}"),
        (Some(_), Some(_)) => panic!("more than one was measured of {of:?}"),
    }
}

/// Distinct values, in order of appearance.
fn distinct<T: PartialEq>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut all = Vec::new();
    for value in values {
        if !all.contains(&value) {
            all.push(value);
        }
    }
    all
}
