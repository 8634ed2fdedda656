//! The Markdown table.

use core::fmt::Write;

use crate::run::Measurement;
use kit::{figures::figure, gpu_time::Time};

/// One table for each size.
pub fn markdown(measurements: &[Measurement], frames: usize) -> String {
    let mut text = String::new();
    let adapter = measurements.first().map_or("", |m| &m.adapter);
    let _ = writeln!(
        text,
        "{adapter}, median of {frames} frames in ms. Lighting: what the lighting pass takes more than without effects. Bytes a \
         pixel: each texture once written and once read, but for depth and normals. Groove (albedo 0.5, of its light), wall and \
         sphere (of πL): RMSE (bias) against the closed form."
    );
    let mut sizes: Vec<_> = measurements.iter().map(|m| m.size).collect();
    sizes.sort_by_key(|size| size.x);
    sizes.dedup();
    for size in sizes {
        let _ = writeln!(text, "\n**{}×{}**\n", size.x, size.y);
        text.push_str(
            "| contender | passes | lighting | all | camera | bytes | groove | wall | sphere |\n|---|---|---|---|---|---|---|---|---|\n",
        );
        let rows = || measurements.iter().filter(|m| m.size == size);
        let plain = rows().next().and_then(|m| m.lighting);
        for m in rows() {
            text.push_str(&row(m, plain));
            text.push('\n');
        }
    }
    text
}

fn row(m: &Measurement, plain: Option<Time>) -> String {
    let own: Vec<String> = (m.passes.iter())
        .map(|time| format!("{:.3}", time.median))
        .collect();
    let lighting = m
        .lighting
        .zip(plain)
        .map(|(own, plain)| own.median - plain.median);
    let all = m.passes.iter().map(|time| time.median).sum::<f64>() + lighting.unwrap_or(0.0);
    let [groove, wall, sphere] = m.errors.map_or(["–"; 3].map(String::from), |errors| {
        [errors.groove, errors.wall, errors.sphere]
            .map(|[rmse, bias]| format!("{rmse:.3} ({bias:+.3})"))
    });
    format!(
        "| {} | {} | {} | {all:.3} | {} | {:.1} | {groove} | {wall} | {sphere} |",
        m.contender,
        own.join(" + "),
        figure(lighting, 3),
        figure(m.camera.map(|time| time.median), 3),
        m.bytes,
    )
}
