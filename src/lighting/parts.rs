//! Parts of lighting that pipelines skip where a view does not need them.

use bevy::pbr::MeshPipelineKey;
use bitflags::bitflags;

use super::features::{LightingKey, ShadowMaps};
use crate::view::LightingIo;

bitflags! {
    /// Parts of lighting, with the bits of `parts.wgsl`. Other parts need no bit: without lights, decals or words of optional
    /// targets, their loops and branches do nothing.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct LightingParts: u32 {
        /// Environment maps and reflection probes.
        const ENVIRONMENT_MAP = 1 << 0;
        /// Irradiance volumes.
        const IRRADIANCE_VOLUME = 1 << 1;
        /// Bevy's ambient occlusion.
        const SCREEN_SPACE_AMBIENT_OCCLUSION = 1 << 2;
        /// Bevy's contact shadows.
        const CONTACT_SHADOWS = 1 << 3;
        /// Fog.
        const DISTANCE_FOG = 1 << 4;
        /// The atmosphere between the sun and the surface.
        const ATMOSPHERE = 1 << 5;
        /// Lights with shadow maps, whose bias needs the geometric normal.
        const SHADOW_MAPS = 1 << 6;
        /// Layers of lights.
        const LIGHT_LAYERS = 1 << 7;
        /// Output of the diffuse light.
        const DIFFUSE_LIGHT = 1 << 8;
        /// Reflections of an effect.
        const INDIRECT_SPECULAR = 1 << 9;
        /// Diffuse light of an effect.
        const INDIRECT_DIFFUSE = 1 << 10;
        /// The crate's ambient occlusion.
        const AMBIENT_OCCLUSION = 1 << 11;
        /// Output of the light that enters scattering surfaces.
        const SCATTERS_LIGHT = 1 << 12;
        /// The filter of shadow maps, a setting of the camera: Gaussian.
        const GAUSSIAN_SHADOWS = 1 << 13;
        /// The same: temporal.
        const TEMPORAL_SHADOWS = 1 << 14;
        /// A setting of ambient occlusion: [`LightingIo::OCCLUSION_WIDE`].
        const OCCLUSION_WIDE = 1 << 15;
        /// [`LightingIo::OCCLUSION_EDGE_AWARE`].
        const OCCLUSION_EDGE_AWARE = 1 << 16;
        /// [`LightingIo::OCCLUSION_HALF`].
        const OCCLUSION_HALF = 1 << 17;
        /// [`LightingIo::OCCLUSION_MULTIBOUNCE`].
        const OCCLUSION_MULTIBOUNCE = 1 << 18;
        /// [`LightingIo::OCCLUSION_OF_DIRECT_LIGHT`].
        const OCCLUSION_OF_DIRECT_LIGHT = 1 << 19;
    }
}

impl LightingKey {
    /// The parts that a view with this key needs.
    pub(crate) fn parts(self) -> LightingParts {
        use MeshPipelineKey as View;
        let view = |bit| self.view.contains(bit);
        let io = |what| self.io.contains(what);
        let shadow_filter = self.view & View::SHADOW_FILTER_METHOD_RESERVED_BITS;
        [
            (view(View::ENVIRONMENT_MAP), LightingParts::ENVIRONMENT_MAP),
            (
                view(View::IRRADIANCE_VOLUME),
                LightingParts::IRRADIANCE_VOLUME,
            ),
            (
                view(View::SCREEN_SPACE_AMBIENT_OCCLUSION),
                LightingParts::SCREEN_SPACE_AMBIENT_OCCLUSION,
            ),
            (view(View::CONTACT_SHADOWS), LightingParts::CONTACT_SHADOWS),
            (view(View::DISTANCE_FOG), LightingParts::DISTANCE_FOG),
            (view(View::ATMOSPHERE), LightingParts::ATMOSPHERE),
            (
                self.shadow_maps.intersects(ShadowMaps::OF_ANY_LIGHT),
                LightingParts::SHADOW_MAPS,
            ),
            (self.light_layers, LightingParts::LIGHT_LAYERS),
            (io(LightingIo::DIFFUSE_LIGHT), LightingParts::DIFFUSE_LIGHT),
            (
                io(LightingIo::INDIRECT_SPECULAR),
                LightingParts::INDIRECT_SPECULAR,
            ),
            (
                io(LightingIo::INDIRECT_DIFFUSE),
                LightingParts::INDIRECT_DIFFUSE,
            ),
            (
                io(LightingIo::AMBIENT_OCCLUSION),
                LightingParts::AMBIENT_OCCLUSION,
            ),
            (self.scatters, LightingParts::SCATTERS_LIGHT),
            (
                shadow_filter == View::SHADOW_FILTER_METHOD_GAUSSIAN,
                LightingParts::GAUSSIAN_SHADOWS,
            ),
            (
                shadow_filter == View::SHADOW_FILTER_METHOD_TEMPORAL,
                LightingParts::TEMPORAL_SHADOWS,
            ),
            (
                io(LightingIo::OCCLUSION_WIDE),
                LightingParts::OCCLUSION_WIDE,
            ),
            (
                io(LightingIo::OCCLUSION_EDGE_AWARE),
                LightingParts::OCCLUSION_EDGE_AWARE,
            ),
            (
                io(LightingIo::OCCLUSION_HALF),
                LightingParts::OCCLUSION_HALF,
            ),
            (
                io(LightingIo::OCCLUSION_MULTIBOUNCE),
                LightingParts::OCCLUSION_MULTIBOUNCE,
            ),
            (
                io(LightingIo::OCCLUSION_OF_DIRECT_LIGHT),
                LightingParts::OCCLUSION_OF_DIRECT_LIGHT,
            ),
        ]
        .into_iter()
        .filter_map(|(is_needed, part)| is_needed.then_some(part))
        .collect()
    }
}
