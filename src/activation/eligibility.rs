//! Decides which views can be lean.

use bevy::render::render_resource::TextureFormat;

use super::inputs::RequestedViewItem;
use crate::view::{Effect, EffectStatuses, LeanOffReason, OutOfMemory};

/// True if neither the camera nor the memory of the GPU speaks against the view. Otherwise its status is set to the
/// reason.
pub(super) fn is_eligible(
    view: &RequestedViewItem,
    memory: &OutOfMemory,
    statuses: &mut EffectStatuses,
) -> bool {
    let mut status = statuses.of(view.id().main_entity, Effect::Deferred);
    !status.is_off_for(reason_against(view)) && !status.is_off_by_memory(memory.label(view.entity))
}

fn reason_against(view: &RequestedViewItem) -> Option<LeanOffReason> {
    if !view.settings.enabled {
        return Some(LeanOffReason::Disabled);
    }
    let is_3d = view.camera_3d.is_some();
    let of_depth = LeanOffReason::against_reading_depth(view.camera, is_3d, view.msaa);
    if of_depth.is_some() {
        of_depth
    } else if !view.camera.hdr {
        Some(LeanOffReason::NotHdr)
    } else if view.view.target_format != TextureFormat::Rgba16Float {
        Some(LeanOffReason::Format(view.view.target_format))
    } else if view.deferred_prepass {
        Some(LeanOffReason::DeferredPrepass)
    } else {
        None
    }
}
