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
    render::{
        render_phase::{
            PhaseItem, RenderCommand, RenderCommandResult, SetItemPipeline, TrackedRenderPass,
        },
        view::ViewUniformOffset,
    },
};

use super::{binding_numbers::pack::VISIBILITY_MASK_GROUP, visibility_masks::SetVisibilityMask};

/// Draws meshes that write no visibility mask. `MOTION`: they write their motion.
pub(super) type DrawPlain<const MOTION: bool> = (
    SetItemPipeline,
    SetView<0, MOTION>,
    SetPrepassViewEmptyBindGroup<1>,
    SetMesh<2, MOTION>,
    SetMaterialBindGroup<3>,
    DrawMesh,
);

/// The same with the visibility mask of the batch in place of the empty bind group.
pub(super) type DrawWithVisibilityMask<const MOTION: bool> = (
    SetItemPipeline,
    SetView<0, MOTION>,
    SetVisibilityMask<VISIBILITY_MASK_GROUP>,
    SetMesh<2, MOTION>,
    SetMaterialBindGroup<3>,
    DrawMesh,
);

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
