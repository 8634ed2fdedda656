//! What more than one effect needs, whichever of them are added.

use bevy::{prelude::*, render::RenderApp, shader::load_shader_library};

use crate::tiles::RowOrder;

/// Added by each effect, once.
pub(crate) struct SharedPlugin;

impl SharedPlugin {
    pub(crate) fn add_to(app: &mut App) {
        if !app.is_plugin_added::<Self>() {
            app.add_plugins(Self);
        }
    }
}

impl Plugin for SharedPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "tiles.wgsl");
        load_shader_library!(app, "gbuffer/layout.wgsl");
        load_shader_library!(app, "gbuffer/layout/emissive.wgsl");
        load_shader_library!(app, "gbuffer/layout/motion.wgsl");
        load_shader_library!(app, "gbuffer/layout/specialization.wgsl");
        load_shader_library!(app, "lighting/geometric_normal.wgsl");
    }

    fn finish(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        let order = RowOrder::from_world(render_app.world());
        render_app.insert_resource(order);
    }
}
