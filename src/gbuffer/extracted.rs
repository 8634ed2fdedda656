//! The meshes that Bevy has extracted anew in this frame.

use bevy::{
    ecs::system::SystemParam,
    pbr::{RenderMeshInstanceGpuQueue, RenderMeshInstanceGpuQueues},
    prelude::*,
    render::sync_world::MainEntity,
};

/// After Bevy's `MeshExtractionSystems`: the visible meshes that moved, changed or became visible. Bevy looks for them among all meshes,
/// in parallel; what concerns a few of them need not do so again.
#[derive(SystemParam)]
pub(super) struct ExtractedMeshes<'w> {
    queues: Option<ResMut<'w, RenderMeshInstanceGpuQueues>>,
}

impl ExtractedMeshes<'_> {
    /// `None` where Bevy does not list them: on devices for which it makes the uniforms of meshes on the CPU.
    pub(super) fn iter(&mut self) -> Option<impl Iterator<Item = MainEntity>> {
        let queues = self.queues.as_mut()?.bypass_change_detection();
        Some(queues.iter_mut().flat_map(|queue| {
            let (plain, culled): (&[_], [&[_]; 2]) = match queue {
                RenderMeshInstanceGpuQueue::None => (&[], [&[]; 2]),
                RenderMeshInstanceGpuQueue::CpuCulling { changed, .. } => (changed, [&[]; 2]),
                RenderMeshInstanceGpuQueue::GpuCulling {
                    changed_cpu_culling,
                    changed_gpu_culling,
                    ..
                } => (&[], [changed_cpu_culling, changed_gpu_culling]),
            };
            let plain = plain.iter().map(|(mesh, _)| *mesh);
            plain.chain(culled.into_iter().flatten().map(|(mesh, ..)| *mesh))
        }))
    }
}
