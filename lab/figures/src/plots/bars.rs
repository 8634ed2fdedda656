//! Stacked bars, one below the other.

use plotters::{
    prelude::*,
    style::text_anchor::{HPos, VPos},
};

use super::{
    Plot,
    style::{self, Area, CHARACTER, Drawn, Symbol},
};

const WIDTH: u32 = 900;
const BAR: i32 = 24;
const AXIS: i32 = 56;
const HEAD: i32 = 28;

struct Bar {
    name: String,
    parts: Vec<f64>,
}

/// Contents of the plot.
pub struct Bars {
    axis: String,
    parts: Vec<String>,
    /// Named groups, each on its own scale.
    groups: Vec<(String, Vec<Bar>)>,
}

impl Bars {
    pub fn new(axis: &str, parts: &[&str]) -> Self {
        Self {
            axis: axis.into(),
            parts: parts.iter().map(|part| (*part).into()).collect(),
            groups: Vec::new(),
        }
    }

    pub fn add(&mut self, name: String, parts: Vec<f64>) {
        self.add_to("", name, parts);
    }

    /// Adds a bar to a group, which has its own scale.
    pub fn add_to(&mut self, group: &str, name: String, parts: Vec<f64>) {
        let bar = Bar { name, parts };
        match self.groups.iter_mut().find(|(name, _)| name == group) {
            Some((_, bars)) => bars.push(bar),
            None => self.groups.push((group.into(), vec![bar])),
        }
    }

    pub fn plot(&self, name: &str, title: String) -> Plot {
        let entries: Vec<(String, Symbol)> = match self.parts.len() {
            // The axis names a single part.
            1 => Vec::new(),
            _ => (self.parts.iter().enumerate())
                .map(|(index, part)| (part.clone(), Symbol::Bar(part_color(index))))
                .collect(),
        };
        let legend_height = match entries.is_empty() {
            true => 0,
            false => style::legend_height(&entries, WIDTH),
        };
        let own_scales = self.groups.len() > 1;
        let of_group = |(_, bars): &(String, Vec<Bar>)| {
            bars.len() as i32 * BAR + if own_scales { HEAD } else { AXIS }
        };
        let foot = if own_scales { 34 } else { 4 };
        let height = self.groups.iter().map(of_group).sum::<i32>() + foot;
        let svg = style::svg(&title, WIDTH, legend_height + height as u32, |area| {
            let (legend, panel) = area.split_vertically(legend_height);
            if !entries.is_empty() {
                style::draw_legend(&legend, &entries)?;
            }
            let names = self.groups.iter().flat_map(|(_, bars)| bars);
            let longest = names.map(|bar| bar.name.chars().count()).max();
            let left = 24 + (longest.unwrap_or(0) as f64 * CHARACTER) as i32;
            let mut top = 0;
            for group in &self.groups {
                self.draw_group(&panel, group, left, top, own_scales)?;
                top += of_group(group);
            }
            if own_scales {
                let text = format!("{}, each group on a scale of its own", self.axis);
                let style = style::text(HPos::Center, VPos::Center);
                panel.draw_text(&text, &style, (WIDTH as i32 / 2, top + 16))?;
            }
            Ok(())
        });
        let name = name.into();
        Plot { name, title, svg }
    }

    fn draw_group(
        &self,
        area: &Area,
        (name, bars): &(String, Vec<Bar>),
        left: i32,
        top: i32,
        own_scale: bool,
    ) -> Drawn {
        let most = bars
            .iter()
            .map(|bar| bar.parts.iter().sum::<f64>())
            .fold(0.0, f64::max);
        let most = if most > 0.0 { most } else { 1.0 };
        // With room for the figure behind the longest bar.
        let scale = f64::from(WIDTH as i32 - left - 90) / most;
        let at = |value: f64| left + (value * scale).round() as i32;
        let right = style::text(HPos::Right, VPos::Center);
        let bottom = top + bars.len() as i32 * BAR + if own_scale { HEAD } else { 0 };
        let mut row = top;
        if own_scale {
            let style = style::text(HPos::Left, VPos::Center);
            area.draw_text(name, &style, (left, row + HEAD / 2 + 3))?;
            row += HEAD;
        } else {
            for tick in style::linear_ticks(most) {
                let x = at(tick);
                let line =
                    PathElement::new([(x, top), (x, bottom + 4)], style::GRID.stroke_width(1));
                area.draw(&line)?;
                let text = style::text(HPos::Center, VPos::Top);
                area.draw_text(&style::tick_text(&tick), &text, (x, bottom + 8))?;
            }
            let text = style::text(HPos::Center, VPos::Top);
            let middle = (left + at(most)) / 2;
            area.draw_text(&self.axis, &text, (middle, bottom + 30))?;
        }
        for bar in bars {
            let middle = row + BAR / 2;
            area.draw_text(&bar.name, &right, (left - 8, middle))?;
            let mut sum = 0.0;
            for (index, part) in bar
                .parts
                .iter()
                .enumerate()
                .filter(|(_, part)| **part > 0.0)
            {
                let corners = [(at(sum), row + 4), (at(sum + part), row + BAR - 4)];
                area.draw(&Rectangle::new(corners, part_color(index).filled()))?;
                sum += part;
            }
            let text = style::text(HPos::Left, VPos::Center);
            area.draw_text(&figure(sum), &text, (at(sum) + 6, middle))?;
            row += BAR;
        }
        Ok(())
    }
}

fn part_color(index: usize) -> RGBColor {
    style::COLORS[index % style::COLORS.len()]
}

/// Three digits of a value, or all before the point.
fn figure(value: f64) -> String {
    match value {
        _ if value >= 100.0 => format!("{value:.0}"),
        _ if value >= 10.0 => format!("{value:.1}"),
        _ if value >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}
