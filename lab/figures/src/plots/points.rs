//! Points with names, both axes logarithmic: speed against error.

use plotters::{
    prelude::*,
    style::text_anchor::{HPos, VPos},
};

use super::{
    Plot,
    style::{self, Area, CHARACTER, Drawn, Symbol},
};

const WIDTH: u32 = 900;
const HEIGHT: u32 = 440;

struct Point {
    group: &'static str,
    name: String,
    place: (f64, f64),
}

/// Contents of the plot.
pub struct Points {
    axes: [String; 2],
    points: Vec<Point>,
    /// Vertical lines, at their x.
    lines: Vec<(String, f64)>,
}

impl Points {
    pub fn new(x: &str, y: &str) -> Self {
        Self {
            axes: [x, y].map(Into::into),
            points: Vec::new(),
            lines: Vec::new(),
        }
    }

    pub fn add(&mut self, group: &'static str, name: &str, x: f64, y: f64) {
        // The axes have no 0.
        if x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite() {
            let (name, place) = (name.into(), (x, y));
            self.points.push(Point { group, name, place });
        }
    }

    pub fn line(&mut self, name: &str, x: f64) {
        self.lines.push((name.into(), x));
    }

    fn groups(&self) -> Vec<(&'static str, RGBColor)> {
        let mut groups: Vec<&str> = Vec::new();
        for point in &self.points {
            if !groups.contains(&point.group) {
                groups.push(point.group);
            }
        }
        let mut place = 0;
        let colored = groups.into_iter().map(|group| {
            let color = style::color(group, place);
            place += usize::from(!group.starts_with("Bevy"));
            (group, color)
        });
        colored.collect()
    }

    pub fn plot(&self, name: &str, title: String) -> Plot {
        let mut entries: Vec<(String, Symbol)> = (self.groups().iter())
            .map(|(group, color)| ((*group).into(), Symbol::Dot(*color)))
            .collect();
        for (name, _) in &self.lines {
            entries.push((name.clone(), Symbol::Dashes(style::BEVY_FORWARD)));
        }
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
        let places = || self.points.iter().map(|point| point.place);
        let lines = self.lines.iter().map(|(_, x)| *x);
        let x = style::log_range(places().map(|(x, _)| x).chain(lines), 1.3);
        let y = style::log_range(places().map(|(_, y)| y), 1.4);
        let mut chart = style::log_chart(area, &self.axes, [x, y])?;
        for (_, place) in &self.lines {
            let ends = [(*place, y.0), (*place, y.1)];
            let line = DashedLineSeries::new(ends, 7, 5, style::BEVY_FORWARD.stroke_width(2));
            chart.draw_series(line)?;
        }
        let groups = self.groups();
        for point in &self.points {
            let color = groups.iter().find(|(group, _)| *group == point.group);
            let color = color.map_or(BLACK, |(_, color)| *color);
            chart.draw_series([Circle::new(point.place, 5, color.filled())])?;
        }

        let dots: Vec<(i32, i32)> = (self.points.iter())
            .map(|point| chart.backend_coord(&point.place))
            .collect();
        let plane = chart.plotting_area().get_pixel_range();
        let names: Vec<&str> = self
            .points
            .iter()
            .map(|point| point.name.as_str())
            .collect();
        // The labels' coordinates are relative to the whole picture.
        let (left, top) = area.get_base_pixel();
        for label in place_names(
            &names,
            &dots,
            [plane.0.start, plane.0.end, plane.1.start, plane.1.end],
        ) {
            let at = |(x, y): (i32, i32)| (x - left, y - top);
            if let Some((from, to)) = label.leader {
                area.draw(&PathElement::new(
                    [at(from), at(to)],
                    style::COLORS[7].stroke_width(1),
                ))?;
            }
            let text = style::text(HPos::Left, VPos::Center);
            area.draw_text(&label.name, &text, at(label.place))?;
        }
        Ok(())
    }
}

/// A name beside its point.
struct Label {
    name: String,
    /// The middle of its left side.
    place: (i32, i32),
    /// A line to the point, if the name is not beside it.
    leader: Option<((i32, i32), (i32, i32))>,
}

/// Left, right, top, bottom.
type Bounds = [i32; 4];

fn overlap(a: Bounds, b: Bounds) -> bool {
    a[0] < b[1] && b[0] < a[1] && a[2] < b[3] && b[2] < a[3]
}

/// Places each name where there is neither another one nor a point: beside its own point, or else further up or down
/// with a line to it.
fn place_names(names: &[&str], dots: &[(i32, i32)], plane: Bounds) -> Vec<Label> {
    let mut taken: Vec<Bounds> = dots
        .iter()
        .map(|(x, y)| [x - 6, x + 6, y - 6, y + 6])
        .collect();
    // Names of points at one place are joined.
    let mut labels: Vec<Label> = Vec::new();
    let mut done: Vec<(i32, i32)> = Vec::new();
    for (index, (x, y)) in dots.iter().copied().enumerate() {
        let near = |(a, b): &(i32, i32)| (a - x).abs() <= 2 && (b - y).abs() <= 2;
        if done.iter().any(near) {
            continue;
        }
        done.push((x, y));
        let same: Vec<&str> = (dots.iter().zip(names).skip(index))
            .filter(|(dot, _)| near(dot))
            .map(|(_, name)| *name)
            .collect();
        let name = match &same[..] {
            [first, others @ ..] if others.len() > 1 => {
                format!("{first} and {} more", others.len())
            }
            _ => same.join(" = "),
        };
        let width = (name.chars().count() as f64 * CHARACTER) as i32;
        let bounds = |left: i32, middle: i32| [left, left + width, middle - 9, middle + 9];
        let offsets = (0..12).flat_map(|step: i32| [step * 10, -step * 10]);
        let candidates = offsets.flat_map(|dy| {
            let aside = if dy.abs() > 8 { 16 } else { 9 };
            [
                (x + aside, y + dy),
                (x - aside - width, y + dy),
                (x - width / 2, y + dy),
            ]
        });
        let is_free = |(left, middle): &(i32, i32)| {
            let own = bounds(*left, *middle);
            own[0] >= plane[0]
                && own[1] <= plane[1]
                && own[2] >= plane[2]
                && own[3] <= plane[3]
                && !taken.iter().any(|other| overlap(own, *other))
        };
        let mut candidates = candidates.collect::<Vec<_>>().into_iter();
        let place = candidates.find(is_free).unwrap_or((x + 9, y));
        taken.push(bounds(place.0, place.1));
        let far = (place.1 - y).abs() > 14;
        let end = (
            x.clamp(place.0, place.0 + width),
            place.1 + if place.1 > y { -9 } else { 9 },
        );
        let leader = far.then_some(((x, y), end));
        labels.push(Label {
            name,
            place,
            leader,
        });
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_overlap() {
        let dots = [(100, 100), (104, 100), (110, 104), (390, 20), (110, 104)];
        let names = ["first", "second", "third", "at the edge", "there too"];
        let labels = place_names(&names, &dots, [0, 400, 0, 200]);
        assert_eq!(labels.len(), 4);
        assert_eq!(labels[2].name, "third = there too");
        let bounds: Vec<Bounds> = (labels.iter())
            .map(|label| {
                let width = (label.name.chars().count() as f64 * CHARACTER) as i32;
                let (x, y) = label.place;
                [x, x + width, y - 9, y + 9]
            })
            .collect();
        for (index, a) in bounds.iter().enumerate() {
            assert!(
                a[0] >= 0 && a[1] <= 400 && a[2] >= 0 && a[3] <= 200,
                "{a:?}"
            );
            assert!(bounds[..index].iter().all(|b| !overlap(*a, *b)), "{a:?}");
        }
    }
}
