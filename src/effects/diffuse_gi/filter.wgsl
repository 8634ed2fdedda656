// Filters gathered light: weighted means of blocks of 4×4 texels, whose slices cover all directions of the pattern, without texels of
// other surfaces. The weights are continuous, so that no blocks are visible. Where few of the directions have most of the light, as
// beside a small lamp, more blocks count. Where fewer blocks are on the surface, the mean of the 4×4 texels around.
#import bevy_lean_deferred::gbuffer::layout::light::{LARGEST_HALF, pack_halves, unpack_halves}
#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::effects::diffuse_gi::bindings::{
    edge_step, gathered_texture, levels, output_texture, view,
}
#import bevy_lean_deferred::effects::diffuse_gi::entry::unpack_depth

/// Side of the texels of a workgroup.
const SIDE: u32 = 16u;
/// Invocations of a workgroup.
const STRIDE: u32 = 256u;
/// Side of a block: of the pattern, so that each block has all directions.
const BLOCK: u32 = 4u;
/// Blocks of the workgroup's texels and one more on either side: along an axis of the first grid, and of the second one, which begins
/// half a block before.
const FIRST_SIDE: u32 = 6u;
const SECOND_SIDE: u32 = 7u;
const FIRST_COUNT: u32 = FIRST_SIDE * FIRST_SIDE;
const BLOCK_COUNT: u32 = FIRST_COUNT + SECOND_SIDE * SECOND_SIDE;
/// Texels of the blocks before those of the workgroup, and the side of all.
const MARGIN: u32 = 6u;
const CACHE_SIDE: u32 = SECOND_SIDE * BLOCK;

/// Gathered light, as halves, and depths. CACHE_SIDE² texels.
var<workgroup> light: array<vec2<u32>, 784>;
var<workgroup> depths: array<f32, 784>;
/// Means of the blocks. x: the depth for which they hold; y: mean of the squares of `total`.
var<workgroup> block_light: array<vec4<f32>, BLOCK_COUNT>;
var<workgroup> block_depths: array<vec2<f32>, BLOCK_COUNT>;

/// Depth of texels without a surface: none is near to it.
const NO_SURFACE: f32 = -1e9;
/// Squared coefficients of variation of the texels' light from which on the wide mean counts, and counts alone. Of sixteen texels of
/// which one to eight see a lamp, it is 15 to 1.
const SPARSE: f32 = 0.5;
const SPARSEST: f32 = 1.5;
/// Weight of the blocks on the surface, at most 1 per grid, from which on the wide mean counts in full.
const ENOUGH: f32 = 0.5;
/// Share of a texel's tolerance in depth that blocks have. They are up to eight texels away, where the other face of an edge is still
/// within the whole of it.
const OF_BLOCKS: f32 = 1.0 / 16.0;

fn total(color: vec3<f32>) -> f32 {
    return color.r + color.g + color.b;
}

/// The surface around a texel as a plane: depth is affine on screen.
struct Plane {
    depth: f32,
    slope: vec2<f32>,
    inverse_step: f32,
}

fn plane_at(center: u32) -> Plane {
    let depth = depths[center];
    let slope = vec2(
        flatter_slope(depths[center - 1u], depth, depths[center + 1u]),
        flatter_slope(depths[center - CACHE_SIDE], depth, depths[center + CACHE_SIDE]),
    );
    return Plane(depth, slope, 1.0 / edge_step(depth, f32(view.divisor)));
}

/// Weight, 0 to 1, of a texel of this depth at `offset` from the plane's centre.
fn weight_on(plane: Plane, depth: f32, offset: vec2<f32>) -> f32 {
    let expected = plane.depth + plane.slope.y * offset.y + plane.slope.x * offset.x;
    return saturate(2.0 - abs(depth - expected) * plane.inverse_step);
}

/// Weighted sums over texels or blocks.
struct Sums {
    light: vec4<f32>,
    /// Of `total`.
    squares: f32,
    weights: f32,
}

const EMPTY: Sums = Sums(vec4(0.0), 0.0, 1e-6);

/// Sums over the texels of the block whose second texel along both axes is `center`, on this plane.
fn block_sums(plane: Plane, center: u32) -> Sums {
    var sums = EMPTY;
    if plane.depth > 0.0 {
        for (var y = 0u; y < BLOCK; y++) {
            for (var x = 0u; x < BLOCK; x++) {
                let other = center + x + CACHE_SIDE * y - 1u - CACHE_SIDE;
                let weight = weight_on(plane, depths[other], vec2(f32(x), f32(y)) - 1.0);
                let gathered = unpack_halves(light[other]);
                let brightness = total(gathered.rgb);
                sums.light += gathered * weight;
                sums.squares += brightness * brightness * weight;
                sums.weights += weight;
            }
        }
    }
    return sums;
}

/// Sums over the blocks around a texel.
struct Around {
    /// Of the nearest 2×2 blocks of each grid.
    near: Sums,
    /// Of the nearest 3×3.
    wide: Sums,
}

/// Weights of three blocks in a row for a texel at `part` of the middle one, 0 to 1: continuous across blocks, so that neighbours are
/// alike.
fn wide_weights(part: f32) -> array<f32, 3> {
    return array<f32, 3>(0.5 * (1.0 - part), 0.5, 0.5 * part);
}

/// The same of the nearest two: linear between the middles of blocks.
fn near_weights(part: f32) -> array<f32, 3> {
    return array<f32, 3>(saturate(0.5 - part), 1.0 - abs(part - 0.5), saturate(part - 0.5));
}

/// Adds the blocks of a grid around a texel, which is at `place` there. `first` and `side`: index of the grid's first block, and
/// blocks in a row.
fn add_blocks(around: ptr<function, Around>, plane: Plane, place: vec2<u32>, first: u32, side: u32) {
    let corner = first + place.x / BLOCK + side * (place.y / BLOCK);
    let inner = vec2<f32>(place % BLOCK);
    let part = (inner + 0.5) / f32(BLOCK);
    let wide_x = wide_weights(part.x);
    let wide_y = wide_weights(part.y);
    let near_x = near_weights(part.x);
    let near_y = near_weights(part.y);
    // The texel of the first of the blocks that has its depth: the second along both axes.
    let at_corner = Plane(
        plane.depth - dot(plane.slope, inner + f32(BLOCK - 1u)), plane.slope, plane.inverse_step / OF_BLOCKS,
    );
    for (var y = 0u; y < 3u; y++) {
        for (var x = 0u; x < 3u; x++) {
            let block = corner + (x + side * y);
            let of_block = block_depths[block];
            let light = block_light[block];
            let alike = weight_on(at_corner, of_block.x, f32(BLOCK) * vec2(f32(x), f32(y)));
            let near = near_x[x] * near_y[y] * alike;
            (*around).near.light += light * near;
            (*around).near.weights += near;
            let wide = wide_x[x] * wide_y[y] * alike;
            (*around).wide.light += light * wide;
            (*around).wide.squares += of_block.y * wide;
            (*around).wide.weights += wide;
        }
    }
}

/// First texel of a block.
fn place_of_block(block: u32) -> vec2<u32> {
    let second = block - FIRST_COUNT;
    return select(
        BLOCK * vec2(second % SECOND_SIDE, second / SECOND_SIDE),
        BLOCK * vec2(block % FIRST_SIDE, block / FIRST_SIDE) + BLOCK / 2u,
        block < FIRST_COUNT,
    );
}

@compute @workgroup_size(256, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) i: u32) {
    let corner = vec2<i32>(workgroup.xy * SIDE) - i32(MARGIN);
    let last = vec2<i32>(view.texture_size) - 1;
    for (var read = i; read < CACHE_SIDE * CACHE_SIDE; read += STRIDE) {
        let texel = corner + vec2<i32>(vec2(read % CACHE_SIDE, read / CACHE_SIDE));
        let inside = clamp(texel, vec2(0), last);
        light[read] = pack_halves(min(textureLoad(gathered_texture, inside, 0), vec4(LARGEST_HALF)));
        let depth = unpack_depth(textureLoad(levels, inside, 0).r);
        // Texels beyond the border have no weight.
        depths[read] = select(NO_SURFACE, depth, depth > 0.0 && all(texel == inside));
    }
    workgroupBarrier();

    if i < BLOCK_COUNT {
        let block = place_of_block(i) + 1u;
        let middle = block.x + CACHE_SIDE * block.y;
        let on_block = plane_at(middle);
        let sums = block_sums(on_block, middle);
        block_light[i] = sums.light / sums.weights;
        block_depths[i] = vec2(on_block.depth, sums.squares / sums.weights);
    }
    let place = vec2(i % SIDE, i / SIDE);
    let center = (place.x + MARGIN) + CACHE_SIDE * (place.y + MARGIN);
    let plane = plane_at(center);
    workgroupBarrier();

    let texel = workgroup.xy * SIDE + place;
    if any(texel >= view.texture_size) {
        return;
    }
    var found = vec4(0.0);
    if plane.depth > 0.0 {
        var around = Around(EMPTY, EMPTY);
        add_blocks(&around, plane, place, 0u, FIRST_SIDE);
        add_blocks(&around, plane, place + BLOCK / 2u, FIRST_COUNT, SECOND_SIDE);
        let wide = around.wide.light / around.wide.weights;
        let brightness = total(wide.rgb);
        let variation = around.wide.squares / around.wide.weights / max(brightness * brightness, 1e-12) - 1.0;
        // Beside edges, where blocks are on one side of the texel only, their mean is of light further away.
        let near_share = saturate(around.near.weights - 1.0);
        var narrower = around.near.light / around.near.weights;
        if near_share < 1.0 {
            let own = block_sums(plane, center);
            narrower = mix(own.light / own.weights, narrower, near_share);
        }
        let share = saturate((variation - SPARSE) / (SPARSEST - SPARSE)) * saturate(around.wide.weights / ENOUGH);
        found = mix(narrower, wide, share);
    }
    // Clamp to the whole hemisphere.
    textureStore(output_texture, texel, found / max(found.a, 1.0));
}
