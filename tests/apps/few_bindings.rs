//! Devices with too few bindings for reflections on forward meshes: one message says so, and the meshes are lit without.

use bevy::{
    prelude::*,
    render::{
        RenderApp,
        render_resource::{BindingType, PipelineCache, PipelineDescriptor, ShaderStages},
    },
};
use bevy_lean_deferred::{
    LeanDeferredPlugins, effects::LeanScreenSpaceReflectionsAdvanced,
    lighting::forward::PIPELINE_LABEL, prelude::*,
};
use kit::{
    device::render_plugin_within, gpu, headless::Headless, log_watch, own_process::in_own_process,
    scenes::SceneBuilder,
};
use wgpu::Limits;

const SIZE: UVec2 = UVec2::new(96, 64);

const MESSAGE: &str = "forward meshes do not reflect the image";

/// A glass sheet before solids, on a device with these limits.
fn app(limits: Limits, forward_meshes: bool) -> Headless {
    let mut app = App::new();
    app.add_plugins((
        Headless::default_plugins().set(render_plugin_within(limits)),
        LeanDeferredPlugins,
    ));
    let mut headless = Headless::from_app(SIZE, app, |_| {});
    let mut s = SceneBuilder {
        headless: &mut headless,
    };
    s.solids();
    s.sun(false);
    s.mesh(
        Plane3d::default().mesh().size(3.0, 3.0),
        StandardMaterial {
            base_color: Color::WHITE.with_alpha(0.6),
            alpha_mode: AlphaMode::Blend,
            perceptual_roughness: 0.0,
            metallic: 1.0,
            ..default()
        },
        Transform::from_xyz(0.0, 0.1, 1.5),
    );
    s.default_camera((
        LeanDeferred::default(),
        LeanScreenSpaceReflections {
            advanced: LeanScreenSpaceReflectionsAdvanced {
                forward_meshes,
                ..default()
            },
            ..default()
        },
    ));
    headless.settle();
    headless.frames(6);
    headless
}

/// Largest number of textures that fragment shaders of these meshes bind.
fn most_textures(headless: &Headless) -> u32 {
    let world = headless.app.sub_app(RenderApp).world();
    let pipelines = world.resource::<PipelineCache>().pipelines();
    let counts = pipelines.filter_map(|pipeline| {
        let PipelineDescriptor::RenderPipelineDescriptor(descriptor) = &pipeline.descriptor else {
            return None;
        };
        let entries = descriptor.layout.iter().flat_map(|layout| &layout.entries);
        let textures = entries.filter(|entry| {
            entry.count.is_none()
                && entry.visibility.contains(ShaderStages::FRAGMENT)
                && matches!(entry.ty, BindingType::Texture { .. })
        });
        (descriptor.label.as_deref() == Some(PIPELINE_LABEL)).then(|| textures.count() as u32)
    });
    counts.max().expect("there are such pipelines")
}

#[test]
fn forward_meshes_do_without_reflections() {
    in_own_process(|| {
        let without = app(gpu::limits(), false).capture();
        let mut whole = app(gpu::limits(), true);
        assert!(whole.capture() != without, "it reflects nothing");
        assert_eq!(log_watch::messages_with(MESSAGE).len(), 0);
        let textures = most_textures(&whole);
        println!("{textures} textures");
        // Every device has 16. Those with arrays of textures need no more.
        let few_textures = (textures > 16).then(|| Limits {
            max_sampled_textures_per_shader_stage: textures - 1,
            ..gpu::limits()
        });
        let few_groups = Limits {
            max_bind_groups: 4,
            ..gpu::limits()
        };
        for (count, limits) in (1..).zip(few_textures.into_iter().chain([few_groups])) {
            let mut few = app(limits, true);
            assert!(few.capture() == without, "the picture differs");
            assert_eq!(log_watch::messages_with(MESSAGE).len(), count);
        }
        let errors = log_watch::messages_with("Caught rendering error");
        assert!(errors.is_empty(), "{errors:?}");
        log_watch::assert_validation_layer_silent();
    });
}
