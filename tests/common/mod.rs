//! What tests and benches share: rendering without a window, comparing pictures, scenes built in code.
#![allow(dead_code, reason = "each binary uses a part")]

pub mod headless;
pub mod metrics;
pub mod scenes;
