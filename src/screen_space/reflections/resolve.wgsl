// What each pixel mirrors, of what the rays around it have found. A rough mirror has the mean of 5×5, whose sixteen
// directions make a lobe. A smooth one has the light of one place: where its own ray ends, as far away as those beside it went.
#import bevy_lean_deferred::screen_space::reflections::bindings::{
    DIVISOR, ROUGH_STEP, depth_in_view, edge_step, hits_texture, output_texture, rays_texture, sends_ray, step_of_rays, view,
    view_position,
}
#import bevy_lean_deferred::screen_space::reflections::rough_light::{MEANS, make_mean, rough_light}
#import bevy_lean_deferred::screen_space::reflections::smooth_light::smooth_light
#import bevy_lean_deferred::screen_space::reflections::surface::{mirror_of, normal_word_at, smoothness}
#import bevy_lean_deferred::screen_space::reflections::texels::{
    FIRST_MADE, INVOCATIONS, IS_ROUGH, REACH, Receiver, SIDE, TEXELS, depths, hits, lights, normals, pack_halves, slope_at,
    width_at,
}

/// Pixels a side.
const PIXELS: i32 = TEXELS * DIVISOR;
/// Radius of a lobe where it meets a surface, in pixels, up to which it is taken for a single place, and from which on it
/// is the mean of rays.
const SMOOTH_UP_TO: f32 = 2.0;
const ROUGH_FROM: f32 = 8.0;

/// 1 if any of them mirrors: all write the same.
var<workgroup> mirrors_any: u32;

/// `place` is that of the pixel in the workgroup.
fn light_at(pixel: vec2<i32>, place: vec2<i32>) -> vec4<f32> {
    let depth = depth_in_view(pixel);
    let mirror = mirror_of(pixel, normal_word_at(pixel));
    let fade = smoothness(mirror.roughness) * view.intensity;
    if !(depth > 0.0) || fade == 0.0 {
        return vec4(0.0);
    }
    let texel = vec2<i32>(vec2<u32>(place) / u32(DIVISOR));
    let first = texel.x + SIDE * texel.y + FIRST_MADE;
    var receiver: Receiver;
    receiver.at = vec2<f32>(pixel) + 0.5;
    receiver.depth = depth;
    receiver.normal = mirror.normal;
    receiver.roughness = mirror.roughness;
    receiver.slope = slope_at(first);
    receiver.inverse_step = 1.0 / edge_step(depth, f32(DIVISOR));
    let along = vec2<f32>(vec2<u32>(place) % u32(DIVISOR)) / f32(DIVISOR);
    let alpha = mirror.roughness * mirror.roughness;
    let radius = alpha * width_at(first, view_position(receiver.at, depth));
    let roughness = smoothstep(SMOOTH_UP_TO, ROUGH_FROM, radius);
    var light = vec4(0.0);
    if roughness < 1.0 {
        light += (1.0 - roughness) * smooth_light(receiver, first, along);
    }
    if roughness > 0.0 {
        light += roughness * rough_light(receiver, texel, first, along);
    }
    return vec4(light.rgb / max(light.a, 1e-6), light.a * fade);
}

/// What the textures hold of a texel that the workgroup reads.
struct Texel {
    normal: u32,
    depth: f32,
    light: vec4<f32>,
    hit: u32,
}

/// Where texel `read` of the workgroup is. `corner` is the first one whose pixels it makes.
fn place_of(corner: vec2<i32>, read: i32) -> vec2<i32> {
    return corner + vec2<i32>(vec2(u32(read) % u32(SIDE), u32(read) / u32(SIDE))) - REACH * ROUGH_STEP;
}

/// The nearest one in the picture.
fn nearest_inside(texel: vec2<i32>) -> vec2<i32> {
    return clamp(texel, vec2(0), vec2<i32>(view.texture_size) - 1);
}

fn texel_at(corner: vec2<i32>, read: i32) -> Texel {
    let texel = nearest_inside(place_of(corner, read));
    var known: Texel;
    known.normal = normal_word_at(texel * DIVISOR);
    known.depth = depth_in_view(texel * DIVISOR);
    known.light = textureLoad(rays_texture, texel, 0);
    known.hit = textureLoad(hits_texture, texel, 0).r;
    return known;
}

fn keep(corner: vec2<i32>, read: i32, known: Texel) {
    let texel = place_of(corner, read);
    let mirror = mirror_of(nearest_inside(texel) * DIVISOR, known.normal);
    // What is beyond the rim counts for nothing.
    let counts = all(texel == nearest_inside(texel)) && smoothness(mirror.roughness) > 0.0;
    // Where there is no ray, the textures hold anything.
    let apart = step_of_rays(mirror.roughness);
    let has_ray = counts && known.depth > 0.0 && sends_ray(texel, apart);
    let light = vec4(known.light.rgb * known.light.a, known.light.a);
    lights[read] = select(vec2(0u), pack_halves(light), has_ray);
    hits[read] = select(0u, known.hit, has_ray) | select(0u, IS_ROUGH, apart > 1);
    normals[read] = select(vec2(0u), pack_halves(vec4(mirror.normal, 0.0)), counts);
    depths[read] = select(0.0, known.depth, counts);
    if counts {
        mirrors_any = 1u;
    }
}

@compute @workgroup_size(256, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let i = i32(invocation);
    // Memory holds what ran before.
    if i == 0 {
        mirrors_any = 0u;
    }
    workgroupBarrier();
    let corner = vec2<i32>(workgroup.xy) * TEXELS;
    // Asked for before any is waited for.
    let first = texel_at(corner, i);
    let second = texel_at(corner, i + INVOCATIONS);
    if i + 2 * INVOCATIONS < SIDE * SIDE {
        keep(corner, i + 2 * INVOCATIONS, texel_at(corner, i + 2 * INVOCATIONS));
    }
    keep(corner, i, first);
    if i + INVOCATIONS < SIDE * SIDE {
        keep(corner, i + INVOCATIONS, second);
    }
    let is_empty = workgroupUniformLoad(&mirrors_any) == 0u || view.exposure_ratio == 0.0;
    if !is_empty {
        for (var mean = i; mean < MEANS * MEANS; mean += INVOCATIONS) {
            make_mean(mean);
        }
        workgroupBarrier();
    }
    for (var n = i; n < PIXELS * PIXELS; n += INVOCATIONS) {
        let place = vec2<i32>(vec2(u32(n) % u32(PIXELS), u32(n) / u32(PIXELS)));
        let pixel = corner * DIVISOR + place;
        if all(pixel < vec2<i32>(view.viewport_size)) {
            var light = vec4(0.0);
            if !is_empty {
                light = light_at(pixel, place);
            }
            textureStore(output_texture, pixel, light);
        }
    }
}
