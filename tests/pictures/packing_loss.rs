//! Separates the difference between lean and forward pictures into packing and lighting.
//!
//! The third picture is forward with a material that rounds its inputs as the G-buffer does: lean differs from it by lighting alone
//! (positions and geometric normals from depth, light stored as exposed).

use bevy::{
    asset::uuid_handle,
    mesh::MeshVertexBufferLayoutRef,
    pbr::{
        ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline,
        MaterialPlugin,
    },
    prelude::*,
    reflect::TypePath,
    render::render_resource::{
        AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError,
    },
    shader::ShaderRef,
};
use kit::{
    headless::{Headless, Picture},
    lean::{set_lean, settled, show},
    log_watch,
    metrics::difference,
    own_process::in_own_process,
    scenes::{
        SceneBuilder,
        build::{ambient, material},
    },
};

const ROUNDED: Handle<Shader> = uuid_handle!("7c0d6a0e-34c1-4f7e-8d55-1b0f6a2f6b11");

const SHADER: &str = r"
#import bevy_lean_deferred::gbuffer::layout
#import bevy_lean_deferred::gbuffer::layout::light::unpack_light
#import bevy_lean_deferred::gbuffer::pack::pack_pbr_input
#import bevy_lean_deferred::lighting::surface::specialize
#import bevy_pbr::{
    forward_io::{FragmentOutput, VertexOutput},
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{apply_pbr_lighting, main_pass_post_lighting_processing},
    pbr_types::STANDARD_MATERIAL_FLAGS_UNLIT_BIT,
    prepass_io,
}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    var pbr = pbr_input_from_standard_material(in, is_front);
    let is_unlit = (pbr.material.flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) != 0u;
    // Nothing moves here.
    var vertex: prepass_io::VertexOutput;
    let words = pack_pbr_input(pbr, vertex);
    pbr.material.base_color = vec4(layout::unpack_albedo(words.surface), 1.0);
    pbr.material.metallic = layout::unpack_metallic(words.surface);
    pbr.material.perceptual_roughness = layout::unpack_roughness(words.normal);
    pbr.diffuse_occlusion = vec3(layout::unpack_occlusion(words.surface));
    pbr.N = layout::unpack_normal(words.normal);
    pbr.material.emissive = vec4(unpack_light(words.emissive), 0.0);
    specialize(&pbr, words.specialization);
    if is_unlit {
        return FragmentOutput(main_pass_post_lighting_processing(pbr, pbr.material.base_color));
    }
    return FragmentOutput(main_pass_post_lighting_processing(pbr, apply_pbr_lighting(pbr)));
}
";

/// Rounds the material that it extends.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
struct Rounded {}

impl MaterialExtension for Rounded {
    fn fragment_shader() -> ShaderRef {
        ROUNDED.into()
    }

    fn specialize(
        _: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        _: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        if let Some(fragment) = &mut descriptor.fragment {
            let defs = ["GBUFFER_EMISSIVE", "GBUFFER_SPECIALIZATION"];
            fragment.shader_defs.extend(defs.map(Into::into));
        }
        Ok(())
    }
}

type RoundedMaterial = ExtendedMaterial<StandardMaterial, Rounded>;

#[derive(Clone, Copy, PartialEq)]
enum Way {
    Forward,
    Rounded,
    Lean,
}

fn app() -> Headless {
    let mut headless = Headless::with(UVec2::new(320, 240), |app| {
        app.add_plugins(MaterialPlugin::<RoundedMaterial>::default());
    });
    headless
        .world()
        .resource_mut::<Assets<Shader>>()
        .insert(ROUNDED.id(), Shader::from_wgsl(SHADER, "rounded.wgsl"))
        .expect("a place for a constant handle");
    headless
}

fn picture(headless: &mut Headless, base: &StandardMaterial, way: Way) -> Picture {
    show(headless, |scene| balls(scene, base, way));
    set_lean(headless, way == Way::Lean);
    settled(headless)
}

fn balls(scene: &mut SceneBuilder, base: &StandardMaterial, way: Way) {
    let ball = Sphere::new(0.45)
        .mesh()
        .uv(48, 24)
        .with_generated_tangents()
        .expect("a sphere has all that tangents need");
    let ball = scene.add::<Mesh>(ball);
    for i in 0..12 {
        let mut sample = base.clone();
        sample.base_color = Color::hsl(i as f32 * 30.0, 0.6, 0.5);
        sample.perceptual_roughness = 0.15 + 0.07 * i as f32;
        let place = Transform::from_xyz((i % 4) as f32 - 1.5, (i / 4) as f32 * 0.9 - 0.4, 0.0);
        if way == Way::Rounded {
            let material = scene.add::<RoundedMaterial>(RoundedMaterial {
                base: sample,
                extension: Rounded {},
            });
            scene.spawn((Mesh3d(ball.clone()), MeshMaterial3d(material), place));
        } else {
            let material = scene.add::<StandardMaterial>(sample);
            scene.spawn((Mesh3d(ball.clone()), MeshMaterial3d(material), place));
        }
    }
    scene.sun(false);
    scene.default_camera(ambient());
}

/// Kinds of surfaces, with the least PSNR in dB of lean against forward, and against forward that rounds.
fn kinds() -> [(&'static str, [f64; 2], StandardMaterial); 7] {
    let base = material((0.5, 0.5, 0.5), 0.0, 0.5);
    let metal = material((0.5, 0.5, 0.5), 1.0, 0.5);
    [
        ("plain", [45.0, 60.0], base.clone()),
        (
            "emissive",
            [45.0, 60.0],
            StandardMaterial {
                emissive: LinearRgba::rgb(0.05, 0.2, 0.4),
                ..base.clone()
            },
        ),
        (
            "reflectance",
            [40.0, 60.0],
            StandardMaterial {
                reflectance: 0.93,
                ..base.clone()
            },
        ),
        (
            "clearcoat",
            [40.0, 60.0],
            StandardMaterial {
                clearcoat: 0.73,
                clearcoat_perceptual_roughness: 0.21,
                ..base.clone()
            },
        ),
        (
            "anisotropy",
            [40.0, 60.0],
            StandardMaterial {
                anisotropy_strength: 0.77,
                anisotropy_rotation: 0.6,
                ..metal
            },
        ),
        (
            "diffuse transmission",
            [45.0, 60.0],
            StandardMaterial {
                diffuse_transmission: 0.63,
                thickness: 0.11,
                ..base.clone()
            },
        ),
        (
            "unlit",
            [45.0, 60.0],
            StandardMaterial {
                unlit: true,
                ..base
            },
        ),
    ]
}

#[test]
#[ignore = "nightly: figures of what parity bounds"]
fn lighting_at_full_precision_and_packed() {
    in_own_process(|| {
        let mut headless = app();
        let mut failures = Vec::new();
        for (name, [least_packed, least_full], base) in kinds() {
            let [forward, rounded, lean] = [Way::Forward, Way::Rounded, Way::Lean]
                .map(|way| picture(&mut headless, &base, way));
            let packed = difference(&forward, &lean).psnr;
            let full = difference(&rounded, &lean).psnr;
            let packing = difference(&forward, &rounded).psnr;
            println!(
                "{name:20} lean: {packed:.1} dB beside forward, {full:.1} beside forward that rounds; these: {packing:.1}"
            );
            if packed < least_packed || full < least_full {
                failures.push(name);
            }
        }
        assert!(failures.is_empty(), "{failures:?}");
        log_watch::assert_validation_layer_silent();
    });
}
