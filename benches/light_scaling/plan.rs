//! The requested measurements.

/// Sizes, numbers of lights and limits of a run.
pub struct Plan {
    /// Ascending.
    pub lights: Vec<u32>,
    pub frames: usize,
    pub warm_up: usize,
    /// Larger numbers of lights are left out beyond this median of a stage, in milliseconds.
    pub limit: f64,
    /// Reduces the scene to a quarter each way.
    pub small: bool,
    /// Keeps the resolution of Bevy's clusters, however long their lists of lights are.
    pub fixed_grid: bool,
    pub pictures: Option<String>,
}
