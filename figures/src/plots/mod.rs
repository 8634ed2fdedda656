//! Plots as SVG, of any bench. One that a single bench has is beside that bench.

pub mod bars;
pub mod lines;
pub mod points;
pub mod style;

/// A plot, drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plot {
    /// Among the plots of its bench.
    pub name: String,
    pub title: String,
    pub svg: String,
}
