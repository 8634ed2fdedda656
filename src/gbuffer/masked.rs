//! Alpha-masked meshes are drawn twice: first their depth, by a fragment shader that only discards, then their targets where they are
//! visible. Foliage has many layers, and most fragments of a layer are holes or hidden, so the shader that packs the surface runs for
//! few of them.
//!
//! Both pipelines compute the same positions, because those of Bevy's vertex shaders are invariant (`bevy/invariant_positions.rs`).
//! Materials with a vertex shader of their own are drawn once, as are those with a fragment shader of their own, which may discard by
//! other rules.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

use bevy::{
    ecs::system::{SystemParamItem, lifetimeless::SRes},
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_phase::{
            CachedRenderPipelinePhaseItem, RenderCommand, RenderCommandResult, TrackedRenderPass,
        },
        render_resource::{
            CachedRenderPipelineId, ColorWrites, CompareFunction, PipelineCache,
            RenderPipelineDescriptor,
        },
    },
};

/// The part of its meshes that a pipeline draws.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum DrawnPart {
    /// Depth and targets.
    Whole,
    /// Depth.
    Depth,
    /// Targets, where depth is that of the mesh.
    AtDepth,
}

impl DrawnPart {
    /// Changes the descriptor of a pipeline that draws all into that of one that draws this part.
    pub(super) fn change(self, descriptor: &mut RenderPipelineDescriptor) {
        if self == Self::Depth {
            descriptor.label = Some("lean_deferred/gbuffer/masked_depth".into());
            let targets = descriptor.fragment.iter_mut();
            for target in targets.flat_map(|fragment| fragment.targets.iter_mut().flatten()) {
                target.write_mask = ColorWrites::empty();
            }
        } else if self == Self::AtDepth {
            if let Some(fragment) = &mut descriptor.fragment {
                fragment.shader_defs.push("GBUFFER_AT_DEPTH".into());
            }
            if let Some(depth) = &mut descriptor.depth_stencil {
                depth.depth_compare = Some(CompareFunction::Equal);
                depth.depth_write_enabled = Some(false);
            }
        }
    }
}

/// In the render world: pipelines of masked meshes.
#[derive(Resource, Default)]
pub struct MaskedPipelines {
    /// Those that draw depth, by those that draw the targets.
    depth: HashMap<CachedRenderPipelineId, CachedRenderPipelineId>,
    draws_depth: AtomicBool,
    is_off: bool,
}

impl MaskedPipelines {
    /// For tests and benches: draws masked meshes once.
    #[cfg(feature = "test_hooks")]
    pub fn off() -> Self {
        Self {
            is_off: true,
            ..Self::default()
        }
    }

    /// From now on, further meshes are drawn once.
    pub(super) fn turn_off(&mut self) {
        self.is_off = true;
    }

    pub(super) fn are_in_use(&self) -> bool {
        !self.is_off
    }

    pub(super) fn insert(
        &mut self,
        targets: CachedRenderPipelineId,
        depth: CachedRenderPipelineId,
    ) {
        self.depth.insert(targets, depth);
    }

    /// The pipeline that draws depth before this one draws the targets.
    pub(super) fn depth(&self, targets: CachedRenderPipelineId) -> Option<CachedRenderPipelineId> {
        self.depth.get(&targets).copied()
    }

    /// Forgets the pipelines of another device.
    pub(super) fn clear(&mut self) {
        self.depth.clear();
    }

    /// Renders a phase of masked meshes: their depth, then the rest.
    pub(super) fn render(&self, mut render: impl FnMut()) {
        if !self.depth.is_empty() {
            // Passes of the G-buffer run one after another.
            self.draws_depth.store(true, Relaxed);
            render();
            self.draws_depth.store(false, Relaxed);
        }
        render();
    }
}

/// Binds the pipeline of an item, or the one that draws its depth.
pub(super) struct SetGBufferPipeline;

impl<P: CachedRenderPipelinePhaseItem> RenderCommand<P> for SetGBufferPipeline {
    type Param = (SRes<PipelineCache>, SRes<MaskedPipelines>);
    type ViewQuery = ();
    type ItemQuery = ();

    fn render<'w>(
        item: &P,
        _: (),
        _: Option<()>,
        (cache, masked): SystemParamItem<'w, '_, Self::Param>,
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        let own = item.cached_pipeline();
        let id = if masked.draws_depth.load(Relaxed) {
            masked.depth(own)
        } else {
            Some(own)
        };
        let pipeline = id.and_then(|id| cache.into_inner().get_render_pipeline(id));
        let Some(pipeline) = pipeline else {
            return RenderCommandResult::Skip;
        };
        pass.set_render_pipeline(pipeline);
        RenderCommandResult::Success
    }
}
