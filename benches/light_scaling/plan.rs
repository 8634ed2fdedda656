//! What is asked for.

/// What is measured, and for how long.
pub struct Plan {
    /// Ascending.
    pub lights: Vec<u32>,
    pub frames: usize,
    pub warm_up: usize,
    /// Beyond this median of a stage, in milliseconds, larger numbers of lights are left out.
    pub limit: f64,
    /// Whether the scene is a quarter of the whole one each way.
    pub small: bool,
    /// Whether Bevy's clusters stay as they are, however many lights are listed in them.
    pub fixed_grid: bool,
    pub pictures: Option<String>,
}
