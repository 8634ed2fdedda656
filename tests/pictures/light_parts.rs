//! Diffuse and specular light separately, as effects read them and as debug views show them.

use bevy::{camera::ClearColorConfig, prelude::*, render::RenderApp};
use bevy_lean_deferred::{
    prelude::*,
    view::{DiffuseLight, ReadsDiffuseLight},
};
use kit::{
    hdr::{Light, change_views, light, settled_light},
    headless::Headless,
    lean::{change_cameras, show},
    own_process::in_own_process,
    reference::shader_library::layout::light::unpack_light,
    scenes::{self, Scene},
    skipped::on_swiftshader,
};

const SIZE: UVec2 = UVec2::new(96, 72);

/// A scene whose parts exceed the whole on SwiftShader, for an unknown reason.
const LIGHTMAPPED: &str = "lightmapped_specials_environment_map";

/// Rounding error of a half float, relative and absolute.
const HALF_ROUNDING: f32 = 1.0 / 2048.0;
const LEAST_HALF: f32 = 6e-8;

/// Scenes with fog in front of the light, or with something visible beside lean surfaces: a sky, or meshes that forward draws.
const NOT_LIGHT_ALONE: [&str; 8] = [
    "fog_linear",
    "fog_exponential",
    "fog_atmospheric",
    "volumetric_fog",
    "skybox",
    "special_fog",
    "special_environment_map",
    DRAWN_OVER,
];

/// Prefixes of scenes in which some surfaces emit light too, or are unlit.
const WITH_EMISSION: [&str; 2] = ["special_", "lightmapped_"];

/// A scene in which forward draws some meshes over others.
const DRAWN_OVER: &str = "special_normal_map";

fn set_debug_view(headless: &mut Headless, debug_view: Option<DebugView>) {
    change_cameras(headless, |camera| {
        if let Some(mut camera) = camera.get_mut::<Camera>() {
            camera.clear_color = ClearColorConfig::Custom(Color::BLACK);
        }
        camera.insert(LeanDeferred::default());
        match debug_view {
            Some(view) => camera.insert(LeanDebugView::from(view)),
            None => camera.remove::<LeanDebugView>(),
        };
    });
}

/// Diffuse light of the single camera, unpacked from its words.
fn diffuse_light(headless: &mut Headless) -> Vec<Vec3> {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut textures = world.query::<&DiffuseLight>();
    let texture = textures.single(world).expect("it is asked for");
    let texture = texture.texture.texture.clone();
    let words = headless.read(&texture);
    let words = words.as_chunks::<4>().0.iter();
    words
        .map(|word| unpack_light(u32::from_le_bytes(*word)))
        .collect()
}

/// Panics if reading diffuse light changes the picture by more than drivers differ between shaders.
fn assert_same_picture(name: &str, before: &Light, now: &Light) {
    let pairs = before.texels.iter().zip(&now.texels);
    let other = pairs.filter(|(before, now)| {
        let pairs = before.iter().zip(*now);
        let mut apart =
            pairs.map(|(before, now)| (before - now).abs() - 4.0 * HALF_ROUNDING * before.abs());
        apart.any(|apart| apart > LEAST_HALF)
    });
    let other = other.count();
    assert!(
        other <= before.texels.len() / 1000,
        "{name}: {other} pixels"
    );
}

fn check_scene(headless: &mut Headless, scene: &Scene) {
    show(headless, scene.build);
    set_debug_view(headless, None);
    let whole = settled_light(headless);
    change_views(headless, |view| {
        view.insert(ReadsDiffuseLight);
    });
    assert_same_picture(scene.name, &whole, &settled_light(headless));
    let read = diffuse_light(headless);
    let [diffuse, specular] = [DebugView::DiffuseLight, DebugView::SpecularLight].map(|view| {
        set_debug_view(headless, Some(view));
        settled_light(headless)
    });
    let is_all = !WITH_EMISSION
        .iter()
        .any(|name| scene.name.starts_with(name));
    let adds_up = !NOT_LIGHT_ALONE.contains(&scene.name);
    let parts = diffuse.texels.iter().zip(&specular.texels);
    for (i, ((whole, (diffuse, specular)), read)) in
        whole.texels.iter().zip(parts).zip(read).enumerate()
    {
        let at = || {
            format!(
                "{}, pixel {}, {}",
                scene.name,
                i as u32 % SIZE.x,
                i as u32 / SIZE.x
            )
        };
        // 0 at pixels without a lean mesh.
        if read != Vec3::ZERO && scene.name != DRAWN_OVER {
            // Words include emitted light too: all that is not specular.
            let [whole, diffuse, specular] =
                [whole, diffuse, specular].map(|texel| Vec3::from_slice(texel));
            let (expected, rounded) = match (is_all, adds_up) {
                (true, _) => (diffuse, diffuse),
                (false, true) => (whole - specular, whole + specular),
                (false, false) => (read.max(diffuse), read),
            };
            let allowed = expected.max_element() / 510.0
                + 4.0 * HALF_ROUNDING * rounded.max_element()
                + 2.0 * LEAST_HALF;
            let off = (read - expected).abs().max_element();
            assert!(
                off <= allowed,
                "{}: {read} is read, {expected} is shown",
                at()
            );
        }
        for channel in 0..3 {
            let sum = diffuse[channel] + specular[channel];
            let allowed = HALF_ROUNDING * (2.0 * sum + whole[channel]) + LEAST_HALF;
            let off = sum - whole[channel];
            assert!(
                !adds_up || off <= allowed && (!is_all || -off <= allowed),
                "{}: {diffuse:?} and {specular:?} make {whole:?}",
                at()
            );
        }
    }
    change_views(headless, |view| {
        view.remove::<ReadsDiffuseLight>();
    });
    light(headless);
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut textures = world.query::<&DiffuseLight>();
    assert_eq!(textures.iter(world).count(), 0, "nothing reads it any more");
}

fn check_scenes(scenes: impl Iterator<Item = &'static Scene>) {
    let mut headless = Headless::new(SIZE);
    for scene in scenes {
        if scene.name.starts_with(LIGHTMAPPED)
            && on_swiftshader(true, false, "parts of light of lightmapped surfaces")
        {
            continue;
        }
        check_scene(&mut headless, scene);
    }
}

/// True for a scene of each kind of light, of special materials in the sun, and of lightmapped surfaces: each adds its parts by code of its
/// own. Lighting is compiled four times for each.
fn is_kind_of_light(scene: &&Scene) -> bool {
    let kinds = [
        "rect",
        "environment_map",
        "irradiance_volume",
        "many_lights_of_all_kinds",
        "special_sun_and_ambient",
        "special_transmitted_shadows",
        "lightmapped_specials_bicubic",
    ];
    kinds.contains(&scene.name)
}

#[test]
fn parts_of_each_kind_of_light_make_the_whole() {
    in_own_process(|| {
        let scenes = scenes::LIGHTS.iter().chain(scenes::SPECIAL_MATERIALS);
        check_scenes(scenes.filter(is_kind_of_light));
    });
}

#[test]
#[ignore = "nightly: combinations of lights"]
fn parts_of_lights_make_the_whole() {
    in_own_process(|| check_scenes(scenes::LIGHTS.iter()));
}

#[test]
#[ignore = "nightly: combinations of lights and materials"]
fn parts_of_special_materials_make_the_whole() {
    in_own_process(|| check_scenes(scenes::SPECIAL_MATERIALS.iter()));
}
