// Motion vectors, packed as two half floats.
//
// x low, y high, as in `pack2x16float`.
#define_import_path bevy_lean_deferred::gbuffer::layout::motion

#import bevy_lean_deferred::gbuffer::layout::is_nan

/// Largest half float. Longer motions are clamped.
const LARGEST_MOTION: f32 = 65504.0;

/// Motion across the picture, in UV units, from one clip-space position to another, as in Bevy's `prepass.wgsl`.
fn motion_between(clip: vec4<f32>, previous_clip: vec4<f32>) -> vec2<f32> {
    return (clip.xy / clip.w - previous_clip.xy / previous_clip.w) * vec2(0.5, -0.5);
}

/// Packs a motion in UV units. NaN components become 0.
fn pack_motion(motion: vec2<f32>) -> u32 {
    let number = select(motion, vec2(0.0), vec2(is_nan(motion.x), is_nan(motion.y)));
    return pack2x16float(clamp(number, vec2(-LARGEST_MOTION), vec2(LARGEST_MOTION)));
}

/// Unpacks a motion.
fn unpack_motion(word: u32) -> vec2<f32> {
    return unpack2x16float(word);
}
