//! The crate's own buffers of the lighting pass.

use bevy::{
    camera::{MainPassResolutionOverride, visibility::RenderLayers},
    light::IrradianceVolume,
    pbr::{RenderViewLightProbes, resources::GpuAtmosphere},
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{DynamicUniformBuffer, ShaderType, StorageBuffer},
        renderer::{RenderDevice, RenderQueue},
        view::{ExtractedView, ViewTarget},
    },
};

use super::{
    bevy::{
        background::{background, lit_pixels, target_size},
        light_order::LightOrder,
    },
    features::ViewEnvironmentMaps,
    light_layer_table::LightLayersTable,
    light_layers::LightLayers,
    state::ViewLighting,
};
use crate::{
    shader_library::reconstruction::position::edge_of,
    view::{ActiveLeanView, AmbientOcclusion, IndirectDiffuse, LeanDebugView},
};

/// Parameters of a view for the lighting shader, beside Bevy's uniforms.
#[derive(ShaderType, Reflect, Clone, Copy, Debug, Default)]
#[reflect(no_auto_register)]
pub struct LightingUniform {
    background: Vec4,
    viewport_origin: UVec2,
    viewport_size: UVec2,
    edge: Vec2,
    writes_background: u32,
    depth_tells_geometry: u32,
    occlusion_edge: Vec3,
    occlusion_intensity: f32,
    occlusion_of_direct_light: f32,
    occlusion_of_baked_light: f32,
    debug_columns: u32,
    parts: u32,
    diffuse_is_half: u32,
}

/// The crate's own buffers, one for all views.
#[derive(Resource, Default)]
pub(super) struct LightingBuffers {
    pub(super) uniforms: DynamicUniformBuffer<LightingUniform>,
    /// Bevy's own copy is private. `None` unless a lean view has an atmosphere.
    pub(super) atmosphere: Option<StorageBuffer<GpuAtmosphere>>,
}

/// Fills [`LightingBuffers`] for the views of this frame.
pub(super) fn write_lighting_buffers(
    mut buffers: ResMut<LightingBuffers>,
    render_device: Res<RenderDevice>,
    render_queue: Res<RenderQueue>,
    clear_color: Res<ClearColor>,
    mut views: Query<(
        &mut ViewLighting,
        (&ExtractedCamera, &ExtractedView),
        (&ViewTarget, &ActiveLeanView),
        (
            Option<&AmbientOcclusion>,
            Option<&IndirectDiffuse>,
            Option<&LeanDebugView>,
        ),
        Option<&MainPassResolutionOverride>,
        Option<&GpuAtmosphere>,
    )>,
) {
    let buffers = &mut *buffers;
    if views.is_empty() {
        buffers.atmosphere = None;
        return;
    }
    if let Some(atmosphere) = views.iter().find_map(|(.., atmosphere)| atmosphere) {
        let buffer = buffers
            .atmosphere
            .get_or_insert_with(|| StorageBuffer::from(atmosphere.clone()));
        buffer.set(atmosphere.clone());
        buffer.write_buffer(&render_device, &render_queue);
    } else {
        buffers.atmosphere = None;
    }

    let count = 2 * views.iter().len();
    let Some(mut writer) = buffers
        .uniforms
        .get_writer(count, &render_device, &render_queue)
    else {
        return;
    };
    for (mut lighting, (camera, view), (target, active), of_view, resolution, _) in &mut views {
        let (occlusion, diffuse, debug_view) = of_view;
        let target_size = target_size(target);
        let (origin, size) = lit_pixels(camera, target, resolution);
        let uniform = LightingUniform {
            background: background(camera, &clear_color),
            viewport_origin: origin,
            viewport_size: size,
            edge: edge_of(view.clip_from_view, size),
            writes_background: 0,
            depth_tells_geometry: active.depth_tells_geometry.into(),
            occlusion_edge: occlusion.map_or(Vec3::ZERO, |found| found.edge),
            occlusion_intensity: occlusion.map_or(0.0, |found| found.intensity),
            occlusion_of_direct_light: occlusion.map_or(0.0, |found| found.of_direct_light),
            occlusion_of_baked_light: occlusion.map_or(0.0, |found| found.of_baked_light),
            debug_columns: debug_view.map_or(0, |view| view.columns(size.x)),
            parts: lighting.parts.bits(),
            diffuse_is_half: diffuse.is_some_and(|light| light.is_half).into(),
        };
        lighting.bindings.uniform_offsets = [0, 1].map(|writes_background| {
            writer.write(&LightingUniform {
                writes_background,
                ..uniform
            })
        });
        lighting.bindings.viewport_size = size;
        lighting.bindings.covers_target = origin == UVec2::ZERO && size == target_size;
    }
}

/// Uploads the layers of lights for the views whose lighting is compiled for them: a table per view, written when it has
/// changed.
pub(super) fn write_light_layers(
    (layers, order): (Res<LightLayers>, LightOrder),
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    mut views: Query<(
        &mut ViewLighting,
        Option<&ActiveLeanView>,
        Option<&RenderLayers>,
        Option<&ViewEnvironmentMaps>,
        Option<&RenderViewLightProbes<IrradianceVolume>>,
    )>,
    mut table: Local<LightLayersTable>,
) {
    let mut has_common = false;
    for (mut lighting, active, view_layers, environment_maps, volumes) in &mut views {
        if !active.is_some_and(|active| active.has_light_layers) {
            lighting.light_layers = None;
            continue;
        }
        if !has_common {
            table.fill_common(&layers, &order);
            has_common = true;
        }
        let view_layers = view_layers.unwrap_or_default();
        table.fill_of_view(&layers, &order, view_layers, environment_maps, volumes);
        let buffer = lighting.light_layers.get_or_insert_default();
        if buffer.buffer().is_none() || *buffer.get() != *table {
            buffer.set(table.clone());
            buffer.write_buffer(&device, &queue);
        }
    }
}
