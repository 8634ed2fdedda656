//! Caches bind groups and recreates them only when a bound resource has changed. While nothing changes, the check costs
//! neither an allocation nor a look-up.

use core::num::NonZeroU64;

use bevy::render::{
    render_resource::{
        BindGroup, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutId,
        BindingResource, PipelineCache,
    },
    renderer::RenderDevice,
};
use wgpu::BufferBinding;

/// A layout that was looked up once: Bevy's cache clones and hashes its descriptor at each look-up. Belongs to one
/// device.
#[derive(Clone)]
pub(crate) struct ResolvedLayout {
    descriptor: BindGroupLayoutDescriptor,
    layout: BindGroupLayout,
}

impl ResolvedLayout {
    pub(crate) fn new(cache: &PipelineCache, descriptor: BindGroupLayoutDescriptor) -> Self {
        Self {
            layout: cache.get_bind_group_layout(&descriptor),
            descriptor,
        }
    }

    pub(crate) fn descriptor(&self) -> &BindGroupLayoutDescriptor {
        &self.descriptor
    }
}

/// The resource at one binding, compared by identity. This handle keeps it alive, so that no other resource can get the
/// same identity.
#[derive(Clone, PartialEq)]
enum Bound {
    Buffer(wgpu::Buffer, u64, Option<NonZeroU64>),
    Texture(wgpu::TextureView),
    Textures(Vec<wgpu::TextureView>),
    Sampler(wgpu::Sampler),
}

impl Bound {
    /// `None` for kinds that this crate does not bind.
    fn new(resource: &BindingResource) -> Option<Self> {
        Some(match resource {
            BindingResource::Buffer(b) => Self::Buffer(b.buffer.clone(), b.offset, b.size),
            BindingResource::TextureView(view) => Self::Texture((*view).clone()),
            BindingResource::Sampler(sampler) => Self::Sampler((*sampler).clone()),
            _ => return None,
        })
    }

    fn is(&self, resource: &BindingResource) -> bool {
        match (self, resource) {
            (Self::Buffer(buffer, offset, size), BindingResource::Buffer(other)) => {
                (buffer, *offset, *size) == (other.buffer, other.offset, other.size)
            }
            (Self::Texture(view), BindingResource::TextureView(other)) => view == *other,
            (Self::Sampler(sampler), BindingResource::Sampler(other)) => sampler == *other,
            _ => false,
        }
    }
}

/// A cached bind group; see the module's documentation.
#[derive(Default)]
pub(crate) struct CachedBindGroup {
    bound: Vec<(u32, Bound)>,
    layout: Option<BindGroupLayoutId>,
    /// `None` once `bound` or `layout` has changed.
    group: Option<BindGroup>,
}

/// The entries of a bind group during their comparison with those of the last frame.
pub(crate) struct Entries<'a> {
    cached: &'a mut CachedBindGroup,
    count: usize,
}

impl Entries<'_> {
    /// Pushes the next entry. Returns `None` for kinds of resources that this crate does not bind.
    pub(crate) fn push(&mut self, binding: u32, resource: BindingResource) -> Option<()> {
        let fits = |(other, bound): &(u32, Bound)| *other == binding && bound.is(&resource);
        if !self.cached.bound.get(self.count).is_some_and(fits) {
            self.replace(binding, Bound::new(&resource)?);
        }
        self.count += 1;
        Some(())
    }

    /// Pushes an array of `length` textures as the next entry.
    pub(crate) fn push_textures<'t>(
        &mut self,
        binding: u32,
        length: usize,
        texture: impl Fn(usize) -> &'t wgpu::TextureView,
    ) {
        let fits = |(other, bound): &(u32, Bound)| {
            *other == binding
                && matches!(bound, Bound::Textures(views) if views.len() == length
                    && views.iter().enumerate().all(|(i, view)| view == texture(i)))
        };
        if !self.cached.bound.get(self.count).is_some_and(fits) {
            let views = (0..length).map(|i| texture(i).clone()).collect();
            self.replace(binding, Bound::Textures(views));
        }
        self.count += 1;
    }

    fn replace(&mut self, binding: u32, bound: Bound) {
        self.cached.group = None;
        self.cached.bound.truncate(self.count + 1);
        match self.cached.bound.get_mut(self.count) {
            Some(entry) => *entry = (binding, bound),
            None => self.cached.bound.push((binding, bound)),
        }
    }
}

impl CachedBindGroup {
    /// Creates the bind group if there is none, or if `layout` or the entries that `fill` pushes differ from those of
    /// the last call. Drops it if `fill` returns `None` because a resource is missing.
    pub(crate) fn update(
        &mut self,
        device: &RenderDevice,
        layout: &ResolvedLayout,
        fill: impl FnOnce(&mut Entries) -> Option<()>,
    ) -> Option<()> {
        if self.layout != Some(layout.layout.id()) {
            self.clear();
            self.layout = Some(layout.layout.id());
        }
        let mut entries = Entries {
            cached: self,
            count: 0,
        };
        let is_complete = fill(&mut entries).is_some();
        let count = entries.count;
        if !is_complete {
            self.clear();
            return None;
        }
        if count < self.bound.len() {
            self.bound.truncate(count);
            self.group = None;
        }
        if self.group.is_none() {
            self.group = Some(self.make(device, layout));
        }
        Some(())
    }

    /// As [`update`](Self::update), with the `resource` of each binding of `layout`.
    pub(crate) fn bind<'r>(
        &mut self,
        device: &RenderDevice,
        layout: &ResolvedLayout,
        resource: impl Fn(u32) -> Option<BindingResource<'r>>,
    ) -> Option<()> {
        self.update(device, layout, |entries| {
            let mut bindings = layout.descriptor.entries.iter().map(|entry| entry.binding);
            bindings.try_for_each(|binding| entries.push(binding, resource(binding)?))
        })
    }

    fn make(&self, device: &RenderDevice, layout: &ResolvedLayout) -> BindGroup {
        let arrays: Vec<Vec<&wgpu::TextureView>> = self
            .bound
            .iter()
            .map(|(_, bound)| match bound {
                Bound::Textures(views) => views.iter().collect(),
                _ => Vec::new(),
            })
            .collect();
        let entries: Vec<_> = self
            .bound
            .iter()
            .zip(&arrays)
            .map(|((binding, bound), array)| BindGroupEntry {
                binding: *binding,
                resource: match bound {
                    Bound::Buffer(buffer, offset, size) => BindingResource::Buffer(BufferBinding {
                        buffer,
                        offset: *offset,
                        size: *size,
                    }),
                    Bound::Texture(view) => BindingResource::TextureView(view),
                    Bound::Textures(_) => BindingResource::TextureViewArray(array),
                    Bound::Sampler(sampler) => BindingResource::Sampler(sampler),
                },
            })
            .collect();
        device.create_bind_group(&*layout.descriptor.label, &layout.layout, &entries)
    }

    pub(crate) fn get(&self) -> Option<&BindGroup> {
        self.group.as_ref()
    }

    /// Number of textures that it binds.
    pub(crate) fn texture_views(&self) -> usize {
        let views = self.bound.iter().map(|(_, bound)| match bound {
            Bound::Texture(_) => 1,
            Bound::Textures(views) => views.len(),
            Bound::Buffer(..) | Bound::Sampler(_) => 0,
        });
        views.sum()
    }

    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}
