// Which texels of a picture look where, so that neighbours together see everything.
#define_import_path bevy_lean_deferred::pattern

/// Which of the 4×4 texels of the pattern has which of sixteen turns: neighbours rather different ones (Bayer 1973, "An
/// optimum method for two-level rendition of continuous-tone pictures").
fn turn_of(place: vec2<u32>) -> u32 {
    let x = place.x ^ place.y;
    return ((x & 1u) << 3u) | ((place.y & 1u) << 2u) | (x & 2u) | ((place.y & 2u) >> 1u);
}
