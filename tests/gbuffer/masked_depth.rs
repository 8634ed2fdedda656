//! Alpha-masked meshes whose depth is drawn before their surface look as those that are drawn once.

use bevy::{
    asset::RenderAssetUsages,
    camera::visibility::VisibilityRange,
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass},
    prelude::*,
    render::{
        RenderApp,
        occlusion_culling::OcclusionCulling,
        render_resource::{
            CompareFunction, Extent3d, PipelineCache, PipelineDescriptor, RenderPipelineDescriptor,
            TextureDimension, TextureFormat,
        },
    },
};
use bevy_lean_deferred::gbuffer::MaskedPipelines;
use kit::{
    headless::{Headless, Picture},
    lean::{build, set_lean},
    log_watch,
    own_process::in_own_process,
    scenes::SceneBuilder,
    skipped::culls_what_is_hidden,
};

const SIZE: UVec2 = UVec2::new(160, 120);

/// Components of a camera.
type Dress = fn(&mut EntityWorldMut);

const CAMERAS: [(&str, Dress); 5] = [
    ("without a prepass", |_| {}),
    ("depth prepass", |camera| {
        camera.insert(DepthPrepass);
    }),
    ("motion vectors", |camera| {
        camera.insert(MotionVectorPrepass);
    }),
    ("normal prepass", |camera| {
        camera.insert(NormalPrepass);
    }),
    ("occlusion culling", |camera| {
        camera.insert((DepthPrepass, OcclusionCulling));
    }),
];

/// A texture of soft discs: alpha has all values, also those at the cutoff.
fn discs(s: &mut SceneBuilder) -> Handle<Image> {
    const TEXELS: u32 = 64;
    let texel = |index: u32| {
        let place = UVec2::new(index % TEXELS, index / TEXELS).as_vec2();
        let nearest = (place / 16.0).fract() - 0.5;
        let alpha = (1.4 - 2.4 * nearest.length()).clamp(0.0, 1.0);
        [90, 200, 60, (255.0 * alpha) as u8]
    };
    let data = (0..TEXELS * TEXELS).flat_map(texel).collect();
    let image = Image::new(
        Extent3d {
            width: TEXELS,
            height: TEXELS,
            ..default()
        },
        TextureDimension::D2,
        data,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    s.world().resource_mut::<Assets<Image>>().add(image)
}

/// Leaves in front of one another, some of which emit light, are double-sided, move, or fade out by distance; a wall behind them, and a
/// card that lies in the wall.
fn stage(dress: Dress, depth_first: bool) -> Headless {
    let mut moving = Entity::PLACEHOLDER;
    let mut headless = build(SIZE, |s| {
        let leaf = StandardMaterial {
            base_color_texture: Some(discs(s)),
            alpha_mode: AlphaMode::Mask(0.5),
            perceptual_roughness: 0.8,
            ..default()
        };
        let card = Rectangle::new(1.6, 1.2);
        for layer in 0..6u8 {
            let step = f32::from(layer);
            let mut material = leaf.clone();
            match layer {
                1 => material.emissive = LinearRgba::rgb(0.3, 0.1, 0.0),
                2 => (material.double_sided, material.cull_mode) = (true, None),
                3 => material.base_color = Color::srgb(0.9, 0.5, 0.3),
                _ => {}
            }
            let place =
                Transform::from_xyz(0.2 * step - 0.5, 0.4 + 0.05 * step, 0.3 * step).with_rotation(
                    Quat::from_euler(EulerRot::YXZ, 0.3 * step - 0.8, 0.2, 0.4 * step),
                );
            let leaf = s.mesh(card, material, place);
            match layer {
                4 => moving = leaf,
                5 => {
                    let range = VisibilityRange {
                        start_margin: 0.0..0.0,
                        end_margin: 1.0..9.0,
                        use_aabb: false,
                    };
                    s.world().entity_mut(leaf).insert(range);
                }
                _ => {}
            }
        }
        let wall = Transform::from_xyz(0.0, 0.5, -0.6);
        s.mesh(Rectangle::new(6.0, 3.0), Color::srgb(0.4, 0.4, 0.6), wall);
        s.mesh(Rectangle::new(6.0, 3.0), leaf, wall);
        s.sun(true);
        let camera = s.default_camera(());
        dress(&mut s.world().entity_mut(camera));
    });
    if !depth_first {
        let render_app = headless.app.sub_app_mut(RenderApp);
        render_app.insert_resource(MaskedPipelines::off());
    }
    set_lean(&mut headless, true);
    headless.settle();
    for frame in 0..3u8 {
        let mut leaf = headless.world().entity_mut(moving);
        let mut transform = leaf.get_mut::<Transform>().expect("it has one");
        transform.translation.x += 0.04 * f32::from(frame);
        headless.frame();
    }
    headless.settle();
    headless
}

/// Descriptors of all pipelines that draw the depth of masked meshes, and of those that draw a surface where depth is equal.
fn parts(headless: &Headless) -> [Vec<RenderPipelineDescriptor>; 2] {
    let world = headless.app.sub_app(RenderApp).world();
    let pipelines = world.resource::<PipelineCache>().pipelines();
    let of_meshes: Vec<_> = pipelines
        .filter_map(|pipeline| match &pipeline.descriptor {
            PipelineDescriptor::RenderPipelineDescriptor(descriptor) => {
                Some((**descriptor).clone())
            }
            PipelineDescriptor::ComputePipelineDescriptor(_) => None,
        })
        .collect();
    let labelled = |label: &str| {
        let is_wanted = |own: &&RenderPipelineDescriptor| own.label.as_deref() == Some(label);
        of_meshes
            .iter()
            .filter(is_wanted)
            .cloned()
            .collect::<Vec<_>>()
    };
    let mut at_depth = labelled("lean_deferred/gbuffer");
    at_depth.retain(|own| {
        let depth = own.depth_stencil.as_ref();
        depth.is_some_and(|depth| depth.depth_compare == Some(CompareFunction::Equal))
    });
    [labelled("lean_deferred/gbuffer/masked_depth"), at_depth]
}

fn picture(dress: Dress, depth_first: bool) -> (Picture, Headless) {
    let mut headless = stage(dress, depth_first);
    (headless.capture(), headless)
}

/// Compilers may contract products and sums of positions in one pipeline and not in the other, which llvmpipe never does.
#[test]
fn positions_of_bevys_vertex_shaders_are_invariant() {
    in_own_process(|| {
        let headless = stage(|_| {}, true);
        let shaders = headless.app.world().resource::<Assets<Shader>>();
        for name in ["bevy_pbr::prepass_io", "bevy_pbr::forward_io"] {
            let is_named = |shader: &&Shader| *shader.import_path.module_name() == name;
            let all = shaders.iter().map(|(_, shader)| shader);
            let found: Vec<&Shader> = all.filter(is_named).collect();
            let [shader] = found[..] else {
                panic!("{} modules are called {name}", found.len());
            };
            let text = shader.source.as_str();
            assert!(
                text.contains("@invariant @builtin(position) position"),
                "{name}"
            );
        }
    });
}

#[test]
fn depth_first_looks_the_same() {
    in_own_process(|| {
        for (name, dress) in CAMERAS {
            let (once, at_once) = picture(dress, false);
            if name == "occlusion culling" && !culls_what_is_hidden(&at_once) {
                continue;
            }
            let (twice, in_two) = picture(dress, true);
            let different = (once.rgba.chunks(4).zip(twice.rgba.chunks(4)))
                .filter(|(once, twice)| once != twice)
                .count();
            assert_eq!(different, 0, "{name}: pixels that differ");
            assert!(
                once.rgba.chunks(4).any(|texel| texel[1] > texel[0] + 20),
                "{name}: leaves"
            );
            assert!(
                parts(&at_once).iter().all(Vec::is_empty),
                "{name}: drawn once"
            );
            let [depth, surface] = parts(&in_two);
            assert!(!surface.is_empty(), "{name}");
            assert_eq!(depth.len(), surface.len(), "{name}");
            for surface in surface {
                let state = surface.depth_stencil.expect("it tests depth");
                assert_eq!(state.depth_write_enabled, Some(false), "{name}");
            }
        }
        log_watch::assert_validation_layer_silent();
    });
}
