//! Switches between Bevy's forward and deferred methods at run time.

use bevy::{ecs::system::SystemParam, pbr::DefaultOpaqueRendererMethod, prelude::*};

/// The opaque method of materials that name none; initially forward.
#[derive(SystemParam)]
pub struct OpaqueMethod<'w, 's> {
    default_method: ResMut<'w, DefaultOpaqueRendererMethod>,
    materials: ResMut<'w, Assets<StandardMaterial>>,
    was_deferred: Local<'s, bool>,
}

impl OpaqueMethod<'_, '_> {
    pub fn set(&mut self, is_deferred: bool) {
        if core::mem::replace(&mut *self.was_deferred, is_deferred) == is_deferred {
            return;
        }
        if is_deferred {
            self.default_method.set_to_deferred();
        } else {
            self.default_method.set_to_forward();
        }
        // Bevy reads the default method when it prepares a material, so every material must count as changed.
        for (_, material) in self.materials.iter_mut() {
            let _ = &mut *material;
        }
    }
}
