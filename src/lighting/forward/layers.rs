//! Binds the layers of lights for meshes that Bevy's passes draw.

use bevy::{
    ecs::{
        query::ROQueryItem,
        system::{SystemParamItem, lifetimeless::Read},
    },
    pbr::{
        DrawMesh, SetMaterialBindGroup, SetMeshBindGroup, SetMeshViewBindGroup,
        SetMeshViewBindingArrayBindGroup,
    },
    prelude::*,
    render::{
        render_phase::{
            PhaseItem, RenderCommand, RenderCommandResult, SetItemPipeline, TrackedRenderPass,
        },
        render_resource::{
            BindGroupLayoutDescriptor, ShaderStages, binding_types::storage_buffer_read_only,
        },
        renderer::RenderDevice,
    },
};

use super::{
    binding_numbers::{LIGHT_LAYERS, LIGHT_LAYERS_GROUP},
    pipelines::ForwardPipelines,
};
use crate::{
    gpu::bindings::layout,
    lighting::{light_layer_table::LightLayersTable, state::ViewLighting},
};

/// Bevy's `DrawMaterial`, with the layers of lights in a further bind group.
pub(super) type DrawWithLightLayers = (
    SetItemPipeline,
    SetMeshViewBindGroup<0>,
    SetMeshViewBindingArrayBindGroup<1>,
    SetMeshBindGroup<2>,
    SetMaterialBindGroup<3>,
    SetLightLayers<LIGHT_LAYERS_GROUP>,
    DrawMesh,
);

/// Layout of that bind group.
pub(super) fn light_layers_layout() -> BindGroupLayoutDescriptor {
    layout(
        "lean_deferred/lighting/forward",
        ShaderStages::FRAGMENT,
        [(
            LIGHT_LAYERS,
            storage_buffer_read_only::<LightLayersTable>(false),
        )],
    )
}

/// Binds the table that lighting has for the view.
pub(super) struct SetLightLayers<const I: usize>;

impl<P: PhaseItem, const I: usize> RenderCommand<P> for SetLightLayers<I> {
    type Param = ();
    type ViewQuery = Option<Read<ViewLighting>>;
    type ItemQuery = ();

    fn render<'w>(
        _: &P,
        lighting: ROQueryItem<'w, '_, Self::ViewQuery>,
        _: Option<()>,
        _: SystemParamItem<'w, '_, Self::Param>,
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        let Some(group) = lighting.and_then(|lighting| lighting.forward_layers.get()) else {
            return RenderCommandResult::Failure("the layers of lights were not uploaded");
        };
        pass.set_bind_group(I, group, &[]);
        RenderCommandResult::Success
    }
}

/// Updates the bind groups of views with light layers, once a pipeline reads them.
pub(super) fn prepare_forward_layers(
    pipelines: Res<ForwardPipelines>,
    device: Res<RenderDevice>,
    mut views: Query<&mut ViewLighting>,
) {
    let Some(layout) = (pipelines.layers_layout.as_ref()).filter(|_| pipelines.has_layered) else {
        return;
    };
    for mut lighting in &mut views {
        let ViewLighting {
            light_layers,
            forward_layers,
            ..
        } = &mut *lighting;
        let table = light_layers.as_ref().and_then(|table| table.binding());
        match table {
            Some(table) => {
                forward_layers.update(&device, layout, |entries| entries.push(LIGHT_LAYERS, table));
            }
            None => forward_layers.clear(),
        }
    }
}
