//! The state that a prewarmed camera will have in its level.

use bevy::render::render_resource::PipelineCache;

use super::inputs::RequestedViewItem;
use crate::{
    gbuffer::MotionResolvePipelines,
    gpu::pipeline_watch::PipelineWatch,
    view::{ActiveLeanView, LightingIo, PrewarmFeatures, PrewarmedCamera, PrewarmedView},
};

/// The states of a view, drawn in this `order`, on which all meshes of the level are visible: with light that scatters, if some of
/// them scatter it, and without. Sets that of the `camera`.
pub(super) fn states_of_level(
    view: &RequestedViewItem,
    order: ActiveLeanView,
    camera: &mut PrewarmedCamera,
) -> impl Iterator<Item = ActiveLeanView> {
    let features = camera.all_features();
    let has_light_layers =
        order.has_light_layers || features.contains(PrewarmFeatures::LIGHT_LAYERS);
    let meshes = PrewarmedView {
        has_motion: has_motion(view, features),
        has_light_layers,
        culls_in_two_phases: order.culls_in_two_phases,
    };
    camera.view = Some(meshes);
    let io = LightingIo::asked(view.io) - LightingIo::SUBSURFACE_LIGHT;
    let scatters = (camera.scatters).then_some(io | LightingIo::SUBSURFACE_LIGHT);
    let demand = camera.demand;
    core::iter::once(io).chain(scatters).map(move |io| {
        let state = ActiveLeanView {
            resolves_motion: meshes.has_motion,
            has_light_layers,
            io,
            ..order
        };
        let demand = demand.on(&state);
        ActiveLeanView {
            has_light_layers: order.has_light_layers,
            targets: demand.targets,
            variants: demand.variants,
            ..state
        }
    })
}

/// True if the view resolves motion, now or with these features.
fn has_motion(view: &RequestedViewItem, features: PrewarmFeatures) -> bool {
    let is_asked = view.motion_prepass || features.contains(PrewarmFeatures::MOTION_VECTORS);
    is_asked && !view.normal_prepass
}

/// Queues the pipelines that resolve motion, if the view will need them.
pub(super) fn request_motion(
    view: &RequestedViewItem,
    features: PrewarmFeatures,
    in_two_phases: bool,
    pipelines: Option<&mut MotionResolvePipelines>,
    (cache, watch): (&PipelineCache, &PipelineWatch),
) {
    if let Some(pipelines) = pipelines.filter(|_| has_motion(view, features)) {
        pipelines.are_ready(cache, watch, in_two_phases);
    }
}
