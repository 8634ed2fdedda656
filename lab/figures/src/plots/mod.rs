//! Plots as SVG, for any bench. The plot of a single bench is beside that bench.

pub mod bars;
pub mod lines;
pub mod points;
pub mod style;

/// A plot, drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plot {
    /// Unique among the plots of its bench.
    pub name: String,
    pub title: String,
    pub svg: String,
}
