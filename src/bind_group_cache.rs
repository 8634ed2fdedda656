//! A bind group that is made anew only when what it binds has changed.

use core::num::NonZeroU64;

use bevy::render::{
    render_resource::{
        BindGroup, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor, BindingResource,
        PipelineCache,
    },
    renderer::RenderDevice,
};

/// What stands at one binding, compared by identity.
#[derive(Clone, PartialEq)]
enum Bound {
    Buffer(wgpu::Buffer, u64, Option<NonZeroU64>),
    Texture(wgpu::TextureView),
    Textures(Vec<wgpu::TextureView>),
    Sampler(wgpu::Sampler),
}

impl Bound {
    fn new(resource: &BindingResource) -> Option<Self> {
        Some(match resource {
            BindingResource::Buffer(b) => Self::Buffer(b.buffer.clone(), b.offset, b.size),
            BindingResource::TextureView(view) => Self::Texture((*view).clone()),
            BindingResource::TextureViewArray(views) => {
                Self::Textures(views.iter().map(|view| (*view).clone()).collect())
            }
            BindingResource::Sampler(sampler) => Self::Sampler((*sampler).clone()),
            _ => return None,
        })
    }
}

/// See the module's documentation.
#[derive(Default)]
pub(crate) struct CachedBindGroup {
    current: Option<(BindGroupLayout, Vec<(u32, Bound)>, BindGroup)>,
}

impl CachedBindGroup {
    /// Makes the bind group if there is none, or if `layout` or `entries` are not those of the last call.
    pub(crate) fn update(
        &mut self,
        device: &RenderDevice,
        pipeline_cache: &PipelineCache,
        layout: &BindGroupLayoutDescriptor,
        entries: &[BindGroupEntry],
    ) {
        let layout_label = layout.label.clone();
        let layout = pipeline_cache.get_bind_group_layout(layout);
        let bound: Option<Vec<_>> = entries
            .iter()
            .map(|entry| Some((entry.binding, Bound::new(&entry.resource)?)))
            .collect();
        if let (Some((old_layout, old_bound, _)), Some(bound)) = (&self.current, &bound)
            && old_layout.id() == layout.id()
            && old_bound == bound
        {
            return;
        }
        let bind_group = device.create_bind_group(&*layout_label, &layout, entries);
        self.current = Some((layout, bound.unwrap_or_default(), bind_group));
    }

    pub(crate) fn get(&self) -> Option<&BindGroup> {
        self.current.as_ref().map(|(_, _, bind_group)| bind_group)
    }

    pub(crate) fn clear(&mut self) {
        self.current = None;
    }
}
