//! Pictures side by side, with differences.

use std::{fmt::Write, io::Cursor, path::Path};

use base64::{Engine, prelude::BASE64_STANDARD};
use image::{ImageFormat, Rgb, RgbImage, imageops::FilterType};

use super::escape;

/// Largest width of a picture.
const WIDTH: u32 = 640;
/// A reference picture, and those that are compared with it.
struct Group {
    title: String,
    reference: String,
    others: Vec<String>,
    /// The differences are errors; otherwise they show an effect.
    errors: bool,
    /// Factor that makes differences visible.
    gain: u8,
}

/// The section of the pictures that a bench has written into `folder`.
pub fn section(bench: &str, folder: &Path) -> Result<String, String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .map_err(|error| format!("{}: {error}", folder.display()))?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| Some(name.strip_suffix(".png")?.to_owned()))
        .collect();
    names.sort();
    let groups = groups(bench, &names);
    if groups.is_empty() {
        return Ok(String::new());
    }
    let mut html = String::from("<details open><summary>Pictures</summary>\n");
    for group in groups {
        let _ = writeln!(
            html,
            "<h3>{}</h3>\n<div class=pictures>",
            escape(&group.title)
        );
        let reference = read(folder, &group.reference)?;
        html.push_str(&figure(&group.reference, &reference)?);
        for other in &group.others {
            let picture = read(folder, other)?;
            html.push_str(&figure(other, &picture)?);
            if let Some(difference) = difference(&reference, &picture, group.gain) {
                let what = if group.errors {
                    "difference from"
                } else {
                    "what it changes of"
                };
                let caption = format!("{other}: {what} {}, × {}", group.reference, group.gain);
                html.push_str(&figure(&caption, &difference)?);
            }
        }
        html.push_str("</div>\n");
    }
    html.push_str("</details>\n");
    Ok(html)
}

/// Groups of the pictures to compare, by the file names of the bench.
fn groups(bench: &str, names: &[String]) -> Vec<Group> {
    // The reference's name within the file's, and the others that a page has room for.
    let (reference, errors, gain, shown): (&str, bool, u8, &[&str]) = match bench {
        "frame_times" | "levels" | "many_meshes" => {
            ("Bevy_forward", true, 16, &["Bevy_deferred", "lean"])
        }
        "light_scaling" => ("Bevy_forward", true, 16, &["Bevy_deferred", "lean"]),
        "ambient_occlusion" => (
            "Ultra__indirect",
            true,
            2,
            &[
                "Medium__indirect",
                "HDAO__indirect",
                "naive",
                "Bevy_Medium",
                "Bevy_Ultra",
            ],
        ),
        "screen_space" => (
            "none",
            false,
            4,
            &[
                "GI__Medium__Half",
                "reflections__Medium__Half",
                "Bevy's_reflections",
                "scattering__High__All",
            ],
        ),
        _ => return Vec::new(),
    };
    let mut groups = Vec::new();
    for name in names {
        let Some((before, after)) = name.split_once(reference) else {
            continue;
        };
        let is_shown = |other: &&String| {
            let middle = other
                .strip_prefix(before)
                .and_then(|rest| rest.strip_suffix(after));
            middle.is_some_and(|middle| shown.contains(&middle))
        };
        let others: Vec<String> = names.iter().filter(is_shown).cloned().collect();
        let title = format!("{before} {after}")
            .replace('_', " ")
            .trim()
            .to_owned();
        if !others.is_empty() {
            let reference = name.clone();
            groups.push(Group {
                title,
                reference,
                others,
                errors,
                gain,
            });
        }
    }
    // Of many groups only some are shown, from few lights to many.
    let step = groups.len().div_ceil(MOST_GROUPS).max(1);
    groups.into_iter().step_by(step).collect()
}

const MOST_GROUPS: usize = 12;

fn read(folder: &Path, name: &str) -> Result<RgbImage, String> {
    let path = folder.join(format!("{name}.png"));
    let picture = image::open(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(picture.to_rgb8())
}

/// Difference at the pictures' size; `None` if their sizes differ.
fn difference(a: &RgbImage, b: &RgbImage, gain: u8) -> Option<RgbImage> {
    if a.dimensions() != b.dimensions() {
        return None;
    }
    let pixels = a.pixels().zip(b.pixels());
    let pixels = pixels.flat_map(|(Rgb(a), Rgb(b))| {
        core::array::from_fn::<u8, 3, _>(|c| a[c].abs_diff(b[c]).saturating_mul(gain))
    });
    RgbImage::from_vec(a.width(), a.height(), pixels.collect())
}

fn figure(name: &str, picture: &RgbImage) -> Result<String, String> {
    let (width, height) = picture.dimensions();
    let small = match width > WIDTH {
        true => {
            let height = (u64::from(height) * u64::from(WIDTH) / u64::from(width)).max(1) as u32;
            image::imageops::resize(picture, WIDTH, height, FilterType::Triangle)
        }
        false => picture.clone(),
    };
    let mut png = Cursor::new(Vec::new());
    small
        .write_to(&mut png, ImageFormat::Png)
        .map_err(|error| format!("{name}: {error}"))?;
    let data = BASE64_STANDARD.encode(png.into_inner());
    let caption = escape(&name.replace('_', " "));
    Ok(format!(
        "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}</figcaption></figure>\n"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_one_scene_stand_together() {
        let names = [
            "a_Bevy_forward",
            "a_lean",
            "a_lean_culling_by_subgroups",
            "b_Bevy_deferred",
            "b_Bevy_forward",
            "c_lean",
        ];
        let groups = groups("frame_times", &names.map(String::from));
        let found: Vec<_> = groups
            .iter()
            .map(|g| (&g.reference[..], &g.others[..]))
            .collect();
        let [a, b] = [["a_lean".to_owned()], ["b_Bevy_deferred".to_owned()]];
        assert_eq!(
            found,
            [("a_Bevy_forward", &a[..]), ("b_Bevy_forward", &b[..])]
        );
    }

    #[test]
    fn differences_are_made_visible() {
        let picture = |value| RgbImage::from_pixel(2, 1, Rgb([value, 10, 200]));
        let difference = difference(&picture(7), &picture(9), 16).unwrap();
        assert_eq!(difference.get_pixel(1, 0), &Rgb([32, 0, 0]));
    }
}
