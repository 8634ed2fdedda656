//! What benches do with what they have measured.

pub use ::figures::json::{figure, write_json};
