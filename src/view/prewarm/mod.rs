//! Prewarming: pipelines are compiled during a loading screen.
//!
//! [`LeanPrewarm`] on a camera of the main world becomes a [`PrewarmedCamera`] of the render world until it is done. Each stage
//! requests what the camera will need: the effects by themselves, the G-buffer the pipelines of the meshes of the main world
//! (`gbuffer/prewarm.rs`), activation those of lighting (`activation/prewarm.rs`).
//!
//! - `settings.rs`: the component, and features of a level.
//! - `impossible.rs`: ends prewarms of cameras that cannot be lean.
//! - `progress.rs`: the cameras that are prewarmed, and their progress.

mod impossible;
mod progress;
mod settings;

pub(crate) use progress::{PrewarmedCamera, PrewarmedView, Prewarming};
pub use settings::{LeanPrewarm, PrewarmFeatures, PrewarmProgress};

use bevy::{
    prelude::*,
    render::{Extract, ExtractSchedule, RenderApp},
};

/// The systems of `ExtractSchedule` that collect what the main world has, while cameras are prewarmed.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct PrewarmExtraction;

pub(super) fn add_to(app: &mut App) {
    app.register_type::<LeanPrewarm>().add_systems(
        Last,
        impossible::end_impossible_prewarms.run_if(any_with_component::<LeanPrewarm>),
    );
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
        return;
    };
    render_app
        .init_resource::<Prewarming>()
        .configure_sets(
            ExtractSchedule,
            PrewarmExtraction.run_if(|prewarming: Res<Prewarming>| prewarming.is_active()),
        )
        .add_systems(
            ExtractSchedule,
            progress::follow_prewarms
                .before(PrewarmExtraction)
                .ambiguous_with_all()
                .run_if(is_any_known),
        );
}

/// True if there is a camera to begin with or to end.
fn is_any_known(prewarming: Res<Prewarming>, cameras: Extract<Query<&LeanPrewarm>>) -> bool {
    prewarming.is_active() || cameras.iter().any(|prewarm| !prewarm.progress.is_done)
}
