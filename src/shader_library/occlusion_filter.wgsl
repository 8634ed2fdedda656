// Filter of ambient occlusion: 3×3 or 5×5 texels (4×4 from half resolution), read with gathers.
#define_import_path bevy_lean_deferred::occlusion_filter

#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::tiles::pixel_of_texel

struct OcclusionFilter {
    /// 1 / view-space distance is `edge.x * depth + edge.y`. Its square times `edge.z` is the depth step that separates surfaces.
    edge: vec3<f32>,
    /// Factor on the occlusion.
    intensity: f32,
    /// The view's part of the depth texture.
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
}

/// Kind of the filter: 3×3 texels if neither half nor wide.
struct FilterKind {
    /// 4×4 texels of a texture with half the size of the view per axis.
    is_half: bool,
    /// 5×5 texels.
    is_wide: bool,
    /// Ignores neighbours across a depth step.
    is_edge_aware: bool,
}

/// The kind that the shader is compiled for.
fn compiled_kind() -> FilterKind {
    var kind: FilterKind;
#ifdef OCCLUSION_HALF
    kind.is_half = true;
#endif
#ifdef OCCLUSION_WIDE
    kind.is_wide = true;
#endif
#ifdef OCCLUSION_EDGE_AWARE
    kind.is_edge_aware = true;
#endif
    return kind;
}

/// Gathers 2×2 texels, of which `first` has the least coordinates. The components are the texels (0, 1), (1, 1), (1, 0), (0, 0)
/// relative to it.
fn gather_at(occlusion: texture_2d<f32>, nearest: sampler, first: vec2<i32>) -> vec4<f32> {
    let place = vec2<f32>(first + 1) / vec2<f32>(textureDimensions(occlusion));
    return textureGather(0, occlusion, nearest, place);
}

/// Depth around a pixel as a plane. Exact on planar surfaces, because depth is affine on screen.
struct DepthPlane {
    center: f32,
    /// Change in depth per pixel.
    slope: vec2<f32>,
    /// 1 / the depth step that separates surfaces.
    inverse_step: f32,
}

fn depth_in_view(depth: texture_depth_2d, parameters: OcclusionFilter, pixel: vec2<i32>) -> f32 {
    let inside = clamp(pixel, vec2(0), vec2<i32>(parameters.viewport_size) - 1);
    return textureLoad(depth, vec2<i32>(parameters.viewport_origin) + inside, 0);
}

fn depth_plane(depth: texture_depth_2d, parameters: OcclusionFilter, pixel: vec2<i32>, center: f32) -> DepthPlane {
    let left = depth_in_view(depth, parameters, pixel - vec2(1, 0));
    let right = depth_in_view(depth, parameters, pixel + vec2(1, 0));
    let above = depth_in_view(depth, parameters, pixel - vec2(0, 1));
    let below = depth_in_view(depth, parameters, pixel + vec2(0, 1));
    let slope = vec2(flatter_slope(left, center, right), flatter_slope(above, center, below));
    let nearness = parameters.edge.x * center + parameters.edge.y;
    // The second term exceeds rounding errors of depth. At depth 0, infinitely far away in perspective, any difference is a step.
    let step = parameters.edge.z * nearness * nearness + 1e-6 * center;
    return DepthPlane(center, slope, 1.0 / max(step, 1e-30));
}

/// Weight of a texel whose occlusion was gathered at `offset` pixels from the plane's centre: 1 on the plane, 0 a step away.
fn edge_weight(plane: DepthPlane, depth: f32, offset: vec2<i32>) -> f32 {
    let expected = plane.center + dot(plane.slope, vec2<f32>(offset));
    return saturate(1.0 - abs(depth - expected) * plane.inverse_step);
}

/// Weighted sum of occlusion around a pixel, and the sum of the weights.
struct OcclusionSum {
    sum: f32,
    weights: f32,
}

/// From half resolution: 1 2 1 after linear interpolation. Even and odd texels weigh the same, which also removes the 2×2 pattern.
fn sum_of_half(
    occlusion: texture_2d<f32>,
    nearest: sampler,
    depth: texture_depth_2d,
    parameters: OcclusionFilter,
    kind: FilterKind,
    pixel: vec2<i32>,
    plane: DepthPlane,
) -> OcclusionSum {
    var result: OcclusionSum;
    let base = pixel >> vec2(1u);
    let odd = vec2<f32>(pixel & vec2(1)) * 0.5;
    var mean = 0.0;
    for (var i = 0; i < 4; i++) {
        let corner = vec2(2 * (i & 1) - 1, 2 * (i >> 1u) - 1);
        let values = gather_at(occlusion, nearest, base + corner);
        for (var j = 0; j < 4; j++) {
            let texel = corner + vec2(i32(j == 1 || j == 2), i32(j < 2));
            let ramp = mix(vec2(1.0) - abs(vec2<f32>(texel)) * 0.5, 1.0 - abs(vec2<f32>(texel) - 1.0) * 0.5, odd);
            let clipped = max(ramp, vec2(0.0));
            var weight = clipped.x * clipped.y;
            // The weights add up to 4.
            mean += 0.25 * weight * values[j];
            if kind.is_edge_aware {
                let other = pixel_of_texel(base + texel, 2, vec2<i32>(parameters.viewport_size));
                weight *= edge_weight(plane, depth_in_view(depth, parameters, other), other - pixel) + 1e-3;
            }
            result.sum += weight * values[j];
            result.weights += weight;
        }
    }
    // A few texels of the same surface do not cover all directions. Where less than half of the weight remains, occlusion above
    // the unweighted mean counts less, so that no single texel turns a pixel black.
    let bounded = min(result.sum, mean * result.weights);
    result.sum = mix(bounded, result.sum, saturate(0.25 * result.weights * result.weights));
    return result;
}

/// From full resolution. Of 5×5 texels: 1 2 2 2 1 along each axis; 0 for the sixth texel of three gathers. Of 3×3 texels: the four
/// gathers overlap, and read the centre four times and its direct neighbours twice.
fn sum_of_full(
    occlusion: texture_2d<f32>,
    nearest: sampler,
    depth: texture_depth_2d,
    parameters: OcclusionFilter,
    kind: FilterKind,
    pixel: vec2<i32>,
    plane: DepthPlane,
) -> OcclusionSum {
    var result: OcclusionSum;
    let side = select(2, 3, kind.is_wide);
    for (var i = 0; i < side * side; i++) {
        let corner = select(vec2(i & 1, i >> 1u) - 1, 2 * vec2(i % 3, i / 3) - 2, kind.is_wide);
        let values = gather_at(occlusion, nearest, pixel + corner);
        for (var j = 0; j < 4; j++) {
            let offset = corner + vec2(i32(j == 1 || j == 2), i32(j < 2));
            let along = select(vec2(1), min(3 - abs(offset), vec2(2)), kind.is_wide);
            var weight = f32(along.x * along.y);
            if kind.is_edge_aware && along.x * along.y > 0 && any(offset != vec2(0)) {
                weight *= edge_weight(plane, depth_in_view(depth, parameters, pixel + offset), offset);
            }
            result.sum += weight * values[j];
            result.weights += weight;
        }
    }
    return result;
}

/// Filtered occlusion of a viewport `pixel`, 0 to 1. `center` is its depth.
fn filtered_occlusion(
    occlusion: texture_2d<f32>,
    nearest: sampler,
    depth: texture_depth_2d,
    parameters: OcclusionFilter,
    kind: FilterKind,
    pixel: vec2<i32>,
    center: f32,
) -> f32 {
    var plane: DepthPlane;
    if kind.is_edge_aware {
        plane = depth_plane(depth, parameters, pixel, center);
    }
    var result: OcclusionSum;
    if kind.is_half {
        result = sum_of_half(occlusion, nearest, depth, parameters, kind, pixel, plane);
    } else {
        result = sum_of_full(occlusion, nearest, depth, parameters, kind, pixel, plane);
    }
    return saturate(result.sum / result.weights * parameters.intensity);
}
