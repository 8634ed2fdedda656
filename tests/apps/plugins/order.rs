//! Plugins in any order, added twice, and with parts of Bevy missing: they work, or report the error.

use std::panic::{AssertUnwindSafe, catch_unwind};

use bevy::{
    app::PluginsState,
    pbr::{ExtendedMaterial, Material, MaterialExtension, MaterialPlugin, PbrPlugin},
    prelude::*,
    reflect::TypePath,
    render::render_resource::AsBindGroup,
};
use bevy_lean_deferred::{
    LeanAutoExposurePlugin, LeanDeferredPlugins, gbuffer::GBufferMaterialExtension, prelude::*,
};

use super::{Effects, SIZE, solids};
use kit::{headless::Headless, lean::active_lean_views, log_watch, scenes::SceneBuilder};

/// An empty extension of `StandardMaterial`. The G-buffer carries the material as its base.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
struct Nothing {}

impl MaterialExtension for Nothing {}
impl GBufferMaterialExtension for Nothing {}

type OwnMaterial = ExtendedMaterial<StandardMaterial, Nothing>;

fn red() -> StandardMaterial {
    Color::srgb(0.8, 0.1, 0.1).into()
}

/// True if a ball of `material` is drawn in the G-buffer: its roughness is shown in grey, and forward would draw over it in colour.
fn goes_through_the_gbuffer<M: Material>(headless: &mut Headless, material: M) -> bool {
    let mut scene = SceneBuilder { headless };
    scene.sun(false);
    let mesh = scene.add::<Mesh>(Sphere::new(1.0).mesh().uv(32, 16));
    let material = scene.add::<M>(material);
    let transform = Transform::from_xyz(0.0, 0.4, 0.0);
    scene.spawn((Mesh3d(mesh), MeshMaterial3d(material), transform));
    scene.default_camera((
        LeanDeferred::default(),
        LeanDebugView::from(DebugView::Roughness),
    ));
    headless.settle();
    assert_eq!(active_lean_views(headless), 1);
    let picture = headless.capture();
    let middle = (picture.size.x * picture.size.y / 2 + picture.size.x / 2) as usize * 4;
    let [r, g, b] = [0, 1, 2].map(|channel| picture.rgba[middle + channel]);
    r.abs_diff(g) <= 1 && r.abs_diff(b) <= 1
}

fn app_with(add_plugins: impl FnOnce(&mut App)) -> Headless {
    let mut app = App::new();
    add_plugins(&mut app);
    Headless::from_app(SIZE, app, |_| {})
}

#[test]
fn own_material_in_any_order() {
    let material = || OwnMaterial {
        base: red(),
        extension: Nothing {},
    };
    let mut gbuffer_first = app_with(|app| {
        app.add_plugins(Headless::default_plugins())
            .add_plugins(GBufferMaterialPlugin::<OwnMaterial>::default())
            .add_plugins(MaterialPlugin::<OwnMaterial>::default())
            .add_plugins(LeanDeferredPlugins);
    });
    assert!(goes_through_the_gbuffer(&mut gbuffer_first, material()));

    let mut material_first = app_with(|app| {
        app.add_plugins(Headless::default_plugins())
            .add_plugins(LeanDeferredPlugins)
            .add_plugins(MaterialPlugin::<OwnMaterial>::default())
            .add_plugins(GBufferMaterialPlugin::<OwnMaterial>::default());
    });
    assert!(goes_through_the_gbuffer(&mut material_first, material()));
}

/// A G-buffer material in an app that lacks [`MaterialPlugin`] or this crate is reported.
#[test]
fn gbuffer_material_without_what_it_needs() {
    let mut without_material = app_with(|app| {
        app.add_plugins(Headless::default_plugins())
            .add_plugins(LeanDeferredPlugins)
            .add_plugins(GBufferMaterialPlugin::<OwnMaterial>::default());
    });
    without_material.frames(3);
    assert_eq!(log_watch::messages_with("MaterialPlugin for it").len(), 1);

    let mut without_gbuffer = app_with(|app| {
        app.add_plugins(Headless::default_plugins())
            .add_plugins(MaterialPlugin::<OwnMaterial>::default())
            .add_plugins(GBufferMaterialPlugin::<OwnMaterial>::default());
    });
    without_gbuffer.frames(3);
    let messages = log_watch::messages_with("the app has no LeanDeferredPlugin");
    assert_eq!(messages.len(), 1, "{messages:?}");
}

#[test]
fn extended_standard_material_added_by_the_app() {
    let mut headless = app_with(|app| {
        app.add_plugins(Headless::default_plugins())
            .add_plugins(MaterialPlugin::<ExtendedStandardMaterial>::default())
            .add_plugins(LeanDeferredPlugins);
    });
    let material = ExtendedStandardMaterial {
        base: red(),
        extension: ShadingExtension::None,
    };
    assert!(goes_through_the_gbuffer(&mut headless, material));
}

/// The message of the panic of `f`.
fn panic_of(f: impl FnOnce()) -> String {
    let payload = catch_unwind(AssertUnwindSafe(f)).expect_err("it is refused");
    let text = payload.downcast_ref::<String>().cloned();
    text.unwrap_or_else(|| payload.downcast_ref::<&str>().unwrap_or(&"").to_string())
}

/// Bevy rejects a plugin that is added twice, and names it.
#[test]
fn twice() {
    let text = panic_of(|| {
        app_with(|app| {
            app.add_plugins(Headless::default_plugins())
                .add_plugins(LeanDeferredPlugins)
                .add_plugins(LeanAutoExposurePlugin);
        });
    });
    assert!(text.contains("LeanAutoExposurePlugin"), "{text}");
    assert!(text.contains("already added"), "{text}");

    let text = panic_of(|| {
        app_with(|app| {
            app.add_plugins(Headless::default_plugins())
                .add_plugins(LeanDeferredPlugins)
                .add_plugins(MaterialPlugin::<ExtendedStandardMaterial>::default());
        });
    });
    assert!(text.contains("ShadingExtension"), "{text}");
    assert!(text.contains("already added"), "{text}");
}

#[test]
fn before_default_plugins() {
    let headless = app_with(|app| {
        app.add_plugins(LeanDeferredPlugins)
            .add_plugins(Headless::default_plugins());
    });
    let (mut headless, camera) = solids(headless);
    headless.settle();
    let forward = headless.capture();
    Effects::ALL.put_on(&mut headless.world().entity_mut(camera));
    headless.settle();
    assert!(headless.capture() == forward);
    let line = "is off, as all plugins of this crate that need AssetPlugin";
    assert_eq!(log_watch::messages_with(line).len(), 1);
}

#[test]
fn without_pbr() {
    let mut headless = app_with(|app| {
        app.add_plugins(Headless::default_plugins().disable::<PbrPlugin>())
            .add_plugins(LeanDeferredPlugins);
    });
    let target = headless.render_target();
    headless.world().spawn((
        Camera3d::default(),
        target,
        LeanDeferred::default(),
        LeanScreenSpaceAmbientOcclusion::default(),
        LeanAutoExposure::default(),
    ));
    headless.settle();
    let line = "is off, as all plugins of this crate that need PbrPlugin";
    assert_eq!(log_watch::messages_with(line).len(), 1);
}

/// A server with assets and no renderer runs.
#[test]
fn without_renderer() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), LeanDeferredPlugins));
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    let camera = app.world_mut().spawn_empty().id();
    Effects::ALL.put_on(&mut app.world_mut().entity_mut(camera));
    app.update();
    Effects::NONE.put_on(&mut app.world_mut().entity_mut(camera));
    app.update();
}
