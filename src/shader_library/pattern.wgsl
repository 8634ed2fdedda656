// Distributes directions over neighbouring texels, which together cover all of them.
#define_import_path bevy_lean_deferred::pattern

/// Index of a texel's rotation in the 4×4 pattern, 0 to 15. Neighbours have clearly different ones (Bayer 1973, "An optimum
/// method for two-level rendition of continuous-tone pictures").
fn rotation_index(place: vec2<u32>) -> u32 {
    let x = place.x ^ place.y;
    return ((x & 1u) << 3u) | ((place.y & 1u) << 2u) | (x & 2u) | ((place.y & 2u) >> 1u);
}
