//! One JPEG file of several pictures: off and on, ours and others.

use std::path::Path;

use image::{
    GenericImage, Rgb, RgbImage,
    codecs::jpeg::JpegEncoder,
    imageops::{FilterType, crop_imm, resize},
};

/// Width of the line between two pictures.
const LINE: u32 = 2;
/// Qualities of JPEG files, until one is small enough. With the first, no artefacts are seen at 100 %.
const QUALITIES: [u8; 6] = [90, 85, 80, 70, 60, 50];

/// The arrangement of the pictures, and the size of the file.
#[derive(Clone, Copy, Default)]
pub struct Layout {
    /// Whole pictures side by side. Otherwise a vertical strip of each, which stays where it is in its own picture.
    pub beside: bool,
    /// The part of each picture that is taken: left, top, width and height in percent of the picture.
    pub crop: Option<[u32; 4]>,
    /// Width in pixels to which the result is shrunk.
    pub width: Option<u32>,
    /// Most kilobytes of the file.
    pub kilobytes: Option<usize>,
}

/// Writes a JPEG file with all pictures, from left to right.
pub fn write(pictures: &[impl AsRef<Path>], path: &Path, layout: Layout) -> Result<(), String> {
    let pictures = pictures
        .iter()
        .map(|path| crop(read(path.as_ref())?, layout.crop))
        .collect::<Result<Vec<_>, _>>()?;
    let joined = match layout.beside {
        true => beside(&pictures)?,
        false => wipe(&pictures)?,
    };
    let file = encode(&shrink(joined, layout.width), layout.kilobytes);
    let file = file.map_err(|error| format!("{}: {error}", path.display()))?;
    std::fs::write(path, file).map_err(|error| format!("{}: {error}", path.display()))
}

/// Encodes with the best quality that is small enough.
fn encode(picture: &RgbImage, kilobytes: Option<usize>) -> Result<Vec<u8>, String> {
    let limit = kilobytes.map_or(usize::MAX, |kilobytes| 1000 * kilobytes);
    for quality in QUALITIES {
        let mut file = Vec::new();
        JpegEncoder::new_with_quality(&mut file, quality)
            .encode_image(picture)
            .map_err(|error| error.to_string())?;
        if file.len() <= limit {
            return Ok(file);
        }
    }
    Err(format!("larger than {limit} bytes at the lowest quality"))
}

fn shrink(picture: RgbImage, width: Option<u32>) -> RgbImage {
    match width {
        Some(width) if width < picture.width() => {
            let height = (picture.height() * width).div_ceil(picture.width());
            resize(&picture, width, height, FilterType::Triangle)
        }
        _ => picture,
    }
}

fn read(path: &Path) -> Result<RgbImage, String> {
    let picture = image::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(picture.into_rgb8())
}

fn crop(picture: RgbImage, part: Option<[u32; 4]>) -> Result<RgbImage, String> {
    let Some([left, top, width, height]) = part else {
        return Ok(picture);
    };
    if left + width > 100 || top + height > 100 {
        return Err("the part is not within the picture".into());
    }
    let [x, width] = [left, width].map(|percent| picture.width() * percent / 100);
    let [y, height] = [top, height].map(|percent| picture.height() * percent / 100);
    Ok(crop_imm(&picture, x, y, width, height).to_image())
}

/// The size of all pictures.
fn size(pictures: &[RgbImage]) -> Result<(u32, u32), String> {
    let sizes = pictures.iter().map(RgbImage::dimensions);
    let mut sizes = sizes.collect::<Vec<_>>();
    sizes.dedup();
    match sizes[..] {
        [] => Err("no pictures".into()),
        [size] => Ok(size),
        _ => Err("the pictures differ in size".into()),
    }
}

fn wipe(pictures: &[RgbImage]) -> Result<RgbImage, String> {
    let (width, height) = size(pictures)?;
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

fn beside(pictures: &[RgbImage]) -> Result<RgbImage, String> {
    let (width, height) = size(pictures)?;
    let number = pictures.len() as u32;
    let all = number * width + (number - 1) * LINE;
    let mut joined = RgbImage::from_pixel(all, height, Rgb([255; 3]));
    for (index, picture) in (0..).zip(pictures) {
        let copied = joined.copy_from(picture, index * (width + LINE), 0);
        copied.map_err(|error| error.to_string())?;
    }
    Ok(joined)
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
        assert!(beside(&[]).is_err());
    }

    #[test]
    fn whole_pictures_are_side_by_side() {
        let joined = beside(&[plain((2, 1), 1), plain((2, 1), 2)]).expect("they fit");
        let row: Vec<u8> = joined.pixels().map(|pixel| pixel[0]).collect();
        assert_eq!(row, [1, 1, 255, 255, 2, 2]);
        assert_eq!(shrink(joined, Some(3)).dimensions(), (3, 1));
    }

    #[test]
    fn parts_are_in_percent() {
        let picture = RgbImage::from_fn(10, 20, |x, y| Rgb([x as u8, y as u8, 0]));
        let part = crop(picture.clone(), Some([50, 50, 30, 20])).expect("it is within");
        assert_eq!(part.dimensions(), (3, 4));
        assert_eq!(part.get_pixel(0, 0), &Rgb([5, 10, 0]));
        assert!(crop(picture, Some([50, 50, 51, 20])).is_err());
    }

    #[test]
    fn files_are_small_enough() {
        let noise = RgbImage::from_fn(64, 64, |x, y| Rgb([(x * 37 + y * 101) as u8; 3]));
        let largest = encode(&noise, None).expect("no limit").len();
        assert!(largest > 3000);
        assert!(encode(&noise, Some(3)).expect("a lower quality").len() <= 3000);
        assert!(encode(&noise, Some(0)).is_err());
    }
}
