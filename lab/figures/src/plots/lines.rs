//! Lines over a number, both axes logarithmic.

use plotters::prelude::*;

use super::{
    Plot,
    style::{self, Area, Drawn, Symbol},
};

const WIDTH: u32 = 900;
const HEIGHT: u32 = 420;

struct Line {
    name: String,
    points: Vec<(f64, f64)>,
    dashed: bool,
    color: RGBColor,
}

/// Contents of the plot.
pub struct Lines {
    axes: [String; 2],
    lines: Vec<Line>,
}

impl Lines {
    pub fn new(x: &str, y: &str) -> Self {
        Self {
            axes: [x, y].map(Into::into),
            lines: Vec::new(),
        }
    }

    /// Lines whose names are equal up to a comma share a colour.
    pub fn add(&mut self, name: String, points: Vec<(f64, f64)>, dashed: bool) {
        let group = |name: &str| name.split(',').next().unwrap_or_default().to_owned();
        let own = group(&name);
        let same = self.lines.iter().find(|line| group(&line.name) == own);
        let color = same.map(|line| line.color);
        // Bevy's lines have colours of their own.
        let mut others: Vec<RGBColor> = Vec::new();
        for line in self
            .lines
            .iter()
            .filter(|line| !line.name.starts_with("Bevy"))
        {
            if !others.contains(&line.color) {
                others.push(line.color);
            }
        }
        let color = color.unwrap_or_else(|| style::color(&own, others.len()));
        let points = points
            .into_iter()
            .filter(|(x, y)| *x > 0.0 && *y > 0.0)
            .collect();
        self.lines.push(Line {
            name,
            points,
            dashed,
            color,
        });
    }

    pub fn plot(&self, name: &str, title: String) -> Plot {
        let entry = |line: &Line| {
            let symbol = match line.dashed {
                true => Symbol::Dashes(line.color),
                false => Symbol::Line(line.color),
            };
            (line.name.clone(), symbol)
        };
        let entries: Vec<(String, Symbol)> = self.lines.iter().map(entry).collect();
        let legend_height = style::legend_height(&entries, WIDTH);
        let svg = style::svg(&title, WIDTH, legend_height + HEIGHT, |area| {
            let (legend, panel) = area.split_vertically(legend_height);
            style::draw_legend(&legend, &entries)?;
            self.draw(&panel)
        });
        let name = name.into();
        Plot { name, title, svg }
    }

    fn draw(&self, area: &Area) -> Drawn {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let x = style::log_range(points().map(|(x, _)| *x), 1.2);
        let y = style::log_range(points().map(|(_, y)| *y), 1.3);
        let mut chart = style::log_chart(area, &self.axes, [x, y])?;
        for line in &self.lines {
            let points = line.points.iter().copied();
            let stroke = line.color.stroke_width(2);
            match line.dashed {
                true => {
                    chart.draw_series(DashedLineSeries::new(points.clone(), 7, 5, stroke))?;
                }
                false => {
                    chart.draw_series(LineSeries::new(points.clone(), stroke))?;
                }
            }
            let dots = points.map(|point| Circle::new(point, 4, line.color.filled()));
            chart.draw_series(dots)?;
        }
        Ok(())
    }
}
