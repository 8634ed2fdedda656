//! The request for a history.

use bevy::prelude::*;

/// On a view of the render world: requests its history. Insert before `RenderSystems::PrepareViews`; remove once nothing reads it.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ReadsHistory;
