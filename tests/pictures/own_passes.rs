//! An app's own pass, which draws the colour and depth of a wall among the solids, at each place of Bevy's frame: lean shows the wall as
//! forward does.

use bevy::{
    core_pipeline::{
        core_3d::{main_opaque_pass_3d, main_transparent_pass_3d},
        prepass::DepthPrepass,
        schedule::{Core3d, Core3dSystems},
    },
    prelude::*,
    render::RenderApp,
};
use bevy_lean_deferred::LeanDeferredPlugins;
use kit::{
    headless::{Headless, Picture, small_shadow_maps},
    lean::{active_lean_views, change_cameras, judge, report, set_lean, settled},
    own_process::in_own_process,
    scenes::{LEAST_PSNR, SceneBuilder, build::ambient},
};

use super::foreign_depth::{add_wall_pipeline, draw_wall};

const SIZE: UVec2 = UVec2::new(160, 120);

/// Place of the frame at which the wall is drawn.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
enum Place {
    BeforePrepass,
    InPrepass,
    BeforeMainPass,
    BeforeOpaque,
    BeforeOpaqueInMainPass,
    BeforeTransparent,
    BeforeTransparentInMainPass,
    AfterTransparent,
    AfterTransparentInMainPass,
    AfterMainPass,
    InEarlyPostProcess,
}

impl Place {
    const ALL: [Self; 11] = [
        Self::BeforePrepass,
        Self::InPrepass,
        Self::BeforeMainPass,
        Self::BeforeOpaque,
        Self::BeforeOpaqueInMainPass,
        Self::BeforeTransparent,
        Self::BeforeTransparentInMainPass,
        Self::AfterTransparent,
        Self::AfterTransparentInMainPass,
        Self::AfterMainPass,
        Self::InEarlyPostProcess,
    ];
}

fn is_at(place: Place) -> impl Fn(Option<Res<Place>>) -> bool + Clone {
    move |chosen| chosen.is_some_and(|chosen| *chosen == place)
}

fn add_wall(app: &mut App, place: Place) {
    let wall = draw_wall.run_if(is_at(place));
    let wall = match place {
        Place::BeforePrepass => wall.before(Core3dSystems::Prepass),
        Place::InPrepass => wall.in_set(Core3dSystems::Prepass),
        Place::BeforeMainPass => wall.before(Core3dSystems::MainPass),
        Place::BeforeOpaque => wall.before(main_opaque_pass_3d),
        Place::BeforeOpaqueInMainPass => wall
            .in_set(Core3dSystems::MainPass)
            .before(main_opaque_pass_3d),
        Place::BeforeTransparent => wall
            .after(main_opaque_pass_3d)
            .before(main_transparent_pass_3d),
        Place::BeforeTransparentInMainPass => wall
            .in_set(Core3dSystems::MainPass)
            .after(main_opaque_pass_3d)
            .before(main_transparent_pass_3d),
        Place::AfterTransparent => wall
            .after(main_transparent_pass_3d)
            .before(Core3dSystems::EarlyPostProcess),
        Place::AfterTransparentInMainPass => wall
            .in_set(Core3dSystems::MainPass)
            .after(main_transparent_pass_3d),
        Place::AfterMainPass => wall
            .after(Core3dSystems::MainPass)
            .before(Core3dSystems::EarlyPostProcess),
        Place::InEarlyPostProcess => wall.in_set(Core3dSystems::EarlyPostProcess),
    };
    app.sub_app_mut(RenderApp).add_systems(Core3d, wall);
}

fn add_walls(app: &mut App) {
    for place in Place::ALL {
        add_wall(app, place);
    }
}

/// An app that draws the wall by systems added `before` this crate's plugins, and `after` them.
fn app_with(before: fn(&mut App), after: fn(&mut App)) -> Headless {
    let mut app = App::new();
    app.add_plugins(Headless::default_plugins());
    before(&mut app);
    app.add_plugins(LeanDeferredPlugins);
    let mut headless = Headless::from_app(SIZE, app, |app| {
        small_shadow_maps(app);
        after(app);
    });
    add_wall_pipeline(&mut headless);
    let mut scene = SceneBuilder {
        headless: &mut headless,
    };
    scene.solids();
    scene.sun(true);
    scene.spawn((
        PointLight {
            color: Color::srgb(1.0, 0.3, 0.1),
            intensity: 2e6,
            ..default()
        },
        Transform::from_xyz(1.0, 2.0, 2.0),
    ));
    scene.default_camera(ambient());
    headless
}

/// Pictures of the wall at each place. Two each, as the order of recording may change from frame to frame.
fn pictures(headless: &mut Headless, lean: bool) -> Vec<[Picture; 2]> {
    set_lean(headless, lean);
    settled(headless);
    assert_eq!(active_lean_views(headless), usize::from(lean));
    let pictures = Place::ALL.map(|place| {
        let render_app = headless.app.sub_app_mut(RenderApp);
        render_app.insert_resource(place);
        [headless.capture(), headless.capture()]
    });
    headless
        .app
        .sub_app_mut(RenderApp)
        .world_mut()
        .remove_resource::<Place>();
    pictures.into()
}

fn compare(headless: &mut Headless, camera: &str) -> Vec<Result<(), String>> {
    let [lean, forward] = [true, false].map(|lean| pictures(headless, lean));
    let places = Place::ALL.iter().zip(forward.iter().zip(&lean));
    places
        .flat_map(|(place, (forward, lean))| {
            assert!(forward[0] == forward[1], "{place:?}: forward is steady");
            assert!(forward[0].rgba[1] > forward[0].rgba[0] + 50, "{place:?}");
            lean.each_ref()
                .map(|lean| judge(&format!("{place:?}{camera}"), &forward[0], lean, LEAST_PSNR))
        })
        .collect()
}

fn assert_walls_are_forwards(before: fn(&mut App), after: fn(&mut App)) {
    let mut headless = app_with(before, after);
    let mut results = compare(&mut headless, "");
    change_cameras(&mut headless, |camera| {
        camera.insert(DepthPrepass);
    });
    results.extend(compare(&mut headless, "_prepass"));
    report(results);
}

fn nothing(_: &mut App) {}

#[test]
fn passes_added_before_this_crates_show_what_they_show_in_forward() {
    in_own_process(|| assert_walls_are_forwards(add_walls, nothing));
}

#[test]
fn passes_added_after_this_crates_show_what_they_show_in_forward() {
    in_own_process(|| assert_walls_are_forwards(nothing, add_walls));
}
