//! Records the figures that benches measure.

pub use ::figures::json::write_json;
