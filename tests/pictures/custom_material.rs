//! A material with its own G-buffer shader goes through the G-buffer and looks as in forward.

use bevy::{
    asset::uuid_handle,
    pbr::{ExtendedMaterial, MaterialExtension, MaterialPlugin},
    prelude::*,
    reflect::TypePath,
    render::render_resource::AsBindGroup,
    shader::ShaderRef,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    headless::Headless, log_watch, metrics::difference, own_process::in_own_process,
    scenes::SceneBuilder,
};

const FORWARD: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e01");
const GBUFFER: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e02");

/// What both shaders do to the base colour.
const STRIPES: &str = r"
@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> width: f32;

fn stripes(color: vec4<f32>, y: f32) -> vec4<f32> {
    return vec4(color.rgb * select(0.25, 1.0, fract(y / width) < 0.5), color.a);
}
";

const FORWARD_MAIN: &str = r"
#import bevy_pbr::{
    forward_io::{FragmentOutput, VertexOutput},
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{alpha_discard, apply_pbr_lighting, main_pass_post_lighting_processing},
}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    var pbr = pbr_input_from_standard_material(in, is_front);
    pbr.material.base_color = stripes(pbr.material.base_color, in.world_position.y);
    pbr.material.base_color = alpha_discard(pbr.material, pbr.material.base_color);
    return FragmentOutput(main_pass_post_lighting_processing(pbr, apply_pbr_lighting(pbr)));
}
";

const GBUFFER_MAIN: &str = r"
#import bevy_lean_deferred::gbuffer::pack::{GBufferOutput, apply_discards, pack_pbr_input}
#import bevy_pbr::{
    pbr_fragment::pbr_input_from_standard_material,
    prepass_io::VertexOutput,
}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> GBufferOutput {
    var pbr = pbr_input_from_standard_material(in, is_front);
    pbr.material.base_color = stripes(pbr.material.base_color, in.world_position.y);
    apply_discards(in, &pbr);
    return pack_pbr_input(pbr, in);
}
";

/// Stripes over the base colour, by height.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
struct Stripes {
    #[uniform(100)]
    width: f32,
}

impl MaterialExtension for Stripes {
    fn fragment_shader() -> ShaderRef {
        FORWARD.into()
    }
}

impl GBufferMaterialExtension for Stripes {
    fn gbuffer_fragment_shader() -> ShaderRef {
        GBUFFER.into()
    }
}

type StripedMaterial = ExtendedMaterial<StandardMaterial, Stripes>;

fn picture_pair(registers: bool) -> (f64, f64) {
    let mut headless = Headless::with(UVec2::new(160, 120), |app| {
        app.add_plugins(MaterialPlugin::<StripedMaterial>::default());
        if registers {
            app.add_plugins(GBufferMaterialPlugin::<StripedMaterial>::default());
        }
    });
    let mut shaders = headless.world().resource_mut::<Assets<Shader>>();
    for (handle, main) in [(FORWARD, FORWARD_MAIN), (GBUFFER, GBUFFER_MAIN)] {
        let shader = Shader::from_wgsl(format!("{main}{STRIPES}"), "stripes.wgsl");
        shaders
            .insert(handle.id(), shader)
            .expect("a place for a constant handle");
    }
    let mut scene = SceneBuilder {
        headless: &mut headless,
    };
    scene.floor();
    scene.sun(true);
    let material = scene.add::<StripedMaterial>(StripedMaterial {
        base: Color::srgb(0.8, 0.5, 0.3).into(),
        extension: Stripes { width: 0.3 },
    });
    let mesh = scene.add::<Mesh>(Sphere::new(1.0).mesh().uv(32, 16));
    scene.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material),
        Transform::from_xyz(0.0, 1.0, 0.0),
    ));
    let camera = scene.default_camera(());
    headless.settle();
    let forward = headless.capture();
    headless.world().entity_mut(camera).insert(LeanDeferred {
        debug_view: None,
        ..default()
    });
    headless.settle();
    let lit = difference(&forward, &headless.capture()).psnr;

    // What the G-buffer holds shows through a debug view; what forward draws is lit over it.
    headless.world().entity_mut(camera).insert(LeanDeferred {
        debug_view: Some(DebugChannel::Roughness),
        ..default()
    });
    headless.settle();
    let debug = headless.capture();
    let center = debug.rgba[(debug.size.x * debug.size.y / 2 + debug.size.x / 2) as usize * 4..]
        .iter()
        .take(3)
        .copied()
        .collect::<Vec<_>>();
    let spread = center.iter().max().unwrap() - center.iter().min().unwrap();
    (lit, f64::from(spread))
}

#[test]
fn registered_material_goes_through_the_gbuffer() {
    in_own_process(|| {
        let (psnr, spread) = picture_pair(true);
        println!("custom material: PSNR {psnr:.1} dB");
        assert!(psnr >= 45.0, "{psnr} dB");
        assert!(spread <= 1.0, "a grey debug view shows in its place");
        log_watch::assert_validation_layer_silent();
    });
}

#[test]
fn unregistered_material_is_drawn_by_forward() {
    in_own_process(|| {
        let (psnr, spread) = picture_pair(false);
        assert!(psnr >= 45.0, "{psnr} dB");
        assert!(
            spread > 1.0,
            "forward draws it in colour over the debug view"
        );
    });
}
