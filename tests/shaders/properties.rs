//! Properties that hold for all values: random and hostile ones are searched for a counterexample, which is then simplified.

mod culling;
mod packing;
