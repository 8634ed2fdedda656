//! Surfaces that packing and depth could distort, against Bevy forward and Bevy deferred.

mod dark_albedo;

use bevy::{
    camera::Camera3d, core_pipeline::prepass::DepthPrepass, ecs::world::CommandQueue,
    pbr::DefaultOpaqueRendererMethod, prelude::*,
};
use kit::{
    headless::{Headless, Picture},
    lean::{active_lean_views, settled, show},
    log_watch,
    metrics::{Difference, pixel_difference},
    renderer::Renderer,
    scenes::SceneBuilder,
};

/// One scene as each renderer renders it.
struct Pictures {
    forward: Picture,
    deferred: Picture,
    lean: Picture,
}

impl Pictures {
    fn of(headless: &mut Headless, scene: impl Fn(&mut SceneBuilder)) -> Self {
        let [forward, deferred, lean] =
            Renderer::ALL.map(|renderer| picture(headless, &scene, renderer));
        Self {
            forward,
            deferred,
            lean,
        }
    }

    /// Prints the differences of Bevy deferred and lean from forward. Saves the pictures to the folder that `PARITY_PICTURES` names, if
    /// set.
    fn compare(&self, name: &str) -> [Difference; 2] {
        if let Some(folder) = std::env::var_os("PARITY_PICTURES") {
            let folder = std::path::Path::new(&folder);
            self.forward
                .save(folder.join(format!("{name}_forward.png")));
            self.deferred
                .save(folder.join(format!("{name}_deferred.png")));
            self.lean.save(folder.join(format!("{name}_lean.png")));
        }
        let differences =
            [&self.deferred, &self.lean].map(|test| pixel_difference(&self.forward, test));
        for (renderer, difference) in ["Bevy deferred", "lean"].into_iter().zip(&differences) {
            println!("{name:24} {renderer:14} {difference}");
        }
        differences
    }
}

fn picture(
    headless: &mut Headless,
    scene: impl FnOnce(&mut SceneBuilder),
    renderer: Renderer,
) -> Picture {
    // Bevy reads the method when it prepares a material, so each picture has materials of its own.
    let mut method = headless
        .world()
        .resource_mut::<DefaultOpaqueRendererMethod>();
    match renderer {
        Renderer::BevyDeferred => method.set_to_deferred(),
        Renderer::Forward | Renderer::Lean => method.set_to_forward(),
    }
    show(headless, scene);
    let world = headless.world();
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let cameras: Vec<Entity> = cameras.iter(world).collect();
    let mut queue = CommandQueue::default();
    let mut commands = Commands::new(&mut queue, world);
    for camera in cameras {
        renderer.prepare_camera(&mut commands.entity(camera));
    }
    queue.apply(world);
    let picture = settled(headless);
    let is_lean = active_lean_views(headless) == 1;
    assert_eq!(is_lean, renderer == Renderer::Lean);
    let world = headless.world();
    let mut prepasses = world.query_filtered::<(), With<DepthPrepass>>();
    let has_prepass = prepasses.iter(world).next().is_some();
    assert_eq!(has_prepass, renderer == Renderer::BevyDeferred);
    picture
}

/// Panics with all failures.
fn report(failures: &[String]) {
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
    log_watch::assert_validation_layer_silent();
}
