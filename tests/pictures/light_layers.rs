//! Lights, decals and light probes with `RenderLayers` affect the meshes that share a layer with them, and no others.

mod as_data;
mod existence;

use bevy::{
    camera::{ScalingMode, visibility::RenderLayers},
    light::{ClusteredDecal, DirectionalLight, LightProbe, PointLight, RectLight, SpotLight},
    prelude::*,
};
use bevy_lean_deferred::{DebugView, LeanDebugView, LeanDeferred};
use kit::{
    headless::{Headless, Picture},
    lean::{change_cameras, judge, report, set_lean, settled, show},
    metrics::difference,
    own_process::in_own_process,
    scenes::{
        LEAST_PSNR, SceneBuilder,
        build::{indoor, material},
    },
};

const SIZE: UVec2 = UVec2::new(360, 140);

/// Layers of the meshes of each column; the first have no such component.
const COLUMNS: [&[usize]; 4] = [&[0], &[1], &[0, 2], &[40]];

/// Layers of the camera, which sees all columns.
const SEEN: &[usize] = &[0, 1, 2, 3, 40];

/// A scene whose lights are spawned one by one.
struct Stage<'a, 'b> {
    scene: &'a mut SceneBuilder<'b>,
    /// If set, lights that do not reach these layers are left out.
    only_for: Option<RenderLayers>,
}

impl Stage<'_, '_> {
    /// Spawns a light on `layers`, or without layers.
    fn light(&mut self, layers: Option<&[usize]>, light: impl Bundle) {
        let layers = layers.map(RenderLayers::from_layers);
        let reaches = |wanted: &RenderLayers| {
            let own = layers.as_ref();
            own.is_none_or(|own| own.intersects(wanted))
        };
        if !self.only_for.as_ref().is_none_or(reaches) {
            return;
        }
        let light = self.scene.spawn(light);
        if let Some(layers) = layers {
            self.scene.world().entity_mut(light).insert(layers);
        }
    }
}

/// A ball and a card per column, side by side, in front of a wall.
fn columns(s: &mut SceneBuilder) {
    for (column, layers) in COLUMNS.into_iter().enumerate() {
        let x = (column as f32 - 1.5) * 2.0;
        let meshes = [
            s.mesh(
                Sphere::new(0.6).mesh().uv(32, 16),
                material((0.8, 0.6, 0.4), 0.2, 0.4),
                Transform::from_xyz(x - 0.2, 0.2, 0.4),
            ),
            s.mesh(
                Rectangle::new(1.9, 2.4),
                material((0.6, 0.7, 0.8), 0.0, 0.6),
                Transform::from_xyz(x, 0.0, -0.4).with_rotation(Quat::from_rotation_x(-0.5)),
            ),
        ];
        if layers != [0] {
            for mesh in meshes {
                let layers = RenderLayers::from_layers(layers);
                s.world().entity_mut(mesh).insert(layers);
            }
        }
    }
    let target = s.headless.render_target();
    s.spawn((
        Camera3d::default(),
        bevy::camera::Hdr,
        Msaa::Off,
        target,
        bevy::core_pipeline::tonemapping::Tonemapping::Reinhard,
        Projection::Orthographic(OrthographicProjection {
            scaling_mode: ScalingMode::FixedHorizontal {
                viewport_width: 8.0,
            },
            ..OrthographicProjection::default_3d()
        }),
        Transform::from_xyz(0.0, 0.0, 6.0),
        indoor(),
        RenderLayers::from_layers(SEEN),
    ));
}

fn point(x: f32, shadow_maps_enabled: bool) -> (PointLight, Transform) {
    let light = PointLight {
        intensity: 4_000.0,
        range: 12.0,
        shadow_maps_enabled,
        ..default()
    };
    (light, Transform::from_xyz(x, 1.2, 2.5))
}

fn spot(x: f32, shadow_maps_enabled: bool) -> (SpotLight, Transform) {
    let light = SpotLight {
        intensity: 30_000.0,
        range: 15.0,
        outer_angle: 0.7,
        shadow_maps_enabled,
        ..default()
    };
    let place = Transform::from_xyz(x, 2.0, 4.0).looking_at(Vec3::new(-x, 0.0, 0.0), Vec3::Y);
    (light, place)
}

fn sun(from: Vec3, shadow_maps_enabled: bool) -> (DirectionalLight, Transform) {
    let light = DirectionalLight {
        illuminance: 150.0,
        shadow_maps_enabled,
        ..default()
    };
    (
        light,
        Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y),
    )
}

fn panel(x: f32, color: Color) -> (RectLight, Transform) {
    let light = RectLight {
        color,
        intensity: 4_000.0,
        width: 2.0,
        height: 1.0,
        range: 20.0,
    };
    let place = Transform::from_xyz(x, 1.5, 2.5).looking_at(Vec3::new(x, 0.0, 0.0), Vec3::Y);
    (light, place)
}

/// Volume of a probe: 9 m wide, 3 m high and 3 m deep.
const PROBED: Transform = Transform::from_scale(Vec3::new(9.0, 3.0, 3.0));

type Lights = fn(&mut Stage);

/// Devices on which a kind of light is visible.
#[derive(PartialEq)]
enum Shows {
    Everywhere,
    /// Only devices with bindless textures, which a software renderer lacks.
    WithBindless,
}

fn point_lights(s: &mut Stage) {
    s.light(None, point(-2.0, false));
    s.light(Some(&[0]), point(1.0, true));
    s.light(Some(&[1]), point(-0.5, false));
    s.light(Some(&[1, 2]), point(2.0, true));
    s.light(Some(&[3]), point(0.0, true));
    // All layers from 31 on count as one.
    s.light(Some(&[33, 40]), point(3.5, false));
}

fn spot_lights(s: &mut Stage) {
    s.light(None, point(0.0, false));
    s.light(Some(&[0]), spot(-2.0, true));
    s.light(Some(&[2, 40]), spot(2.0, true));
    s.light(Some(&[1]), spot(-1.0, false));
}

/// Bevy sorts them: those without shadows first.
fn directional_lights(s: &mut Stage) {
    s.light(Some(&[1]), sun(Vec3::new(2.0, 3.0, 4.0), true));
    s.light(Some(&[2]), sun(Vec3::new(-3.0, 2.0, 4.0), false));
    s.light(None, sun(Vec3::new(0.0, 5.0, 3.0), true));
    s.light(Some(&[0, 40]), sun(Vec3::new(-1.0, 0.0, 3.0), false));
}

fn rect_lights(s: &mut Stage) {
    s.light(Some(&[1]), panel(-1.0, Color::srgb(1.0, 0.6, 0.3)));
    s.light(Some(&[2]), panel(1.0, Color::srgb(0.3, 0.6, 1.0)));
    s.light(None, panel(3.0, Color::WHITE));
    s.light(Some(&[0]), panel(-3.0, Color::srgb(0.4, 1.0, 0.5)));
}

fn reflection_probe(s: &mut Stage) {
    let light = s.scene.environment_map(100.0);
    s.light(Some(&[1, 2]), (LightProbe::default(), light, PROBED));
    s.light(None, sun(Vec3::new(0.0, 5.0, 3.0), false));
}

fn irradiance_volume(s: &mut Stage) {
    let volume = s.scene.irradiance_volume(100.0);
    s.light(Some(&[0, 40]), (LightProbe::default(), volume, PROBED));
    s.light(None, sun(Vec3::new(0.0, 5.0, 3.0), false));
}

fn decals(s: &mut Stage) {
    for (layers, image, y) in [
        (None, [240, 60, 40, 255], -0.6),
        (Some(&[1][..]), [40, 60, 240, 255], 0.2),
        (Some(&[0, 40]), [40, 240, 60, 255], 0.9),
    ] {
        let image = s.scene.checker(image, [20, 20, 20, 255]);
        s.light(
            layers,
            (
                ClusteredDecal {
                    base_color_texture: Some(image),
                    ..default()
                },
                Transform::from_xyz(0.0, y, 0.0).with_scale(Vec3::new(9.0, 0.5, 3.0)),
            ),
        );
    }
    s.light(None, sun(Vec3::new(0.0, 2.0, 3.0), false));
}

/// Bevy numbers lights and decals separately from 0: decals with layers have the numbers of lights without.
fn all_kinds(s: &mut Stage) {
    decals(s);
    for x in [-3.0, -1.0, 1.0] {
        s.light(None, point(x, false));
    }
    s.light(Some(&[2]), point(3.0, true));
    s.light(None, spot(-1.0, true));
    s.light(Some(&[1]), spot(2.0, false));
    s.light(Some(&[40]), sun(Vec3::new(2.0, 3.0, 4.0), true));
    s.light(Some(&[0, 1]), panel(-1.0, Color::srgb(1.0, 0.6, 0.3)));
    s.light(None, panel(2.0, Color::srgb(0.3, 0.6, 1.0)));
}

fn picture(
    headless: &mut Headless,
    lights: Lights,
    only_for: Option<&[usize]>,
    lean: Option<LeanDeferred>,
) -> Picture {
    show(headless, |scene| {
        columns(scene);
        lights(&mut Stage {
            scene,
            only_for: only_for.map(RenderLayers::from_layers),
        });
    });
    if let Some(settings) = lean {
        set_lean(headless, true);
        let world = headless.world();
        let mut cameras = world.query::<&mut LeanDeferred>();
        *cameras.single_mut(world).expect("there is one camera") = settings;
    }
    settled(headless)
}

fn column(picture: &Picture, column: usize) -> Picture {
    let width = SIZE.x / COLUMNS.len() as u32;
    let left = column as u32 * width;
    picture.crop(URect::new(left, 0, left + width, SIZE.y))
}

/// Each column matches a scene with only the lights of its layers.
fn compare_columns(headless: &mut Headless, name: &str, lights: Lights) -> Vec<Result<(), String>> {
    let lean = picture(headless, lights, None, Some(LeanDeferred::default()));
    let columns = COLUMNS.into_iter().enumerate().map(|(index, layers)| {
        let forward = picture(headless, lights, Some(layers), None);
        let [forward, lean] = [&forward, &lean].map(|picture| column(picture, index));
        let name = format!("{name}_{index}");
        judge(&name, &forward, &lean, LEAST_PSNR)
    });
    columns.collect()
}

/// Without `light_layers` all lights affect all meshes, as in forward, and the picture differs from the one with layers.
fn compare_without_layers(
    headless: &mut Headless,
    name: &str,
    lights: Lights,
    shows: Shows,
) -> Result<(), String> {
    let forward = picture(headless, lights, None, None);
    let [with, without] = [true, false].map(|light_layers| {
        let settings = LeanDeferred {
            light_layers,
            ..default()
        };
        picture(headless, lights, None, Some(settings))
    });
    let mut is_shown = || forward.rgba != picture(headless, lights, Some(&[1000]), None).rgba;
    if shows == Shows::Everywhere || is_shown() {
        let psnr = difference(&without, &with).psnr;
        assert!(psnr < 30.0, "{name}: {psnr} dB");
    }
    judge(name, &forward, &without, LEAST_PSNR)
}

/// The debug view is grey where the mask is that of layer 0, and otherwise has a colour per set of layers.
#[test]
fn the_mask_can_be_shown() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        picture(headless, point_lights, None, Some(LeanDeferred::default()));
        change_cameras(headless, |camera| {
            camera.insert(LeanDebugView::from(DebugView::VisibilityMask));
        });
        let picture = settled(headless);
        if let Some(folder) = std::env::var_os("PARITY_PICTURES") {
            picture.save(std::path::Path::new(&folder).join("mask_channel.png"));
        }
        let middle = UVec2::new(SIZE.x / COLUMNS.len() as u32, SIZE.y) / 2;
        let colors: Vec<_> = (0..COLUMNS.len())
            .map(|index| {
                let rect = URect::from_corners(middle, middle + 1);
                column(&picture, index).crop(rect).rgba
            })
            .collect();
        let is_near = |channel: &u8| channel.abs_diff(colors[0][0]) <= 2;
        assert!(colors[0][..3].iter().all(is_near), "{colors:?}");
        for (index, color) in colors.iter().enumerate() {
            assert!(!colors[..index].contains(color), "{colors:?}");
        }
    });
}

type Kind = (&'static str, Lights, Shows);

/// All lights, decals, and probes.
const DAILY: [Kind; 2] = [
    ("irradiance_volume", irradiance_volume, Shows::Everywhere),
    ("all_kinds", all_kinds, Shows::Everywhere),
];

const NIGHTLY: [Kind; 6] = [
    ("point_lights", point_lights, Shows::Everywhere),
    ("spot_lights", spot_lights, Shows::Everywhere),
    ("directional_lights", directional_lights, Shows::Everywhere),
    ("rect_lights", rect_lights, Shows::Everywhere),
    ("reflection_probe", reflection_probe, Shows::WithBindless),
    ("decals", decals, Shows::WithBindless),
];

fn compare_kinds_with_layers(kinds: impl IntoIterator<Item = Kind>) {
    let headless = &mut Headless::new(SIZE);
    let kinds = kinds.into_iter();
    report(kinds.flat_map(|(name, lights, _)| compare_columns(headless, name, lights)));
}

#[test]
fn with_layers() {
    in_own_process(|| compare_kinds_with_layers(DAILY));
}

#[test]
#[ignore = "nightly: kinds of lights one by one"]
fn single_kinds_with_layers() {
    in_own_process(|| compare_kinds_with_layers(NIGHTLY));
}

fn compare_kinds_without_layers(kinds: impl IntoIterator<Item = Kind>) {
    let headless = &mut Headless::new(SIZE);
    let kinds = kinds.into_iter();
    report(
        kinds.map(|(name, lights, shows)| compare_without_layers(headless, name, lights, shows)),
    );
}

#[test]
fn without_layers() {
    in_own_process(|| compare_kinds_without_layers(DAILY));
}

#[test]
#[ignore = "nightly: kinds of lights one by one"]
fn single_kinds_without_layers() {
    in_own_process(|| compare_kinds_without_layers(NIGHTLY));
}
