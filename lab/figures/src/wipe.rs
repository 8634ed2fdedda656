//! One picture of strips of several: off and on, ours and others.

use std::path::Path;

use image::{Rgb, RgbImage, codecs::jpeg::JpegEncoder};

/// Width of the line between two strips.
const LINE: u32 = 2;
/// Quality of JPEG files: no artefacts are seen at 100 %.
const QUALITY: u8 = 90;

/// Writes a JPEG file with a vertical strip of each picture, from left to right, each where it is in its own picture.
pub fn write(pictures: &[impl AsRef<Path>], path: &Path) -> Result<(), String> {
    let pictures = pictures
        .iter()
        .map(|path| read(path.as_ref()))
        .collect::<Result<Vec<_>, _>>()?;
    let wiped = wipe(&pictures)?;
    let says = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let file = std::fs::File::create(path).map_err(|error| says(&error))?;
    JpegEncoder::new_with_quality(std::io::BufWriter::new(file), QUALITY)
        .encode_image(&wiped)
        .map_err(|error| says(&error))
}

fn read(path: &Path) -> Result<RgbImage, String> {
    let picture = image::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(picture.into_rgb8())
}

fn wipe(pictures: &[RgbImage]) -> Result<RgbImage, String> {
    let Some((first, others)) = pictures.split_first() else {
        return Err("no pictures".into());
    };
    let (width, height) = first.dimensions();
    if others
        .iter()
        .any(|other| other.dimensions() != (width, height))
    {
        return Err("the pictures differ in size".into());
    }
    let strips = pictures.len() as u32;
    Ok(RgbImage::from_fn(width, height, |x, y| {
        let strip = x * strips / width;
        let begins = (strip * width).div_ceil(strips);
        match strip > 0 && x < begins + LINE {
            true => Rgb([255; 3]),
            false => *pictures[strip as usize].get_pixel(x, y),
        }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(size: (u32, u32), value: u8) -> RgbImage {
        RgbImage::from_pixel(size.0, size.1, Rgb([value; 3]))
    }

    #[test]
    fn strips_are_where_they_were() {
        let wiped = wipe(&[plain((10, 2), 1), plain((10, 2), 2), plain((10, 2), 3)]);
        let row: Vec<u8> = (0..10)
            .map(|x| wiped.as_ref().expect("they fit").get_pixel(x, 1)[0])
            .collect();
        assert_eq!(row, [1, 1, 1, 1, 255, 255, 2, 255, 255, 3]);
    }

    #[test]
    fn pictures_have_one_size() {
        assert!(wipe(&[plain((10, 2), 1), plain((9, 2), 2)]).is_err());
        assert!(wipe(&[]).is_err());
    }
}
