//! The Markdown table.

use core::fmt::Write;

use bevy::math::UVec2;

use crate::run::Measurement;
use kit::{figures::figure, gpu_time::Time};

/// One row for each measurement; ratios are to Bevy deferred on the same scene.
pub fn markdown(measurements: &[Measurement], size: UVec2, frames: usize) -> String {
    let mut text = String::new();
    let adapter = measurements.first().map_or("", |m| &m.adapter);
    let _ = writeln!(
        text,
        "{adapter}, {}×{}, median of {frames} frames (10th–90th percentile) in ms; bytes a pixel \
         written by geometry / moved by geometry and lighting; errors against forward.\n",
        size.x, size.y
    );
    text.push_str(
        "| scene | renderer | geometry | × | lighting | × | camera | bytes | PSNR dB | FLIP | > 8/255 |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for m in measurements {
        let peer = measurements
            .iter()
            .find(|p| p.scene == m.scene && p.contender == "Bevy deferred");
        text.push_str(&row(m, peer));
        text.push('\n');
    }
    text
}

/// One row; ratios are to `peer`.
pub fn row(m: &Measurement, peer: Option<&Measurement>) -> String {
    let off_by_8 = m
        .off_by_8
        .map_or("–".into(), |share| format!("{:.3}%", share * 100.0));
    format!(
        "| {} | {} | {} | {} | {} | {} | {} | {} / {} | {} | {} | {off_by_8} |",
        m.scene,
        m.contender,
        Time::text(m.geometry),
        ratio(m.geometry, peer.and_then(|p| p.geometry)),
        Time::text(m.lighting),
        ratio(m.lighting, peer.and_then(|p| p.lighting)),
        Time::text(m.camera),
        m.bytes_written_by_geometry,
        m.bytes_in_all,
        figure(m.psnr, 1),
        figure(m.flip, 4),
    )
}

fn ratio(time: Option<Time>, peer: Option<Time>) -> String {
    match (time, peer) {
        (Some(time), Some(peer)) if peer.median > 0.0 => {
            format!("{:.2}", time.median / peer.median)
        }
        _ => "–".into(),
    }
}
