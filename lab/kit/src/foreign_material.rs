//! A material of a third crate, like those of voxel terrain crates. It has a shader for Bevy's main pass only, which reads a vertex
//! attribute that no other material has.

use bevy::{
    asset::uuid_handle,
    mesh::{
        MeshVertexAttribute, MeshVertexBufferLayoutRef, VertexAttributeDescriptor, VertexFormat,
    },
    pbr::{
        ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline,
        MaterialPlugin,
    },
    prelude::*,
    reflect::TypePath,
    render::render_resource::{
        AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError,
    },
    shader::{ShaderDefVal, ShaderRef},
};

/// A vertex's row of the palette.
pub const ATTRIBUTE_ROW: MeshVertexAttribute =
    MeshVertexAttribute::new("Row", 0x5eed_0045, VertexFormat::Uint32);

/// [`ATTRIBUTE_ROW`] at its shader location.
pub fn row_attribute() -> VertexAttributeDescriptor {
    ATTRIBUTE_ROW.at_shader_location(8)
}

const SHADER: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e45");

const SOURCE: &str = r"
#import bevy_pbr::{
    forward_io::{FragmentOutput, VertexOutput},
    mesh_functions,
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{apply_pbr_lighting, main_pass_post_lighting_processing},
    view_transformations::position_world_to_clip,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> palette: array<vec4<f32>, 4>;

struct Vertex {
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(8) row: u32,
}

struct Voxel {
    @builtin(position) position: vec4<f32>,
    @location(0) world_position: vec4<f32>,
    @location(1) world_normal: vec3<f32>,
    @location(6) @interpolate(flat) instance_index: u32,
    @location(8) @interpolate(flat) row: u32,
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
fn fragment(voxel: Voxel, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    var in: VertexOutput;
    in.position = voxel.position;
    in.world_position = voxel.world_position;
    in.world_normal = voxel.world_normal;
#ifdef VERTEX_OUTPUT_INSTANCE_INDEX
    in.instance_index = voxel.instance_index;
#endif
    var pbr = pbr_input_from_standard_material(in, is_front);
    pbr.material.base_color *= palette[voxel.row];
    return FragmentOutput(main_pass_post_lighting_processing(pbr, apply_pbr_lighting(pbr)));
}
";

/// Colours by palette row.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
pub struct Palette {
    #[uniform(100)]
    pub rows: [Vec4; 4],
}

pub type VoxelMaterial = ExtendedMaterial<StandardMaterial, Palette>;

impl MaterialExtension for Palette {
    fn vertex_shader() -> ShaderRef {
        SHADER.into()
    }

    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }

    fn specialize(
        _: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        _: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let prepass = ShaderDefVal::from("PREPASS_PIPELINE");
        if !descriptor.vertex.shader_defs.contains(&prepass) {
            let attributes = [
                Mesh::ATTRIBUTE_POSITION.at_shader_location(0),
                Mesh::ATTRIBUTE_NORMAL.at_shader_location(1),
                row_attribute(),
            ];
            descriptor.vertex.buffers = vec![layout.0.get_layout(&attributes)?];
        }
        Ok(())
    }
}

/// Adds the material and its shader.
pub struct VoxelPlugin;

impl Plugin for VoxelPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(MaterialPlugin::<VoxelMaterial>::default());
        let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
        shaders
            .insert(SHADER.id(), Shader::from_wgsl(SOURCE, "voxels.wgsl"))
            .expect("a place for a constant handle");
    }
}

/// A cube with one row per side; the four rows repeat.
pub fn voxel_mesh() -> Mesh {
    let rows: Vec<u32> = (0..24).map(|vertex| vertex / 4 % 4).collect();
    Mesh::from(Cuboid::from_length(1.4)).with_inserted_attribute(ATTRIBUTE_ROW, rows)
}
