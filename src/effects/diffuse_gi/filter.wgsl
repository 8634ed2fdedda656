// Filters gathered light: weighted means of blocks of 4×4 texels, without those of other surfaces. Slices of each block cover the
// hemisphere evenly, and those of 2×2 neighbouring blocks lie between each other. Whatever the texel, its weights of every second
// block, along either axis, sum to half of all, and are continuous: neither blocks nor their differences are visible. Beside edges, where
// some blocks are not on the surface, the mean is continued to the texel by linear regression. With few of them, that of the 4×4 texels
// around takes over.
#import bevy_lean_deferred::gbuffer::layout::light::{LARGEST_HALF, pack_halves, unpack_halves}
#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::effects::diffuse_gi::bindings::{
    edge_step, gathered_texture, levels, output_texture, view,
}
#import bevy_lean_deferred::effects::diffuse_gi::entry::{unpack_depth, unpack_pixel}

/// Side of the texels of a workgroup.
const SIDE: u32 = 16u;
/// Invocations of a workgroup.
const STRIDE: u32 = 256u;
/// Side of a block.
const BLOCK: u32 = 4u;
/// Blocks in a row: those of the workgroup's texels, and two more on either side.
const BLOCKS: u32 = 8u;
const BLOCK_COUNT: u32 = BLOCKS * BLOCKS;
/// Texels of the blocks before those of the workgroup, and the side of all.
const MARGIN: u32 = 2u * BLOCK;
const CACHE_SIDE: u32 = BLOCKS * BLOCK;

/// Gathered light, as halves, and depths. CACHE_SIDE² texels. Means of the blocks then take the place of the first texels' light:
/// shared memory for both would leave room for fewer workgroups.
var<workgroup> light: array<vec2<u32>, 1024>;
var<workgroup> depths: array<f32, 1024>;

/// Depth of texels without a surface: none is near to it.
const NO_SURFACE: f32 = -1e9;
/// Squared coefficients of variation of the light of 4×4 texels from which on blocks further away count beside an edge, and count in
/// full. Of sixteen texels of which one to eight see a lamp, it is 15 to 1.
const SPARSE: f32 = 0.5;
const SPARSEST: f32 = 1.5;
/// Of the 4×4 texels, those on the surface: blocks further away begin to count below the first number, and count in full below the
/// second.
const MOST_TEXELS: f32 = 16.0;
const FEWEST_TEXELS: f32 = 8.0;
/// Weight of the blocks on the surface, at most 1, from which on they may take the place of the texels in full.
const ENOUGH: f32 = 1.0 / 16.0;
/// Mean square of the blocks' distances along an axis, in blocks: 3/4 of all blocks. Less here, because light falls more steeply than
/// linearly into creases.
const SPREAD: f32 = 0.69;
/// Lower bound of the variance of these distances: with 0.2, light exceeds its surroundings by 0.4% in corners.
const LEAST_SPREAD: f32 = 0.25;
/// Largest share of the hemisphere that a half float holds beside the number of a pixel.
const MOST_HIDDEN: f32 = 1.0 - 1.0 / 256.0;
/// Share of a texel's tolerance in depth that blocks have. They are up to eleven texels away, where the other face of an edge is still
/// within the whole of it.
const OF_BLOCKS: f32 = 1.0 / 8.0;

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

/// Weighted sums over texels.
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

/// Light of the blocks around a texel.
struct Around {
    light: vec4<f32>,
    /// Weights of the blocks on the surface, at most 1.
    weights: f32,
}

/// Share below `x` of a triangle of area 1 from -2 to 2.
fn below(x: f32) -> f32 {
    let rest = 2.0 - min(abs(x), 2.0);
    let tail = 0.125 * rest * rest;
    return select(tail, 1.0 - tail, x > 0.0);
}

/// Weights of five blocks in a row for a texel at `part` of the middle one, 0 to 1: the blocks as steps, averaged over the width of
/// two, twice.
fn weights_along(part: f32) -> array<f32, 5> {
    let edges = vec4(below(-1.0 - part), below(-part), below(1.0 - part), below(2.0 - part));
    return array<f32, 5>(edges.x, edges.y - edges.x, edges.z - edges.y, edges.w - edges.z, 1.0 - edges.w);
}

/// Light of the blocks around a texel, which is at `place` of the workgroup: their mean, continued to the texel by linear regression.
fn light_around(plane: Plane, place: vec2<u32>) -> Around {
    let corner = place / BLOCK;
    let first_block = corner.x + BLOCKS * corner.y;
    // A block has the depth of its second texel along both axes.
    let first_depth = BLOCK * (corner.x + CACHE_SIDE * corner.y) + 1u + CACHE_SIDE;
    let inner = vec2<f32>(place % BLOCK);
    let at_first = Plane(
        plane.depth - dot(plane.slope, inner + f32(2u * BLOCK - 1u)), plane.slope, plane.inverse_step / OF_BLOCKS,
    );
    let part = (inner + 0.5) / f32(BLOCK);
    let along_x = weights_along(part.x);
    let along_y = weights_along(part.y);
    var weights: array<f32, 25>;
    var sum = 1e-6;
    var moment = vec2(0.0);
    for (var y = 0u; y < 5u; y++) {
        var of_row = 0.0;
        for (var x = 0u; x < 5u; x++) {
            let depth = depths[first_depth + BLOCK * (x + CACHE_SIDE * y)];
            let alike = weight_on(at_first, depth, f32(BLOCK) * vec2(f32(x), f32(y)));
            let weight = along_x[x] * along_y[y] * alike;
            weights[x + 5u * y] = weight;
            of_row += weight;
            moment.x += weight * f32(x);
        }
        sum += of_row;
        moment.y += of_row * f32(y);
    }
    // Mean place of these blocks, in blocks from the first one and from the texel. 0 from the texel if all count.
    let center = moment / sum;
    let off = center - 1.5 - part;
    // Change of the weights per block. The sum of the weights stays.
    let slope = off / max(SPREAD - dot(off, off), LEAST_SPREAD);
    let at_first_block = 1.0 + dot(slope, center);
    var light_sum = vec4(0.0);
    for (var y = 0u; y < 5u; y++) {
        for (var x = 0u; x < 5u; x++) {
            let weight = weights[x + 5u * y] * (at_first_block - slope.y * f32(y) - slope.x * f32(x));
            light_sum += unpack_halves(light[first_block + (x + BLOCKS * y)]) * weight;
        }
    }
    return Around(max(light_sum, vec4(0.0)) / sum, sum);
}

/// Light of a texel at `place` of the workgroup, on this plane, whose index is `center`.
fn filtered(plane: Plane, place: vec2<u32>, center: u32) -> vec4<f32> {
    let around = light_around(plane, place);
    // In full from 69% of the weights on: a texel or two from an edge.
    let share_of_blocks = saturate(4.0 * around.weights - 1.75);
    if share_of_blocks == 1.0 {
        return around.light;
    }
    let own = block_sums(plane, center);
    let mean = own.light / own.weights;
    let brightness = total(mean.rgb);
    let variation = own.squares / own.weights / max(brightness * brightness, 1e-12) - 1.0;
    let is_sparse = saturate((variation - SPARSE) / (SPARSEST - SPARSE));
    let is_small = saturate((MOST_TEXELS - own.weights) / (MOST_TEXELS - FEWEST_TEXELS));
    let share = max(is_sparse, is_small) * saturate(around.weights / ENOUGH);
    return mix(mean, around.light, max(share, share_of_blocks));
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

    var mean_of_block = vec2(0u);
    if i < BLOCK_COUNT {
        let second = BLOCK * vec2(i % BLOCKS, i / BLOCKS) + 1u;
        let middle = second.x + CACHE_SIDE * second.y;
        let sums = block_sums(plane_at(middle), middle);
        mean_of_block = pack_halves(sums.light / sums.weights);
    }
    let place = vec2(i % SIDE, i / SIDE);
    let center = (place.x + MARGIN) + CACHE_SIDE * (place.y + MARGIN);
    let plane = plane_at(center);
    workgroupBarrier();
    if i < BLOCK_COUNT {
        light[i] = mean_of_block;
    }
    workgroupBarrier();

    let texel = workgroup.xy * SIDE + place;
    if any(texel >= view.texture_size) {
        return;
    }
    var found = vec4(0.0);
    if plane.depth > 0.0 {
        found = filtered(plane, place, center);
        // Clamp to the whole hemisphere.
        found /= max(found.a, 1.0);
        // Depths have these bits, too. Lighting learns the pixel from a negative alpha.
        let pixel = unpack_pixel(bitcast<u32>(plane.depth));
        if pixel > 0u {
            found.a = -f32(pixel) - min(found.a, MOST_HIDDEN);
        }
    }
    textureStore(output_texture, texel, found);
}
