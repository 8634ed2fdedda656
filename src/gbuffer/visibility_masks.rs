//! Binds the visibility masks of meshes for the G-buffer's shaders: a uniform per set of layers, bound before each
//! batch. Meshes on different layers share a pipeline, though not a draw.

use bevy::{
    ecs::system::{SystemParamItem, lifetimeless::SRes},
    platform::collections::{HashMap, HashSet},
    prelude::*,
    render::{
        render_phase::{RenderCommand, RenderCommandResult, TrackedRenderPass},
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, DynamicUniformBuffer,
            PipelineCache, ShaderStages, binding_types::uniform_buffer,
        },
        renderer::{RenderDevice, RenderQueue},
    },
};

use super::{
    binding_numbers::pack::MESH_VISIBILITY_MASK, phase::DrawnGBufferPhases, phase_item::GBufferItem,
};
use crate::gpu::bindings::layout;

/// Binds the mask of the item.
pub(super) struct SetVisibilityMask<const I: usize>;

impl<const ALPHA_MASKED: bool, const I: usize> RenderCommand<GBufferItem<ALPHA_MASKED, true>>
    for SetVisibilityMask<I>
{
    type Param = SRes<VisibilityMasks>;
    type ViewQuery = ();
    type ItemQuery = ();

    fn render<'w>(
        item: &GBufferItem<ALPHA_MASKED, true>,
        _: (),
        _: Option<()>,
        masks: SystemParamItem<'w, '_, Self::Param>,
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        let masks = masks.into_inner();
        let (Some(group), Some(offset)) = (
            masks.bind_group.as_ref(),
            item.batch_set_key
                .visibility_mask
                .and_then(|mask| masks.offsets.get(&mask)),
        ) else {
            return RenderCommandResult::Failure("a visibility mask was not uploaded");
        };
        pass.set_bind_group(I, group, &[*offset]);
        RenderCommandResult::Success
    }
}

/// The masks that the meshes of all views write.
#[derive(Resource, Default)]
pub(super) struct VisibilityMasks {
    offsets: HashMap<u32, u32>,
    buffer: DynamicUniformBuffer<u32>,
    bind_group: Option<BindGroup>,
    is_uploaded: bool,
    /// Number of masks above which unused ones are dropped.
    limit: usize,
}

impl VisibilityMasks {
    /// Call for each mesh that writes a mask, before [`upload_visibility_masks`].
    pub(super) fn insert(&mut self, mask: u32) {
        let buffer = &mut self.buffer;
        self.offsets.entry(mask).or_insert_with(|| {
            self.is_uploaded = false;
            buffer.push(&mask)
        });
    }

    fn retain(&mut self, used: &HashSet<u32>) {
        self.offsets.clear();
        self.buffer.clear();
        for mask in used {
            self.insert(*mask);
        }
    }
}

/// The layout at `VISIBILITY_MASK_GROUP` of pipelines that write masks.
pub(super) fn visibility_mask_layout() -> BindGroupLayoutDescriptor {
    layout(
        "lean_deferred/gbuffer/visibility_mask",
        ShaderStages::FRAGMENT,
        [(MESH_VISIBILITY_MASK, uniform_buffer::<u32>(true))],
    )
}

/// Lower bound of that limit: with fewer masks, a search for unused ones is not worth its cost.
const SMALLEST_LIMIT: usize = 64;

/// Uploads the masks after meshes were queued, in frames with a new mask.
pub(super) fn upload_visibility_masks(
    mut masks: ResMut<VisibilityMasks>,
    phases: DrawnGBufferPhases,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    pipeline_cache: Res<PipelineCache>,
) {
    if masks.is_uploaded || masks.offsets.is_empty() {
        return;
    }
    if masks.offsets.len() > masks.limit.max(SMALLEST_LIMIT) {
        let used = phases.visibility_masks();
        masks.retain(&used);
        masks.limit = 2 * used.len();
    }
    let masks = &mut *masks;
    masks.buffer.write_buffer(&device, &queue);
    masks.bind_group = masks.buffer.binding().map(|binding| {
        device.create_bind_group(
            "lean_deferred/gbuffer/visibility_mask",
            &pipeline_cache.get_bind_group_layout(&visibility_mask_layout()),
            &BindGroupEntries::with_indices(((MESH_VISIBILITY_MASK, binding),)),
        )
    });
    masks.is_uploaded = true;
}

/// Drops the uploads on each new device; queued meshes keep their masks.
pub(super) fn forget_uploaded_visibility_masks(mut masks: ResMut<VisibilityMasks>) {
    let used = masks.offsets.keys().copied().collect();
    masks.buffer = default();
    masks.bind_group = None;
    masks.retain(&used);
}
