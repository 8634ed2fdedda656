// Lattices of pixels whose depths are stored densely, so that distant samples of neighbouring pixels share cache lines. There are four:
// for pixels with even or odd x, and even or odd y. Each has one pixel of every 4×4, and its point mirror about a pixel that samples it
// is the lattice itself: of two opposite samples, both are on it or none.
#define_import_path bevy_lean_deferred::effects::ambient_occlusion::lattice

/// Pixels from one pixel of a lattice to the next, along each axis.
const SPACING: i32 = 4;

/// First pixel of a lattice. Of the four lattices, one has each column and one each row, so that none of a scene's thin parts is in no
/// lattice.
fn first_of_lattice(parity: vec2<i32>) -> vec2<i32> {
    return parity + 2 * vec2(parity.x ^ parity.y, parity.x);
}

/// Texel of the first pixel of a lattice. The four are beside each other.
fn corner_of_lattice(parity: vec2<i32>, view_size: vec2<i32>) -> vec2<i32> {
    return parity * ((view_size + SPACING - 1) / SPACING);
}
