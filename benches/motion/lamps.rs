//! Small bright lamps above floors.

use figures::benches::motion::LampMeasurement;
use kit::{
    analytic_lamps::{Lamp, LampScene},
    motion::yard::Subject,
};

use crate::{Args, contender::Contender};

const LIGHTS: [f32; 2] = [8.0, 200.0];
const ROUGHNESS: [f32; 5] = [0.05, 0.1, 0.2, 0.3, 0.5];
/// Frames after a cut. The first has no light of a frame before it.
const FRAMES: [usize; 3] = [2, 4, 32];

fn lamps(subject: Subject) -> Vec<Lamp> {
    match subject {
        Subject::Reflections => LIGHTS
            .into_iter()
            .flat_map(|light| ROUGHNESS.map(|roughness| Lamp::OverMetal { light, roughness }))
            .collect(),
        Subject::DiffuseLight => LIGHTS.map(|light| Lamp::OverDiffuse { light }).into(),
    }
}

pub fn measure(
    subject: Subject,
    contender: Contender,
    args: &Args,
    mut measured: impl FnMut(LampMeasurement),
) {
    // Occlusion has no light.
    if (subject, contender) == (Subject::DiffuseLight, Contender::BevyTaa) {
        return;
    }
    for lamp in lamps(subject) {
        let name = contender.name(subject);
        eprintln!("{name}, {lamp:?}");
        let mut scene = LampScene::new(lamp, args.size, |camera| {
            contender.dress(subject, false, camera);
        });
        for frames in FRAMES {
            let errors = scene.errors(frames);
            measured(LampMeasurement {
                device: scene.headless().adapter_and_driver(),
                size: args.size.to_array(),
                subject: subject.name().into(),
                contender: name.into(),
                light: lamp.light(),
                roughness: lamp.roughness(),
                frames,
                rmse: errors.rmse,
                bias: errors.bias,
                rotation: errors.rotation,
            });
        }
    }
}
