//! The table.

use core::fmt::Write;

use bevy::math::UVec2;

use crate::run::{Measurement, Times};

/// Times of `measurement`, render world / whole frame, with the ratio of the render world's to that of `peer`.
pub fn row(measurement: &Measurement, peer: Option<&Measurement>) -> String {
    let mut row = format!("| {} | {} |", measurement.meshes, measurement.contender);
    let columns = |m: &Measurement| -> Vec<Times> {
        let mut times = m.steady.clone();
        times.extend([m.emissive, m.expiry, m.turn]);
        times
    };
    let peers = peer.map(columns);
    for (column, times) in columns(measurement).into_iter().enumerate() {
        let _ = write!(row, " {:.2} / {:.2}", times.render_world, times.frame);
        if let Some(peers) = &peers {
            let ratio = times.render_world / peers[column].render_world;
            let _ = write!(row, " (× {ratio:.2})");
        }
        row.push_str(" |");
    }
    let _ = write!(row, " {:.1} | {:.4} |", measurement.psnr, measurement.flip);
    row
}

/// All of them; ratios are to Bevy deferred.
pub fn markdown(measurements: &[Measurement], size: UVec2) -> String {
    let mut table = String::new();
    if let Some(first) = measurements.first() {
        let _ = writeln!(
            table,
            "{}, {} cores, {}×{}. CPU time in ms, render world / whole frame; × is to Bevy deferred.\n",
            first.adapter, first.cores, size.x, size.y
        );
    }
    table.push_str(
        "| meshes | renderer | static | a tenth moves | all move | emissive mesh appears | its target goes \
         | camera turns around | PSNR dB | FLIP |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for measurement in measurements {
        let peer = measurements
            .iter()
            .find(|m| m.meshes == measurement.meshes && m.contender == "Bevy deferred");
        table.push_str(&row(measurement, peer));
        table.push('\n');
    }
    table
}
