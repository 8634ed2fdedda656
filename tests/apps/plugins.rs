//! Each plugin alone and with others, in any order, and with parts of Bevy missing.

mod ambiguity;
mod broken_shaders;
mod order;
mod passes;
mod unused;

use bevy::prelude::*;
use bevy_lean_deferred::{
    LeanAutoExposurePlugin, LeanDeferredPlugin, LeanScreenSpaceAmbientOcclusionPlugin, prelude::*,
};
use kit::{
    headless::{Headless, Picture, small_shadow_maps},
    lean::{active_lean_views, instant_exposure, settled},
    scenes::SceneBuilder,
};

const SIZE: UVec2 = UVec2::new(160, 120);

/// Effects of an app or a camera.
#[derive(Clone, Copy, Debug)]
struct Effects {
    deferred: bool,
    occlusion: bool,
    exposure: bool,
}

impl Effects {
    const NONE: Self = Self::from_bits(0);
    const ALL: Self = Self::from_bits(7);

    const fn from_bits(bits: u32) -> Self {
        Self {
            deferred: bits & 1 != 0,
            occlusion: bits & 2 != 0,
            exposure: bits & 4 != 0,
        }
    }

    /// An app with the plugins of these effects, added one by one, that shows the solids.
    fn app(self) -> (Headless, Entity) {
        let mut app = App::new();
        app.add_plugins(Headless::default_plugins());
        if self.deferred {
            app.add_plugins(LeanDeferredPlugin);
        }
        if self.occlusion {
            app.add_plugins(LeanScreenSpaceAmbientOcclusionPlugin);
        }
        if self.exposure {
            app.add_plugins(LeanAutoExposurePlugin);
        }
        solids(Headless::from_app(SIZE, app, small_shadow_maps))
    }

    fn put_on(self, camera: &mut EntityWorldMut) {
        camera.remove::<(
            LeanDeferred,
            LeanScreenSpaceAmbientOcclusion,
            LeanAutoExposure,
        )>();
        if self.deferred {
            camera.insert(LeanDeferred::default());
        }
        if self.occlusion {
            camera.insert(LeanScreenSpaceAmbientOcclusion {
                intensity: 3.0,
                ..default()
            });
        }
        if self.exposure {
            camera.insert(instant_exposure());
        }
    }
}

/// The solids, and the camera that sees them.
fn solids(mut headless: Headless) -> (Headless, Entity) {
    let mut scene = SceneBuilder {
        headless: &mut headless,
    };
    scene.solids();
    scene.sun(true);
    let camera = scene.default_camera(());
    (headless, camera)
}

fn picture(headless: &mut Headless, camera: Entity, effects: Effects) -> (Picture, usize) {
    effects.put_on(&mut headless.world().entity_mut(camera));
    let picture = settled(headless);
    (picture, active_lean_views(headless))
}

#[test]
fn each_pair_of_plugins_renders_as_the_group() {
    check_plugins([3, 5, 6]);
}

#[test]
#[ignore = "nightly: each pair has them"]
fn each_plugin_alone_and_all_of_them_render_as_the_group() {
    check_plugins([1, 2, 4, 7]);
}

/// Compares apps that have only the plugins of these bits with one that has the group.
fn check_plugins<const N: usize>(apps: [u32; N]) {
    let (mut group, camera) = solids(Headless::new(SIZE));
    let (plain, _) = picture(&mut group, camera, Effects::NONE);
    for bits in apps {
        let effects = Effects::from_bits(bits);
        let (expected, lean_views) = picture(&mut group, camera, effects);
        assert_eq!(lean_views, usize::from(effects.deferred), "{effects:?}");
        assert!(expected != plain || bits == 1, "{effects:?} shows nothing");

        let (mut app, camera) = effects.app();
        // With the components of all effects, as in an app that leaves a plugin out.
        let (found, lean_views) = picture(&mut app, camera, Effects::ALL);
        assert_eq!(lean_views, usize::from(effects.deferred), "{effects:?}");
        assert!(
            found == expected,
            "{effects:?} alone: {:?}",
            kit::metrics::difference(&expected, &found)
        );
    }
}
