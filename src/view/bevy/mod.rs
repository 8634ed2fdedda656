//! Rules of Bevy that views repeat. `docs/internals/porting.md` has them all.

// - `unfit_items.rs`: removes phase items of other crates that no longer fit a changed camera.

pub(super) mod unfit_items;
