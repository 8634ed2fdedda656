// Overlay on the tonemapped picture: darkens pixels that count less, and shows the exposure on a scale.
//
// The scale has a line per stop, a long one at 0, a white mark at the exposure and a green one at its target. The exposure in
// stops is printed above it.
#import bevy_lean_deferred::auto_exposure::bindings::{state, view}
#import bevy_lean_deferred::auto_exposure::pattern::pattern_weight

#ifdef MASK
#import bevy_lean_deferred::auto_exposure::bindings::{mask, mask_sampler}
#endif

/// Brightness of pixels that do not count.
const UNCOUNTED: f32 = 0.35;
const WHITE: vec4<f32> = vec4(1.0);
const GREEN: vec4<f32> = vec4(0.1, 0.9, 0.2, 1.0);
const PANEL: vec4<f32> = vec4(0.0, 0.0, 0.0, 0.85);

/// Glyphs of 3×5 dots: 0 to 9, minus, plus, point. The lowest bit is top left.
const GLYPHS = array<u32, 13>(
    0x7b6fu, 0x749au, 0x73e7u, 0x79e7u, 0x49edu, 0x79cfu, 0x7bcfu, 0x4927u, 0x7befu, 0x79efu,
    0x01c0u, 0x05d0u, 0x2000u,
);
const MINUS: u32 = 10u;
const PLUS: u32 = 11u;
const POINT: u32 = 12u;

/// True if `dot`, in a row of glyphs 4 dots wide, belongs to the number `stops` with its sign and one decimal.
fn is_of_number(dot: vec2<i32>, stops: f32) -> bool {
    if any(dot < vec2(0)) || any(dot >= vec2(20, 5)) || dot.x % 4 == 3 {
        return false;
    }
    let tenths = u32(clamp(round(10.0 * abs(stops)), 0.0, 999.0));
    var glyph = 0u;
    switch dot.x / 4 {
        case 0: { glyph = select(PLUS, MINUS, stops < 0.0); }
        case 1: {
            if tenths < 100u {
                return false;
            }
            glyph = tenths / 100u;
        }
        case 2: { glyph = (tenths / 10u) % 10u; }
        case 3: { glyph = POINT; }
        default: { glyph = tenths % 10u; }
    }
    let bit = u32(dot.y * 3 + dot.x % 4);
    return ((GLYPHS[glyph] >> bit) & 1u) == 1u;
}

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
    let dot = vec2<i32>(floor((in_scale + vec2(-2.0, 14.0) * unit) / (2.0 * unit)));
    if is_of_number(dot, state.exposure) {
        return WHITE;
    }
    if all(dot >= vec2(-1)) && all(dot < vec2(20, 7)) {
        return PANEL;
    }

#ifdef MASK
    let weight = saturate(textureSampleLevel(mask, mask_sampler, pixel / size, 0.0).r);
#else
    let weight = pattern_weight(pixel, size, view.spot_radius);
#endif
    return vec4(0.0, 0.0, 0.0, (1.0 - UNCOUNTED) * (1.0 - weight));
}
