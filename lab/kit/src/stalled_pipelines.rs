//! Delays pipeline compilation for as long as a test wants.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use bevy::tasks::AsyncComputeTaskPool;

/// Limit of the delay: Bevy itself waits for a pipeline of its upscaling, and would wait for ever.
const LONGEST: Duration = Duration::from_secs(20);

/// While alive, it occupies all threads that compile pipelines. For apps that compile asynchronously.
pub struct StalledPipelines(Arc<AtomicBool>);

impl StalledPipelines {
    pub fn new() -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let pool = AsyncComputeTaskPool::get();
        let began = Instant::now();
        for _ in 0..pool.thread_num() {
            let is_over = is_over.clone();
            pool.spawn(async move {
                while !is_over.load(Ordering::Relaxed) && began.elapsed() < LONGEST {
                    std::thread::sleep(Duration::from_millis(1));
                }
            })
            .detach();
        }
        Self(is_over)
    }
}

impl Drop for StalledPipelines {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
