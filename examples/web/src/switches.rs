//! Switches of the page: components of the camera that it inserts and removes at run time.

use core::sync::atomic::{AtomicU32, Ordering};

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::{camera::View, motion::Motion};

/// A switch's name, and its effect on a camera.
struct Switch {
    name: &'static str,
    insert: fn(&mut EntityCommands),
    remove: fn(&mut EntityCommands),
}

/// A switch that inserts and removes a component.
const fn component<C: Component + Default>(name: &'static str) -> Switch {
    Switch {
        name,
        insert: |camera| {
            camera.insert(C::default());
        },
        remove: |camera| {
            camera.remove::<C>();
        },
    }
}

const SWITCHES: [Switch; 6] = [
    component::<LeanDeferred>("lean"),
    component::<LeanScreenSpaceAmbientOcclusion>("ambient-occlusion"),
    component::<LeanScreenSpaceGi>("diffuse-gi"),
    component::<LeanScreenSpaceReflections>("reflections"),
    component::<LeanSubsurfaceScattering>("subsurface-scattering"),
    Switch {
        name: "auto-exposure",
        insert: |camera| {
            // Keeps a night dark.
            camera.insert(LeanAutoExposure {
                target: 0.1,
                ..default()
            });
        },
        remove: |camera| {
            camera.remove::<LeanAutoExposure>();
        },
    },
];

/// Name of the switch of all motion, beside those of the camera.
const MOTION: &str = "motion";

/// Bit of the renderer, the first of [`SWITCHES`].
const LEAN: u32 = 1;

/// One bit for each of [`SWITCHES`], and one for [`MOTION`]. The page writes it between frames.
static ON: AtomicU32 = AtomicU32::new(0);

/// Switches something on or off. Returns false if nothing has that name.
#[wasm_bindgen]
pub fn set_switch(name: &str, on: bool) -> bool {
    let mut names = SWITCHES.iter().map(|switch| switch.name).chain([MOTION]);
    let Some(index) = names.position(|other| other == name) else {
        return false;
    };
    if on {
        ON.fetch_or(1 << index, Ordering::Relaxed);
    } else {
        ON.fetch_and(!(1 << index), Ordering::Relaxed);
    }
    true
}

/// Applies the page's switches to the camera and to [`Motion`].
pub fn apply(
    mut commands: Commands,
    camera: Single<Entity, With<View>>,
    mut motion: ResMut<Motion>,
    mut applied: Local<u32>,
) {
    let on = ON.load(Ordering::Relaxed);
    let mut camera = commands.entity(*camera);
    for (index, switch) in SWITCHES.iter().enumerate() {
        match (on >> index & 1, *applied >> index & 1) {
            (1, 0) => (switch.insert)(&mut camera),
            (0, 1) => (switch.remove)(&mut camera),
            _ => {}
        }
    }
    // Effects that need it add it, but the page chooses the renderer.
    if on != *applied && on & LEAN == 0 {
        camera.remove::<LeanDeferred>();
    }
    motion.set_if_neq(Motion(on >> SWITCHES.len() & 1 == 1));
    *applied = on;
}
