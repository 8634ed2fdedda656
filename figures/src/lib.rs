//! What the benches of `bevy_lean_deferred` measure, and all that is made of it.
//!
//! - [`benches`]: what each bench writes as JSON, its tables and its plots.
//! - [`template`], [`table`]: text with figures in it, one grammar for all tables and sentences.
//! - [`store`]: folders of figures.
//! - [`docs`]: tables, sentences and plots of README and docs, brought up to date or checked.
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
