//! The plot: time over number of lights, both logarithmic, a panel for each size and arrangement.

use std::error::Error;

use plotters::{
    coord::Shift,
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use crate::{
    contender::Contender,
    report::{Point, Report},
};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Of one panel, and of the strips above all of them, in pixels.
const PANEL: (u32, u32) = (620, 440);
const TITLE_HEIGHT: u32 = 44;
const LEGEND_ROW_HEIGHT: u32 = 30;
const LEGEND_COLUMNS: usize = 3;

/// SVG's sizes are these by 1.24.
const TEXT: i32 = 18;
const TITLE: i32 = 24;

/// That can be told apart with any colour vision (Okabe and Ito 2008, "Color Universal Design").
const COLORS: [RGBColor; 6] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];
const GRID: RGBColor = RGBColor(225, 225, 225);

/// What lighting must move: depth and two words of G-buffer read, colour written.
const BYTES_A_PIXEL: f64 = 4.0 + 8.0 + 8.0;

/// Draws `report` into an SVG file; `bandwidth` is that of the GPU's memory, in TB/s.
pub fn draw(report: &Report, path: &str, bandwidth: f64) -> Result<(), Box<dyn Error>> {
    let mut sizes: Vec<[u32; 2]> = report.points.iter().map(|p| p.size).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let mut arrangements: Vec<&str> = Vec::new();
    for point in &report.points {
        if !arrangements.contains(&point.arrangement.as_str()) {
            arrangements.push(&point.arrangement);
        }
    }
    let entries = legend(report, bandwidth);
    let legend_height = LEGEND_ROW_HEIGHT * entries.len().div_ceil(LEGEND_COLUMNS) as u32;
    let width = PANEL.0 * arrangements.len() as u32;
    let height = TITLE_HEIGHT + legend_height + PANEL.1 * sizes.len() as u32;

    let root = SVGBackend::new(path, (width, height)).into_drawing_area();
    root.fill(&WHITE)?;
    let (title, rest) = root.split_vertically(TITLE_HEIGHT);
    let (legend, panels) = rest.split_vertically(legend_height);
    let text = format!("Lighting over the number of lights, {}", report.adapter);
    let style = ("sans-serif", TITLE).into_font().color(&BLACK);
    let middle = style.pos(Pos::new(HPos::Center, VPos::Center));
    title.draw_text(&text, &middle, (width as i32 / 2, TITLE_HEIGHT as i32 / 2))?;
    draw_legend(&legend, &entries)?;

    let ranges = Ranges::of(report, &sizes, bandwidth);
    let panels = panels.split_evenly((sizes.len(), arrangements.len()));
    for (row, size) in sizes.iter().enumerate() {
        for (column, arrangement) in arrangements.iter().enumerate() {
            let panel = &panels[row * arrangements.len() + column];
            draw_panel(panel, report, *size, arrangement, &ranges, bandwidth)?;
        }
    }
    root.present()?;
    Ok(())
}

/// Milliseconds that the bytes of a picture's lighting need at least.
fn bytes_limit([width, height]: [u32; 2], bandwidth: f64) -> f64 {
    f64::from(width) * f64::from(height) * BYTES_A_PIXEL / (bandwidth * 1e12) * 1e3
}

/// What all panels show.
struct Ranges {
    lights: (f64, f64),
    times: (f64, f64),
}

impl Ranges {
    fn of(report: &Report, sizes: &[[u32; 2]], bandwidth: f64) -> Self {
        let limits = sizes.iter().map(|size| bytes_limit(*size, bandwidth));
        let stages = report.points.iter().filter_map(|p| p.stage);
        let times = stages.flat_map(|time| [time.low, time.high]).chain(limits);
        let lights = report.points.iter().map(|p| f64::from(p.lights));
        let (fewest, most) = bounds(lights);
        let (shortest, longest) = bounds(times.filter(|time| *time > 0.0));
        Self {
            lights: (fewest * 0.8, most * 1.25),
            times: (shortest * 0.6, longest * 1.6),
        }
    }
}

/// The least and the largest.
fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, 0.0), |(least, most), value| {
        (least.min(value), most.max(value))
    })
}

/// What stands for something.
enum Symbol {
    Line(RGBColor),
    Dashes,
    Cross,
}

fn legend(report: &Report, bandwidth: f64) -> Vec<(String, Symbol)> {
    let contenders = report.contenders().into_iter();
    let mut entries: Vec<(String, Symbol)> = contenders
        .map(|c| {
            let name = format!("{}, {}", c.name(), c.stage());
            (name, Symbol::Line(color(c)))
        })
        .collect();
    let limit = format!("{BYTES_A_PIXEL} bytes a pixel at {bandwidth} TB/s");
    entries.push((limit, Symbol::Dashes));
    if report.points.iter().any(|p| p.left_out.is_some()) {
        entries.push(("not measured: too slow".into(), Symbol::Cross));
    }
    entries
}

fn color(contender: Contender) -> RGBColor {
    COLORS[contender.index() % COLORS.len()]
}

fn draw_legend(area: &Area, entries: &[(String, Symbol)]) -> Result<(), Box<dyn Error>> {
    let style = ("sans-serif", TEXT).into_font().color(&BLACK);
    let style = style.pos(Pos::new(HPos::Left, VPos::Center));
    let cells = area.split_evenly((entries.len().div_ceil(LEGEND_COLUMNS), LEGEND_COLUMNS));
    let middle = LEGEND_ROW_HEIGHT as i32 / 2;
    let line = |from, to, color: RGBColor| {
        PathElement::new([(from, middle), (to, middle)], color.stroke_width(2))
    };
    for ((name, symbol), cell) in entries.iter().zip(&cells) {
        match symbol {
            Symbol::Line(color) => {
                cell.draw(&line(24, 64, *color))?;
                cell.draw(&Circle::new((44, middle), 4, color.filled()))?;
            }
            Symbol::Dashes => {
                for from in [24, 36, 48] {
                    cell.draw(&line(from, from + 7, BLACK))?;
                }
            }
            Symbol::Cross => cell.draw(&Cross::new((44, middle), 5, BLACK.stroke_width(2)))?,
        }
        cell.draw_text(name, &style, (74, middle))?;
    }
    Ok(())
}

fn draw_panel(
    area: &Area,
    report: &Report,
    size: [u32; 2],
    arrangement: &str,
    ranges: &Ranges,
    bandwidth: f64,
) -> Result<(), Box<dyn Error>> {
    let (Ranges { lights, times }, [width, height]) = (ranges, size);
    let text = ("sans-serif", TEXT).into_font().color(&BLACK);
    let mut chart = ChartBuilder::on(area)
        .caption(format!("{width}×{height}, {arrangement}"), text.clone())
        .margin(10)
        .margin_right(24)
        .x_label_area_size(56)
        .y_label_area_size(80)
        .build_cartesian_2d(
            (lights.0..lights.1).log_scale().base(4.0),
            (times.0..times.1).log_scale(),
        )?;
    chart
        .configure_mesh()
        .x_desc("point lights")
        .y_desc("GPU time of the stage (ms)")
        .x_max_light_lines(1)
        .x_label_formatter(&|lights| format!("{lights:.0}"))
        .y_label_formatter(&|time| format!("{time}"))
        .y_labels(8)
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .label_style(text.clone())
        .axis_desc_style(text)
        .draw()?;

    for contender in report.contenders() {
        let is_shown = |p: &&Point| {
            p.size == size && p.arrangement == arrangement && p.contender == contender.name()
        };
        let shown = || report.points.iter().filter(is_shown);
        let measured: Vec<_> = shown()
            .filter_map(|p| Some((f64::from(p.lights), p.stage?)))
            .collect();
        let color = color(contender);
        let medians = measured.iter().map(|(lights, time)| (*lights, time.median));
        chart.draw_series(LineSeries::new(medians.clone(), color.stroke_width(2)))?;
        chart.draw_series(medians.map(|point| Circle::new(point, 4, color.filled())))?;
        // From the 10th to the 90th percentile.
        chart.draw_series(measured.iter().map(|(lights, time)| {
            let ends = [(*lights, time.low), (*lights, time.high)];
            PathElement::new(ends, color.stroke_width(1))
        }))?;
        // At the upper edge, the first of those left out.
        let left_out = shown().find(|p| p.left_out.is_some());
        chart.draw_series(left_out.map(|p| {
            let place = (f64::from(p.lights), times.1 / 1.3);
            Cross::new(place, 5, color.stroke_width(2))
        }))?;
    }
    let limit = bytes_limit(size, bandwidth);
    let ends = [(lights.0, limit), (lights.1, limit)];
    chart.draw_series(DashedLineSeries::new(ends, 7, 5, BLACK.stroke_width(2)))?;
    Ok(())
}
