//! Indirect light that effects compute outside lighting is mixed in where environment maps and ambient light are added. These tests replace
//! the effects by the light that they would compute in uniform surroundings.

use bevy::{
    camera::Exposure, light::AmbientLight, prelude::*, render::render_resource::TextureView,
};
use bevy_lean_deferred::{
    prelude::*,
    view::{IndirectDiffuse, IndirectSpecular},
};
use kit::{
    hdr::{Light, change_views, even_texture, float_texture, light, settled_light},
    headless::Headless,
    lean::{active_lean_views, change_cameras, show},
    log_watch,
    own_process::in_own_process,
    scenes::{self, SceneBuilder, build::material},
};

const SIZE: UVec2 = UVec2::new(96, 72);

/// Exposed light of the uniform sky.
const EXPOSED: f32 = 0.25;

/// Clearcoat and diffuse transmission of two balls of the stage.
const SPECIAL: [f32; 2] = [0.8, 0.5];

/// Solids and balls of several shading models, under a uniform sky or in the dark.
fn spawn_stage(s: &mut SceneBuilder, sky: bool, [clearcoat, transmission]: [f32; 2]) {
    s.solids();
    let materials = [
        StandardMaterial {
            clearcoat,
            clearcoat_perceptual_roughness: 0.1,
            ..material((0.7, 0.3, 0.2), 0.5, 0.6)
        },
        StandardMaterial {
            diffuse_transmission: transmission,
            ..material((0.2, 0.6, 0.2), 0.0, 0.5)
        },
        StandardMaterial {
            reflectance: 0.9,
            ..material((0.3, 0.3, 0.7), 0.2, 0.3)
        },
    ];
    for (i, material) in materials.into_iter().enumerate() {
        s.mesh(
            Sphere::new(0.4).mesh().uv(32, 16),
            material,
            Transform::from_xyz(i as f32 - 1.0, 0.4, 1.8),
        );
    }
    let dark = AmbientLight {
        brightness: 0.0,
        ..default()
    };
    let camera = s.default_camera((LeanDeferred::default(), dark));
    if sky {
        let mut images = s.world().resource_mut::<Assets<Image>>();
        let mut light = EnvironmentMapLight::solid_color(&mut images, Color::WHITE);
        light.intensity = EXPOSED / Exposure::default().exposure();
        s.world().entity_mut(camera).insert(light);
    }
}

fn stage(headless: &mut Headless, sky: bool, special: [f32; 2]) {
    show(headless, |s| spawn_stage(s, sky, special));
    headless.settle();
}

fn find_specular(headless: &mut Headless, texel: [f32; 4]) {
    let texture = even_texture(headless, SIZE, texel);
    change_views(headless, |view| {
        view.insert(IndirectSpecular(Some(texture.clone())));
    });
}

/// Diffuse light of a texture with a texel per pixel.
fn diffuse_of(texture: &TextureView) -> IndirectDiffuse {
    IndirectDiffuse {
        texture: Some(texture.clone()),
        is_half: false,
    }
}

fn find_diffuse(headless: &mut Headless, texel: [f32; 4]) {
    let texture = even_texture(headless, SIZE, texel);
    change_views(headless, |view| {
        view.insert(diffuse_of(&texture));
    });
}

fn show_part(headless: &mut Headless, part: DebugView) {
    change_cameras(headless, |camera| {
        camera.insert(LeanDebugView::from(part));
    });
}

/// Panics if the two differ by more than the precision of half floats.
fn assert_alike(what: &str, found: &Light, expected: &Light) {
    let lit = expected.texels.iter().filter(|texel| texel[1] > 0.0);
    assert!(lit.count() > 2000, "{what}: there is something to see");
    for (i, (found, expected)) in found.texels.iter().zip(&expected.texels).enumerate() {
        for channel in 0..3 {
            let off = (found[channel] - expected[channel]).abs();
            assert!(
                off <= 0.0015 * expected[channel].abs() + 1e-6,
                "{what}, pixel {}, {}: {found:?}, expected {expected:?}",
                i as u32 % SIZE.x,
                i as u32 / SIZE.x
            );
        }
    }
}

#[test]
fn found_light_takes_the_place_of_other_light() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        what_is_mirrored_takes_the_place_of_the_sky(headless);
        each_pixel_mirrors_its_own(headless);
        what_shines_on_surfaces_takes_the_place_of_what_it_hides(headless);
        found_light_needs_no_environment_map(headless);
        lightmaps_have_what_shines_on_surfaces(headless);
    });
}

fn what_is_mirrored_takes_the_place_of_the_sky(headless: &mut Headless) {
    stage(headless, true, SPECIAL);
    let sky = settled_light(headless);
    for confidence in [0.25, 1.0] {
        find_specular(headless, [EXPOSED, EXPOSED, EXPOSED, confidence]);
        let mixed = settled_light(headless);
        assert_alike(&format!("confidence {confidence}"), &mixed, &sky);
    }
    // A mirror image twice as bright adds specular light only.
    let twice = 2.0 * EXPOSED;
    find_specular(headless, [twice, twice, twice, 1.0]);
    let brighter = settled_light(headless);
    show_part(headless, DebugView::DiffuseLight);
    let diffuse = settled_light(headless);
    find_specular(headless, [0.0; 4]);
    assert_alike("diffuse light", &settled_light(headless), &diffuse);
    let more = |(bright, sky): (&[f32; 4], &[f32; 4])| bright[1] > sky[1] * 1.01;
    let pairs = || brighter.texels.iter().zip(&sky.texels);
    assert!(pairs().filter(|pair| more(*pair)).count() > 2000);
    assert!(pairs().all(|(bright, sky)| bright[1] >= sky[1] * 0.999));
}

/// Adjacent pixels, of which some mirror something and others nothing, each get their own light.
fn each_pixel_mirrors_its_own(headless: &mut Headless) {
    stage(headless, true, SPECIAL);
    let texels = [[0.0; 4], [0.5, 0.7, 0.4, 1.0], [0.1, 0.4, 0.6, 0.4]];
    let expected = texels.map(|texel| {
        find_specular(headless, texel);
        settled_light(headless)
    });
    let which = |pixel: UVec2| ((pixel.x * 7 + pixel.y * 13 + pixel.x * pixel.y) % 3) as usize;
    let texture = float_texture(headless, SIZE, |pixel| texels[which(pixel)]);
    change_views(headless, |view| {
        view.insert(IndirectSpecular(Some(texture.clone())));
    });
    let mixed = settled_light(headless);
    for (i, texel) in mixed.texels.iter().enumerate() {
        let pixel = UVec2::new(i as u32 % SIZE.x, i as u32 / SIZE.x);
        assert_eq!(*texel, expected[which(pixel)].texels[i], "{pixel}");
    }
}

fn what_shines_on_surfaces_takes_the_place_of_what_it_hides(headless: &mut Headless) {
    stage(headless, true, SPECIAL);
    show_part(headless, DebugView::DiffuseLight);
    let sky = settled_light(headless);
    for hidden in [0.25, 1.0] {
        let light = hidden * EXPOSED;
        find_diffuse(headless, [light, light, light, hidden]);
        let mixed = settled_light(headless);
        assert_alike(&format!("hidden {hidden}"), &mixed, &sky);
    }
}

fn found_light_needs_no_environment_map(headless: &mut Headless) {
    // Without coat and transmission: beneath a coat a surface mirrors only the environment, which alone lights its back too.
    stage(headless, true, [0.0; 2]);
    let sky = settled_light(headless);
    stage(headless, false, [0.0; 2]);
    find_specular(headless, [EXPOSED, EXPOSED, EXPOSED, 1.0]);
    find_diffuse(headless, [EXPOSED, EXPOSED, EXPOSED, 1.0]);
    let found = settled_light(headless);
    assert_alike("in the dark", &found, &sky);
}

fn lightmaps_have_what_shines_on_surfaces(headless: &mut Headless) {
    let mut scenes = scenes::SPECIAL_MATERIALS.iter();
    let scene = scenes
        .find(|scene| scene.name == "lightmapped_specials")
        .expect("there is such a scene");
    show(headless, scene.build);
    change_cameras(headless, |camera| {
        camera.insert(LeanDeferred::default());
    });
    let before = settled_light(headless);
    find_diffuse(headless, [EXPOSED, EXPOSED, EXPOSED, 0.0]);
    let after = settled_light(headless);
    let pairs = || before.texels.iter().zip(&after.texels);
    let brighter = pairs().filter(|(before, after)| after[1] > before[1] + 0.01);
    let equal = pairs().filter(|(before, after)| before == after && before[1] > 0.0);
    let [brighter, equal] = [brighter.count(), equal.count()];
    assert!(
        brighter > 1000 && equal > 500,
        "{brighter} pixels are brighter, {equal} as before"
    );
}

#[test]
fn what_is_not_there_or_not_a_number_changes_nothing() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        stage(&mut headless, true, SPECIAL);
        let without = settled_light(&mut headless);
        change_views(&mut headless, |view| {
            view.insert((IndirectSpecular(None), IndirectDiffuse::default()));
        });
        let nothing = settled_light(&mut headless);
        assert!(nothing == without, "no textures");
        for texel in [
            [f32::NAN, 0.5, 0.5, 1.0],
            [0.5, 0.5, 0.5, f32::NAN],
            [-1.0, -1.0, -1.0, -1.0],
        ] {
            find_specular(&mut headless, texel);
            find_diffuse(&mut headless, texel);
            assert_alike("not a number", &settled_light(&mut headless), &without);
        }
        let endless = [f32::INFINITY, 0.0, 0.0, 1.0];
        find_specular(&mut headless, endless);
        find_diffuse(&mut headless, endless);
        let lit = settled_light(&mut headless);
        assert!(lit.texels.iter().flatten().all(|x| !x.is_nan()));

        // A single texel applies to all pixels.
        find_specular(&mut headless, [0.5, 0.2, 0.1, 0.7]);
        find_diffuse(&mut headless, [0.2, 0.3, 0.1, 0.4]);
        let full = settled_light(&mut headless);
        let specular = even_texture(&headless, UVec2::ONE, [0.5, 0.2, 0.1, 0.7]);
        let diffuse = even_texture(&headless, UVec2::ONE, [0.2, 0.3, 0.1, 0.4]);
        change_views(&mut headless, |view| {
            view.insert(IndirectSpecular(Some(specular.clone())));
            view.insert(diffuse_of(&diffuse));
        });
        assert!(settled_light(&mut headless) == full, "a single texel");
        change_views(&mut headless, |view| {
            view.remove::<(IndirectSpecular, IndirectDiffuse)>();
        });
        assert!(settled_light(&mut headless) == without, "no longer there");
        log_watch::assert_validation_layer_silent();
    });
}

/// While lighting compiles for new inputs, the view stays unchanged.
#[test]
fn the_picture_stays_while_lighting_compiles() {
    in_own_process(|| {
        let mut headless = Headless::with_compilation(SIZE, false, |_| {});
        spawn_stage(
            &mut SceneBuilder {
                headless: &mut headless,
            },
            true,
            SPECIAL,
        );
        let without = settled_light(&mut headless);
        let texture = even_texture(&headless, SIZE, [0.5, 0.2, 0.1, 0.7]);
        let mut states = vec![without];
        for frame in 0..40 {
            change_views(&mut headless, |view| {
                if frame < 20 || frame % 2 == 0 {
                    view.insert(IndirectSpecular(Some(texture.clone())));
                } else {
                    view.remove::<IndirectSpecular>();
                }
            });
            let now = light(&mut headless);
            assert_eq!(active_lean_views(&mut headless), 1, "frame {frame}");
            if !states.contains(&now) {
                states.push(now);
            }
        }
        assert_eq!(states.len(), 2, "with what is found, and without");
    });
}
