//! Statistics that the replayer prints of each shader.

use serde_json::{Map, Value};

use super::plan::{Pick, Wanted};
use crate::benches::isa::Shader;

/// A line of the replayer: a version of a shader.
pub struct Line(Map<String, Value>);

impl Line {
    /// The lines of a file, in the order in which their pipelines were made.
    pub fn all(text: &str) -> Result<Vec<Self>, String> {
        let parse = |line: &str| serde_json::from_str(line).map(Line);
        let lines = text.lines().map(parse).collect::<Result<_, _>>();
        lines.map_err(|error| format!("a line of the replayer: {error}"))
    }

    fn text(&self, name: &str) -> &str {
        self.0.get(name).and_then(Value::as_str).unwrap_or_default()
    }

    fn number(&self, name: &str) -> Option<u64> {
        self.0.get(name)?.as_u64()
    }

    fn or_zero(&self, name: &str) -> u64 {
        self.number(name).unwrap_or(0)
    }

    fn instructions(&self) -> u64 {
        let of_anv = || self.or_zero("Instruction Count");
        self.number("Instructions").unwrap_or_else(of_anv)
    }

    /// With the names that RADV and ANV have for their statistics.
    pub fn shader(&self, family: &str, wanted: &Wanted) -> Shader {
        let subgroup = self.or_zero("subgroup");
        let shader = Shader {
            family: family.into(),
            name: wanted.name.into(),
            beside: wanted.beside.map(Into::into),
            per_pixel: (wanted.per_pixel != 1.0).then_some(wanted.per_pixel),
            subgroup,
            ..Shader::default()
        };
        match self.number("VGPRs") {
            Some(registers) => Shader {
                registers,
                demand: self.number("Pre-Sched VGPRs"),
                // RADV counts subgroups of 32.
                waves: (self.number("Subgroups per SIMD"))
                    .map(|waves| waves * 32 / subgroup.max(1)),
                // Scalar registers spill to lanes of vector registers, not to memory.
                spills: self.or_zero("Spilled VGPRs"),
                scratch: self.or_zero("Scratch size"),
                shared: self.or_zero("LDS size"),
                instructions: self.instructions(),
                code: self.number("Code size"),
                latency: self.or_zero("Latency"),
                inverse_throughput: self.number("Inverse Throughput"),
                ..shader
            },
            None => Shader {
                registers: self.or_zero("Max live registers"),
                spills: self.or_zero("Spill Count"),
                scratch: self.or_zero("Scratch Memory Size"),
                shared: self.or_zero("Workgroup Memory Size"),
                instructions: self.instructions(),
                latency: self.or_zero("Cycle Count"),
                ..shader
            },
        }
    }
}

/// The line of the wanted shader: of its versions the one with the widest subgroups.
pub fn pick<'a>(lines: &'a [Line], wanted: &Wanted) -> Result<&'a Line, String> {
    let stage = wanted.stage.name();
    let shaders: Vec<&Line> = lines
        .iter()
        .filter(|line| line.text("name") == wanted.label && line.text("stage") == stage)
        .collect();
    let mut hashes: Vec<&str> = Vec::new();
    for line in &shaders {
        if !hashes.contains(&line.text("hash")) {
            hashes.push(line.text("hash"));
        }
    }
    let hash = match wanted.pick {
        Pick::Nth(number) => hashes.get(number).copied(),
        Pick::Heaviest | Pick::Lightest => {
            // The first of several that are alike.
            let by_weight = |line: &&&Line| line.instructions();
            let shader = match wanted.pick {
                Pick::Heaviest => shaders.iter().rev().max_by_key(by_weight),
                _ => shaders.iter().min_by_key(by_weight),
            };
            shader.map(|line| line.text("hash"))
        }
    };
    let versions = shaders
        .into_iter()
        .filter(|line| Some(line.text("hash")) == hash);
    let widest = versions.max_by_key(|line| line.or_zero("subgroup"));
    widest.ok_or(format!(
        "no {stage} shader of {}: {}",
        wanted.label, wanted.name
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::isa::plan::Stage;

    const LINES: &str = r#"{"name":"l","hash":"a","stage":"compute","Instructions":8,"subgroup":64,"VGPRs":64,"Subgroups per SIMD":16,"Latency":7}
{"name":"l","hash":"b","stage":"compute","Instruction Count":16,"subgroup":8,"Spill Count":3,"Cycle Count":9}
{"name":"l","hash":"b","stage":"compute","Instruction Count":16,"subgroup":16,"Spill Count":5,"Cycle Count":11}
{"name":"m","hash":"c","stage":"fragment","subgroup":64,"VGPRs":8}"#;

    fn shader(pick: Pick) -> Shader {
        let wanted = Wanted {
            name: "n",
            label: "l",
            stage: Stage::Compute,
            pick,
            beside: None,
            per_pixel: 1.0,
        };
        let lines = Line::all(LINES).unwrap();
        super::pick(&lines, &wanted).unwrap().shader("f", &wanted)
    }

    #[test]
    fn shaders_are_picked_by_order_and_weight() {
        let first = shader(Pick::Nth(0));
        assert_eq!(
            (first.waves, first.registers, first.latency),
            (Some(8), 64, 7)
        );
        let heaviest = shader(Pick::Heaviest);
        assert_eq!(
            (heaviest.subgroup, heaviest.spills, heaviest.latency),
            (16, 5, 11)
        );
        assert_eq!(heaviest.waves, None);
        assert_eq!(shader(Pick::Nth(1)), heaviest);
        assert_eq!(shader(Pick::Lightest), first);
    }
}
