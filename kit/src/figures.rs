//! Records the figures that benches measure.

pub use ::figures::json::{figure, write_json};
