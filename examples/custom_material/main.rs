//! A material of your own in the G-buffer: water, which its vertex shader moves. `assets/shaders/water.wgsl` is its shader. Clear water is
//! blended: Bevy's pass draws it, and its shader asks for the light that it mirrors.
//!
//! `cargo run --example custom_material -- [--clear] [--headless OUT.png] [--help]`

use argh::FromArgs;
use bevy::{
    anti_alias::taa::TemporalAntiAliasing,
    camera::visibility::NoFrustumCulling,
    light::{GeneratedEnvironmentMapLight, NotShadowCaster, Skybox},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{MaterialPipeline, MaterialPipelineKey},
    prelude::*,
    reflect::TypePath,
    render::render_resource::{
        AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError,
    },
    shader::ShaderRef,
};
use bevy_lean_deferred::{
    effects::LeanScreenSpaceReflectionsAdvanced,
    gbuffer::{ForwardReason, GBufferTargets},
    lighting::define_lean_lighting,
    prelude::*,
};
use kit::{
    example::{
        made_up_sky::made_up_sky,
        run::{self, SceneReady},
    },
    headless::Headless,
};

/// Animated water in the G-buffer.
#[derive(FromArgs)]
struct Args {
    /// clear water, through which the ground is seen
    #[argh(switch)]
    clear: bool,
    /// render without a window, write this PNG and quit
    #[argh(option)]
    headless: Option<String>,
}

fn main() -> AppExit {
    let args: Args = argh::from_env();
    let opacity = if args.clear { 0.35 } else { 1.0 };
    let add_scene = move |app: &mut App| add_scene(app, opacity);
    if let Some(path) = args.headless {
        let headless = Headless::with(UVec2::new(1280, 720), add_scene);
        // TAA averages as many frames.
        return run::write_picture(headless, &path, 60);
    }
    App::new()
        .add_plugins((DefaultPlugins, LeanDeferredPlugins))
        .add_plugins(add_scene)
        .run()
}

/// Opacity of the water that is looked at from above.
#[derive(Resource)]
struct Opacity(f32);

fn add_scene(app: &mut App, opacity: f32) {
    app.add_plugins((
        MaterialPlugin::<Water>::default(),
        GBufferMaterialPlugin::<Water>::default(),
    ))
    .insert_resource(Opacity(opacity))
    .insert_resource(SceneReady)
    .add_systems(Startup, setup);
}

const SHADER: &str = "shaders/water.wgsl";

/// Waves on a horizontal plane.
#[derive(Asset, AsBindGroup, TypePath, Clone)]
pub struct Water {
    /// Blended if its alpha is less than 1.
    #[uniform(0)]
    pub color: LinearRgba,
    /// Height of the longest wave, in metres.
    #[uniform(0)]
    pub height: f32,
}

impl Material for Water {
    fn vertex_shader() -> ShaderRef {
        SHADER.into()
    }

    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }

    // For cameras that are not lean, and have a prepass.
    fn prepass_vertex_shader() -> ShaderRef {
        SHADER.into()
    }

    // The G-buffer has the vertex shader of Bevy's deferred pass.
    fn deferred_vertex_shader() -> ShaderRef {
        SHADER.into()
    }

    fn alpha_mode(&self) -> AlphaMode {
        if self.color.alpha < 1.0 {
            AlphaMode::Blend
        } else {
            AlphaMode::Opaque
        }
    }

    // For the light functions in Bevy's passes.
    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        _: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        define_lean_lighting(descriptor);
        Ok(())
    }
}

impl GBufferMaterial for Water {
    fn gbuffer_fragment_shader() -> ShaderRef {
        SHADER.into()
    }

    fn gbuffer_needs(&self) -> Result<GBufferNeeds, ForwardReason> {
        // The mesh rests, but its vertices move. On cameras without motion vectors this costs nothing.
        Ok(GBufferNeeds {
            targets: GBufferTargets::MOTION,
            ..GBufferNeeds::BASE
        })
    }
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut waters: ResMut<Assets<Water>>,
    mut images: ResMut<Assets<Image>>,
    opacity: Res<Opacity>,
) {
    let sky = images.add(made_up_sky());
    commands.spawn((
        Camera3d::default(),
        LeanDeferred::default(),
        LeanScreenSpaceReflections {
            advanced: LeanScreenSpaceReflectionsAdvanced {
                // On clear water too.
                forward_meshes: true,
                ..default()
            },
            ..default()
        },
        // It reads the motion vectors.
        TemporalAntiAliasing::default(),
        Transform::from_xyz(0.0, 2.5, 9.0).looking_at(Vec3::new(0.0, 0.3, 0.0), Vec3::Y),
        Skybox {
            image: Some(sky.clone()),
            brightness: 900.0,
            ..default()
        },
        GeneratedEnvironmentMapLight {
            environment_map: sky,
            intensity: 900.0,
            ..default()
        },
    ));
    commands.spawn((
        DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(-3.0, 3.0, -2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(40.0, 40.0).subdivisions(199))),
        MeshMaterial3d(waters.add(Water {
            color: LinearRgba::new(0.01, 0.06, 0.08, opacity.0),
            height: 0.12,
        })),
        NotShadowCaster,
        // The waves leave the bounds of the mesh.
        NoFrustumCulling,
    ));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(40.0, 40.0))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.55, 0.47, 0.33),
            perceptual_roughness: 0.9,
            ..default()
        })),
        Transform::from_xyz(0.0, -0.7, 0.0),
    ));
    let post = meshes.add(Cuboid::new(0.3, 3.0, 0.3));
    let wood = materials.add(StandardMaterial {
        base_color: Color::srgb(0.5, 0.33, 0.2),
        perceptual_roughness: 0.8,
        ..default()
    });
    for i in 0..6 {
        let x = i as f32 - 2.5;
        commands.spawn((
            Mesh3d(post.clone()),
            MeshMaterial3d(wood.clone()),
            Transform::from_xyz(1.6 * x, 0.0, -0.9 * x),
        ));
    }
}
