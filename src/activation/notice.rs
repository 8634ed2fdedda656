//! Logs that a camera has become lean.

use bevy::{prelude::*, render::sync_world::MainEntity};

use crate::{
    gbuffer::{GBufferTextures, GBufferUsage},
    view::{ActiveLeanView, EffectStatuses, GBufferTargets},
};

/// Logs the size and the memory of a camera's G-buffer when it becomes lean: once, and again after Bevy has rendered it.
pub(super) fn log_newly_lean_cameras(
    mut statuses: ResMut<EffectStatuses>,
    views: Query<(&MainEntity, &GBufferTextures), With<ActiveLeanView>>,
) {
    for (camera, textures) in &views {
        if statuses.is_newly_lean(*camera) {
            let text = describe(&GBufferUsage::of(textures));
            info!("Camera {} is lean: {text}.", camera.id());
        }
    }
}

fn describe(usage: &GBufferUsage) -> String {
    let UVec2 { x, y } = usage.size;
    let optional = usage.targets.iter().map(GBufferTargets::name);
    let targets: Vec<_> = core::iter::once("base").chain(optional).collect();
    let mebibytes = usage.bytes() as f64 / f64::from(1 << 20);
    format!("{x}x{y}, {}, {mebibytes:.1} MiB", targets.join(" + "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_has_size_targets_and_memory() {
        let mut usage = GBufferUsage {
            size: UVec2::new(2560, 1440),
            targets: GBufferTargets::empty(),
        };
        assert_eq!(describe(&usage), "2560x1440, base, 28.1 MiB");
        usage.targets = GBufferTargets::EMISSIVE | GBufferTargets::MOTION;
        assert_eq!(
            describe(&usage),
            "2560x1440, base + emissive + motion, 59.8 MiB"
        );
    }
}
