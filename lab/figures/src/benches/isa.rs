//! Registers, occupancy and estimated cycles of shaders, as Mesa's compilers make them for GPUs that are not there.

use serde::{Deserialize, Serialize};

use super::{Figures, distinct};
use crate::{
    isa::FAMILIES,
    numbers::{beside, fixed, thousands},
    plots::{Plot, bars::Bars},
    table::Table,
    time::Device,
};

/// A shader, compiled for a GPU.
#[derive(Serialize, Deserialize, Clone, Debug, Default, PartialEq)]
#[serde(default)]
pub struct Shader {
    /// The GPU, as Mesa calls its family.
    pub family: String,
    pub name: String,
    /// Name of Bevy's counterpart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beside: Option<String>,
    /// Share of an invocation's estimated cycles that one pixel takes, if it is not one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_pixel: Option<f64>,
    /// Invocations of a subgroup; of the widest version, where several were compiled.
    pub subgroup: u64,
    /// Vector registers of an invocation on AMD; most registers live at once, of 128, on Intel.
    pub registers: u64,
    /// Vector registers live at once before instructions are scheduled.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub demand: Option<u64>,
    /// Subgroups of that size that fit on a SIMD, 16 at most.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waves: Option<u64>,
    /// Registers spilled to memory.
    pub spills: u64,
    /// Bytes of scratch memory: of a subgroup on AMD, of an invocation's thread on Intel.
    pub scratch: u64,
    /// Bytes of shared memory of a workgroup.
    pub shared: u64,
    pub instructions: u64,
    /// Bytes of code.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub code: Option<u64>,
    /// The compiler's estimate of cycles from begin to end.
    pub latency: u64,
    /// The compiler's estimate of cycles that a SIMD is busy with a subgroup.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inverse_throughput: Option<u64>,
}

impl Shader {
    /// Inverse throughput of 64 pixels.
    fn cycles_of_pixels(&self) -> Option<f64> {
        let cycles = self.inverse_throughput? as f64;
        Some(cycles * self.per_pixel.unwrap_or(1.0))
    }
}

#[derive(Serialize, Deserialize, Default, Debug)]
pub struct Isa {
    /// The compilers and their version.
    pub compiler: String,
    pub shaders: Vec<Shader>,
}

/// Families whose numbers stand side by side in a table.
pub const AMD: [&str; 2] = ["vangogh", "navi31"];
pub const INTEL: &str = "tgl";

impl Isa {
    pub fn join(&mut self, more: Self) {
        self.shaders.extend(more.shaders);
    }

    pub fn shader(&self, family: &str, name: &str) -> Option<&Shader> {
        let mut shaders = self.shaders.iter();
        shaders.find(|shader| shader.family == family && shader.name == name)
    }

    fn names(&self) -> Vec<&str> {
        distinct(self.shaders.iter().map(|shader| shader.name.as_str()))
    }

    /// The value of a shader on each of the families.
    fn on(&self, families: &[&str], name: &str, value: impl Fn(&Shader) -> Option<u64>) -> String {
        let values = families.iter().map(|family| {
            let value = self.shader(family, name).and_then(&value);
            value.map_or(fixed(None, 0), thousands)
        });
        beside(distinct(values))
    }

    /// The inverse throughput per pixel over that of Bevy's counterpart.
    fn ratio(&self, family: &str, name: &str) -> Option<f64> {
        let shader = self.shader(family, name)?;
        let bevys = self.shader(family, shader.beside.as_deref()?)?;
        Some(shader.cycles_of_pixels()? / bevys.cycles_of_pixels()?)
    }

    /// Shaders on AMD's families, their numbers side by side.
    pub fn amd(&self) -> Table {
        let columns = [
            "shader",
            "registers",
            "demand",
            "waves",
            "shared",
            "spills, scratch",
            "instructions",
            "KiB of code",
            "latency",
            "inverse throughput",
            "× Bevy",
        ];
        let row = |name: &str| {
            let on = |value: fn(&Shader) -> Option<u64>| self.on(&AMD, name, value);
            let code = AMD.map(|family| {
                let code = self.shader(family, name).and_then(|shader| shader.code);
                fixed(code.map(|bytes| bytes as f64 / 1024.0), 1)
            });
            let ratios = AMD.map(|family| fixed(self.ratio(family, name), 2));
            vec![
                name.to_owned(),
                on(|shader| Some(shader.registers)),
                on(|shader| shader.demand),
                on(|shader| shader.waves),
                on(|shader| Some(shader.shared)),
                on(|shader| Some(shader.spills + shader.scratch)),
                on(|shader| Some(shader.instructions)),
                beside(distinct(code)),
                on(|shader| Some(shader.latency)),
                on(|shader| shader.inverse_throughput),
                beside(distinct(ratios)),
            ]
        };
        Table::new(&columns, self.names().into_iter().map(row))
    }

    /// Shaders on Intel's.
    pub fn intel(&self) -> Table {
        let columns = [
            "shader",
            "SIMD",
            "live registers",
            "spills",
            "scratch",
            "shared",
            "instructions",
            "cycles",
        ];
        let row = |name: &str| {
            let on =
                |value: fn(&Shader) -> u64| self.on(&[INTEL], name, |shader| Some(value(shader)));
            vec![
                name.to_owned(),
                on(|shader| shader.subgroup),
                on(|shader| shader.registers),
                on(|shader| shader.spills),
                on(|shader| shader.scratch),
                on(|shader| shader.shared),
                on(|shader| shader.instructions),
                on(|shader| shader.latency),
            ]
        };
        Table::new(&columns, self.names().into_iter().map(row))
    }

    /// Regressions from `recorded`: fewer or narrower subgroups, more spills or scratch memory; and shaders that are gone.
    pub fn worse_than(&self, recorded: &Self) -> Vec<String> {
        let mut worse = Vec::new();
        for old in &recorded.shaders {
            let (family, name) = (&old.family, &old.name);
            let Some(new) = self.shader(family, name) else {
                worse.push(format!("{family}: {name}: is not there any more"));
                continue;
            };
            let mut complain = |is_worse: bool, what: &str, old: u64, new: u64| {
                if is_worse {
                    worse.push(format!("{family}: {name}: {what} {new}, recorded {old}"));
                }
            };
            let waves = |shader: &Shader| shader.waves.unwrap_or(0);
            let [old_waves, new_waves] = [old, new].map(waves);
            // On AMD the driver may choose another width; waves are counted in invocations then.
            let (old_threads, new_threads) = (old_waves * old.subgroup, new_waves * new.subgroup);
            complain(new_threads < old_threads, "waves", old_waves, new_waves);
            let is_narrower = old.waves.is_none() && new.subgroup < old.subgroup;
            complain(is_narrower, "SIMD", old.subgroup, new.subgroup);
            complain(new.spills > old.spills, "spills", old.spills, new.spills);
            let is_more = new.scratch > old.scratch;
            complain(is_more, "bytes of scratch", old.scratch, new.scratch);
        }
        worse
    }
}

impl Figures for Isa {
    fn device(&self) -> Device {
        Device {
            adapter: FAMILIES.map(|(family, _)| family).join(", "),
            driver: self.compiler.clone(),
        }
    }

    fn tables(&self) -> Vec<Table> {
        let [first, second] = AMD.map(str::to_uppercase);
        vec![
            self.amd().titled(format!("**{first} / {second}**")),
            self.intel().titled(format!("**{}**", INTEL.to_uppercase())),
        ]
    }

    fn legend(&self) -> String {
        "By compilers, without a GPU. One number where both families have the same. Waves: subgroups of 64 on a SIMD, 16 at most; \
         latency and inverse throughput: the compiler's estimate in cycles, which models neither caches nor how long loops run"
            .into()
    }

    /// Inverse throughput per pixel beside that of Bevy's counterpart.
    fn plots(&self) -> Vec<Plot> {
        let family = AMD[0];
        let cycles = |name: &str| self.shader(family, name)?.cycles_of_pixels();
        let mut bars = Bars::new("cycles of a SIMD for 64 pixels, estimated", &["cycles"]);
        let pairs = self.names().into_iter().filter_map(|name| {
            let beside = self.shader(family, name)?.beside.as_deref()?;
            Some((name, cycles(name)?, beside, cycles(beside)?))
        });
        for (name, own, beside, bevys) in pairs {
            bars.add_to(name, "lean".into(), vec![own]);
            bars.add_to(name, beside.into(), vec![bevys]);
        }
        let title = format!("Inverse throughput on {}", family.to_uppercase());
        vec![bars.plot("throughput", title)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn isa(change: impl FnOnce(&mut Shader)) -> Isa {
        let mut shader = Shader {
            family: "vangogh".into(),
            name: "lighting".into(),
            subgroup: 64,
            waves: Some(8),
            ..Shader::default()
        };
        change(&mut shader);
        Isa {
            shaders: vec![shader],
            ..Isa::default()
        }
    }

    #[test]
    fn what_is_worse_is_told() {
        let recorded = isa(|_| {});
        let worse = |change: fn(&mut Shader)| isa(change).worse_than(&recorded);
        assert!(worse(|_| {}).is_empty());
        assert!(worse(|shader| shader.waves = Some(9)).is_empty());
        // As many invocations.
        let halved = worse(|shader| (shader.subgroup, shader.waves) = (32, Some(16)));
        assert!(halved.is_empty());
        let fewer = worse(|shader| shader.waves = Some(7));
        assert_eq!(fewer, ["vangogh: lighting: waves 7, recorded 8"]);
        assert_eq!(worse(|shader| shader.scratch = 4).len(), 1);
        assert_eq!(worse(|shader| shader.spills = 4).len(), 1);
        assert_eq!(worse(|shader| shader.name.clear()).len(), 1);

        let recorded = isa(|shader| (shader.waves, shader.subgroup) = (None, 16));
        let narrower = isa(|shader| (shader.waves, shader.subgroup) = (None, 8));
        assert_eq!(narrower.worse_than(&recorded).len(), 1);
        assert!(recorded.worse_than(&narrower).is_empty());
    }
}
