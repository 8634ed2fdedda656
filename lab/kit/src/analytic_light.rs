//! Scenes with known light, and the errors of what a camera shows of them.

use bevy::{camera::Exposure, light::AmbientLight, prelude::*};
use bevy_lean_deferred::prelude::*;

use crate::{
    hdr::{Light, light, next_light},
    headless::{Headless, Picture},
    lean::build,
    scenes::SceneBuilder,
};

/// Frames after which all bounces have accumulated, but for less than a thousandth.
pub const CONVERGED: usize = 24;

/// A surface of this albedo and emission, without specular reflection.
pub fn surface(albedo: f32, glow: f32) -> StandardMaterial {
    StandardMaterial {
        base_color: Color::linear_rgb(albedo, albedo, albedo),
        emissive: LinearRgba::rgb(glow, glow, glow),
        reflectance: 0.0,
        perceptual_roughness: 1.0,
        ..default()
    }
}

/// A camera under a uniform sky of radiance `sky`, exposed.
pub fn camera(s: &mut SceneBuilder, transform: Transform, sky: f32, extra: impl Bundle) -> Entity {
    let dark = AmbientLight {
        brightness: 0.0,
        ..default()
    };
    let camera = s.camera(transform, (LeanDeferred::default(), dark, extra));
    if sky > 0.0 {
        let mut images = s.world().resource_mut::<Assets<Image>>();
        let mut light = EnvironmentMapLight::solid_color(&mut images, Color::WHITE);
        light.intensity = sky / Exposure::default().exposure();
        s.world().entity_mut(camera).insert(light);
    }
    camera
}

/// A picture of light and the rays of its pixels.
pub struct Seen {
    pub light: Light,
    rays: Vec<Ray3d>,
}

impl Seen {
    /// The view ray of each pixel, row by row.
    pub fn rays(&self) -> &[Ray3d] {
        &self.rays
    }

    /// Each pixel whose ray meets the plane through `point`, the position on the plane, and the pixel's brightness.
    pub fn on_plane(&self, point: Vec3, normal: Vec3) -> impl Iterator<Item = (UVec2, Vec3, f32)> {
        let width = self.light.size.x;
        (0..).zip(&self.rays).filter_map(move |(i, ray)| {
            let plane = InfinitePlane3d::new(normal);
            let distance = ray.intersect_plane(point, plane)?;
            let pixel = UVec2::new(i % width, i / width);
            Some((pixel, ray.get_point(distance), self.at(pixel)))
        })
    }

    /// The same view with other texels.
    pub fn like(&self, texels: Vec<[f32; 4]>) -> Self {
        Self {
            light: Light {
                size: self.light.size,
                texels,
            },
            rays: self.rays.clone(),
        }
    }

    /// The part inside `rect`.
    pub fn within(&self, rect: URect) -> Self {
        let width = self.light.size.x;
        let rows = rect.min.y..rect.max.y;
        let places =
            rows.flat_map(|y| (rect.min.x..rect.max.x).map(move |x| (y * width + x) as usize));
        let (texels, rays) = places.map(|i| (self.light.texels[i], self.rays[i])).unzip();
        let size = rect.size();
        Self {
            light: Light { size, texels },
            rays,
        }
    }

    /// Saves light times `scale`, in gray, to the folder that `LIGHT_PICTURES` names, if set.
    pub fn save(&self, name: &str, scale: f32) {
        let Some(folder) = std::env::var_os("LIGHT_PICTURES") else {
            return;
        };
        let gray = |texel: &[f32; 4]| (texel[1] * scale * 255.0).clamp(0.0, 255.0) as u8;
        let texels = self.light.texels.iter().map(gray);
        let picture = Picture {
            size: self.light.size,
            rgba: texels.flat_map(|gray| [gray, gray, gray, 255]).collect(),
        };
        picture.save(std::path::Path::new(&folder).join(format!("{name}.png")));
    }

    pub fn at(&self, pixel: UVec2) -> f32 {
        self.light.texels[(pixel.y * self.light.size.x + pixel.x) as usize][1]
    }
}

/// Light of the single camera, `frames` frames after it has settled.
pub fn see(headless: &mut Headless, frames: usize) -> Seen {
    headless.settle();
    headless.frames(frames);
    look(headless)
}

/// Light of the single camera in the frame after the next.
pub fn look(headless: &mut Headless) -> Seen {
    let light = light(headless);
    seen(headless, light)
}

/// As [`look`], but in the next frame; needs an earlier [`look`].
pub fn look_at_once(headless: &mut Headless) -> Seen {
    let light = next_light(headless);
    seen(headless, light)
}

/// `light` as seen by the single camera, whose rays are those of the last frame.
pub fn seen(headless: &mut Headless, light: Light) -> Seen {
    let world = headless.world();
    let mut cameras = world.query::<(&Camera, &GlobalTransform)>();
    let (camera, transform) = cameras.single(world).expect("one camera");
    let rays = (0..light.size.element_product())
        .map(|i| {
            let pixel = UVec2::new(i % light.size.x, i / light.size.x);
            let center = pixel.as_vec2() + 0.5;
            camera
                .viewport_to_world(transform, center)
                .expect("the camera has a viewport")
        })
        .collect();
    Seen { light, rays }
}

/// Light at `place`, interpolated between four pixels. `None` outside the picture.
pub fn light_at(headless: &mut Headless, seen: &Seen, place: Vec3) -> Option<f32> {
    let world = headless.world();
    let mut cameras = world.query::<(&Camera, &GlobalTransform)>();
    let (camera, transform) = cameras.single(world).ok()?;
    let at = camera.world_to_viewport(transform, place).ok()? - 0.5;
    let (first, along) = (at.floor(), at.fract());
    if first.cmplt(Vec2::ZERO).any() || (first + 1.0).cmpge(seen.light.size.as_vec2()).any() {
        return None;
    }
    let pixel = |x: f32, y: f32| seen.at((first + Vec2::new(x, y)).as_uvec2());
    let row = |y| pixel(0.0, y).lerp(pixel(1.0, y), along.x);
    Some(row(0.0).lerp(row(1.0), along.y))
}

/// Builds a scene and looks at it after `frames` frames.
pub fn show(size: UVec2, frames: usize, scene: impl FnOnce(&mut SceneBuilder)) -> (Headless, Seen) {
    let mut headless = build(size, scene);
    let seen = see(&mut headless, frames);
    (headless, seen)
}

/// Root mean square and mean of differences.
pub fn errors(differences: impl IntoIterator<Item = f32>) -> (f32, f32) {
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0);
    for difference in differences {
        sum += f64::from(difference);
        squares += f64::from(difference) * f64::from(difference);
        count += 1;
    }
    let count = f64::from(count.max(1));
    ((squares / count).sqrt() as f32, (sum / count) as f32)
}

/// Errors relative to the truth, or absolute ones where the result is a share of a source's light.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    pub rmse: f32,
    pub bias: f32,
}

impl Errors {
    pub fn of(differences: impl IntoIterator<Item = f32>) -> Self {
        let (rmse, bias) = errors(differences);
        Self { rmse, bias }
    }
}

/// Configuration factor from the face of a groove to its other face.
const OF_OTHER_FACE: f32 = 0.5;

/// A groove under a sky of 1, seen from above: two faces of this albedo that meet at the bottom at 90°.
pub fn groove_app(size: UVec2, albedo: f32, effect: impl Bundle) -> Headless {
    build(size, |s| {
        let face = Plane3d::default().mesh().size(40.0, 20.0);
        for side in [-1.0_f32, 1.0] {
            let turned = Quat::from_rotation_x(side * core::f32::consts::FRAC_PI_4);
            let transform = Transform::from_rotation(turned)
                .with_translation(turned * Vec3::new(0.0, 0.0, -10.0 * side));
            s.mesh(face, surface(albedo, 0.0), transform);
        }
        let above = Transform::from_xyz(0.0, 8.0, 0.0).looking_at(Vec3::ZERO, Vec3::NEG_Z);
        camera(s, above, 1.0, effect);
    })
}

/// Light that a groove sends out `frames` frames after a cut, with all bounces without. In the first frame nothing is known of the other
/// face: it has the whole sky's light, ρL. Each later one has the other face's light of the frame before, ρ(1 − F)L + ρF L', which
/// approaches ρL(1 − F) / (1 − ρF).
pub fn groove_light(albedo: f32, frames: Option<i32>) -> f32 {
    let again = albedo * OF_OTHER_FACE;
    let last = albedo * (1.0 - OF_OTHER_FACE) / (1.0 - again);
    let to_come = frames.map_or(0.0, |frames| again.powi(frames));
    last + (albedo - last) * to_come
}

/// Relative errors near the bottom of a groove, where the distance is small beside the extent of the faces in the picture.
pub fn groove_errors(seen: &Seen, truth: f32) -> Errors {
    let size = seen.light.size;
    let (middle, near) = (size.y / 2, 3..=6);
    let pixels = (0..size.y)
        .filter(|y| near.contains(&y.abs_diff(middle)))
        .flat_map(|y| (size.x / 4..3 * size.x / 4).map(move |x| UVec2::new(x, y)));
    Errors::of(pixels.map(|pixel| seen.at(pixel) / truth - 1.0))
}

/// Relative errors of a groove with all bounces.
pub fn groove(size: UVec2, albedo: f32, effect: impl Bundle) -> Errors {
    let mut headless = groove_app(size, albedo, effect);
    let seen = see(&mut headless, CONVERGED);
    let truth = groove_light(albedo, None);
    seen.save("groove", 0.5 / truth);
    groove_errors(&seen, truth)
}

/// Errors of a floor of albedo 0.5 beside an emitter of radiance 1, in shares of πL, where `expected` has a value.
fn beside(
    name: &str,
    size: UVec2,
    scene: impl FnOnce(&mut SceneBuilder),
    expected: impl Fn(Vec3) -> Option<f32>,
) -> Errors {
    let (_, seen) = show(size, 4, scene);
    seen.save(name, 2.0);
    let floor = seen.on_plane(Vec3::ZERO, Vec3::Y);
    Errors::of(floor.filter_map(|(_, place, found)| Some(found / 0.5 - expected(place)?)))
}

/// A floor beside a glowing wall: E = πL · ½(1 − x / √(x² + h²)).
pub fn wall(size: UVec2, effect: impl Bundle) -> Errors {
    let height = 0.3;
    let scene = |s: &mut SceneBuilder| {
        s.mesh(
            Plane3d::default().mesh().size(60.0, 30.0),
            surface(0.5, 0.0),
            Transform::default(),
        );
        s.mesh(
            Cuboid::new(60.0, height, 1.0),
            surface(0.0, 1.0),
            Transform::from_xyz(0.0, height / 2.0, -0.5),
        );
        let from = Transform::from_xyz(0.0, 2.0, 3.5);
        let from = from.looking_at(Vec3::new(0.0, 0.0, 0.2), Vec3::Y);
        camera(s, from, 0.0, effect);
    };
    beside("wall", size, scene, |place| {
        let x = place.z;
        // In screen space the wall ends at the picture's edges.
        let is_floor = (0.03..0.75).contains(&x) && place.x.abs() < 0.5;
        is_floor.then(|| 0.5 * (1.0 - x / x.hypot(height)))
    })
}

/// A floor beside a glowing sphere: E = πL · c r² / D³.
pub fn sphere(size: UVec2, effect: impl Bundle) -> Errors {
    let (radius, height) = (0.5_f32, 0.6_f32);
    let scene = |s: &mut SceneBuilder| {
        s.mesh(
            Plane3d::default().mesh().size(60.0, 60.0),
            surface(0.5, 0.0),
            Transform::default(),
        );
        let ball = Sphere::new(radius).mesh().ico(6).expect("few subdivisions");
        s.mesh(
            ball,
            surface(0.0, 1.0),
            Transform::from_xyz(0.0, height, 0.0),
        );
        let from = Transform::from_xyz(0.0, 3.0, 4.0);
        let from = from.looking_at(Vec3::new(0.0, 0.3, 0.0), Vec3::Y);
        camera(s, from, 0.0, effect);
    };
    beside("sphere", size, scene, |place| {
        let squared = place.x * place.x + place.z * place.z;
        let distance = (squared + height * height).sqrt();
        // Skips floor that the ball hides from the camera, and floor beneath it.
        let is_seen = place.z > 0.0 && (radius..2.0).contains(&squared.sqrt());
        is_seen.then(|| height * radius * radius / distance.powi(3))
    })
}
