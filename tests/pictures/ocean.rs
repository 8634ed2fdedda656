//! A sea: a smooth material whose shader turns the normal per fragment, under a low sun and a sky that it reflects.

use bevy::{
    anti_alias::taa::TemporalAntiAliasing,
    asset::uuid_handle,
    pbr::{ExtendedMaterial, MaterialExtension, MaterialPlugin},
    prelude::*,
    reflect::TypePath,
    render::render_resource::AsBindGroup,
    shader::ShaderRef,
};
use bevy_lean_deferred::{gbuffer::GBufferMaterialExtension, prelude::*};
use kit::{
    headless::Headless,
    lean::{active_lean_views, change_cameras, judge, report, set_lean, settled, show},
    own_process::in_own_process,
    scenes::SceneBuilder,
};

use super::fragment_shaders::{forward_main, gbuffer_main, insert_shader};

const FORWARD: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e33");
const GBUFFER: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e34");

const CHANGE: &str = "pbr.N = normal_of_waves(in.world_position.xz);";

/// Long waves, and ripples that steepen them.
const WAVES: &str = r"
@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> height: f32;

fn normal_of_waves(place: vec2<f32>) -> vec3<f32> {
    var slope = vec2(0.0);
    var direction = vec2(1.0, 0.0);
    var frequency = 0.7;
    for (var i = 0; i < 6; i++) {
        slope += direction * cos(dot(direction, place) * frequency);
        direction = vec2(0.62 * direction.x - 0.78 * direction.y, 0.78 * direction.x + 0.62 * direction.y);
        frequency *= 1.9;
    }
    return normalize(vec3(-height * slope.x, 1.0, -height * slope.y));
}
";

#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
struct Waves {
    /// Slope of each wave.
    #[uniform(100)]
    height: f32,
}

impl MaterialExtension for Waves {
    fn fragment_shader() -> ShaderRef {
        FORWARD.into()
    }
}

impl GBufferMaterialExtension for Waves {
    fn gbuffer_fragment_shader() -> ShaderRef {
        GBUFFER.into()
    }
}

type Sea = ExtendedMaterial<StandardMaterial, Waves>;

fn app() -> Headless {
    let mut headless = Headless::with(UVec2::new(320, 180), |app| {
        app.add_plugins((
            MaterialPlugin::<Sea>::default(),
            GBufferMaterialPlugin::<Sea>::default(),
        ));
    });
    for (handle, main) in [
        (FORWARD, forward_main(CHANGE)),
        (GBUFFER, gbuffer_main(CHANGE)),
    ] {
        insert_shader(
            &mut headless,
            handle,
            format!("{main}{WAVES}"),
            "waves.wgsl",
        );
    }
    headless
}

/// A sea with waves of `slope`, seen against a sun `elevation` radians above the horizon.
fn sea(scene: &mut SceneBuilder, slope: f32, elevation: f32, sky: bool) {
    let material = scene.add::<Sea>(Sea {
        base: StandardMaterial {
            base_color: Color::srgb(0.02, 0.08, 0.12),
            perceptual_roughness: 0.0,
            ..default()
        },
        extension: Waves { height: slope },
    });
    let mesh = scene.add::<Mesh>(Plane3d::default().mesh().size(400.0, 400.0));
    scene.spawn((Mesh3d(mesh), MeshMaterial3d(material)));
    let toward = Vec3::new(0.0, elevation.sin(), -elevation.cos());
    scene.spawn((
        DirectionalLight {
            illuminance: 20_000.0,
            ..default()
        },
        Transform::from_translation(toward).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let view = Transform::from_xyz(0.0, 2.0, 0.0).looking_at(Vec3::new(0.0, 0.0, -12.0), Vec3::Y);
    let camera = scene.camera(view, bevy::camera::Exposure { ev100: 13.0 });
    if sky {
        let light = scene.environment_map(1500.0);
        scene.world().entity_mut(camera).insert(light);
    }
}

/// Measured: 64.7 to 80 dB.
const LEAST_PSNR: f64 = 60.0;

/// Measured: 47.8 and 49.3 dB.
const LEAST_TAA_PSNR: f64 = 46.0;

#[test]
fn seas_glitter_as_in_forward() {
    in_own_process(|| {
        let cases = [
            (0.0, 0.01),
            (0.0, 0.1),
            (0.0, 0.5),
            (0.05, 0.02),
            (0.05, 0.3),
            (0.2, 0.1),
        ];
        let headless = &mut app();
        report(cases.into_iter().flat_map(|(slope, elevation)| {
            [false, true].map(|sky| {
                let name = format!("sea_{slope}_{elevation}_{sky}");
                show(headless, |s| sea(s, slope, elevation, sky));
                set_lean(headless, false);
                let forward = settled(headless);
                set_lean(headless, true);
                let lean = settled(headless);
                assert_eq!(active_lean_views(headless), 1, "{name}");
                judge(&name, &forward, &lean, LEAST_PSNR)
            })
        }));
    });
}

/// Glints vary with the jitter; TAA averages those of both renderers.
#[test]
#[ignore = "nightly: 72 frames with TAA"]
fn seas_glitter_as_in_forward_under_taa() {
    in_own_process(|| {
        report([(0.05, 0.02), (0.2, 0.3)].map(|(slope, elevation)| {
            let mut headless = app();
            show(&mut headless, |s| sea(s, slope, elevation, true));
            change_cameras(&mut headless, |camera| {
                camera.insert(TemporalAntiAliasing::default());
            });
            let [forward, lean] = [false, true].map(|is_lean| {
                set_lean(&mut headless, is_lean);
                settled(&mut headless)
            });
            assert_eq!(active_lean_views(&mut headless), 1);
            let name = format!("sea_{slope}_{elevation}_taa");
            judge(&name, &forward, &lean, LEAST_TAA_PSNR)
        }));
    });
}
