//! Binds what meshes that Bevy's passes draw read of this crate: the layers of lights, and what reflections are traced through.

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
            BindGroupLayoutDescriptor, IntoBinding, PipelineCache, SamplerBindingType,
            ShaderStages, TextureSampleType,
            binding_types::{sampler, storage_buffer_read_only, texture_2d, uniform_buffer},
        },
        renderer::RenderDevice,
    },
};

use super::{
    binding_numbers::{
        HI_Z_TEXTURE, HISTORY_SAMPLER, HISTORY_TEXTURE, LIGHT_LAYERS, OWN_GROUP, REFLECTIONS,
    },
    pipelines::ForwardPipelines,
    reflections::{ForwardReflectionUniform, ForwardReflections},
};
use crate::{
    gpu::{
        bind_group_cache::{CachedBindGroup, ResolvedLayout},
        bindings::layout,
    },
    lighting::{light_layer_table::LightLayersTable, state::ViewLighting},
    view::ActiveLeanView,
};

/// Bevy's `DrawMaterial`, with the crate's own bind group: that of reflections, which has the layers of lights too if the view has any, or
/// that of the layers alone.
pub(super) type DrawWithOwnGroup<const REFLECTS: bool> = (
    SetItemPipeline,
    SetMeshViewBindGroup<0>,
    SetMeshViewBindingArrayBindGroup<1>,
    SetMeshBindGroup<2>,
    SetMaterialBindGroup<3>,
    SetOwnGroup<OWN_GROUP, REFLECTS>,
    DrawMesh,
);

/// Layout of the group, for a view with light layers and for pipelines with reflections.
pub(super) fn own_layout(has_layers: bool, reflects: bool) -> BindGroupLayoutDescriptor {
    let layers = has_layers.then(|| {
        (
            LIGHT_LAYERS,
            storage_buffer_read_only::<LightLayersTable>(false),
        )
    });
    let reflections = [
        (
            REFLECTIONS,
            // Without a dynamic offset: Bevy's groups have as many as some devices allow.
            uniform_buffer::<ForwardReflectionUniform>(false),
        ),
        (HI_Z_TEXTURE, texture_2d(TextureSampleType::Uint)),
        (
            HISTORY_TEXTURE,
            texture_2d(TextureSampleType::Float { filterable: true }),
        ),
        (HISTORY_SAMPLER, sampler(SamplerBindingType::Filtering)),
    ];
    let reflections = reflections.into_iter().filter(|_| reflects);
    layout(
        "lean_deferred/lighting/forward",
        ShaderStages::FRAGMENT,
        layers.into_iter().chain(reflections),
    )
}

/// The layouts, on devices with a bind group for them.
pub(super) struct OwnLayouts {
    layers: ResolvedLayout,
    /// Without and with light layers.
    reflections: [ResolvedLayout; 2],
}

impl OwnLayouts {
    pub(super) fn new(cache: &PipelineCache, device: &RenderDevice) -> Option<Self> {
        let groups = device.limits().max_bind_groups as usize;
        let resolved =
            |has_layers, reflects| ResolvedLayout::new(cache, own_layout(has_layers, reflects));
        (groups > OWN_GROUP).then(|| Self {
            layers: resolved(true, false),
            reflections: [false, true].map(|has_layers| resolved(has_layers, true)),
        })
    }
}

/// The bind groups of a view.
#[derive(Default)]
pub(crate) struct OwnGroups {
    layers: CachedBindGroup,
    reflections: CachedBindGroup,
}

/// Binds a group of the view.
pub(super) struct SetOwnGroup<const I: usize, const REFLECTS: bool>;

impl<P: PhaseItem, const I: usize, const REFLECTS: bool> RenderCommand<P>
    for SetOwnGroup<I, REFLECTS>
{
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
        let groups = lighting.map(|lighting| &lighting.forward_groups);
        let group = groups.and_then(|groups| match REFLECTS {
            true => groups.reflections.get(),
            false => groups.layers.get(),
        });
        let Some(group) = group else {
            return RenderCommandResult::Failure("the bind group of forward meshes is incomplete");
        };
        pass.set_bind_group(I, group, &[]);
        RenderCommandResult::Success
    }
}

/// Updates the bind groups of views, once a pipeline reads them.
pub(crate) fn prepare_forward_groups(
    pipelines: Res<ForwardPipelines>,
    device: Res<RenderDevice>,
    mut views: Query<(
        &mut ViewLighting,
        Option<&ActiveLeanView>,
        Option<&ForwardReflections>,
    )>,
) {
    let Some(layouts) = &pipelines.layouts else {
        return;
    };
    for (mut lighting, active, reflections) in &mut views {
        let ViewLighting {
            light_layers,
            forward_groups: groups,
            ..
        } = &mut *lighting;
        let Some(active) = active else {
            *groups = default();
            continue;
        };
        let table = light_layers.as_ref().and_then(|table| table.binding());
        match table.clone().filter(|_| pipelines.has_layered) {
            Some(table) => {
                (groups.layers).update(&device, &layouts.layers, |entries| {
                    entries.push(LIGHT_LAYERS, table)
                });
            }
            None => groups.layers.clear(),
        }
        match reflections.filter(|_| pipelines.has_reflecting) {
            Some(reflections) => {
                let has_layers = active.has_light_layers;
                let layout = &layouts.reflections[usize::from(has_layers)];
                (groups.reflections).bind(&device, layout, |binding| {
                    let textures = reflections.textures.as_ref()?;
                    Some(match binding {
                        LIGHT_LAYERS => table.clone()?,
                        REFLECTIONS => reflections.uniform.binding()?,
                        HI_Z_TEXTURE => textures.hi_z.into_binding(),
                        HISTORY_TEXTURE => textures.history.into_binding(),
                        HISTORY_SAMPLER => textures.history_sampler.into_binding(),
                        _ => return None,
                    })
                });
            }
            None => groups.reflections.clear(),
        }
    }
}
