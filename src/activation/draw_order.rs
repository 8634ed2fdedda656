//! Decides when and how the meshes of a view are drawn.

use bevy::camera::Camera3dDepthLoadOp;

use super::{
    foreign_depth::others_may_draw_depth,
    inputs::{DecisionInputs, RequestedViewItem},
};
use crate::{
    shader_library::reconstruction::position::depth_of_surfaces_is_above_zero,
    view::{ActiveLeanView, GBufferTargets, LightingIo, LightingVariants},
};

/// Decides the draw order of a view that can be lean. Its targets, variants, inputs and outputs of lighting stay empty.
pub(super) fn draw_order(view: &RequestedViewItem, inputs: &mut DecisionInputs) -> ActiveLeanView {
    let depth = view.depth_prepass;
    let normal = view.normal_prepass;
    let motion = view.motion_prepass;
    let draws_in_prepass = depth || normal || motion;
    let culls_in_two_phases =
        draws_in_prepass && view.occlusion_culling && !view.no_indirect_drawing;
    let resolves_motion = motion
        && !normal
        && (depth || !culls_in_two_phases)
        && can_resolve_motion(inputs, culls_in_two_phases);
    ActiveLeanView {
        draws_in_prepass,
        keeps_prepass: normal || (motion && !resolves_motion),
        resolves_motion,
        has_light_layers: inputs.scene.has_light_layers(view.settings, view.layers),
        targets: GBufferTargets::empty(),
        variants: LightingVariants::empty(),
        io: LightingIo::empty(),
        culls_in_two_phases,
        depth_tells_geometry: !draws_in_prepass && depth_tells_geometry(view),
    }
}

fn can_resolve_motion(inputs: &mut DecisionInputs, in_two_phases: bool) -> bool {
    let pipelines = inputs.motion_pipelines.as_mut();
    let (cache, watch) = (&inputs.pipeline_cache, &inputs.pipeline_watch);
    pipelines.is_some_and(|pipelines| pipelines.are_ready(cache, watch, in_two_phases))
}

/// True if, when lighting reads depth, it is above 0 exactly at pixels with a lean mesh.
fn depth_tells_geometry(view: &RequestedViewItem) -> bool {
    let starts_at_zero = view
        .camera_3d
        .is_some_and(|camera| matches!(camera.depth_load_op, Camera3dDepthLoadOp::Clear(0.0)));
    starts_at_zero
        && !view.is_read
        && depth_of_surfaces_is_above_zero(view.view.clip_from_view)
        && !others_may_draw_depth(view.visible)
}
