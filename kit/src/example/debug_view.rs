//! The debug view of an example's camera, chosen on the command line and by keys.

use bevy::prelude::*;
use bevy_lean_deferred::{DebugView, LeanDebugView};

use super::choices::{self, next, next_or_none};

/// Shares of the width that show the view.
const SPLITS: [f32; 2] = [1.0, 0.5];

/// The chosen view, and the share of the width that shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DebugChoice {
    pub view: Option<DebugView>,
    pub split: f32,
}

impl Default for DebugChoice {
    fn default() -> Self {
        Self {
            view: None,
            split: 1.0,
        }
    }
}

impl DebugChoice {
    /// Chooses the next view in `all`, or none after the last.
    pub fn change_view(&mut self, all: &[DebugView]) {
        self.view = next_or_none(all, self.view);
    }

    /// Chooses the next split: the whole width, or half of it.
    pub fn change_split(&mut self) {
        self.split = next(&SPLITS, self.split);
    }

    /// True if the view covers the picture, which then has no use for tonemapping.
    pub fn is_whole(&self) -> bool {
        self.view.is_some() && self.split >= 1.0
    }

    pub fn put_on(&self, camera: &mut EntityCommands) {
        match self.view {
            Some(shows) => camera.insert(LeanDebugView {
                shows,
                split: self.split,
            }),
            None => camera.remove::<LeanDebugView>(),
        };
    }
}

/// The views that lighting draws.
pub fn views_of_lighting() -> Vec<DebugView> {
    let all = DebugView::ALL.into_iter();
    all.filter(|view| view.shader_def().is_some()).collect()
}

/// Parses a view from its name in kebab case.
pub fn debug_view(text: &str) -> Result<DebugView, String> {
    choices::parse(&DebugView::ALL, text)
}
