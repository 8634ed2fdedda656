//! Hitches of a walk through a level in which features come and go.

use serde::{Deserialize, Serialize};

use super::{Figures, distinct};
use crate::{numbers::fixed, plots::Plot, table::Table, time::Device};

/// Pipelines of one label.
#[derive(Serialize, Deserialize, Clone)]
pub struct Pipelines {
    pub label: String,
    /// Requested before the walk begins, while the level loads.
    pub loading: usize,
    /// Requested in the walk.
    pub walk: usize,
}

/// A feature that comes or goes, with what happens in the frames from it to the next event.
#[derive(Serialize, Deserialize, Clone, Default)]
pub struct Event {
    pub name: String,
    /// Frames that were not lean, though an earlier one was.
    pub not_lean: usize,
    /// Frames in which forward drew meshes whose pipelines or targets were not ready.
    pub waiting_meshes: usize,
    /// Frames in which GI or reflections had no history, though they had it in an earlier one.
    pub lost_history: usize,
    /// Time above twice the median, in milliseconds.
    pub hitches: f64,
}

#[derive(Serialize, Deserialize, Clone)]
pub struct Measurement {
    #[serde(flatten)]
    pub device: Device,
    pub cores: usize,
    pub size: [u32; 2],
    pub frames: usize,
    pub contender: String,
    /// Pipelines are compiled in the frame that requests them.
    pub synchronous: bool,
    pub pipelines: Vec<Pipelines>,
    /// `None` for renderers of Bevy.
    pub not_lean: Option<usize>,
    /// `None` for renderers of Bevy.
    pub waiting_meshes: Option<usize>,
    /// `None` without GI and reflections.
    pub lost_history: Option<usize>,
    /// Milliseconds of a frame.
    pub median: f64,
    pub longest: f64,
    /// Sum of the time above twice the median, in milliseconds.
    pub hitches: f64,
    /// The events with a hitch, a forward frame, a waiting mesh or a lost history.
    pub events: Vec<Event>,
}

impl Measurement {
    fn compilation(&self) -> String {
        match self.synchronous {
            true => "synchronous".into(),
            false => "asynchronous".into(),
        }
    }

    /// Numbers of pipelines whose labels are wanted: while loading, and in the walk.
    fn requested(&self, is_wanted: impl Fn(&str) -> bool) -> Option<String> {
        let wanted = self.pipelines.iter().filter(|p| is_wanted(&p.label));
        let (loading, walk) = wanted.fold((0, 0), |(loading, walk), p| {
            (loading + p.loading, walk + p.walk)
        });
        (loading + walk > 0).then(|| format!("{loading} + {walk}"))
    }
}

#[derive(Serialize, Deserialize, Default)]
#[serde(transparent)]
pub struct Stutter(pub Vec<Measurement>);

const DASH: &str = "–";
/// Prefix of this crate's labels.
const LEAN: &str = "lean_deferred/";
const LIGHTING: &str = "lean_deferred/lighting";
const GBUFFER: &str = "lean_deferred/gbuffer";

const COLUMNS: [&str; 12] = [
    "renderer",
    "compilation",
    "lighting",
    "G-buffer",
    "effects",
    "Bevy",
    "not lean",
    "meshes waited",
    "history lost",
    "median",
    "longest",
    "hitches",
];

impl Stutter {
    pub fn join(&mut self, more: Self) {
        self.0.extend(more.0);
    }

    /// A row for each walk.
    pub fn table(&self) -> Table {
        let row = |m: &Measurement| {
            let is_effect = |label: &str| {
                label.starts_with(LEAN)
                    && !label.starts_with(LIGHTING)
                    && !label.starts_with(GBUFFER)
            };
            let requested = [
                m.requested(|label| label.starts_with(LIGHTING)),
                m.requested(|label| label.starts_with(GBUFFER)),
                m.requested(is_effect),
                m.requested(|label| !label.starts_with(LEAN)),
            ];
            let counts = [m.not_lean, m.waiting_meshes, m.lost_history];
            let times = [(m.median, 2), (m.longest, 1), (m.hitches, 0)];
            let mut row = vec![m.contender.clone(), m.compilation()];
            row.extend(requested.map(|number| number.unwrap_or(DASH.into())));
            row.extend(counts.map(|count| count.map_or(DASH.into(), |count| count.to_string())));
            row.extend(times.map(|(time, digits)| fixed(time, digits)));
            row
        };
        Table::new(&COLUMNS, self.0.iter().map(row))
    }

    /// A row for each label, with the pipelines of each renderer in the first of its walks.
    fn labels(&self) -> Table {
        let contenders = distinct(self.0.iter().map(|m| m.contender.as_str()));
        let walks: Vec<&Measurement> = (contenders.iter())
            .filter_map(|contender| self.0.iter().find(|m| m.contender == *contender))
            .collect();
        let pipelines = walks.iter().flat_map(|m| &m.pipelines);
        let mut labels = distinct(pipelines.map(|p| p.label.as_str()));
        labels.sort_unstable();
        let row = |label: &str| {
            let requested = walks.iter().map(|m| m.requested(|other| other == label));
            let mut row = vec![label.to_owned()];
            row.extend(requested.map(|number| number.unwrap_or(DASH.into())));
            row
        };
        let columns = [&["label"][..], &contenders].concat();
        Table::new(&columns, labels.into_iter().map(row))
    }

    /// A row for each recorded event.
    fn events(&self) -> Table {
        let columns = [
            "renderer",
            "compilation",
            "event",
            "not lean",
            "meshes waited",
            "history lost",
            "hitches",
        ];
        let rows = self.0.iter().flat_map(|m| {
            m.events.iter().map(|event| {
                vec![
                    m.contender.clone(),
                    m.compilation(),
                    event.name.clone(),
                    event.not_lean.to_string(),
                    event.waiting_meshes.to_string(),
                    event.lost_history.to_string(),
                    fixed(event.hitches, 0),
                ]
            })
        });
        Table::new(&columns, rows)
    }
}

impl Figures for Stutter {
    fn device(&self) -> Device {
        (self.0.first()).map_or(Device::default(), |m| m.device.clone())
    }

    fn tables(&self) -> Vec<Table> {
        vec![
            self.table().titled("**Walks**"),
            self.labels().titled("**Pipelines by label**"),
            self.events().titled("**Events**"),
        ]
    }

    fn legend(&self) -> String {
        let about = self.0.first().map(|m| {
            let [x, y] = m.size;
            format!("{} cores, {x}×{y}, {} frames. ", m.cores, m.frames)
        });
        format!(
            "{}Pipelines: requested while the level loads + in the walk. Frames after the first lean one that were not lean, in \
             which forward drew meshes whose pipelines or targets were not ready, and in which GI or reflections had lost their \
             history. Times of frames in ms; hitches: the sum of what is above twice the median. An event has the frames up to the \
             next one",
            about.unwrap_or_default()
        )
    }

    fn plots(&self) -> Vec<Plot> {
        vec![]
    }
}
