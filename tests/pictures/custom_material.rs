//! A material with its own G-buffer shader is drawn into the G-buffer and matches forward.

use core::time::Duration;
use std::time::Instant;

use bevy::{
    asset::uuid_handle,
    light::NotShadowCaster,
    pbr::{ExtendedMaterial, MaterialExtension, MaterialPlugin},
    prelude::*,
    reflect::TypePath,
    render::render_resource::AsBindGroup,
    shader::ShaderRef,
    time::TimeUpdateStrategy,
};
use bevy_lean_deferred::{
    gbuffer::{ForwardReason, GBufferMaterialExtension},
    prelude::*,
};
use kit::{
    foreign_material::{Palette, VoxelMaterial, VoxelPlugin, row_attribute, voxel_mesh},
    headless::{Headless, small_shadow_maps},
    lean::active_lean_views,
    log_watch,
    metrics::difference,
    own_process::in_own_process,
    scenes::SceneBuilder,
};

use super::fragment_shaders::{forward_main, gbuffer_main, insert_shader};

#[path = "../../examples/custom_material/main.rs"]
#[expect(dead_code, reason = "of the example, only the material is tested")]
mod example;

use example::Water;

const FORWARD: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e01");
const GBUFFER: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e02");

const RINGS: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e03");

const GBUFFER_FILE: &str = "stripes_gbuffer.wgsl";

/// The change that both shaders make to the base colour.
const STRIPES: &str = r"
@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> width: f32;

fn stripes(color: vec4<f32>, y: f32) -> vec4<f32> {
    return vec4(color.rgb * select(0.25, 1.0, fract(y / width) < 0.5), color.a);
}
";

const CHANGE: &str =
    "pbr.material.base_color = stripes(pbr.material.base_color, in.world_position.y);";

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

/// The material in the documentation of `GBufferMaterial`.
#[derive(Asset, AsBindGroup, TypePath, Clone)]
struct Rings {
    #[uniform(0)]
    rings: Vec4,
}

impl Material for Rings {
    fn fragment_shader() -> ShaderRef {
        RINGS.into()
    }
}

impl GBufferMaterial for Rings {
    fn gbuffer_fragment_shader() -> ShaderRef {
        RINGS.into()
    }

    fn gbuffer_needs(&self) -> Result<GBufferNeeds, ForwardReason> {
        Ok(GBufferNeeds::BASE)
    }
}

type StripedMaterial = ExtendedMaterial<StandardMaterial, Stripes>;

/// A striped ball on a floor, and the camera that sees them.
fn ball(registers: bool, gbuffer_main: &str) -> (Headless, Entity) {
    let mut headless = Headless::with(UVec2::new(160, 120), |app| {
        small_shadow_maps(app);
        app.add_plugins(MaterialPlugin::<StripedMaterial>::default());
        if registers {
            app.add_plugins(GBufferMaterialPlugin::<StripedMaterial>::default());
        }
    });
    set_shader(
        &mut headless,
        FORWARD,
        &forward_main(CHANGE),
        "stripes.wgsl",
    );
    set_shader(&mut headless, GBUFFER, gbuffer_main, GBUFFER_FILE);
    let material = StripedMaterial {
        base: Color::srgb(0.8, 0.5, 0.3).into(),
        extension: Stripes { width: 0.3 },
    };
    let camera = spawn_ball(&mut headless, material);
    (headless, camera)
}

fn spawn_ball<M: Material>(headless: &mut Headless, material: M) -> Entity {
    let mut scene = SceneBuilder { headless };
    scene.floor();
    scene.sun(true);
    let material = scene.add::<M>(material);
    let mesh = scene.add::<Mesh>(Sphere::new(1.0).mesh().uv(32, 16));
    scene.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material),
        Transform::from_xyz(0.0, 1.0, 0.0),
    ));
    scene.default_camera(())
}

fn set_shader(headless: &mut Headless, handle: Handle<Shader>, main: &str, file: &str) {
    insert_shader(headless, handle, format!("{main}{STRIPES}"), file);
}

/// PSNR of the lean picture against the forward one.
fn psnr(headless: &mut Headless, camera: Entity) -> f64 {
    headless.settle();
    let forward = headless.capture();
    headless
        .world()
        .entity_mut(camera)
        .insert(LeanDeferred::default());
    headless.settle();
    let psnr = difference(&forward, &headless.capture()).psnr;
    println!("PSNR {psnr:.1} dB");
    psnr
}

/// True if the ball is in the G-buffer: a debug view shows it in grey, and forward would draw over that in colour.
fn is_in_gbuffer(headless: &mut Headless, camera: Entity) -> bool {
    let debug_view = LeanDebugView::from(DebugView::Roughness);
    let mut entity = headless.world().entity_mut(camera);
    entity.insert((LeanDeferred::default(), debug_view));
    headless.settle();
    let debug = headless.capture();
    let mut entity = headless.world().entity_mut(camera);
    entity.remove::<LeanDebugView>();
    headless.settle();
    let center = (debug.size.x * debug.size.y / 2 + debug.size.x / 2) as usize * 4;
    let center = &debug.rgba[center..center + 3];
    center.iter().max().unwrap() - center.iter().min().unwrap() <= 1
}

#[test]
fn documented_material_goes_through_the_gbuffer() {
    in_own_process(|| {
        let mut headless = Headless::with(UVec2::new(160, 120), |app| {
            small_shadow_maps(app);
            app.add_plugins((
                MaterialPlugin::<Rings>::default(),
                GBufferMaterialPlugin::<Rings>::default(),
            ));
        });
        let source = include_str!("../../src/gbuffer/custom_material.wgsl").into();
        insert_shader(&mut headless, RINGS, source, "rings.wgsl");
        let rings = Vec4::new(0.8, 0.3, 0.1, 4.0);
        let camera = spawn_ball(&mut headless, Rings { rings });
        let psnr = psnr(&mut headless, camera);
        assert!(psnr >= 45.0, "{psnr} dB");
        assert!(is_in_gbuffer(&mut headless, camera));
        log_watch::assert_validation_layer_silent();
    });
}

/// Its vertices move, so time stands still: both renderers draw the same waves.
#[test]
fn water_of_the_example_goes_through_the_gbuffer() {
    in_own_process(|| {
        let mut headless = Headless::with(UVec2::new(160, 120), |app| {
            small_shadow_maps(app);
            app.add_plugins((
                MaterialPlugin::<Water>::default(),
                GBufferMaterialPlugin::<Water>::default(),
            ));
        });
        let mut scene = SceneBuilder {
            headless: &mut headless,
        };
        scene.solids();
        scene.sun(true);
        let mesh = scene.add::<Mesh>(Plane3d::default().mesh().size(12.0, 12.0).subdivisions(63));
        let water = scene.add::<Water>(Water {
            color: LinearRgba::rgb(0.02, 0.1, 0.12),
            height: 0.15,
        });
        let place = Transform::from_xyz(0.0, 0.4, 0.0);
        scene.spawn((Mesh3d(mesh), MeshMaterial3d(water), NotShadowCaster, place));
        let camera = scene.default_camera(LeanForwardMeshes::default());
        headless.frames(30);
        headless
            .world()
            .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
        let psnr = psnr(&mut headless, camera);
        assert!(psnr >= 45.0, "{psnr} dB");
        let forward_meshes = headless.world().get::<LeanForwardMeshes>(camera);
        let forward_meshes = forward_meshes.expect("it has one");
        assert_eq!(forward_meshes.total(), 0, "{forward_meshes:?}");
        log_watch::assert_validation_layer_silent();
    });
}

#[test]
fn unregistered_material_is_drawn_by_forward() {
    in_own_process(|| {
        let (mut headless, camera) = ball(false, &gbuffer_main(CHANGE));
        let psnr = psnr(&mut headless, camera);
        assert!(psnr >= 45.0, "{psnr} dB");
        assert!(!is_in_gbuffer(&mut headless, camera));
    });
}

/// With a broken G-buffer shader forward draws its meshes, one message names the file and the error, and once the file is fixed the meshes
/// are in the G-buffer.
fn assert_forward_draws(fault: impl Fn(&str) -> String, named: &str) {
    let (mut headless, camera) = ball(true, &fault(&gbuffer_main(CHANGE)));
    headless.settle();
    let forward = headless.capture();
    headless
        .world()
        .entity_mut(camera)
        .insert(LeanDeferred::default());
    let start = Instant::now();
    while reports().is_empty() && start.elapsed() < Duration::from_secs(30) {
        headless.frames(1);
    }
    headless.frames(20);
    let reports = reports();
    assert_eq!(reports.len(), 1, "{reports:#?}");
    assert!(reports[0].contains(named), "{reports:#?}");
    assert_eq!(active_lean_views(&mut headless), 1);
    let psnr = difference(&forward, &headless.capture()).psnr;
    assert!(psnr >= 45.0, "{psnr} dB");

    set_shader(&mut headless, GBUFFER, &gbuffer_main(CHANGE), GBUFFER_FILE);
    headless.settle();
    headless.frames(3);
    assert!(
        is_in_gbuffer(&mut headless, camera),
        "the fixed shader is used"
    );
    let psnr = difference(&forward, &headless.capture()).psnr;
    assert!(psnr >= 45.0, "{psnr} dB");
}

/// When an edit breaks a shader in use, forward draws its meshes again, and none is missing while it compiles.
#[test]
fn a_shader_that_breaks_while_it_is_in_use() {
    in_own_process(|| {
        let (mut headless, camera) = ball(true, &gbuffer_main(CHANGE));
        headless.settle();
        let forward = headless.capture();
        headless
            .world()
            .entity_mut(camera)
            .insert(LeanDeferred::default());
        headless.settle();
        assert!(is_in_gbuffer(&mut headless, camera));
        for (main, is_right) in [
            (
                gbuffer_main(CHANGE).replace("(pbr, in)", "(qbr, in)"),
                false,
            ),
            (gbuffer_main(CHANGE), true),
        ] {
            set_shader(&mut headless, GBUFFER, &main, GBUFFER_FILE);
            for frame in 0..6 {
                let psnr = difference(&forward, &headless.capture()).psnr;
                assert!(psnr >= 45.0, "{is_right}, frame {frame}: {psnr} dB");
            }
            assert_eq!(is_in_gbuffer(&mut headless, camera), is_right);
        }
        assert_eq!(reports().len(), 1);
    });
}

fn reports() -> Vec<String> {
    log_watch::messages_with(&format!("lean_deferred/gbuffer ({GBUFFER_FILE})"))
}

#[test]
fn a_shader_with_an_error_of_grammar() {
    in_own_process(|| {
        assert_forward_draws(|main| main.replace("return", "retrun"), "pack_pbr_input")
    });
}

const VOXEL_GBUFFER: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e46");

/// The G-buffer shader that the material's own crate lacks.
const VOXEL_GBUFFER_SOURCE: &str = r"
#import bevy_lean_deferred::gbuffer::pack::{GBufferOutput, pack_pbr_input}
#import bevy_pbr::{
    mesh_functions,
    pbr_fragment::pbr_input_from_standard_material,
    prepass_io::VertexOutput,
    view_transformations::position_world_to_clip,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> palette: array<vec4<f32>, 4>;

struct Vertex {
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
    @location(3) normal: vec3<f32>,
    @location(8) row: u32,
}

struct Voxel {
    @builtin(position) position: vec4<f32>,
    @location(2) world_normal: vec3<f32>,
    @location(4) world_position: vec4<f32>,
    @location(7) @interpolate(flat) instance_index: u32,
    @location(10) @interpolate(flat) row: u32,
}

@vertex
fn vertex(vertex: Vertex) -> Voxel {
    let world_from_local = mesh_functions::get_world_from_local(vertex.instance_index);
    var out: Voxel;
    out.world_position = mesh_functions::mesh_position_local_to_world(
        world_from_local,
        vec4(vertex.position, 1.0),
    );
    out.world_normal = mesh_functions::mesh_normal_local_to_world(vertex.normal, vertex.instance_index);
    out.position = position_world_to_clip(out.world_position.xyz);
    out.instance_index = vertex.instance_index;
    out.row = vertex.row;
    return out;
}

@fragment
fn fragment(voxel: Voxel, @builtin(front_facing) is_front: bool) -> GBufferOutput {
    var in: VertexOutput;
    in.position = voxel.position;
    in.world_position = voxel.world_position;
    in.world_normal = voxel.world_normal;
    in.instance_index = voxel.instance_index;
    var pbr = pbr_input_from_standard_material(in, is_front);
    pbr.material.base_color *= palette[voxel.row];
    return pack_pbr_input(pbr, in);
}
";

/// A cube of a foreign material, for which `GBufferMaterial` cannot be implemented here.
fn voxels(plugins: impl FnOnce(&mut App)) -> (Headless, Entity) {
    let mut headless = Headless::with(UVec2::new(160, 120), |app| {
        small_shadow_maps(app);
        app.add_plugins(VoxelPlugin);
        plugins(app);
    });
    let source = VOXEL_GBUFFER_SOURCE.into();
    insert_shader(&mut headless, VOXEL_GBUFFER, source, "voxels_gbuffer.wgsl");
    let mut scene = SceneBuilder {
        headless: &mut headless,
    };
    scene.floor();
    scene.sun(true);
    let palette = [
        [0.8, 0.3, 0.2],
        [0.3, 0.7, 0.2],
        [0.2, 0.3, 0.8],
        [0.8, 0.7, 0.2],
    ];
    let material = scene.add::<VoxelMaterial>(VoxelMaterial {
        base: StandardMaterial::default(),
        extension: Palette {
            rows: palette.map(|color| Vec3::from(color).extend(1.0)),
        },
    });
    let mesh = scene.add::<Mesh>(voxel_mesh());
    let place = Transform::from_xyz(0.0, 1.0, 0.0).with_rotation(Quat::from_rotation_y(0.6));
    scene.spawn((Mesh3d(mesh), MeshMaterial3d(material), place));
    let camera = scene.default_camera(());
    (headless, camera)
}

fn register_voxels(app: &mut App) {
    app.add_plugins(
        GBufferMaterialPlugin::<VoxelMaterial>::new(VOXEL_GBUFFER, |material: &VoxelMaterial| {
            material.base.gbuffer_needs()
        })
        .with_vertex_shader(VOXEL_GBUFFER, [row_attribute()]),
    );
}

#[test]
fn a_material_of_another_crate_goes_through_the_gbuffer() {
    in_own_process(|| {
        for (is_registered, register) in
            [(false, (|_| {}) as fn(&mut App)), (true, register_voxels)]
        {
            let (mut headless, camera) = voxels(register);
            let psnr = psnr(&mut headless, camera);
            assert!(psnr >= 45.0, "{psnr} dB");
            assert_eq!(is_in_gbuffer(&mut headless, camera), is_registered);
        }
        log_watch::assert_validation_layer_silent();
    });
}

/// The function from the material to its needs is evaluated again when the material changes.
#[test]
fn needs_of_a_material_of_another_crate_follow_it() {
    in_own_process(|| {
        let (mut headless, camera) = voxels(register_voxels);
        psnr(&mut headless, camera);
        for depth_bias in [1.0, 0.0] {
            let mut materials = headless.world().resource_mut::<Assets<VoxelMaterial>>();
            for (_, material) in materials.iter_mut() {
                material.base.depth_bias = depth_bias;
            }
            headless.settle();
            assert_eq!(is_in_gbuffer(&mut headless, camera), depth_bias == 0.0);
        }
    });
}
