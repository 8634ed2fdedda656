// Water in motion: one shader for Bevy's forward pass, its prepass and the G-buffer, vertices and fragments.
#import bevy_pbr::{
    mesh_functions::{
        get_previous_world_from_local, get_world_from_local, mesh_position_local_to_world,
    },
    pbr_types::PbrInput,
    view_transformations::position_world_to_clip,
}

#ifdef PREPASS_PIPELINE
#import bevy_pbr::prepass_io::{Vertex, VertexOutput}
#import bevy_render::globals::Globals
#ifdef DEFERRED_PREPASS
// The G-buffer. Fragments of other prepasses have no normals.
#import bevy_lean_deferred::gbuffer::pack::{GBufferOutput, pack_pbr_input}
#import bevy_pbr::pbr_fragment::pbr_input_from_vertex_output
#endif
#else
#import bevy_lean_deferred::lighting::forward::light::apply_lean_lighting_with_reflection
#import bevy_lean_deferred::lighting::forward::reflected_light::lean_reflected_light
#import bevy_pbr::{
    forward_io::{FragmentOutput, Vertex, VertexOutput},
    mesh_view_bindings::globals,
    pbr_fragment::pbr_input_from_vertex_output,
    pbr_functions::main_pass_post_lighting_processing,
}
#endif

struct Water {
    color: vec4<f32>,
    // Height of the longest wave, in metres.
    height: f32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> water: Water;

#ifdef PREPASS_PIPELINE
// Bevy binds it here in prepasses; `prepass_bindings` does not declare it.
@group(0) @binding(1) var<uniform> globals: Globals;
#endif

// Waves that the vertices follow.
const LONG_WAVES: u32 = 4u;
// Waves that turn the normals of fragments: shorter ones too.
const ALL_WAVES: u32 = 8u;

struct Waves {
    height: f32,
    // Along x and z.
    slope: vec2<f32>,
}

// The `count` longest waves at a place on the xz plane.
fn waves_at(place: vec2<f32>, time: f32, count: u32) -> Waves {
    var waves: Waves;
    var direction = vec2(0.6, 0.8);
    var amplitude = water.height;
    // In radians per metre.
    var frequency = 0.8;
    for (var i = 0u; i < count; i++) {
        // On deep water, long waves are faster.
        let phase = frequency * dot(direction, place) - sqrt(9.81 * frequency) * time;
        waves.height += amplitude * sin(phase);
        waves.slope += amplitude * frequency * cos(phase) * direction;
        // Each wave turns by the golden angle.
        direction = vec2(
            -0.737 * direction.x - 0.675 * direction.y,
            0.675 * direction.x - 0.737 * direction.y,
        );
        amplitude *= 0.5;
        frequency *= 1.7;
    }
    return waves;
}

fn normal_of(waves: Waves) -> vec3<f32> {
    return normalize(vec3(-waves.slope.x, 1.0, -waves.slope.y));
}

@vertex
fn vertex(in: Vertex) -> VertexOutput {
    var out: VertexOutput;
    let world_from_local = get_world_from_local(in.instance_index);
    let place = mesh_position_local_to_world(world_from_local, vec4(in.position, 1.0));
    let waves = waves_at(place.xz, globals.time, LONG_WAVES);
    out.world_position = place + vec4(0.0, waves.height, 0.0, 0.0);
    out.position = position_world_to_clip(out.world_position.xyz);
#ifdef VERTEX_OUTPUT_INSTANCE_INDEX
    out.instance_index = in.instance_index;
#endif

#ifdef PREPASS_PIPELINE
#ifdef NORMAL_PREPASS_OR_DEFERRED_PREPASS
    out.world_normal = normal_of(waves);
#endif
#ifdef MOTION_VECTOR_PREPASS
    // Position of the vertex in the last frame.
    let last_time = globals.time - globals.delta_time;
    let last_world_from_local = get_previous_world_from_local(in.instance_index);
    let last_place = mesh_position_local_to_world(last_world_from_local, vec4(in.position, 1.0));
    let last_waves = waves_at(last_place.xz, last_time, LONG_WAVES);
    out.previous_world_position = last_place + vec4(0.0, last_waves.height, 0.0, 0.0);
#endif
#else
    out.world_normal = normal_of(waves);
#endif
    return out;
}

// The surface of a fragment, for both renderers.
fn set_surface(pbr_input: ptr<function, PbrInput>) {
    let waves = waves_at((*pbr_input).world_position.xz, globals.time, ALL_WAVES);
    let foam = smoothstep(0.9, 1.6, waves.height / water.height);
    (*pbr_input).N = normal_of(waves);
    (*pbr_input).material.base_color = mix(water.color, vec4(0.8, 0.8, 0.8, 1.0), foam);
    (*pbr_input).material.perceptual_roughness = mix(0.08, 0.7, foam);
}

#ifdef PREPASS_PIPELINE
#ifdef DEFERRED_PREPASS
// Packs the surface, to be lit later.
@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> GBufferOutput {
    var pbr_input = pbr_input_from_vertex_output(in, is_front, false);
    set_surface(&pbr_input);
    return pack_pbr_input(pbr_input, in);
}
#endif
#else
// Lights the surface.
@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    var pbr_input = pbr_input_from_vertex_output(in, is_front, false);
    set_surface(&pbr_input);
    // The shore as the last frame showed it; 0 on cameras that do not ask for reflections on forward meshes.
    let roughness = pbr_input.material.perceptual_roughness;
    let mirrored = lean_reflected_light(pbr_input.world_position.xyz, pbr_input.N, roughness);
    var color = apply_lean_lighting_with_reflection(pbr_input, mirrored);
    // The flatter the view, the more the water mirrors, and the less is seen through it (Schlick 1994, "An Inexpensive BRDF Model for
    // Physically-based Rendering").
    let facing = saturate(dot(pbr_input.N, pbr_input.V));
    color.a = mix(color.a, 1.0, pow(1.0 - facing, 5.0));
    return FragmentOutput(main_pass_post_lighting_processing(pbr_input, color));
}
#endif
