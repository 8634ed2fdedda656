//! Reports the GPU memory of each effect to cameras that ask for it.

use bevy::{
    ecs::{schedule::ScheduleConfigs, system::ScheduleSystem},
    prelude::*,
    render::{Extract, ExtractSchedule, MainWorld, sync_world::RenderEntity},
};

use super::in_use::EffectSystems;

/// Insert on a camera to get the bytes of GPU memory that each of its effects holds: textures, and buffers of its own.
/// Those of the last frame; 0 without the effect.
///
/// Cameras of one size share textures of the G-buffer, and the copy of depth in `history`: these count for each camera.
/// Not counted are uniforms and tables of all cameras, pipelines, and the padding that drivers add.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn_camera(mut commands: Commands) {
///     commands.spawn((
///         Camera3d::default(),
///         LeanDeferred::default(),
///         LeanScreenSpaceReflections::default(),
///         LeanMemory::default(),
///     ));
/// }
///
/// fn print_memory(cameras: Query<(Entity, &LeanMemory), Changed<LeanMemory>>) {
///     for (camera, memory) in &cameras {
///         info!("{camera}: {} MiB", memory.total() >> 20);
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct LeanMemory {
    /// Of the G-buffer of [`LeanDeferred`](crate::LeanDeferred), without depth.
    /// [`GBufferUsage`](crate::gbuffer::GBufferUsage) lists its targets.
    pub gbuffer: u64,
    /// Of lighting: the tiles with special surfaces, and the layers of lights.
    pub lighting: u64,
    /// Of the last frame's light and depth, which reflections read.
    pub history: u64,
    /// Of [`LeanScreenSpaceAmbientOcclusion`](crate::LeanScreenSpaceAmbientOcclusion).
    pub ambient_occlusion: u64,
    /// Of [`LeanScreenSpaceGi`](crate::LeanScreenSpaceGi), with the diffuse light that lighting writes for it.
    pub diffuse_gi: u64,
    /// Of [`LeanScreenSpaceReflections`](crate::LeanScreenSpaceReflections), without `history`.
    pub reflections: u64,
    /// Of [`LeanSubsurfaceScattering`](crate::LeanSubsurfaceScattering), with the light that lighting writes for it.
    pub subsurface: u64,
    /// Of [`LeanAutoExposure`](crate::LeanAutoExposure), with what reads it back for
    /// [`MeteredExposure`](crate::effects::auto_exposure::MeteredExposure).
    pub auto_exposure: u64,
}

impl LeanMemory {
    /// Bytes of all effects.
    pub fn total(&self) -> u64 {
        let Self {
            gbuffer,
            lighting,
            history,
            ambient_occlusion,
            diffuse_gi,
            reflections,
            subsurface,
            auto_exposure,
        } = self;
        [
            gbuffer,
            lighting,
            history,
            ambient_occlusion,
            diffuse_gi,
            reflections,
            subsurface,
            auto_exposure,
        ]
        .into_iter()
        .sum()
    }
}

/// The cameras with [`LeanMemory`], their views, and the bytes counted so far.
#[derive(Resource, Default)]
pub(super) struct MemoryReports(Vec<MemoryReport>);

struct MemoryReport {
    camera: Entity,
    view: Entity,
    memory: LeanMemory,
}

/// The systems of [`count`]. Each adds its bytes, in any order.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
struct MemoryCounts;

/// Adds the `bytes` that each view holds by its `V` to a field of [`LeanMemory`].
pub(crate) fn count<V: Component>(
    render_app: &mut SubApp,
    field: fn(&mut LeanMemory) -> &mut u64,
    bytes: fn(&V) -> u64,
) {
    let count = move |mut reports: ResMut<MemoryReports>, views: Query<&V>| {
        for report in &mut reports.0 {
            if let Ok(held) = views.get(report.view) {
                *field(&mut report.memory) += bytes(held);
            }
        }
    };
    render_app.add_systems(
        ExtractSchedule,
        count.in_set(MemoryCounts).in_set(EffectSystems::Memory),
    );
}

/// The systems before and after those of [`count`].
pub(super) fn report_memory() -> ScheduleConfigs<ScheduleSystem> {
    (
        begin_reports.before(MemoryCounts),
        finish_reports.after(MemoryCounts),
    )
        .in_set(EffectSystems::Memory)
}

fn begin_reports(
    mut reports: ResMut<MemoryReports>,
    cameras: Extract<Query<(Entity, RenderEntity), With<LeanMemory>>>,
) {
    let cameras = cameras.iter().map(|(camera, view)| MemoryReport {
        camera,
        view,
        memory: LeanMemory::default(),
    });
    reports.0.clear();
    reports.0.extend(cameras);
}

/// Copies the bytes of the last frame's views to their cameras in the main world.
fn finish_reports(mut main_world: ResMut<MainWorld>, reports: Res<MemoryReports>) {
    for report in &reports.0 {
        if let Some(mut memory) = main_world.get_mut::<LeanMemory>(report.camera) {
            memory.set_if_neq(report.memory);
        }
    }
}
