//! Layouts and pipelines of the lighting pass.

use bevy::{
    asset::load_embedded_asset,
    pbr::{MeshPipeline, MeshPipelineKey, MeshPipelineViewLayoutKey},
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_resource::{
            BindGroupLayoutDescriptor, CachedComputePipelineId, ComputePipelineDescriptor,
            PipelineCache, Sampler, SamplerBindingType, SamplerDescriptor, ShaderStages,
            StorageTextureAccess, TextureFormat, TextureSampleType,
            binding_types::{
                sampler, storage_buffer_read_only, storage_buffer_sized, texture_2d,
                texture_storage_2d, uniform_buffer,
            },
        },
        renderer::RenderDevice,
    },
    shader::ShaderDefVal,
};

use super::{
    bevy::{
        binding_numbers::{arrays, view},
        definitions::{self as bevy_definitions, BevyBinding, read_by_lighting},
    },
    binding_numbers::targets,
    buffers::LightingUniform,
    definitions::definitions,
    diffuse_light::DIFFUSE_LIGHT_FORMAT,
    features::{LightingKey, ShadowMaps},
    light_layer_table::LightLayersTable,
    subsurface_light::{SUBSURFACE_LIGHT_FORMAT, SUBSURFACE_PICTURE_FORMAT},
    tile_list::{filling_layout, reading_layout},
};
use crate::{
    gpu::{bind_group_cache::ResolvedLayout, bindings::layout},
    view::{GBufferTargets, LightingIo},
};

/// The layouts of bind groups 0 (view), 1 (probes and decals) and 2 (G-buffer and output), which all variants of a view
/// share.
#[derive(Clone)]
pub(super) struct LightingLayouts {
    pub(super) view: ResolvedLayout,
    pub(super) arrays: ResolvedLayout,
    pub(super) targets: ResolvedLayout,
    /// The optional targets in bind group 2.
    pub(super) read_targets: GBufferTargets,
    /// Effects whose textures are in bind group 2.
    pub(super) io: LightingIo,
    pub(super) scatters: bool,
    /// Bind group 3, on views with special surfaces.
    list: Option<ResolvedLayout>,
}

impl LightingLayouts {
    pub(super) fn has_light_layers(&self) -> bool {
        self.has_target_binding(targets::LIGHT_LAYERS)
    }

    fn has_target_binding(&self, binding: u32) -> bool {
        let mut bindings = self.targets.descriptor().entries.iter();
        bindings.any(|entry| entry.binding == binding)
    }

    fn has_binding(&self, binding: BevyBinding) -> bool {
        let (layout, binding) = match binding {
            BevyBinding::View(binding) => (&self.view, binding),
            BevyBinding::Arrays(binding) => (&self.arrays, binding),
        };
        let mut entries = layout.descriptor().entries.iter();
        entries.any(|entry| entry.binding == binding)
    }
}

/// Lighting pipelines by key, created by `init_lighting_pipelines`.
#[derive(Resource)]
pub(crate) struct LightingPipelines {
    mesh_pipeline: MeshPipeline,
    shader: Handle<Shader>,
    by_key: HashMap<LightingKey, (CachedComputePipelineId, LightingLayouts)>,
    /// Gathers texels of ambient occlusion.
    pub(super) nearest_sampler: Sampler,
    pub(super) filling_list: ResolvedLayout,
    pub(super) reading_list: ResolvedLayout,
}

pub(super) fn init_lighting_pipelines(
    mut commands: Commands,
    mesh_pipeline: Res<MeshPipeline>,
    asset_server: Res<AssetServer>,
    pipeline_cache: Res<PipelineCache>,
    render_device: Res<RenderDevice>,
) {
    commands.insert_resource(LightingPipelines {
        mesh_pipeline: mesh_pipeline.clone(),
        shader: load_embedded_asset!(asset_server.as_ref(), "lighting.wgsl"),
        by_key: HashMap::default(),
        nearest_sampler: render_device.create_sampler(&SamplerDescriptor {
            label: Some("lean_deferred/lighting/nearest"),
            ..default()
        }),
        filling_list: ResolvedLayout::new(&pipeline_cache, filling_layout()),
        reading_list: ResolvedLayout::new(&pipeline_cache, reading_layout()),
    });
}

/// Bindings in bind group 2 of indirect light that other effects provide.
pub(super) const INDIRECT_LIGHT: [(LightingIo, u32); 2] = [
    (
        LightingIo::INDIRECT_SPECULAR,
        targets::INDIRECT_SPECULAR_TEXTURE,
    ),
    (
        LightingIo::INDIRECT_DIFFUSE,
        targets::INDIRECT_DIFFUSE_TEXTURE,
    ),
];

/// The binding in bind group 2 of an optional target.
pub(super) fn target_binding(target: GBufferTargets) -> u32 {
    targets::EMISSIVE_TEXTURE + target.bits().trailing_zeros()
}

/// The layout of bind group 2: the G-buffer, the output, the crate's uniform, and the optional resources that the key
/// needs.
fn targets_layout(key: LightingKey) -> BindGroupLayoutDescriptor {
    let words = || texture_2d(TextureSampleType::Uint);
    let output = texture_storage_2d(TextureFormat::Rgba16Float, StorageTextureAccess::WriteOnly);
    let mut entries = vec![
        (targets::SURFACE_TEXTURE, words()),
        (targets::NORMAL_TEXTURE, words()),
        (targets::OUTPUT_TEXTURE, output),
        (targets::UNIFORMS, uniform_buffer::<LightingUniform>(true)),
    ];
    if key.io.contains(LightingIo::AMBIENT_OCCLUSION) {
        let occlusion = texture_2d(TextureSampleType::Float { filterable: false });
        entries.extend([
            (
                targets::NEAREST_SAMPLER,
                sampler(SamplerBindingType::NonFiltering),
            ),
            (targets::OCCLUSION_TEXTURE, occlusion),
        ]);
    }
    if key.light_layers {
        let table = storage_buffer_read_only::<LightLayersTable>(false);
        entries.push((targets::LIGHT_LAYERS, table));
    }
    if !key.targets.is_empty() {
        entries.push((targets::VALID_MASK_TEXTURE, words()));
    }
    if key.io.contains(LightingIo::DIFFUSE_LIGHT) {
        let output = texture_storage_2d(DIFFUSE_LIGHT_FORMAT, StorageTextureAccess::WriteOnly);
        entries.push((targets::DIFFUSE_LIGHT_TEXTURE, output));
    }
    if key.scatters {
        let stored = |format| texture_storage_2d(format, StorageTextureAccess::WriteOnly);
        entries.extend([
            (
                targets::SUBSURFACE_LIGHT_TEXTURE,
                stored(SUBSURFACE_LIGHT_FORMAT),
            ),
            (
                targets::SUBSURFACE_PICTURE_TEXTURE,
                stored(SUBSURFACE_PICTURE_FORMAT),
            ),
            (targets::SCATTERING_TILES, storage_buffer_sized(false, None)),
        ]);
    }
    for (found, binding) in INDIRECT_LIGHT {
        if key.io.contains(found) {
            let light = texture_2d(TextureSampleType::Float { filterable: false });
            entries.push((binding, light));
        }
    }
    entries.extend(
        key.targets
            .into_iter()
            .map(|target| (target_binding(target), words())),
    );
    layout(
        "lean_deferred/lighting/targets",
        ShaderStages::COMPUTE,
        entries,
    )
}

/// The key that Bevy's mesh pipeline would have for the view. The G-buffer's own depth takes the place of prepass depth
/// in Bevy's shaders.
fn bevys_key(key: LightingKey) -> MeshPipelineKey {
    key.view | MeshPipelineKey::DEPTH_PREPASS
}

impl LightingPipelines {
    /// Returns the pipeline for `key`, which may still be compiling.
    pub(crate) fn specialize(
        &mut self,
        pipeline_cache: &PipelineCache,
        key: LightingKey,
    ) -> CachedComputePipelineId {
        if let Some((id, _)) = self.by_key.get(&key) {
            return *id;
        }
        let layouts = self.layouts(pipeline_cache, key);
        let id = pipeline_cache.queue_compute_pipeline(ComputePipelineDescriptor {
            label: Some("lean_deferred/lighting".into()),
            layout: [&layouts.view, &layouts.arrays, &layouts.targets]
                .into_iter()
                .chain(&layouts.list)
                .map(|layout| layout.descriptor().clone())
                .collect(),
            shader: self.shader.clone(),
            shader_defs: self.shader_defs(key, &layouts),
            entry_point: Some("main".into()),
            ..default()
        });
        self.by_key.insert(key, (id, layouts));
        id
    }

    /// Returns the pipelines of all dispatches for `key` if they are compiled. Does not queue missing ones.
    pub(crate) fn compiled(
        &self,
        pipeline_cache: &PipelineCache,
        key: LightingKey,
    ) -> Option<Vec<(LightingKey, CachedComputePipelineId)>> {
        key.dispatches()
            .map(|key| {
                let (id, _) = self.by_key.get(&key)?;
                pipeline_cache.get_compute_pipeline(*id)?;
                Some((key, *id))
            })
            .collect()
    }

    pub(super) fn layouts_of(&self, key: LightingKey) -> Option<&LightingLayouts> {
        self.by_key.get(&key).map(|(_, layouts)| layouts)
    }

    /// Derives the layouts from Bevy's view layouts: visible to compute, without bindings that lighting does not read
    /// or that the view lacks.
    fn layouts(&self, pipeline_cache: &PipelineCache, key: LightingKey) -> LightingLayouts {
        let layout_key = MeshPipelineViewLayoutKey::from(bevys_key(key));
        let bevy_layout = self.mesh_pipeline.get_view_layout(layout_key);

        let mut view_layout = bevy_layout.main_layout;
        view_layout.label = "lean_deferred/lighting/view".into();
        view_layout.entries.retain(|entry| {
            !view::UNUSED.contains(&entry.binding)
                && (key.rect_lights
                    || ![view::AREA_LIGHT_LUTS, view::AREA_LIGHT_LUTS_SAMPLER]
                        .contains(&entry.binding))
                && (key.shadow_maps.contains(ShadowMaps::SOFT)
                    || ![
                        view::POINT_SHADOW_TEXTURES_LINEAR_SAMPLER,
                        view::DIRECTIONAL_SHADOW_TEXTURES_LINEAR_SAMPLER,
                    ]
                    .contains(&entry.binding))
        });

        let mut arrays_layout = bevy_layout.binding_array_layout;
        arrays_layout.label = "lean_deferred/lighting/arrays".into();
        arrays_layout
            .entries
            .retain(|entry| key.decals || entry.binding < arrays::CLUSTERED_DECALS);

        for entry in view_layout
            .entries
            .iter_mut()
            .chain(&mut arrays_layout.entries)
        {
            entry.visibility = ShaderStages::COMPUTE;
        }
        LightingLayouts {
            view: ResolvedLayout::new(pipeline_cache, view_layout),
            arrays: ResolvedLayout::new(pipeline_cache, arrays_layout),
            targets: ResolvedLayout::new(pipeline_cache, targets_layout(key)),
            read_targets: key.targets,
            io: key.io,
            scatters: key.scatters,
            list: if !key.shaded.is_empty() {
                Some(self.reading_list.clone())
            } else if key.lists {
                Some(self.filling_list.clone())
            } else {
                None
            },
        }
    }

    fn shader_defs(&self, key: LightingKey, layouts: &LightingLayouts) -> Vec<ShaderDefVal> {
        let bevys = bevy_definitions::of_mesh_pipeline(&self.mesh_pipeline, bevys_key(key));
        let bevys = read_by_lighting(bevys, |binding| layouts.has_binding(binding));
        definitions(key, bevys)
    }
}
