//! What pixels mirror, in a texture of words: light, and the confidence with which it takes the place of the environment.
//!
//! A block of 16×16 pixels has 16 columns and 20 rows: 16 rows of light, a word for each pixel ([`light`](super::light)), and below
//! them four of confidences, a word for each 2×2 pixels, eight bits for one. So each pixel takes five bytes. Where confidence is 0 light
//! may be anything.

use bevy::math::{UVec2, Vec4, Vec4Swizzles};

use super::light::pack_light;

/// Pixels a side of a block.
pub const BLOCK: u32 = 16;
/// Rows that a block has more than it has of pixels.
pub const CONFIDENCE_ROWS: u32 = 4;

const BLOCK_IN_TEXTURE: UVec2 = UVec2::new(BLOCK, BLOCK + CONFIDENCE_ROWS);

/// Of the texture for so many pixels.
pub fn texture_size(viewport_size: UVec2) -> UVec2 {
    viewport_size.map(|side| side.div_ceil(BLOCK)) * BLOCK_IN_TEXTURE
}

/// Where the light of a pixel is.
pub fn light_place(pixel: UVec2) -> UVec2 {
    pixel + UVec2::new(0, pixel.y / BLOCK * CONFIDENCE_ROWS)
}

/// Where the confidences of the 2×2 pixels are of which `pixel` is one.
pub fn confidence_place(pixel: UVec2) -> UVec2 {
    let square = pixel % BLOCK / 2;
    let place = UVec2::new(square.x + 8 * (square.y & 1), BLOCK + (square.y >> 1));
    pixel / BLOCK * BLOCK_IN_TEXTURE + place
}

/// Which of the 2×2 pixels `pixel` is.
pub fn place_in_square(pixel: UVec2) -> u32 {
    (pixel.x & 1) + 2 * (pixel.y & 1)
}

/// The confidence of `specular`, 0 to 1; 0 if the sum of its channels is no number.
pub fn confidence_of(specular: Vec4) -> f32 {
    if specular.element_sum().is_nan() {
        0.0
    } else {
        specular.w.clamp(0.0, 1.0)
    }
}

/// The words of a texture for so many pixels, row by row.
pub fn pack_specular(viewport_size: UVec2, specular: impl Fn(UVec2) -> Vec4) -> Vec<u32> {
    let size = texture_size(viewport_size);
    let mut words = vec![0; size.element_product() as usize];
    let index = |place: UVec2| (place.x + size.x * place.y) as usize;
    for y in 0..viewport_size.y {
        for x in 0..viewport_size.x {
            let pixel = UVec2::new(x, y);
            let specular = specular(pixel);
            words[index(light_place(pixel))] = pack_light(specular.xyz());
            let confidence = (confidence_of(specular) * 255.0 + 0.5) as u32;
            words[index(confidence_place(pixel))] |= confidence << (8 * place_in_square(pixel));
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    #[test]
    fn pixels_share_nothing_but_the_confidences_of_squares() {
        for viewport_size in [(1, 1), (7, 33), (48, 32), (61, 95)].map(UVec2::from) {
            let size = texture_size(viewport_size);
            let mut users = HashMap::<UVec2, Vec<UVec2>>::new();
            for y in 0..viewport_size.y {
                for x in 0..viewport_size.x {
                    let pixel = UVec2::new(x, y);
                    for place in [light_place(pixel), confidence_place(pixel)] {
                        assert!(place.cmplt(size).all(), "{pixel} is at {place} of {size}");
                        users.entry(place).or_default().push(pixel);
                    }
                }
            }
            for pixels in users.values() {
                let squares = pixels.iter().map(|pixel| *pixel / 2);
                assert!(squares.clone().eq(squares.map(|_| pixels[0] / 2)));
                let mut places: Vec<u32> = pixels.iter().map(|p| place_in_square(*p)).collect();
                places.sort_unstable();
                places.dedup();
                assert_eq!(places.len(), pixels.len());
            }
        }
    }
}
