//! Views whose size changes from frame to frame keep their last frame, and their textures.

use std::collections::BTreeSet;

use bevy::{
    camera::Viewport,
    prelude::*,
    render::{RenderApp, render_resource::TextureId},
};
use bevy_lean_deferred::effects::{ViewHistory, diffuse_gi::ViewGi, reflections::ViewReflections};
use kit::{
    analytic_light::surface,
    analytic_mirrors::metal,
    hdr::{Light, light, next_light},
    headless::Headless,
    lean::{build, change_cameras},
    own_process::in_own_process,
};

use super::scenes::{SIZE, courtyard, gi, reflections};

const FRAMES: u32 = 12;

/// Sets the part of the target that the camera draws to.
fn drag(headless: &mut Headless, corner: UVec2, size: UVec2) {
    change_cameras(headless, |camera| {
        let mut camera = camera.get_mut::<Camera>().expect("it is one");
        camera.viewport = Some(Viewport {
            physical_position: corner,
            physical_size: size,
            ..default()
        });
    });
}

/// The textures of the view that this frame used, by effect and number.
fn textures(headless: &mut Headless) -> Vec<(&'static str, usize, TextureId)> {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query::<(&ViewGi, &ViewReflections, &ViewHistory)>();
    let (gi, reflections, history) = views.single(world).expect("one camera has all");
    assert!(gi.last().is_some(), "GI lost its last frame");
    assert!(history.last().is_some(), "the history is lost");
    let gi = gi.textures().map(|texture| ("diffuse GI", texture.id()));
    let reflections = reflections.textures();
    let reflections = reflections.map(|texture| ("reflections", texture.id()));
    let history = [("history", history.texture().id())];
    let all = gi.chain(reflections).chain(history).enumerate();
    all.map(|(number, (effect, id))| (effect, number, id))
        .collect()
}

/// RMS of the difference of light in a part of the target.
fn off(a: &Light, b: &Light, corner: UVec2, size: UVec2) -> f32 {
    let rows = corner.y..corner.y + size.y;
    let pixels =
        rows.flat_map(|y| (corner.x..corner.x + size.x).map(move |x| (y * a.size.x + x) as usize));
    let (sum, count) = pixels.fold((0.0, 0), |(sum, count), i| {
        let off = a.texels[i][1] - b.texels[i][1];
        (sum + off * off, count + 1)
    });
    (sum / count as f32).sqrt()
}

/// The edge of a split screen slides, with the corner of the view, so that both its place and its size change.
#[test]
fn a_dragged_view_keeps_its_last_frame() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            let floor = StandardMaterial {
                metallic: 0.5,
                ..metal(0.2)
            };
            // Without a sky, all light of the floor is of the last frame.
            courtyard(s, floor, surface(0.5, 0.3), 0.0, (gi(), reflections()));
        });
        let part = |frame: u32| {
            let left = 240 - 8 * frame;
            (UVec2::new(left, 20), UVec2::new(SIZE.x - left, 300))
        };
        let (corner, size) = part(0);
        drag(&mut headless, corner, size);
        headless.settle();
        headless.frames(70);
        light(&mut headless);
        let mut seen = BTreeSet::new();
        for frame in 1..=FRAMES {
            let (corner, size) = part(frame);
            drag(&mut headless, corner, size);
            let now = next_light(&mut headless);
            seen.extend(textures(&mut headless));
            if frame % 4 != 0 {
                continue;
            }
            headless.frames(6);
            let still = light(&mut headless);
            seen.extend(textures(&mut headless));
            let black = Light {
                size: still.size,
                texels: vec![[0.0; 4]; still.texels.len()],
            };
            let [lag, bright] = [&now, &black].map(|other| off(other, &still, corner, size));
            println!("frame {frame}: off by {lag:.4} of {bright:.4}");
            // Without a last frame all light is missing.
            assert!(lag < 0.1 * bright);
        }
        check_allocations(&seen);
        // The picture is that of textures without headroom: nothing beyond the drawn part is read.
        let (corner, size) = part(FRAMES);
        headless.frames(20);
        let larger = light(&mut headless);
        let before = textures(&mut headless);
        headless.frames(70);
        let exact = light(&mut headless);
        let after = textures(&mut headless);
        assert!(after.iter().all(|texture| !before.contains(texture)));
        let headroom = off(&larger, &exact, corner, size);
        println!("with headroom: off by {headroom:.1e}");
        assert!(headroom < 2e-3);
    });
}

/// Each texture was that of the first size, of the first change, or with headroom.
fn check_allocations(seen: &BTreeSet<(&'static str, usize, TextureId)>) {
    let slots = seen.iter().map(|(_, number, _)| *number);
    for slot in slots.collect::<BTreeSet<_>>() {
        let held = seen.iter().filter(|(_, number, _)| *number == slot);
        let held: Vec<_> = held.collect();
        println!("{}: {} allocations", held[0].0, held.len());
        assert!(held.len() <= 3, "{held:?}");
    }
}
