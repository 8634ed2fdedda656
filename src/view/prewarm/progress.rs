//! The cameras that are prewarmed, and their progress.

use core::mem::replace;

use bevy::{
    prelude::*,
    render::{
        MainWorld,
        render_resource::PipelineCache,
        sync_world::{MainEntity, MainEntityHashMap},
    },
};

use super::{LeanPrewarm, PrewarmFeatures, PrewarmProgress};
use crate::{
    gpu::pipeline_watch::{PipelineCounts, PipelineWatch},
    view::Demand,
};

/// Pipelines that are requested per frame where Bevy compiles within the frame.
const PIPELINES_PER_FRAME: usize = 2;
/// Frames without a request after which no more are expected. Some effects request theirs once a camera is lean, or once others
/// run.
const QUIET_FRAMES: u32 = 4;

/// In the render world: the cameras that are prewarmed.
#[derive(Resource, Default)]
pub(crate) struct Prewarming(MainEntityHashMap<PrewarmedCamera>);

impl Prewarming {
    /// True while some camera is prewarmed.
    pub(crate) fn is_active(&self) -> bool {
        !self.0.is_empty()
    }

    pub(crate) fn get_mut(&mut self, camera: MainEntity) -> Option<&mut PrewarmedCamera> {
        self.0.get_mut(&camera)
    }

    /// True if `camera`, which has scattering, is prewarmed for surfaces of the level that scatter light beneath them.
    pub(crate) fn scatters(&mut self, camera: MainEntity) -> bool {
        self.0.get_mut(&camera).is_some_and(|camera| {
            camera.scatters = camera.demand.variants.scatter();
            camera.scatters
        })
    }
}

/// The views of a level, as far as the meshes are concerned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PrewarmedView {
    pub(crate) has_motion: bool,
    pub(crate) has_light_layers: bool,
    pub(crate) culls_in_two_phases: bool,
}

/// A camera that is prewarmed.
pub(crate) struct PrewarmedCamera {
    pub(crate) features: Vec<PrewarmFeatures>,
    /// Set once the state of the camera is decided.
    pub(crate) view: Option<PrewarmedView>,
    /// The demand of all meshes of the level that the G-buffer can carry.
    pub(crate) demand: Demand,
    /// Light scatters beneath some of these meshes on this camera.
    pub(crate) scatters: bool,
    /// Meshes whose assets are still loading.
    pub(crate) loading_meshes: usize,
    /// Lighting pipelines that fit the level and were not requested. They are requested last, because effects that run ask
    /// lighting to take part.
    pub(crate) awaited_lighting: usize,
    /// True once these may be requested.
    pub(crate) requests_lighting: bool,
    /// Pipelines that were settled when it began.
    settled_before: usize,
    /// Those that were settled in the last frame.
    settled: usize,
    quiet_frames: u32,
}

impl PrewarmedCamera {
    fn new(features: Vec<PrewarmFeatures>, settled_before: usize) -> Self {
        Self {
            features,
            view: None,
            demand: Demand::default(),
            scatters: false,
            loading_meshes: 0,
            awaited_lighting: 0,
            requests_lighting: false,
            settled_before,
            settled: settled_before,
            quiet_frames: 0,
        }
    }

    /// All features that are named.
    pub(crate) fn all_features(&self) -> PrewarmFeatures {
        self.features.iter().copied().collect()
    }

    /// Ends a frame with these pipelines, and those that were `withheld` in it.
    fn count_frame(&mut self, counts: PipelineCounts, withheld: usize) -> PrewarmProgress {
        let outstanding = counts.waiting + withheld + self.loading_meshes;
        let is_unchanged = replace(&mut self.settled, counts.settled) == counts.settled;
        let is_quiet = outstanding == 0 && is_unchanged && self.view.is_some();
        self.quiet_frames = if is_quiet { self.quiet_frames + 1 } else { 0 };
        let is_over = self.quiet_frames >= QUIET_FRAMES;
        let is_done = is_over && self.requests_lighting && self.awaited_lighting == 0;
        if is_over && !self.requests_lighting {
            self.requests_lighting = true;
            self.quiet_frames = 0;
        }
        let done = counts.settled.saturating_sub(self.settled_before);
        PrewarmProgress {
            done,
            total: done + outstanding + self.awaited_lighting,
            is_done,
        }
    }
}

/// Begins the prewarms of cameras, copies the progress of the last frame to them, and ends those that are done. Sets how many
/// pipelines may be requested in the next frame.
pub(super) fn follow_prewarms(
    mut main_world: ResMut<MainWorld>,
    mut prewarming: ResMut<Prewarming>,
    mut watch: ResMut<PipelineWatch>,
    cache: Res<PipelineCache>,
) {
    let counts = watch.count(&cache);
    let withheld = watch.budget.withheld();
    let prewarming = &mut prewarming.0;
    prewarming.retain(|camera, prewarmed| {
        let Some(mut prewarm) = main_world.get_mut::<LeanPrewarm>(camera.id()) else {
            return false;
        };
        if prewarm.progress.is_done {
            return false;
        }
        if prewarm.features != prewarmed.features {
            *prewarmed = PrewarmedCamera::new(prewarm.features.clone(), prewarmed.settled_before);
            return true;
        }
        let progress = prewarmed.count_frame(counts, withheld);
        if prewarm.progress != progress {
            prewarm.progress = progress;
        }
        !progress.is_done
    });
    let mut cameras = main_world.query::<(Entity, &LeanPrewarm)>();
    for (camera, prewarm) in cameras.iter(&main_world) {
        if !prewarm.progress.is_done {
            prewarming
                .entry(camera.into())
                .or_insert_with(|| PrewarmedCamera::new(prewarm.features.clone(), counts.settled));
        }
    }
    let is_limited = !prewarming.is_empty() && !watch.compiles_in_background();
    watch
        .budget
        .begin_frame(is_limited.then_some(PIPELINES_PER_FRAME));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(settled: usize, waiting: usize) -> PipelineCounts {
        PipelineCounts { settled, waiting }
    }

    /// Ends quiet frames until something changes. Returns the last progress.
    fn quiet(camera: &mut PrewarmedCamera, settled: usize) -> PrewarmProgress {
        let mut progress = PrewarmProgress::default();
        for _ in 0..=QUIET_FRAMES {
            progress = camera.count_frame(counts(settled, 0), 0);
        }
        progress
    }

    #[test]
    fn lighting_comes_last_and_counts_from_the_start() {
        let mut camera = PrewarmedCamera::new(Vec::new(), 5);
        // Nothing is decided yet.
        assert!(!quiet(&mut camera, 5).is_done);
        assert!(!camera.requests_lighting);

        camera.view = Some(PrewarmedView::default());
        camera.awaited_lighting = 2;
        let progress = camera.count_frame(counts(6, 1), 3);
        assert_eq!((progress.done, progress.total), (1, 7));
        let progress = quiet(&mut camera, 10);
        assert_eq!((progress.done, progress.total), (5, 7));
        assert!(camera.requests_lighting && !progress.is_done);

        camera.awaited_lighting = 0;
        let progress = camera.count_frame(counts(10, 1), 1);
        assert_eq!((progress.done, progress.total), (5, 7));
        let progress = quiet(&mut camera, 12);
        assert_eq!((progress.done, progress.total), (7, 7));
        assert!(progress.is_done);
    }

    #[test]
    fn loading_meshes_are_waited_for() {
        let mut camera = PrewarmedCamera::new(Vec::new(), 0);
        camera.view = Some(PrewarmedView::default());
        camera.requests_lighting = true;
        camera.loading_meshes = 1;
        let progress = quiet(&mut camera, 4);
        assert_eq!((progress.done, progress.total), (4, 5));
        assert!(!progress.is_done);
        camera.loading_meshes = 0;
        assert!(quiet(&mut camera, 5).is_done);
    }
}
