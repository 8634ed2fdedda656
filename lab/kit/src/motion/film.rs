//! Films, and their differences from the truth.

use bevy::prelude::*;

use crate::{analytic_light::errors, hdr::Light, headless::Picture};

/// A picture as it is shown: light x of a channel as x / (1 + x), sRGB-encoded, 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    pub size: UVec2,
    pub texels: Vec<[f32; 3]>,
}

impl Shown {
    pub fn of(light: &Light) -> Self {
        let shown = |x: f32| Srgba::gamma_function_inverse(x.max(0.0) / (1.0 + x.max(0.0)));
        let texels = light.texels.iter();
        Self {
            size: light.size,
            texels: texels.map(|[r, g, b, _]| [*r, *g, *b].map(shown)).collect(),
        }
    }

    pub fn picture(&self) -> Picture {
        let bytes = |[r, g, b]: &[f32; 3]| {
            [*r, *g, *b, 1.0].map(|x| (x * 255.0).round().clamp(0.0, 255.0) as u8)
        };
        Picture {
            size: self.size,
            rgba: self.texels.iter().flat_map(bytes).collect(),
        }
    }

    /// Differences from `other`, four times as large, about a gray of 0.5.
    pub fn difference(&self, other: &Self) -> Self {
        let pairs = self.texels.iter().zip(&other.texels);
        let off = |(own, other): (&[f32; 3], &[f32; 3])| {
            (Vec3::from_array(*own) - Vec3::from_array(*other)) * 4.0 + 0.5
        };
        Self {
            size: self.size,
            texels: pairs.map(|pair| off(pair).to_array()).collect(),
        }
    }

    /// All channels of all pixels.
    fn values(&self) -> &[f32] {
        self.texels.as_flattened()
    }
}

/// Root mean square of the difference.
pub fn rmse(some: &Shown, other: &Shown) -> f32 {
    let pairs = some.values().iter().zip(other.values());
    errors(pairs.map(|(some, other)| some - other)).0
}

/// A frame of a film.
#[derive(Clone, Copy)]
pub struct Shot<'a> {
    pub picture: &'a Shown,
    /// The same camera at rest in the pose of this frame.
    pub rest: &'a Shown,
    /// The converged effect at rest in this pose.
    pub truth: &'a Shown,
}

impl Shot<'_> {
    /// Differences of the picture from the truth.
    fn off(&self) -> impl Iterator<Item = f32> {
        let pairs = self.picture.values().iter().zip(self.truth.values());
        pairs.map(|(picture, truth)| picture - truth)
    }
}

/// Root mean square of what pictures change from shot to shot beyond the changes of the truth.
pub fn flicker(shots: &[Shot]) -> f32 {
    let changes = shots.windows(2).flat_map(|pair| {
        let pairs = pair[1].off().zip(pair[0].off());
        pairs.map(|(now, before)| now - before)
    });
    errors(changes).0
}

/// Longest trail that is measured, in shots.
const LONGEST: usize = 16;
/// Change of the truth that counts as one.
const CHANGED: f32 = 0.05;
/// Share of a change that counts as visible.
const VISIBLE: f64 = 0.1;
/// Fewest values of which a share is taken.
const FEWEST: usize = 64;

/// Values whose truth last changed the same number of shots ago.
#[derive(Clone, Copy, Default)]
struct Age {
    /// Light that pictures still have of before the change, as products with the change.
    kept: f64,
    changed: f64,
    count: usize,
}

/// Length of trails in shots: the longest time after a change of the truth at which pictures still differ from the camera at rest by a
/// tenth of the change. At most 16.
pub fn trail(shots: &[Shot]) -> usize {
    let mut ages = [Age::default(); LONGEST];
    for (number, shot) in shots.iter().enumerate() {
        let before = shots[..number].iter().rev().take(LONGEST);
        for (value, now) in shot.truth.values().iter().enumerate() {
            let changes = before.clone().map(|shot| shot.truth.values()[value] - now);
            let mut changes = ages.iter_mut().zip(changes);
            let last = changes.find(|(_, change)| change.abs() > CHANGED);
            if let Some((age, change)) = last {
                let kept = shot.picture.values()[value] - shot.rest.values()[value];
                age.kept += f64::from(change * kept);
                age.changed += f64::from(change * change);
                age.count += 1;
            }
        }
    }
    let is_visible = |age: &Age| age.count >= FEWEST && age.kept > VISIBLE * age.changed;
    ages.iter().rposition(is_visible).map_or(0, |age| age + 1)
}

/// Pictures after a switch, the first of them with the switch, until they show nine tenths of the change from `before` to `after`; all of
/// them if none does. Leaves out pixels of `source`.
pub fn lag(pictures: &[Shown], before: &Shown, after: &Shown, source: &[bool]) -> usize {
    let share = |picture: &Shown| {
        let states = before.texels.iter().zip(&after.texels);
        let texels = picture.texels.iter().zip(states).zip(source);
        let (mut reached, mut all) = (0.0, 0.0);
        for ((now, (before, after)), is_source) in texels {
            if !is_source {
                let before = Vec3::from_array(*before);
                let change = Vec3::from_array(*after) - before;
                reached += (Vec3::from_array(*now) - before).dot(change);
                all += change.length_squared();
            }
        }
        reached / all
    };
    let first = pictures.iter().position(|picture| share(picture) >= 0.9);
    first.unwrap_or(pictures.len())
}

/// Pictures of one size in rows.
pub fn strip(rows: &[Vec<Picture>]) -> Picture {
    let size = rows[0][0].size;
    let bytes = size.x as usize * 4;
    let lines = rows.iter().flat_map(|row| {
        let lines = (0..size.y as usize).map(move |y| y * bytes..(y + 1) * bytes);
        lines.flat_map(move |line| {
            row.iter()
                .flat_map(move |picture| &picture.rgba[line.clone()])
        })
    });
    Picture {
        size: size * UVec2::new(rows[0].len() as u32, rows.len() as u32),
        rgba: lines.copied().collect(),
    }
}
