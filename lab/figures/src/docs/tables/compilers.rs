//! Tables of shaders by their compilers.

use crate::{
    benches::{Isa, isa::Shader},
    numbers::fixed,
    store::Store,
    table::Table,
};

pub fn amd(store: &Store) -> Table {
    store.isa(MACHINE).amd()
}

pub fn intel(store: &Store) -> Table {
    store.isa(MACHINE).intel()
}

/// Folder of the record.
const MACHINE: &str = "mesa25";

/// A GPU with its data sheet.
struct Gpu {
    name: &'static str,
    family: &'static str,
    simds: f64,
    gigahertz: f64,
    /// Bandwidth in GB/s.
    bandwidth: f64,
}

const GPUS: [Gpu; 2] = [
    Gpu {
        name: "Steam Deck",
        family: "vangogh",
        simds: 16.0,
        gigahertz: 1.6,
        bandwidth: 88.0,
    },
    Gpu {
        name: "Radeon RX 7900 XTX",
        family: "navi31",
        simds: 192.0,
        gigahertz: 2.3,
        bandwidth: 960.0,
    },
];

/// Lighting of the street, and the bytes of a pixel that it moves.
const LIGHTING: [(&str, &str, f64); 2] = [
    ("lean", "lighting: the street", 20.0),
    (
        "Bevy deferred",
        "Bevy's deferred lighting: the street",
        41.0,
    ),
];

/// Lower bounds of lighting at 1920×1080, by a model: cycles of the SIMDs, and bandwidth.
pub fn expected(store: &Store) -> Table {
    expected_of(store.isa(MACHINE))
}

fn expected_of(isa: &Isa) -> Table {
    let pixels = 1920.0 * 1080.0;
    let columns = [
        "GPU",
        "renderer",
        "cycles per 64 pixels",
        "by cycles, ms",
        "by bytes, ms",
    ];
    let rows = GPUS.iter().flat_map(|gpu| {
        LIGHTING.map(|(renderer, shader, bytes)| {
            let shader = isa.shader(gpu.family, shader);
            let cycles = shader.and_then(|shader: &Shader| shader.inverse_throughput);
            let cycles = cycles.map(|cycles| cycles as f64);
            let busy =
                cycles.map(|cycles| pixels / 64.0 * cycles / (gpu.simds * gpu.gigahertz * 1e6));
            vec![
                gpu.name.into(),
                renderer.into(),
                fixed(cycles, 0),
                fixed(busy, 2),
                fixed(pixels * bytes / (gpu.bandwidth * 1e6), 2),
            ]
        })
    });
    Table::new(&columns, rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_follow_from_the_data_sheets() {
        let isa = Isa {
            shaders: vec![Shader {
                family: "vangogh".into(),
                name: "lighting: the street".into(),
                inverse_throughput: Some(6400),
                ..Shader::default()
            }],
            ..Isa::default()
        };
        let table = expected_of(&isa);
        // 32,400 subgroups of 6,400 cycles on 16 SIMDs at 1.6 GHz; 41.5 MB at 88 GB/s.
        assert_eq!(table.rows[0][2..], ["6400", "8.10", "0.47"]);
        assert_eq!(table.rows[1][2..], ["–", "–", "0.97"]);
    }
}
