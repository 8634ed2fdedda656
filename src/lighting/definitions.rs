//! The shader definitions of lighting.

use std::collections::BTreeSet;

use bevy::shader::ShaderDefVal;

use super::{
    bevy::definitions::name_of,
    features::{ClusteredLights, LightingKey, ShadowMaps},
    implied::implied_by,
};
use crate::{
    gpu::shader_defs,
    shading_models::MODELS,
    view::{DebugView, GBufferTargets, LightCulling, LightingIo},
};

/// The definitions that fields of `key` set, each with its condition. [`implied_by`] adds those that follow.
fn table(key: LightingKey) -> impl IntoIterator<Item = (bool, &'static str)> {
    let lights = |kinds| key.clustered_lights.contains(kinds);
    let casts = |kinds| key.shadow_maps.contains(kinds);
    let culling = key.light_culling;
    let io = |what| key.io.contains(what);
    [
        (lights(ClusteredLights::ANY), "CLUSTERED_LIGHTS"),
        (lights(ClusteredLights::SPOT), "SPOT_LIGHTS"),
        (lights(ClusteredLights::SPHERE), "SPHERE_LIGHTS"),
        (casts(ShadowMaps::DIRECTIONAL), "DIRECTIONAL_SHADOW_MAPS"),
        (
            casts(ShadowMaps::SEVERAL_DIRECTIONAL),
            "SEVERAL_DIRECTIONAL_SHADOW_MAPS",
        ),
        (casts(ShadowMaps::POINT), "POINT_SHADOW_MAPS"),
        (casts(ShadowMaps::SPOT), "SPOT_SHADOW_MAPS"),
        (casts(ShadowMaps::SOFT), "SOFT_SHADOWS"),
        (culling != LightCulling::PerPixel, "LIGHT_CULLING"),
        (
            culling == LightCulling::Subgroup,
            "LIGHT_CULLING_BY_SUBGROUPS",
        ),
        (key.light_layers, "LIGHT_LAYERS"),
        (key.is_general, "SUPERSET"),
        (io(LightingIo::DIFFUSE_LIGHT), "DIFFUSE_LIGHT"),
        (key.scatters, "SCATTERS_LIGHT"),
        (io(LightingIo::INDIRECT_SPECULAR), "INDIRECT_SPECULAR"),
        (io(LightingIo::INDIRECT_DIFFUSE), "INDIRECT_DIFFUSE"),
        (io(LightingIo::AMBIENT_OCCLUSION), "LEAN_AMBIENT_OCCLUSION"),
        // The dispatch over all tiles lists those with special surfaces; another one lights the list.
        (key.lists, "LISTED_VARIANTS"),
        (!key.shaded.is_empty(), "VISITED_VARIANTS"),
        // Not `LIGHTMAP`: with it, Bevy's functions assume that all surfaces have one.
        (key.lightmaps, "LIGHTMAPPED_SURFACES"),
    ]
}

/// The definitions of the lighting shader for `key`, given those of Bevy's that it reads.
pub(super) fn definitions(key: LightingKey, bevys: Vec<ShaderDefVal>) -> Vec<ShaderDefVal> {
    let models = MODELS.iter().filter(|model| key.shaded.have(model.model));
    let names = (key.projection.shader_def().into_iter())
        .chain(key.targets.iter().map(GBufferTargets::shader_def))
        .chain(key.debug_view.and_then(DebugView::shader_def))
        .chain(models.filter_map(|model| model.shader_def))
        .chain(key.io.occlusion_defs());
    let mut defs: Vec<ShaderDefVal> = shader_defs::of_table(table(key))
        .chain(names.map(ShaderDefVal::from))
        .chain(bevys)
        .collect();
    let implied = defs.iter().flat_map(|def| implied_by(name_of(def)));
    let implied: BTreeSet<&str> = implied.copied().collect();
    defs.extend(implied.into_iter().map(ShaderDefVal::from));
    defs
}
