//! A lean camera in a level in which features come and go one at a time. The bench `stutter` measures the same walk.
//!
//! In processes of their own: many frames, and compilation is delayed in all of the process.

use bevy::prelude::*;
use kit::{
    headless::Picture,
    log_watch,
    metrics::pixel_difference,
    own_process::in_own_process,
    renderer::Renderer,
    walk::{Event, FEATURES, Walk},
};

const SIZE: UVec2 = UVec2::new(96, 64);

/// Features that do not change the picture of a lean camera by themselves: there is no shadow to filter, Bevy draws no decal without binding
/// arrays and no sprite on cameras for meshes, and the camera has no effects.
const UNSEEN: [&str; 5] = [
    "shadow filter",
    "decal",
    "sprite",
    "quality of effects",
    "resolution of effects",
];

fn settled(walk: &mut Walk) -> Picture {
    walk.headless.settle();
    walk.headless.capture()
}

/// The walk shows what it claims to, and its end is its beginning.
#[test]
fn each_feature_is_seen_and_leaves_nothing() {
    in_own_process(|| {
        let mut walk = Walk::new(Renderer::Lean, SIZE, true);
        walk.step();
        let before = settled(&mut walk);
        for (index, feature) in FEATURES.iter().enumerate() {
            let name = feature.name;
            walk.apply(Event::Comes(index));
            let with = settled(&mut walk);
            assert!(walk.is_lean(), "{name}");
            let is_seen = with.size != before.size || pixel_difference(&before, &with).psnr < 55.0;
            assert!(is_seen || UNSEEN.contains(&name), "{name} is not seen");
            walk.apply(Event::Goes(index));
            let after = settled(&mut walk);
            let psnr = pixel_difference(&before, &after).psnr;
            println!("{name}: {psnr:.1} dB from the picture before it");
            assert!(psnr > 60.0, "{name} leaves {psnr:.1} dB");
        }
        log_watch::assert_validation_layer_silent();
    });
}
