//! Draws the meshes of the G-buffer. Bevy's `DrawPrepass` binds previous positions if the view has motion vectors; these
//! functions bind them if the mesh writes its motion, so that motion vectors of a view need no other pipelines.

use bevy::{
    core_pipeline::prepass::PreviousViewUniformOffset,
    ecs::{
        query::ROQueryItem,
        system::{SystemParamItem, lifetimeless::Read},
    },
    pbr::{
        DrawMesh, SetMaterialBindGroup, SetMeshBindGroup, SetPrepassViewBindGroup,
        SetPrepassViewEmptyBindGroup,
    },
    prelude::*,
    render::{
        render_phase::{
            DrawFunctionId, DrawFunctions, PhaseItem, RenderCommand, RenderCommandResult,
            TrackedRenderPass,
        },
        view::ViewUniformOffset,
    },
};

use super::{
    binding_numbers::pack::VISIBILITY_MASK_GROUP,
    masked::SetGBufferPipeline,
    phase_item::{
        AlphaMaskGBuffer, ExtendedAlphaMaskGBuffer, ExtendedOpaqueGBuffer, OpaqueGBuffer,
    },
    placement::MeshOutput,
    visibility_masks::{SetVisibilityMask, VisibilityMasks},
};
use crate::{gpu::named::system_param, view::GBufferTargets};

/// Draws meshes that write no visibility mask. `MOTION`: they write their motion.
pub(super) type DrawPlain<const MOTION: bool> = (
    SetGBufferPipeline,
    SetView<0, MOTION>,
    SetPrepassViewEmptyBindGroup<1>,
    SetMesh<2, MOTION>,
    SetMaterialBindGroup<3>,
    DrawMesh,
);

/// The same with the visibility mask of the batch in place of the empty bind group.
pub(super) type DrawWithVisibilityMask<const MOTION: bool> = (
    SetGBufferPipeline,
    SetView<0, MOTION>,
    SetVisibilityMask<VISIBILITY_MASK_GROUP>,
    SetMesh<2, MOTION>,
    SetMaterialBindGroup<3>,
    DrawMesh,
);

system_param! {
    /// The draw functions of each phase.
    pub(super) struct GBufferDrawFunctions<'w, 's> {
        opaque: Res<'w, DrawFunctions<OpaqueGBuffer>>,
        alpha_mask: Res<'w, DrawFunctions<AlphaMaskGBuffer>>,
        extended_opaque: Res<'w, DrawFunctions<ExtendedOpaqueGBuffer>>,
        extended_alpha_mask: Res<'w, DrawFunctions<ExtendedAlphaMaskGBuffer>>,
        visibility_masks: ResMut<'w, VisibilityMasks>,
        ids: Local<'s, Option<DrawFunctionIds>>,
    }
}

/// Draw functions of opaque and of alpha-masked meshes.
struct DrawFunctionIds {
    base: [DrawFunctionId; 2],
    /// Of meshes without a visibility mask: of those that write no motion, then of those that do.
    extended: [[DrawFunctionId; 2]; 2],
    with_visibility_mask: [[DrawFunctionId; 2]; 2],
}

impl GBufferDrawFunctions<'_, '_> {
    /// Function that draws a mesh, which writes `visibility_mask`.
    pub(super) fn get(
        &mut self,
        output: MeshOutput,
        alpha_masked: bool,
        visibility_mask: Option<u32>,
    ) -> DrawFunctionId {
        let ids = self.ids.get_or_insert_with(|| {
            let opaque = self.extended_opaque.read();
            let alpha_mask = self.extended_alpha_mask.read();
            DrawFunctionIds {
                base: [
                    self.opaque.read().id::<DrawPlain<false>>(),
                    self.alpha_mask.read().id::<DrawPlain<false>>(),
                ],
                extended: [
                    [
                        opaque.id::<DrawPlain<false>>(),
                        alpha_mask.id::<DrawPlain<false>>(),
                    ],
                    [
                        opaque.id::<DrawPlain<true>>(),
                        alpha_mask.id::<DrawPlain<true>>(),
                    ],
                ],
                with_visibility_mask: [
                    [
                        opaque.id::<DrawWithVisibilityMask<false>>(),
                        alpha_mask.id::<DrawWithVisibilityMask<false>>(),
                    ],
                    [
                        opaque.id::<DrawWithVisibilityMask<true>>(),
                        alpha_mask.id::<DrawWithVisibilityMask<true>>(),
                    ],
                ],
            }
        });
        let writes_motion = usize::from(output.targets.contains(GBufferTargets::MOTION));
        let pair = match visibility_mask {
            Some(mask) => {
                self.visibility_masks.insert(mask);
                ids.with_visibility_mask[writes_motion]
            }
            None if output.is_extended() => ids.extended[writes_motion],
            None => ids.base,
        };
        pair[usize::from(alpha_masked)]
    }
}

/// Bevy's command for the view, with or without its previous matrices, which every 3D view has.
pub(super) struct SetView<const I: usize, const MOTION: bool>;

impl<P: PhaseItem, const I: usize, const MOTION: bool> RenderCommand<P> for SetView<I, MOTION> {
    type Param = <SetPrepassViewBindGroup<I> as RenderCommand<P>>::Param;
    type ViewQuery = (
        Read<ViewUniformOffset>,
        Option<Read<PreviousViewUniformOffset>>,
    );
    type ItemQuery = ();

    fn render<'w>(
        item: &P,
        (offset, previous_offset): ROQueryItem<'w, '_, Self::ViewQuery>,
        _: Option<()>,
        groups: SystemParamItem<'w, '_, Self::Param>,
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        let view = (offset, MOTION, previous_offset);
        <SetPrepassViewBindGroup<I> as RenderCommand<P>>::render(item, view, None, groups, pass)
    }
}

/// Bevy's command for the mesh, with or without its previous joints and morph weights.
pub(super) struct SetMesh<const I: usize, const MOTION: bool>;

impl<P: PhaseItem, const I: usize, const MOTION: bool> RenderCommand<P> for SetMesh<I, MOTION> {
    type Param = <SetMeshBindGroup<I> as RenderCommand<P>>::Param;
    type ViewQuery = ();
    type ItemQuery = ();

    fn render<'w>(
        item: &P,
        _: (),
        _: Option<()>,
        groups: SystemParamItem<'w, '_, Self::Param>,
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        <SetMeshBindGroup<I> as RenderCommand<P>>::render(item, MOTION, None, groups, pass)
    }
}
