//! Style that all plots share.

use std::error::Error;

use plotters::{
    coord::{
        Shift,
        combinators::{LogCoord, WithKeyPoints},
    },
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub type Drawn = Result<(), Box<dyn Error>>;
type LogAxis = WithKeyPoints<LogCoord<f64>>;
type LogChart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<LogAxis, LogAxis>>;

/// Font sizes of the SVG are these times 1.24.
pub const TEXT: i32 = 14;
pub const TITLE: i32 = 18;
/// Approximate mean width of a character of [`TEXT`] in pixels: nothing measures fonts.
pub const CHARACTER: f64 = 7.6;

pub const GRID: RGBColor = RGBColor(225, 225, 225);
pub const TITLE_HEIGHT: u32 = 40;
pub const LEGEND_ROW: u32 = 26;

/// Colours that any colour vision can tell apart (Okabe and Ito 2008, "Color Universal Design").
pub const COLORS: [RGBColor; 8] = [
    RGBColor(0, 158, 115),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(204, 121, 167),
    RGBColor(0, 114, 178),
    RGBColor(240, 228, 66),
    RGBColor(213, 94, 0),
    RGBColor(120, 120, 120),
];
pub const BEVY: RGBColor = RGBColor(213, 94, 0);
pub const BEVY_FORWARD: RGBColor = RGBColor(204, 121, 167);

/// Colour of a group with this name: Bevy's have their own, others take the next one by `place`.
pub fn color(group: &str, place: usize) -> RGBColor {
    match group {
        "Bevy forward" => BEVY_FORWARD,
        _ if group.starts_with("Bevy") => BEVY,
        _ => COLORS[place % (COLORS.len() - 2)],
    }
}

/// An SVG with a title, and below it the drawing of `draw`.
pub fn svg(title: &str, width: u32, height: u32, draw: impl FnOnce(&Area) -> Drawn) -> String {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (width, TITLE_HEIGHT + height));
        let root = root.into_drawing_area();
        let drawn = (|| {
            root.fill(&WHITE)?;
            let (head, body) = root.split_vertically(TITLE_HEIGHT);
            let style = ("sans-serif", TITLE).into_font().color(&BLACK);
            let style = style.pos(Pos::new(HPos::Center, VPos::Center));
            head.draw_text(title, &style, (width as i32 / 2, TITLE_HEIGHT as i32 / 2))?;
            draw(&body)?;
            root.present()?;
            Ok::<(), Box<dyn Error>>(())
        })();
        drawn.unwrap_or_else(|error| panic!("the plot {title}: {error}"));
    }
    text
}

pub fn text(horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    let style = ("sans-serif", TEXT).into_font().color(&BLACK);
    style.pos(Pos::new(horizontal, vertical))
}

/// Symbol of a legend's entry.
#[derive(Clone, Copy)]
pub enum Symbol {
    Line(RGBColor),
    Dashes(RGBColor),
    Dot(RGBColor),
    Bar(RGBColor),
    Cross,
}

/// Height of a legend with these entries.
pub fn legend_height(entries: &[(String, Symbol)], width: u32) -> u32 {
    LEGEND_ROW * entries.len().div_ceil(columns(entries, width)) as u32
}

fn columns(entries: &[(String, Symbol)], width: u32) -> usize {
    let longest = entries.iter().map(|(name, _)| name.chars().count()).max();
    let needed = 90.0 + longest.unwrap_or(0) as f64 * CHARACTER;
    ((f64::from(width) / needed) as usize).clamp(1, entries.len().max(1))
}

pub fn draw_legend(area: &Area, entries: &[(String, Symbol)]) -> Drawn {
    let (width, _) = area.dim_in_pixel();
    let columns = columns(entries, width);
    let cells = area.split_evenly((entries.len().div_ceil(columns), columns));
    let middle = LEGEND_ROW as i32 / 2;
    for ((name, symbol), cell) in entries.iter().zip(&cells) {
        let line = |from, to, color: RGBColor| {
            PathElement::new([(from, middle), (to, middle)], color.stroke_width(2))
        };
        let dot = |color: RGBColor| Circle::new((44, middle), 4, color.filled());
        match *symbol {
            Symbol::Line(color) => {
                cell.draw(&line(24, 64, color))?;
                cell.draw(&dot(color))?;
            }
            Symbol::Dashes(color) => {
                for from in [24, 38, 52] {
                    cell.draw(&line(from, from + 9, color))?;
                }
            }
            Symbol::Dot(color) => cell.draw(&dot(color))?,
            Symbol::Bar(color) => {
                let corners = [(34, middle - 7), (58, middle + 7)];
                cell.draw(&Rectangle::new(corners, color.filled()))?;
            }
            Symbol::Cross => cell.draw(&Cross::new((44, middle), 5, BLACK.stroke_width(2)))?,
        }
        cell.draw_text(name, &text(HPos::Left, VPos::Center), (70, middle))?;
    }
    Ok(())
}

/// Least ratio between the ends of a logarithmic axis.
const LEAST_RANGE: f64 = 4.0;

/// Range of the positive values, with some room, for a logarithmic axis.
pub fn log_range(values: impl Iterator<Item = f64>, room: f64) -> (f64, f64) {
    let (least, most) = values
        .filter(|value| *value > 0.0 && value.is_finite())
        .fold((f64::INFINITY, 0.0), |(least, most), value| {
            (value.min(least), value.max(most))
        });
    if most == 0.0 {
        return (0.1, 10.0);
    }
    // Keeps small differences small.
    let room = room.max((LEAST_RANGE / (most / least)).sqrt());
    (least / room, most * room)
}

/// A grid with two logarithmic axes, their descriptions and their ranges.
pub fn log_chart<'a, 'b>(
    area: &'a Area<'b>,
    descriptions: &[String; 2],
    ranges: [(f64, f64); 2],
) -> Result<LogChart<'a, 'b>, Box<dyn Error>> {
    let [x, y] = ranges.map(|(from, to)| {
        let axis = (from..to).log_scale();
        axis.with_key_points(log_ticks((from, to)))
    });
    let label = text(HPos::Center, VPos::Center);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .margin_right(24)
        .x_label_area_size(50)
        .y_label_area_size(86)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .x_desc(&descriptions[0])
        .y_desc(&descriptions[1])
        .x_label_formatter(&tick_text)
        .y_label_formatter(&tick_text)
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .label_style(label.font.clone())
        .axis_desc_style(label.font.clone())
        .draw()?;
    Ok(chart)
}

/// Ticks of a logarithmic axis: 1, 2 and 5 of each power of ten, or the powers alone if there are many.
pub fn log_ticks((least, most): (f64, f64)) -> Vec<f64> {
    let powers = least.log10().floor() as i32..=most.log10().ceil() as i32;
    let factors: &[f64] = match (most / least).log10() {
        decades if decades < 1.2 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        decades if decades < 3.5 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    powers
        // Parsed from text, so that 0.3 is 0.3.
        .flat_map(|power| factors.iter().map(move |f| format!("{f}e{power}")))
        .filter_map(|text| text.parse().ok())
        .filter(|tick| (least..=most).contains(tick))
        .collect()
}

/// The shortest text of the value.
pub fn tick_text(value: &f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if size < 1e-3 => format!("{value:e}"),
        _ => format!("{value}"),
    }
}

/// Ticks of a linear axis from 0 to `most`: five to ten.
pub fn linear_ticks(most: f64) -> Vec<f64> {
    let power = 10f64.powf(most.log10().floor());
    let steps = [0.1, 0.2, 0.5, 1.0, 2.0].map(|step| step * power);
    let step = steps.into_iter().find(|step| most / step <= 8.0);
    let step = step.unwrap_or(power);
    let digits = (-step.log10().floor()).max(0.0) as usize;
    (0..=(most / step) as u32)
        .map(|n| f64::from(n) * step)
        .filter_map(|tick| format!("{tick:.digits$}").parse().ok())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_lie_in_the_range() {
        assert_eq!(log_ticks((0.15, 3.0)), [0.2, 0.5, 1.0, 2.0]);
        assert_eq!(log_range([1.0, 1.0, 0.0].into_iter(), 1.3), (0.5, 2.0));
        assert_eq!(log_ticks((1e-9, 1e-3)).len(), 7);
        assert_eq!(linear_ticks(0.9).last(), Some(&0.8));
        assert_eq!(linear_ticks(27.8), [0.0, 5.0, 10.0, 15.0, 20.0, 25.0]);
        assert!(linear_ticks(80.0).len() <= 9);
    }
}
