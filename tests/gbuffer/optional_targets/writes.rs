//! A mesh writes the optional targets that it needs, whatever others need.

use bevy::{
    core_pipeline::prepass::MotionVectorPrepass,
    prelude::*,
    render::{
        RenderApp,
        render_resource::{ColorWrites, PipelineCache, PipelineDescriptor, TextureFormat},
    },
};
use bevy_lean_deferred::gbuffer::GBufferTargets;

use super::{SMALL, usage};
use kit::{
    headless::Headless,
    lean::{build, set_lean},
    own_process::in_own_process,
    scenes::build::material,
};

/// Number of optional targets that each pipeline of the G-buffer writes.
fn valid_mask(headless: &Headless) -> Vec<usize> {
    let world = headless.app.sub_app(RenderApp).world();
    (world.resource::<PipelineCache>().pipelines())
        .filter_map(|pipeline| match &pipeline.descriptor {
            PipelineDescriptor::RenderPipelineDescriptor(descriptor) => Some(descriptor),
            PipelineDescriptor::ComputePipelineDescriptor(_) => None,
        })
        .filter(|descriptor| descriptor.label.as_deref() == Some("lean_deferred/gbuffer"))
        .filter_map(|descriptor| descriptor.fragment.as_ref())
        .map(|fragment| {
            let words = (fragment.targets.iter().flatten()).filter(|target| {
                target.format == TextureFormat::R32Uint && target.write_mask != ColorWrites::empty()
            });
            // Without the two base targets.
            words.count() - 2
        })
        .collect()
}

#[test]
fn meshes_write_what_they_need() {
    in_own_process(|| {
        let mut mover = Entity::PLACEHOLDER;
        let mut headless = build(SMALL, |s| {
            s.solids();
            s.sun(false);
            let masked = |base: StandardMaterial| StandardMaterial {
                alpha_mode: AlphaMode::Mask(0.5),
                ..base
            };
            let clay = || material((0.8, 0.3, 0.2), 0.0, 0.5);
            let glow = || StandardMaterial {
                emissive: LinearRgba::rgb(0.0, 0.4, 0.1),
                ..clay()
            };
            let coat = || StandardMaterial {
                clearcoat: 1.0,
                ..clay()
            };
            let materials = [
                glow(),
                coat(),
                masked(clay()),
                masked(glow()),
                masked(coat()),
            ];
            for (x, material) in (0..).zip(materials) {
                s.mesh(
                    Sphere::new(0.3),
                    material,
                    Transform::from_xyz(x as f32 * 0.8 - 1.6, 1.6, 0.0),
                );
            }
            mover = s.mesh(Sphere::new(0.3), clay(), Transform::from_xyz(0.0, 0.3, 2.0));
            s.default_camera(MotionVectorPrepass);
        });
        set_lean(&mut headless, true);
        for frame in 0..60 {
            let mut mover = headless.world().entity_mut(mover);
            let mut place = mover.get_mut::<Transform>().expect("it has a place");
            place.translation.x = (frame % 4) as f32 * 0.1;
            headless.frames(1);
        }
        let all = GBufferTargets::EMISSIVE
            .union(GBufferTargets::SPECIALIZATION)
            .union(GBufferTargets::MOTION);
        assert_eq!(usage(&mut headless).targets, all);
        let written = valid_mask(&headless);
        println!("{written:?}");
        assert!(written.contains(&1));
        assert!(written.iter().all(|count| *count <= 1), "{written:?}");
    });
}
