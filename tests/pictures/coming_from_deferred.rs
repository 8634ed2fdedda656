//! An app that migrates from Bevy's deferred renderer: all materials have the method `Deferred`, and `LeanDeferred` replaces
//! `DeferredPrepass` on its cameras. Every mesh is drawn and matches forward, with any other prepass.

use bevy::{
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass},
    pbr::{DefaultOpaqueRendererMethod, DistanceFog, ScreenSpaceAmbientOcclusion},
    prelude::*,
    render::occlusion_culling::OcclusionCulling,
};
use bevy_lean_deferred::LeanDeferred;
use kit::{
    headless::Headless,
    lean::{active_lean_views, change_cameras, judge, report, set_lean, settled, show},
    log_watch,
    own_process::in_own_process,
    scenes::SceneBuilder,
};

const SIZE: UVec2 = UVec2::new(160, 120);

/// Surfaces that the G-buffer carries, including alpha-masked ones, and surfaces that forward must draw.
fn scene(s: &mut SceneBuilder) {
    s.solids();
    s.sun(true);
    let front = |x| Transform::from_xyz(x, 0.5, 1.8);
    s.mesh(
        Sphere::new(0.4),
        StandardMaterial {
            base_color: Color::srgba(0.9, 0.8, 0.2, 0.7),
            alpha_mode: AlphaMode::Mask(0.5),
            ..default()
        },
        front(-1.2),
    );
    // Drawn by forward, for its two shading models.
    s.mesh(
        Sphere::new(0.4),
        StandardMaterial {
            base_color: Color::srgb(0.2, 0.7, 0.9),
            clearcoat: 1.0,
            anisotropy_strength: 0.5,
            ..default()
        },
        front(0.0),
    );
    s.mesh(
        Sphere::new(0.4),
        StandardMaterial {
            base_color: Color::srgba(0.9, 0.2, 0.9, 0.5),
            alpha_mode: AlphaMode::Blend,
            ..default()
        },
        front(1.2),
    );
    // Alpha-masked, with two shading models.
    s.mesh(
        Sphere::new(0.3),
        StandardMaterial {
            base_color: Color::srgba(0.3, 0.9, 0.3, 0.9),
            alpha_mode: AlphaMode::Mask(0.5),
            clearcoat: 1.0,
            anisotropy_strength: 0.5,
            ..default()
        },
        front(2.2),
    );
}

fn app_with(method: DefaultOpaqueRendererMethod) -> Headless {
    let mut headless = Headless::new(SIZE);
    headless.world().insert_resource(method);
    headless
}

type ChangeCamera = fn(&mut EntityWorldMut);
type Camera = (&'static str, ChangeCamera);

/// Replaces the shown scene by this one, seen by a camera that `camera` changes.
fn show_through(headless: &mut Headless, camera: ChangeCamera) {
    show(headless, |s| {
        scene(s);
        let entity = s.default_camera(());
        camera(&mut s.world().entity_mut(entity));
    });
}

const CAMERAS: [Camera; 7] = [
    ("no_prepass", |_| {}),
    ("depth", |camera| {
        camera.insert(DepthPrepass);
    }),
    ("normal", |camera| {
        camera.insert(NormalPrepass);
    }),
    ("motion", |camera| {
        camera.insert(MotionVectorPrepass);
    }),
    ("depth_and_motion", |camera| {
        camera.insert((DepthPrepass, MotionVectorPrepass, OcclusionCulling));
    }),
    ("all", |camera| {
        camera.insert((DepthPrepass, NormalPrepass, MotionVectorPrepass));
    }),
    ("ssao_and_fog", |camera| {
        camera.insert((
            ScreenSpaceAmbientOcclusion::default(),
            DistanceFog {
                color: Color::srgb(0.5, 0.55, 0.6),
                falloff: FogFalloff::Linear {
                    start: 3.0,
                    end: 12.0,
                },
                ..default()
            },
        ));
    }),
];

#[test]
fn every_mesh_is_there() {
    in_own_process(|| compare_all(&[CAMERAS[0], CAMERAS[5], CAMERAS[6]]));
}

#[test]
#[ignore = "nightly: prepasses one by one"]
fn every_mesh_is_there_with_single_prepasses() {
    in_own_process(|| compare_all(&CAMERAS[1..5]));
}

fn compare_all(cameras: &[Camera]) {
    let mut all_forward = app_with(DefaultOpaqueRendererMethod::forward());
    let mut all_deferred = app_with(DefaultOpaqueRendererMethod::deferred());
    report(cameras.iter().map(|&(name, camera)| {
        show_through(&mut all_forward, camera);
        let forward = settled(&mut all_forward);
        show_through(&mut all_deferred, camera);
        set_lean(&mut all_deferred, true);
        let lean = settled(&mut all_deferred);
        assert_eq!(active_lean_views(&mut all_deferred), 1, "{name}");
        judge(name, &forward, &lean, 44.0)
    }));
}

/// A lean camera that cannot be rendered lean, as with MSAA, is rendered by forward with the same meshes.
#[test]
#[ignore = "nightly: cameras that Bevy renders"]
fn every_mesh_is_there_without_the_gbuffer() {
    in_own_process(|| {
        let mut apps = [
            DefaultOpaqueRendererMethod::forward(),
            DefaultOpaqueRendererMethod::deferred(),
        ]
        .map(app_with);
        report([CAMERAS[0], CAMERAS[1], CAMERAS[3]].map(|(name, camera)| {
            let [forward, lean] = apps.each_mut().map(|headless| {
                show_through(headless, camera);
                set_lean(headless, true);
                change_cameras(headless, |camera| {
                    camera.insert(Msaa::Sample4);
                });
                let picture = settled(headless);
                assert_eq!(active_lean_views(headless), 0, "{name}");
                picture
            });
            judge(&format!("{name}_msaa"), &forward, &lean, 80.0)
        }));
    });
}

/// Prepasses may be added and removed while frames run.
#[test]
fn prepasses_come_and_go() {
    in_own_process(|| {
        let mut headless = app_with(DefaultOpaqueRendererMethod::deferred());
        show_through(&mut headless, |_| {});
        set_lean(&mut headless, true);
        let plain = settled(&mut headless);
        type Change = fn(&mut EntityWorldMut);
        let changes: [Change; 4] = [
            |camera| {
                camera.insert((DepthPrepass, NormalPrepass));
            },
            |camera| {
                camera.remove::<DepthPrepass>();
            },
            |camera| {
                camera.insert(MotionVectorPrepass).remove::<NormalPrepass>();
            },
            |camera| {
                camera.remove::<MotionVectorPrepass>();
            },
        ];
        let mut results = Vec::new();
        for (step, change) in changes.into_iter().enumerate() {
            change_cameras(&mut headless, change);
            for (frame, picture) in headless.film(3, |_, _| {}).iter().enumerate() {
                results.push(judge(
                    &format!("step_{step}_{frame}"),
                    &plain,
                    picture,
                    44.0,
                ));
            }
        }
        report(results);
        let errors = log_watch::messages_with("rror");
        assert!(errors.is_empty(), "{errors:?}");
    });
}

/// Cases of an app: numbers of cameras, and their multisampling.
type Late = (DefaultOpaqueRendererMethod, &'static [(usize, Msaa)]);

// Without a deferred prepass Bevy alone, before the camera is lean, panics if there is another prepass.
#[test]
fn meshes_whose_materials_come_late_are_there() {
    in_own_process(|| {
        check_late_materials([
            (DefaultOpaqueRendererMethod::forward(), &[(4, Msaa::Off)]),
            (DefaultOpaqueRendererMethod::deferred(), &[(0, Msaa::Off)]),
        ]);
    });
}

#[test]
#[ignore = "nightly: further cameras, of which Bevy renders those with multisampling"]
fn meshes_whose_materials_come_late_are_there_on_further_cameras() {
    in_own_process(|| {
        let forward = &[(0, Msaa::Off), (0, Msaa::Sample4), (1, Msaa::Sample4)];
        check_late_materials([
            (DefaultOpaqueRendererMethod::forward(), forward),
            (
                DefaultOpaqueRendererMethod::deferred(),
                &[(0, Msaa::Sample4)],
            ),
        ]);
    });
}

/// Meshes whose materials load after their camera became lean are drawn. Bevy has waited for them since before then.
fn check_late_materials(cases: [Late; 2]) {
    let picture = |headless: &mut Headless, camera, msaa: Msaa, late: bool| {
        show_through(headless, camera);
        let world = headless.world();
        let ball = Sphere::new(0.6).mesh().build();
        let ball = world.resource_mut::<Assets<Mesh>>().add(ball);
        let red = Color::srgb(0.8, 0.1, 0.1);
        let materials: [StandardMaterial; 2] = [
            red.into(),
            StandardMaterial {
                alpha_mode: AlphaMode::Blend,
                ..red.with_alpha(0.5).into()
            },
        ];
        let handles = [(); 2].map(|()| {
            let materials = world.resource::<Assets<StandardMaterial>>();
            materials.reserve_handle()
        });
        for (handle, x) in handles.iter().zip([-0.7, 0.7]) {
            world.spawn((
                Mesh3d(ball.clone()),
                MeshMaterial3d(handle.clone()),
                Transform::from_xyz(x, 1.2, 1.6),
            ));
        }
        let switch = |headless: &mut Headless| {
            change_cameras(headless, |camera| {
                camera.insert(LeanDeferred::default());
                camera.insert(msaa);
            });
        };
        if late {
            headless.settle();
            headless.frames(3);
            switch(headless);
            headless.frames(2);
        }
        let mut assets = headless.world().resource_mut::<Assets<StandardMaterial>>();
        for (handle, material) in handles.iter().zip(materials) {
            assets.insert(handle, material).unwrap();
        }
        switch(headless);
        let picture = settled(headless);
        let is_lean = msaa == Msaa::Off;
        assert_eq!(active_lean_views(headless), usize::from(is_lean));
        picture
    };
    let mut results = Vec::new();
    for (method, cases) in cases {
        let mut headless = app_with(method);
        for &(camera, msaa) in cases {
            let (name, camera) = CAMERAS[camera];
            let [at_once, late] =
                [false, true].map(|late| picture(&mut headless, camera, msaa, late));
            let name = format!("late_{name}_{msaa:?}");
            results.push(judge(&name, &at_once, &late, 60.0));
        }
    }
    report(results);
}
