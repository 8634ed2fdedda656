use bevy::{prelude::*, render::RenderApp};
use bevy_lean_deferred::{prelude::*, screen_space::reflections::ViewReflections};
use kit::{
    hdr::read_light,
    headless::Headless,
    scenes::boxes::{self, Boxes},
};

#[test]
fn stats() {
    let size = UVec2::new(640, 352);
    let mut headless = Headless::with(size, |_| {});
    boxes::spawn_into(headless.world(), Boxes::small(64));
    let target = headless.render_target();
    headless.world().spawn((
        Camera3d::default(),
        bevy::camera::Hdr,
        Msaa::Off,
        target,
        boxes::camera_transform(Boxes::small(64)),
        LeanDeferred::default(),
        LeanScreenSpaceReflections {
            quality: ScreenSpaceReflectionsQuality::High,
            ..default()
        },
    ));
    headless.settle();
    headless.frames(4);
    headless.capture().save("/tmp/lp/boxes.png");
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query::<&ViewReflections>();
    let rays = views
        .single(world)
        .unwrap()
        .textures()
        .nth(1)
        .unwrap()
        .clone();
    let light = read_light(&headless, &rays);
    let traced: Vec<_> = light.texels.iter().filter(|t| t[0] > 0.0).collect();
    let n = traced.len() as f32;
    for c in 0..4 {
        let mut all: Vec<f32> = traced.iter().map(|t| t[c]).collect();
        all.sort_by(f32::total_cmp);
        let q = |p: f32| all[((all.len() - 1) as f32 * p) as usize];
        println!(
            "{c}: mean {:.2} quantiles {:?}",
            all.iter().sum::<f32>() / n,
            [0.1, 0.25, 0.5, 0.75, 0.9, 0.97].map(q)
        );
    }
    println!("{} of {}", n, light.texels.len());
    // Per 8x8 texels of a phase: what a subgroup of 32 waits for.
    let w = light.size.x as usize;
    let h = light.size.y as usize;
    for phased in [false, true] {
        let mut sum = 0.0;
        let mut count = 0.0;
        for ty in 0..h / 32 {
            for tx in 0..w / 32 {
                for g in 0..16 {
                    for half in 0..2 {
                        let mut most = 0.0f32;
                        let mut any = 0.0f32;
                        for i in 0..32 {
                            let i = i + 32 * half;
                            let (x, y) = (i % 8, i / 8);
                            let (x, y) = if phased {
                                (4 * x + g % 4, 4 * y + g / 4)
                            } else {
                                (x + 8 * (g % 4), y + 8 * (g / 4))
                            };
                            let t = light.texels[(ty * 32 + y) * w + tx * 32 + x];
                            most = most.max(t[0]);
                            any = any.max(t[1]);
                        }
                        sum += most;
                        count += 1.0;
                        let _ = any;
                    }
                }
            }
        }
        println!(
            "phased {phased}: subgroup's most cell steps {:.2}",
            sum / count
        );
    }
}
