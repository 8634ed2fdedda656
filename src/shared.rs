//! What more than one effect needs, whichever of them are added.

use bevy::{
    asset::io::embedded::EmbeddedAssetRegistry,
    pbr::PbrPlugin,
    prelude::*,
    render::{GpuResourceAppExt, RenderApp, RenderPlugin},
    shader::load_shader_library,
};

use crate::{
    camera_overrides,
    pipeline_watch::{self, PipelineWatch},
    tiles::RowOrder,
};

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
        // Bevy wants all modules that a shader imports, also where `#ifdef` leaves them out.
        load_shader_library!(app, "tiles.wgsl");
        load_shader_library!(app, "gbuffer/layout.wgsl");
        load_shader_library!(app, "gbuffer/layout/emissive.wgsl");
        load_shader_library!(app, "gbuffer/layout/motion.wgsl");
        load_shader_library!(app, "gbuffer/layout/specialization.wgsl");
        load_shader_library!(app, "lighting/geometric_normal.wgsl");
        load_shader_library!(app, "ambient_occlusion/view.wgsl");
        load_shader_library!(app, "ambient_occlusion/filter.wgsl");

        app.add_observer(camera_overrides::override_new_camera)
            .add_observer(camera_overrides::keep_ticks_young);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_gpu_resource::<PipelineWatch>()
            .add_systems(ExtractSchedule, pipeline_watch::watch_pipelines);
    }

    fn finish(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        let order = RowOrder::from_world(render_app.world());
        render_app.insert_resource(order);
    }
}

/// Whether what the effect `plugin` builds upon is there. Else it is to add nothing, and users are told why.
pub(crate) fn can_build(app: &mut App, plugin: &'static str, with_pbr: bool) -> bool {
    let missing = if !app.world().contains_resource::<EmbeddedAssetRegistry>() {
        "AssetPlugin"
    } else if !app.is_plugin_added::<RenderPlugin>() {
        "RenderPlugin"
    } else if with_pbr && !app.is_plugin_added::<PbrPlugin>() {
        "PbrPlugin"
    } else {
        return true;
    };
    app.add_plugins(OffNotice { plugin, missing });
    false
}

/// Tells, once there is a log, that a plugin of this crate has added nothing.
struct OffNotice {
    plugin: &'static str,
    missing: &'static str,
}

impl Plugin for OffNotice {
    fn build(&self, _: &mut App) {}

    fn finish(&self, _: &mut App) {
        let Self { plugin, missing } = self;
        error!(
            "{plugin} is off: add it after DefaultPlugins, which must have {missing}. Cameras render as Bevy has them."
        );
    }

    fn is_unique(&self) -> bool {
        false
    }
}
