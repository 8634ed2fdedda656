//! Figures that the benches of `bevy_lean_deferred` measure, and their tables, plots and pages.
//!
//! - [`benches`]: the JSON, tables and plots of each bench.
//! - [`numbers`], [`table`]: numbers and tables as text.
//! - [`store`]: folders of figures.
//! - [`docs`]: tables and plots of README and docs, updated or checked.
//! - [`page`]: one HTML file of all figures.
//! - [`report`]: runs all benches for such a page.
//! - [`isa`]: compiles shaders for GPUs that are not there.
//! - [`wipe`]: pictures of the docs, off and on.

mod arguments;
pub mod benches;
pub mod docs;
pub mod isa;
pub mod json;
pub mod numbers;
pub mod page;
pub mod plots;
pub mod report;
pub mod store;
pub mod table;
pub mod time;
pub mod wipe;
