//! Time over number of lights, both logarithmic, a panel for each size and arrangement.

use plotters::{
    prelude::*,
    style::text_anchor::{HPos, VPos},
};

use super::{LightScaling, Point, stage};
use crate::plots::{
    Plot,
    style::{self, Area, Drawn, Symbol},
};

/// Size of one panel, in pixels.
const PANEL: (u32, u32) = (620, 420);

/// Bytes that lighting must move per pixel: depth and two words of G-buffer read, colour written.
const BYTES_A_PIXEL: f64 = 4.0 + 8.0 + 8.0;

pub(super) fn plot(figures: &LightScaling) -> Plot {
    let bandwidth = figures.bandwidth;
    let mut sizes: Vec<[u32; 2]> = figures.points.iter().map(|p| p.size).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let mut arrangements: Vec<&str> = Vec::new();
    for point in &figures.points {
        if !arrangements.contains(&point.arrangement.as_str()) {
            arrangements.push(&point.arrangement);
        }
    }
    let entries = legend(figures, bandwidth);
    let width = PANEL.0 * arrangements.len() as u32;
    let legend_height = style::legend_height(&entries, width);
    let height = legend_height + PANEL.1 * sizes.len() as u32;
    let title = format!(
        "Lighting over the number of lights, {}",
        figures.device.adapter
    );
    let svg = style::svg(&title, width, height, |area| {
        let (legend, panels) = area.split_vertically(legend_height);
        style::draw_legend(&legend, &entries)?;
        let ranges = Ranges::of(figures, &sizes, bandwidth);
        let panels = panels.split_evenly((sizes.len(), arrangements.len()));
        for (row, size) in sizes.iter().enumerate() {
            for (column, arrangement) in arrangements.iter().enumerate() {
                let panel = &panels[row * arrangements.len() + column];
                draw_panel(panel, figures, *size, arrangement, &ranges, bandwidth)?;
            }
        }
        Ok(())
    });
    let name = "lights".into();
    Plot { name, title, svg }
}

/// Least time of a picture's lighting in milliseconds, by its bytes.
fn bytes_limit([width, height]: [u32; 2], bandwidth: f64) -> f64 {
    f64::from(width) * f64::from(height) * BYTES_A_PIXEL / (bandwidth * 1e12) * 1e3
}

/// Axis ranges that all panels share.
struct Ranges {
    lights: (f64, f64),
    times: (f64, f64),
}

impl Ranges {
    fn of(figures: &LightScaling, sizes: &[[u32; 2]], bandwidth: Option<f64>) -> Self {
        let limits = sizes
            .iter()
            .filter_map(|size| Some(bytes_limit(*size, bandwidth?)));
        let stages = figures.points.iter().filter_map(|p| p.stage);
        let times = stages.flat_map(|time| [time.low, time.high]).chain(limits);
        let lights = figures.points.iter().map(|p| f64::from(p.lights));
        Self {
            lights: style::log_range(lights, 1.25),
            times: style::log_range(times, 1.6),
        }
    }
}

fn legend(figures: &LightScaling, bandwidth: Option<f64>) -> Vec<(String, Symbol)> {
    let contenders = figures.contenders();
    let mut entries: Vec<(String, Symbol)> = (contenders.iter())
        .map(|contender| {
            let name = format!("{contender}, {}", stage(contender));
            (name, Symbol::Line(color(&contenders, contender)))
        })
        .collect();
    if let Some(bandwidth) = bandwidth {
        let limit = format!("{BYTES_A_PIXEL} bytes a pixel at {bandwidth} TB/s");
        entries.push((limit, Symbol::Dashes(BLACK)));
    }
    if figures.points.iter().any(|p| p.left_out.is_some()) {
        entries.push(("not measured: too slow".into(), Symbol::Cross));
    }
    entries
}

fn color(contenders: &[&str], contender: &str) -> RGBColor {
    let mut own = contenders.iter().filter(|c| !c.starts_with("Bevy"));
    let place = own.position(|c| *c == contender);
    style::color(contender, place.unwrap_or(0))
}

fn draw_panel(
    area: &Area,
    figures: &LightScaling,
    size: [u32; 2],
    arrangement: &str,
    ranges: &Ranges,
    bandwidth: Option<f64>,
) -> Drawn {
    let (Ranges { lights, times }, [width, height]) = (ranges, size);
    let font = style::text(HPos::Center, VPos::Center).font;
    let mut numbers: Vec<f64> = figures.points.iter().map(|p| f64::from(p.lights)).collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    let mut chart = ChartBuilder::on(area)
        .caption(format!("{width}×{height}, {arrangement}"), font.clone())
        .margin(10)
        .margin_right(24)
        .x_label_area_size(50)
        .y_label_area_size(80)
        .build_cartesian_2d(
            (lights.0..lights.1).log_scale().with_key_points(numbers),
            (times.0..times.1)
                .log_scale()
                .with_key_points(style::log_ticks(*times)),
        )?;
    chart
        .configure_mesh()
        .x_desc("point lights")
        .y_desc("GPU time of the stage (ms)")
        .x_label_formatter(&|lights| format!("{lights:.0}"))
        .y_label_formatter(&style::tick_text)
        .light_line_style(TRANSPARENT)
        .bold_line_style(style::GRID)
        .label_style(font.clone())
        .axis_desc_style(font)
        .draw()?;

    let contenders = figures.contenders();
    for contender in &contenders {
        let is_shown = |p: &&Point| {
            p.size == size && p.arrangement == arrangement && p.contender == *contender
        };
        let shown = || figures.points.iter().filter(is_shown);
        let measured: Vec<_> = shown()
            .filter_map(|p| Some((f64::from(p.lights), p.stage?)))
            .collect();
        let color = color(&contenders, contender);
        let medians = measured.iter().map(|(lights, time)| (*lights, time.median));
        chart.draw_series(LineSeries::new(medians.clone(), color.stroke_width(2)))?;
        chart.draw_series(medians.map(|point| Circle::new(point, 4, color.filled())))?;
        // Bars from the 10th to the 90th percentile.
        chart.draw_series(measured.iter().map(|(lights, time)| {
            let ends = [(*lights, time.low), (*lights, time.high)];
            PathElement::new(ends, color.stroke_width(1))
        }))?;
        // At the upper edge, the first point that was left out.
        let left_out = shown().find(|p| p.left_out.is_some());
        chart.draw_series(left_out.map(|p| {
            let place = (f64::from(p.lights), times.1 / 1.3);
            Cross::new(place, 5, color.stroke_width(2))
        }))?;
    }
    if let Some(bandwidth) = bandwidth {
        let limit = bytes_limit(size, bandwidth);
        let ends = [(lights.0, limit), (lights.1, limit)];
        chart.draw_series(DashedLineSeries::new(ends, 7, 5, BLACK.stroke_width(2)))?;
    }
    Ok(())
}
