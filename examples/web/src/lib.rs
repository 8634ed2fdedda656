//! The showcase as a page in the browser, by WebGPU: Bevy's forward renderer and this crate's on one camera, and every
//! effect.
//!
//! `sh examples/web/build.sh` builds the page, `sh examples/web/test.sh` tests it in a headless browser.

mod camera;
mod clusters;
mod motion;
mod report;
mod switches;

use bevy::{prelude::*, window::PresentMode};
use bevy_lean_deferred::LeanDeferredPlugins;
use street::{Detail, StreetPlugin};
use wasm_bindgen::prelude::wasm_bindgen;

use motion::Motion;

/// Starts the app on the canvas with this selector. Returns at once: the browser drives the frames.
///
/// `amount` is the share of the street to spawn, up to 1: software renderers need less.
#[wasm_bindgen]
pub fn start(canvas: String, amount: f32) {
    let window = Window {
        canvas: Some(canvas),
        fit_canvas_to_parent: true,
        present_mode: PresentMode::AutoVsync,
        ..default()
    };
    App::new()
        .add_plugins((
            DefaultPlugins.set(WindowPlugin {
                primary_window: Some(window),
                ..default()
            }),
            LeanDeferredPlugins,
            StreetPlugin {
                detail: detail(amount),
            },
            report::plugin,
        ))
        .init_resource::<Motion>()
        .add_systems(Startup, (camera::spawn, clusters::reserve))
        .add_systems(
            Update,
            (
                switches::apply,
                camera::sway,
                motion::walk_or_stand.run_if(resource_changed::<Motion>),
            )
                .chain(),
        )
        .run();
}

fn detail(amount: f32) -> Detail {
    let all = Detail::SMALL;
    let share = |count: usize| (count as f32 * amount).ceil() as usize;
    Detail {
        far: all.near - all.length() * amount.max(0.5),
        bulbs: share(all.bulbs),
        shadowed_lamps: share(all.shadowed_lamps),
        figures: share(all.figures),
        ..all
    }
}
