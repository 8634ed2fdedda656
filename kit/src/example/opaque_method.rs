//! Forward or Bevy's deferred, at run time.

use bevy::{ecs::system::SystemParam, pbr::DefaultOpaqueRendererMethod, prelude::*};

/// The method of materials that name none. Forward at first.
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
        // Bevy settles a material's method when it prepares the material.
        for (_, material) in self.materials.iter_mut() {
            let _ = &mut *material;
        }
    }
}
