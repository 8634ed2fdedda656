//! Layouts of bind groups of the lighting pass.

use bevy::{
    pbr::{MeshPipeline, MeshPipelineKey, MeshPipelineViewLayoutKey},
    render::render_resource::{
        BindGroupLayoutDescriptor, PipelineCache, SamplerBindingType, ShaderStages,
        StorageTextureAccess, TextureFormat, TextureSampleType,
        binding_types::{
            sampler, storage_buffer_read_only, storage_buffer_sized, texture_2d,
            texture_storage_2d, uniform_buffer,
        },
    },
};

use super::{
    bevy::{
        binding_numbers::{arrays, view},
        definitions::{BevyBinding, VIEW_FLAGS},
    },
    binding_numbers::targets,
    buffers::LightingUniform,
    diffuse_light::DIFFUSE_LIGHT_FORMAT,
    features::{LightingKey, ShadowMaps},
    light_layer_table::LightLayersTable,
    subsurface_light::{SUBSURFACE_LIGHT_FORMAT, SUBSURFACE_PICTURE_FORMAT},
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
    pub(super) list: Option<ResolvedLayout>,
}

impl LightingLayouts {
    /// Creates the layouts of [`descriptors`].
    pub(super) fn new(
        pipeline_cache: &PipelineCache,
        [view, arrays, targets]: [BindGroupLayoutDescriptor; 3],
        key: LightingKey,
        list: Option<ResolvedLayout>,
    ) -> Self {
        Self {
            view: ResolvedLayout::new(pipeline_cache, view),
            arrays: ResolvedLayout::new(pipeline_cache, arrays),
            targets: ResolvedLayout::new(pipeline_cache, targets),
            read_targets: key.targets,
            io: key.io,
            scatters: key.scatters,
            list,
        }
    }

    pub(super) fn has_light_layers(&self) -> bool {
        self.has_target_binding(targets::LIGHT_LAYERS)
    }

    fn has_target_binding(&self, binding: u32) -> bool {
        let mut bindings = self.targets.descriptor().entries.iter();
        bindings.any(|entry| entry.binding == binding)
    }

    pub(super) fn has_binding(&self, binding: BevyBinding) -> bool {
        let (layout, binding) = match binding {
            BevyBinding::View(binding) => (&self.view, binding),
            BevyBinding::Arrays(binding) => (&self.arrays, binding),
        };
        let mut entries = layout.descriptor().entries.iter();
        entries.any(|entry| entry.binding == binding)
    }
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

/// The keys that Bevy's mesh pipeline would have for the view: together, their layouts and definitions are those of `key`. The
/// G-buffer's own depth takes the place of prepass depth in Bevy's shaders. General pipelines have more textures than
/// fragment shaders may have on some devices, of which Bevy warns, so each flag has a key of its own there.
pub(super) fn bevys_keys(key: LightingKey) -> Vec<MeshPipelineKey> {
    if !key.is_general {
        return vec![key.view | MeshPipelineKey::DEPTH_PREPASS];
    }
    let without_flags = VIEW_FLAGS
        .into_iter()
        .fold(key.view, MeshPipelineKey::difference);
    let flags = VIEW_FLAGS
        .into_iter()
        .filter(|flag| key.view.contains(*flag));
    core::iter::once(MeshPipelineKey::empty())
        .chain(flags)
        .map(|flag| without_flags | flag | MeshPipelineKey::DEPTH_PREPASS)
        .collect()
}

/// Bevy's layouts of bind groups 0 and 1 of the view.
fn bevys_layouts(mesh_pipeline: &MeshPipeline, key: LightingKey) -> [BindGroupLayoutDescriptor; 2] {
    let mut layouts = [
        BindGroupLayoutDescriptor::new("lean_deferred/lighting/view", &[]),
        BindGroupLayoutDescriptor::new("lean_deferred/lighting/arrays", &[]),
    ];
    for key in bevys_keys(key) {
        let bevys = mesh_pipeline.get_view_layout(MeshPipelineViewLayoutKey::from(key));
        let bevys = [bevys.main_layout, bevys.binding_array_layout];
        for (layout, bevys) in layouts.iter_mut().zip(bevys) {
            for entry in bevys.entries {
                let mut known = layout.entries.iter();
                if known.all(|known| known.binding != entry.binding) {
                    layout.entries.push(entry);
                }
            }
        }
    }
    for layout in &mut layouts {
        // Dynamic offsets are passed in this order.
        layout.entries.sort_unstable_by_key(|entry| entry.binding);
    }
    layouts
}

/// Layouts of bind groups 0 to 2. Those of the first two derive from Bevy's: visible to compute, without bindings that
/// lighting does not read or that the view lacks.
pub(super) fn descriptors(
    mesh_pipeline: &MeshPipeline,
    key: LightingKey,
) -> [BindGroupLayoutDescriptor; 3] {
    let [mut view_layout, mut arrays_layout] = bevys_layouts(mesh_pipeline, key);
    view_layout.entries.retain(|entry| {
        !view::UNUSED.contains(&entry.binding)
            && (key.rect_lights
                || ![view::AREA_LIGHT_LUTS, view::AREA_LIGHT_LUTS_SAMPLER].contains(&entry.binding))
            && (key.shadow_maps.contains(ShadowMaps::SOFT)
                || ![
                    view::POINT_SHADOW_TEXTURES_LINEAR_SAMPLER,
                    view::DIRECTIONAL_SHADOW_TEXTURES_LINEAR_SAMPLER,
                ]
                .contains(&entry.binding))
    });
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
    [view_layout, arrays_layout, targets_layout(key)]
}
