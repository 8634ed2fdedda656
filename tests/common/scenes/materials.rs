use super::{Scene, SceneBuilder};

pub const SCENES: &[Scene] = &[];
