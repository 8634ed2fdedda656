//! The Markdown table.

use core::fmt::Write;

use crate::{contender::Kind, run::Measurement};
use kit::{figures::figure, gpu_time::Time};

/// One table for each size.
pub fn markdown(measurements: &[Measurement], frames: usize) -> String {
    let mut text = String::new();
    let adapter = measurements.first().map_or("", |m| &m.adapter);
    let _ = writeln!(
        text,
        "{adapter}, median of {frames} frames in ms. Lighting: what the lighting pass takes more than without effects. Bytes a \
         pixel: each texture once written and once read, but for depth and normals. RMSE (bias) against what is known: groove \
         (albedo 0.5, of its light), wall and sphere (of πL); a mirror with outlines and without them, and floors by their \
         roughness under a glowing quad (of its light)."
    );
    let mut sizes: Vec<_> = measurements.iter().map(|m| m.size).collect();
    sizes.sort_by_key(|size| size.x);
    sizes.dedup();
    for size in sizes {
        for kind in Kind::ALL {
            let rows: Vec<&Measurement> = (measurements.iter())
                .filter(|m| m.size == size && m.kind.is_none_or(|other| other == kind))
                .collect();
            let scenes: Vec<&str> = (rows.iter())
                .find(|m| !m.errors.is_empty())
                .map_or(Vec::new(), |m| {
                    m.errors.iter().map(|error| error.scene).collect()
                });
            let columns: String = scenes.iter().map(|scene| format!(" {scene} |")).collect();
            let lines = "---|".repeat(6 + scenes.len());
            let _ = writeln!(text, "\n**{}×{}**\n", size.x, size.y);
            let _ = writeln!(
                text,
                "| contender | passes | lighting | all | camera | bytes |{columns}\n|{lines}"
            );
            let plain = rows.first().and_then(|m| m.lighting);
            for m in rows {
                let _ = writeln!(text, "{}", row(m, plain, scenes.len()));
            }
        }
    }
    text
}

fn row(m: &Measurement, plain: Option<Time>, scenes: usize) -> String {
    let own: Vec<String> = (m.passes.iter())
        .map(|time| format!("{:.3}", time.median))
        .collect();
    let lighting = m
        .lighting
        .zip(plain)
        .map(|(own, plain)| own.median - plain.median);
    let all = m.passes.iter().map(|time| time.median).sum::<f64>() + lighting.unwrap_or(0.0);
    let mut errors: Vec<String> = (m.errors.iter())
        .map(|error| format!(" {:.3} ({:+.3}) |", error.rmse, error.bias))
        .collect();
    errors.resize(scenes, " – |".into());
    format!(
        "| {} | {} | {} | {all:.3} | {} | {:.1} |{}",
        m.contender,
        own.join(" + "),
        figure(lighting, 3),
        figure(m.camera.map(|time| time.median), 3),
        m.bytes,
        errors.concat(),
    )
}
