//! What holds for all values, looked for a counterexample among random and hostile ones, which is then made as simple as
//! it can be.

mod culling;
mod packing;
