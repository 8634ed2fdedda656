//! The systems of an effect are skipped while no camera has it.

use bevy::{light::NotShadowReceiver, prelude::*};
use bevy_lean_deferred::prelude::*;

use super::{SIZE, solids};
use kit::{
    headless::Headless,
    lean::{active_lean_views, judge, report, settled},
    own_process::in_own_process,
    scenes::{LEAST_PSNR, SceneBuilder},
};

fn change(headless: &mut Headless, material: &Handle<StandardMaterial>, emissive: f32) {
    let mut materials = headless.world().resource_mut::<Assets<StandardMaterial>>();
    let mut material = materials.get_mut(material).expect("it is there");
    material.emissive = LinearRgba::rgb(0.0, emissive, 0.2);
    material.clearcoat = 1.0 - emissive;
}

/// Materials and meshes that change while no camera is lean are drawn with their changes once one is.
#[test]
fn changes_while_no_camera_is_lean_show_once_one_is() {
    in_own_process(|| {
        let (mut headless, camera) = solids(Headless::new(SIZE));
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        let material = s.add(StandardMaterial::from(Color::srgb(0.7, 0.2, 0.1)));
        let mesh = s.add::<Mesh>(Sphere::new(0.4));
        let [ball, receiver] = [-0.8, 0.8].map(|x| {
            let place = Transform::from_xyz(x, 0.9, 1.2);
            let material = MeshMaterial3d(material.clone());
            s.spawn((Mesh3d(mesh.clone()), material, place))
        });
        let set_lean = |headless: &mut Headless, is_lean: bool| {
            let mut camera = headless.world().entity_mut(camera);
            match is_lean {
                true => camera.insert(LeanDeferred::default()),
                false => camera.remove::<LeanDeferred>(),
            };
        };
        let mut results = Vec::new();
        // Before the first lean camera, and after one.
        for (name, emissive) in [("before", 0.4), ("after", 0.1)] {
            set_lean(&mut headless, false);
            headless.frames(10);
            change(&mut headless, &material, emissive);
            let mut receiver = headless.world().entity_mut(receiver);
            receiver.insert(NotShadowReceiver);
            headless.frames(10);
            let forward = settled(&mut headless);
            set_lean(&mut headless, true);
            let lean = settled(&mut headless);
            assert_eq!(active_lean_views(&mut headless), 1);
            results.push(judge(name, &forward, &lean, LEAST_PSNR));
            headless.world().entity_mut(ball).insert(NotShadowReceiver);
        }
        report(results);
    });
}
