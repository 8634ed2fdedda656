//! Lists the meshes that Bevy extracted in this frame.

use bevy::{
    ecs::system::SystemParam,
    pbr::{RenderMeshInstanceGpuQueue, RenderMeshInstanceGpuQueues},
    prelude::*,
    render::sync_world::MainEntity,
};

/// Visible meshes that moved, changed or became visible; valid after Bevy's `MeshExtractionSystems`. Bevy searches all
/// meshes in parallel; systems that concern a few of them need not repeat that.
#[derive(SystemParam)]
pub(in crate::gbuffer) struct ExtractedMeshes<'w> {
    queues: Option<ResMut<'w, RenderMeshInstanceGpuQueues>>,
}

impl ExtractedMeshes<'_> {
    /// `None` if Bevy keeps no list: on devices for which it builds mesh uniforms on the CPU.
    pub(in crate::gbuffer) fn iter(&mut self) -> Option<impl Iterator<Item = MainEntity>> {
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
