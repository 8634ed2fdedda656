//! Skips the systems of effects that no camera has. An app with the plugins alone pays for a few run conditions per frame.

use bevy::{
    core_pipeline::schedule::{Core2d, Core3d},
    ecs::query::QueryFilter,
    prelude::*,
    render::{Extract, ExtractSchedule, Render, renderer::CurrentView},
};

/// The systems of an effect in the schedules of the render world. They are skipped while no camera has the effect.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum EffectSystems {
    /// The systems of the G-buffer and of lighting.
    Lean,
    SubsurfaceScattering,
    AmbientOcclusion,
    AutoExposure,
    DiffuseGi,
    Reflections,
    History,
    /// The systems that draw debug views over the picture.
    DebugViews,
    /// The systems that count memory for cameras that ask for it.
    Memory,
}

/// Frames for which systems keep running after the last camera lost the effect: they release resources that they keep per frame.
const LINGERING_FRAMES: u32 = 4;

/// True while used and for [`LINGERING_FRAMES`] after that; `left` counts down.
fn lingers(is_used: bool, left: &mut u32) -> bool {
    let runs = is_used || *left > 0;
    *left = if is_used {
        LINGERING_FRAMES
    } else {
        left.saturating_sub(1)
    };
    runs
}

fn is_used_in_main_world<F: QueryFilter + 'static>(
    cameras: Extract<Query<(), F>>,
    mut left: Local<u32>,
) -> bool {
    lingers(!cameras.is_empty(), &mut left)
}

fn is_used<F: QueryFilter + 'static>(views: Query<(), F>, mut left: Local<u32>) -> bool {
    lingers(!views.is_empty(), &mut left)
}

/// True if the current view has the effect. Passes affect no other views, so they need not linger.
fn is_used_by_view<F: QueryFilter + 'static>(
    view: Option<Res<CurrentView>>,
    views: Query<(), F>,
) -> bool {
    view.is_some_and(|view| views.contains(view.0))
}

impl EffectSystems {
    /// Runs the systems of the set while a camera matches `F`, and its passes on views that do.
    pub(crate) fn run_while<F: QueryFilter + 'static>(self, render_app: &mut SubApp) {
        render_app
            .configure_sets(
                ExtractSchedule,
                self.clone().run_if(is_used_in_main_world::<F>),
            )
            .configure_sets(Render, self.clone().run_if(is_used::<F>))
            .configure_sets(Core3d, self.clone().run_if(is_used_by_view::<F>))
            .configure_sets(Core2d, self.run_if(is_used_by_view::<F>));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_linger_after_the_last_use() {
        let mut left = 0;
        assert!(!lingers(false, &mut left));
        assert!(lingers(true, &mut left));
        let runs = [(); LINGERING_FRAMES as usize].map(|()| lingers(false, &mut left));
        assert!(runs.into_iter().all(|runs| runs));
        assert!(!lingers(false, &mut left));
        assert!(lingers(true, &mut left));
    }
}
