//! Figures that the benches of `bevy_lean_deferred` measure, and their tables, plots and pages.
//!
//! - [`benches`]: the JSON, tables and plots of each bench.
//! - [`template`], [`table`]: text with figures in it, with one grammar for all tables and sentences.
//! - [`store`]: folders of figures.
//! - [`docs`]: tables, sentences and plots of README and docs, updated or checked.
//! - [`page`]: one HTML file of all figures.
//! - [`report`]: runs all benches for such a page.

pub mod benches;
pub mod docs;
pub mod json;
pub mod page;
pub mod plots;
pub mod record;
pub mod report;
pub mod store;
pub mod table;
pub mod template;
pub mod time;
