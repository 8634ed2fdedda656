// Debug view over the tonemapped picture: darkens pixels that count less, and shows the exposure on a scale.
//
// The scale has a line per stop, a long one at 0, a white mark at the exposure and a green one at its target.
#import bevy_lean_deferred::effects::auto_exposure::bindings::{state, view}
#import bevy_lean_deferred::effects::auto_exposure::pattern::pattern_weight

#ifdef MASK
#import bevy_lean_deferred::effects::auto_exposure::bindings::{mask, mask_sampler}
#endif

/// Brightness of pixels that do not count.
const UNCOUNTED: f32 = 0.35;
const WHITE: vec4<f32> = vec4(1.0);
const GREEN: vec4<f32> = vec4(0.1, 0.9, 0.2, 1.0);
const PANEL: vec4<f32> = vec4(0.0, 0.0, 0.0, 0.85);

/// Colour of the scale at `position`, which runs from (0, 0) at the upper left to `size`, in pixels.
fn scale_color(position: vec2<f32>, size: vec2<f32>, unit: f32) -> vec4<f32> {
    // Compensation may exceed the limits.
    let low = floor(min(view.min_exposure, min(state.exposure, state.target_exposure))) - 0.5;
    let high = ceil(max(view.max_exposure, max(state.exposure, state.target_exposure))) + 0.5;
    let pixels_per_stop = size.x / (high - low);
    let stops = low + position.x / pixels_per_stop;
    let half_width = 0.5 * unit / pixels_per_stop;
    let from_bottom = 1.0 - position.y / size.y;
    if abs(stops - state.exposure) < 2.0 * half_width {
        return WHITE;
    }
    if abs(stops - state.target_exposure) < 2.0 * half_width && from_bottom < 0.7 {
        return GREEN;
    }
    let stop = round(stops);
    let height = select(0.25, 0.5, stop == 0.0);
    if abs(stops - stop) < half_width && from_bottom < height {
        return WHITE;
    }
    return PANEL;
}

/// Returns premultiplied alpha.
@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let size = vec2<f32>(view.viewport_size);
    let pixel = position.xy - vec2<f32>(view.viewport_origin);

    let unit = max(floor(size.y / 360.0), 1.0);
    let scale_size = vec2(0.6 * size.x, 14.0 * unit);
    let scale_origin = floor(vec2(0.2 * size.x, size.y - 30.0 * unit));
    let in_scale = pixel - scale_origin;
    if all(in_scale >= vec2(0.0)) && all(in_scale < scale_size) {
        let color = scale_color(in_scale, scale_size, unit);
        return vec4(color.rgb * color.a, color.a);
    }

#ifdef MASK
    let weight = saturate(textureSampleLevel(mask, mask_sampler, pixel / size, 0.0).r);
#else
    let weight = pattern_weight(pixel, size, view.spot_radius);
#endif
    return vec4(0.0, 0.0, 0.0, (1.0 - UNCOUNTED) * (1.0 - weight));
}
