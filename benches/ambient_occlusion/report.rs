//! The Markdown table.

use core::fmt::Write;

use crate::run::Measurement;
use kit::gpu_time::Time;

/// One table for each size.
pub fn markdown(measurements: &[Measurement], frames: usize) -> String {
    let mut text = String::new();
    let adapter = measurements.first().map_or("", |m| &m.adapter);
    let _ = writeln!(
        text,
        "{adapter}, median of {frames} frames (10th–90th percentile) in ms. Lighting: what the lighting pass takes more \
         than without occlusion. Prepass: what Bevy's needs, more than without. Bytes a pixel: each texture once written \
         and once read without depth and normals / with them / each fetch counted; MB a frame of the first. Wall: RMSE \
         (bias) against the closed form, radius 0.5 m; plane: mean where there is no occlusion.\n"
    );
    for m in measurements {
        let is_first = measurements
            .iter()
            .find(|o| o.size == m.size)
            .is_some_and(|o| core::ptr::eq(o, m));
        if is_first {
            let _ = writeln!(text, "\n**{}×{}**\n", m.size.x, m.size.y);
            text.push_str(
                "| contender | gather | merge | lighting | prepass | all | bytes | MB | wall | plane |\n\
                 |---|---|---|---|---|---|---|---|---|---|\n",
            );
        }
        text.push_str(&row(m, measurements));
        text.push('\n');
    }
    text
}

/// What `of` takes more in `m` than in the same camera without occlusion, among `all`.
fn more(m: &Measurement, all: &[Measurement], of: fn(&Measurement) -> Option<Time>) -> Option<f64> {
    let without = all
        .iter()
        .find(|o| o.size == m.size && o.lean == m.lean && o.passes.is_empty())?;
    Some(of(m)?.median - of(without).map_or(0.0, |time| time.median))
}

pub fn row(m: &Measurement, all: &[Measurement]) -> String {
    let lighting = more(m, all, |m| m.lighting);
    let prepass = more(m, all, |m| m.prepass);
    let own: f64 = m.passes.iter().map(|time| time.median).sum();
    let sum = own + lighting.unwrap_or(0.0) + prepass.unwrap_or(0.0);
    let pixels = f64::from(m.size.x) * f64::from(m.size.y);
    let figure = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.3}"));
    format!(
        "| {} | {} | {} | {} | {} | {sum:.3} | {:.1} / {:.1} / {:.0} | {:.1} | {} | {} |",
        m.contender,
        Time::text(m.passes.first().copied()),
        Time::text(m.passes.get(1).copied()),
        figure(lighting),
        figure(prepass),
        m.bytes.compulsory,
        m.bytes.compulsory_with_depth,
        m.bytes.fetched,
        m.bytes.compulsory * pixels / 1e6,
        m.wall.map_or("–".into(), |(rmse, bias)| format!(
            "{rmse:.3} ({bias:+.3})"
        )),
        m.plane.map_or("–".into(), |mean| format!("{mean:.4}")),
    )
}
