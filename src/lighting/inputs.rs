//! The inputs of lighting, per view and of the scene.

use bevy::{
    light::IrradianceVolume,
    pbr::{
        AreaLightLuts, Bluenoise, DfgLut, FogMeta, GlobalClusterableObjectMeta, LightMeta,
        LightProbesBuffer, RenderViewLightProbes, ScreenSpaceAmbientOcclusionResources,
        ShadowSamplers, ViewClusterBindings, ViewContactShadowsUniformOffset, ViewFogUniformOffset,
        ViewLightProbesUniformOffset, ViewLightsUniformOffset, ViewShadowBindings,
        contact_shadows::ContactShadowsBuffer,
        decal::clustered::{DecalsBuffer, RenderClusteredDecals},
        resources::{AtmosphereSampler, AtmosphereTextures},
    },
    prelude::*,
    render::{
        globals::GlobalsBuffer,
        render_asset::RenderAssets,
        render_resource::TextureView,
        texture::{FallbackImage, FallbackImageZero, GpuImage},
        view::{ViewDepthTexture, ViewTarget, ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    bevy::soft_shadows::BlockerSampler, buffers::LightingBuffers, features::ViewEnvironmentMaps,
    parts::LightingParts, state::ViewLighting, subsurface_light::SubsurfaceLight,
};
use crate::{
    gbuffer::GBufferTextures,
    gpu::named::{query_item, system_param},
    view::{AmbientOcclusion, DiffuseLight, IndirectDiffuse, IndirectSpecular, LightingIo},
};

query_item! {
    /// The parts of a view that lighting reads.
    pub(super) struct LitViewItem<'w, 's>: LitView {
        pub(super) lighting: &'static mut ViewLighting,
        pub(super) gbuffer: &'static GBufferTextures,
        pub(super) depth: &'static ViewDepthTexture,
        pub(super) target: &'static ViewTarget,
        pub(super) shadows: &'static ViewShadowBindings,
        pub(super) clusters: &'static ViewClusterBindings,
        pub(super) ssao: Option<&'static ScreenSpaceAmbientOcclusionResources>,
        pub(super) ambient_occlusion: Option<&'static AmbientOcclusion>,
        pub(super) diffuse_light: Option<&'static DiffuseLight>,
        pub(super) subsurface_light: Option<&'static SubsurfaceLight>,
        pub(super) indirect_specular: Option<&'static IndirectSpecular>,
        pub(super) indirect_diffuse: Option<&'static IndirectDiffuse>,
        pub(super) atmosphere: Option<&'static AtmosphereTextures>,
        pub(super) environment_maps: Option<&'static ViewEnvironmentMaps>,
        pub(super) irradiance_volumes: Option<&'static RenderViewLightProbes<IrradianceVolume>>,
        pub(super) view_offset: &'static ViewUniformOffset,
        pub(super) lights_offset: &'static ViewLightsUniformOffset,
        pub(super) probes_offset: &'static ViewLightProbesUniformOffset,
        pub(super) fog_offset: Option<&'static ViewFogUniformOffset>,
        pub(super) contact_shadows_offset: Option<&'static ViewContactShadowsUniformOffset>,
    }
}

impl LitViewItem<'_, '_> {
    /// True if lighting needs this part for the view. Otherwise a pipeline that has the part binds placeholders for it.
    pub(super) fn needs(&self, part: LightingParts) -> bool {
        self.lighting.parts.contains(part)
    }

    /// The texture of one kind of indirect light, if an effect provides it.
    pub(super) fn screen_space_light(&self, kind: LightingIo) -> Option<&TextureView> {
        match kind {
            LightingIo::INDIRECT_SPECULAR => self.indirect_specular?.0.as_ref(),
            _ => self.indirect_diffuse?.texture.as_ref(),
        }
    }
}

system_param! {
    /// The parts of the scene that lighting reads.
    pub(super) struct LightingResources<'w> {
        pub(super) buffers: Res<'w, LightingBuffers>,
        pub(super) view_uniforms: Res<'w, ViewUniforms>,
        pub(super) lights: Res<'w, LightMeta>,
        pub(super) shadow_samplers: Res<'w, ShadowSamplers>,
        pub(super) blocker_sampler: Res<'w, BlockerSampler>,
        pub(super) clustered: Res<'w, GlobalClusterableObjectMeta>,
        pub(super) globals: Res<'w, GlobalsBuffer>,
        pub(super) probes: Res<'w, LightProbesBuffer>,
        pub(super) fog: Res<'w, FogMeta>,
        pub(super) contact_shadows: Res<'w, ContactShadowsBuffer>,
        pub(super) atmosphere_sampler: Option<Res<'w, AtmosphereSampler>>,
        pub(super) blue_noise: Res<'w, Bluenoise>,
        pub(super) area_light_luts: Res<'w, AreaLightLuts>,
        pub(super) dfg_lut: Res<'w, DfgLut>,
        pub(super) decals_buffer: Res<'w, DecalsBuffer>,
        pub(super) decals: Res<'w, RenderClusteredDecals>,
        pub(super) images: Res<'w, RenderAssets<GpuImage>>,
        pub(super) fallback: Res<'w, FallbackImage>,
        pub(super) fallback_zero: Res<'w, FallbackImageZero>,
    }
}
