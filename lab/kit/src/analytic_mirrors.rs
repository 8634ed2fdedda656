//! Scenes with known reflections, and the errors of what a camera shows of them.

use core::f32::consts::{FRAC_PI_2, PI, TAU};

use bevy::{
    asset::RenderAssetUsages,
    pbr::{DefaultOpaqueRendererMethod, ScreenSpaceReflections},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_lean_deferred::prelude::*;
use half::f16;

use crate::{
    analytic_light::{Errors, Seen, camera, look, see, surface},
    headless::Headless,
    lean::build,
    reference::shader_library::ggx::sample_lobe,
    scenes::SceneBuilder,
};

/// A white metal.
pub fn metal(perceptual_roughness: f32) -> StandardMaterial {
    StandardMaterial {
        base_color: Color::WHITE,
        metallic: 1.0,
        perceptual_roughness,
        ..default()
    }
}

/// Emitters of the mirror scene.
const WALL_Z: f32 = -1.5;
const WALL: Vec2 = Vec2::new(3.0, 1.6);
const BALL: (Vec3, f32) = (Vec3::new(-0.7, 0.55, 0.0), 0.4);
const BOX: (Vec3, Vec3) = (Vec3::new(0.8, 0.5, -0.3), Vec3::new(0.3, 0.5, 0.3));

/// Smooth emission of the wall; `at` is 0 to 1 from its lower left corner.
fn pattern(at: Vec2) -> f32 {
    0.5 + 0.4 * (TAU * 4.0 * at.x).sin() * (TAU * 2.0 * at.y).sin()
}

/// A ray hit.
#[derive(Clone, Copy)]
struct Met {
    distance: f32,
    light: f32,
    normal: Vec3,
}

/// The ray's nearest hit above the mirror.
fn meet(ray: Ray3d) -> Option<Met> {
    let mut nearest: Option<Met> = None;
    let mut offer = |distance: f32, light: f32, normal: Vec3| {
        if distance > 1e-4 && nearest.is_none_or(|other| distance < other.distance) {
            nearest = Some(Met {
                distance,
                light,
                normal,
            });
        }
    };
    let distance = (WALL_Z - ray.origin.z) / ray.direction.z;
    let at = ray.get_point(distance).xy() / WALL + Vec2::new(0.5, 0.0);
    if at.cmpge(Vec2::ZERO).all() && at.cmple(Vec2::ONE).all() && ray.direction.z < 0.0 {
        offer(distance, pattern(at), Vec3::Z);
    }
    let from = ray.origin - BALL.0;
    let half = from.dot(*ray.direction);
    let under = half * half - from.length_squared() + BALL.1 * BALL.1;
    if under > 0.0 {
        let distance = -half - under.sqrt();
        offer(distance, 0.8, (ray.get_point(distance) - BALL.0) / BALL.1);
    }
    let inverse = 1.0 / *ray.direction;
    let sides = [BOX.0 - BOX.1, BOX.0 + BOX.1].map(|corner| (corner - ray.origin) * inverse);
    let nearer = sides[0].min(sides[1]);
    let first = nearer.max_element();
    let last = sides[0].max(sides[1]).min_element();
    if first < last {
        let side = Vec3::from_array(nearer.to_array().map(|x| f32::from(x == first)));
        offer(first, 0.3, -side * ray.direction.signum());
    }
    nearest
}

/// A flat mirror's picture of a wall, a ball and a box.
pub struct MirrorSeen {
    pub seen: Seen,
    /// Errors of pixels whose reflected ray hits something in the picture; those of `inside` leave out outlines.
    pub everywhere: Errors,
    pub inside: Errors,
    /// Share of mirror pixels whose reflected ray hits something in the picture.
    pub share: f32,
}

impl Errors {
    /// PSNR of light from 0 to 1, in dB.
    pub fn psnr(self) -> f32 {
        -20.0 * self.rmse.log10()
    }
}

/// An app of the mirror scene, with `dress` applied to the camera.
pub fn mirror_app(
    size: UVec2,
    roughness: f32,
    dress: impl FnOnce(&mut EntityWorldMut),
) -> Headless {
    mirror_app_of(size, metal(roughness), dress)
}

/// The same with another mirror. Nothing is behind it.
pub fn mirror_app_of(
    size: UVec2,
    mirror_material: StandardMaterial,
    dress: impl FnOnce(&mut EntityWorldMut),
) -> Headless {
    build(size, |s| {
        let wall = image(s);
        let wall = StandardMaterial {
            emissive_texture: Some(wall),
            ..surface(0.0, 1.0)
        };
        let middle = Vec3::new(0.0, WALL.y / 2.0, WALL_Z);
        s.mesh(
            Rectangle::from_size(WALL),
            wall,
            Transform::from_translation(middle),
        );
        let ball = Sphere::new(BALL.1)
            .mesh()
            .ico(30)
            .expect("few subdivisions");
        s.mesh(ball, surface(0.0, 0.8), Transform::from_translation(BALL.0));
        let sides = BOX.1 * 2.0;
        s.mesh(
            Cuboid::from_size(sides),
            surface(0.0, 0.3),
            Transform::from_translation(BOX.0),
        );
        let mirror = Plane3d::default().mesh().size(8.0, 8.0);
        s.mesh(mirror, mirror_material, Transform::default());
        let from = Transform::from_xyz(0.0, 1.1, 3.2);
        let from = from.looking_at(Vec3::new(0.0, 0.35, 0.0), Vec3::Y);
        let entity = camera(s, from, 0.0, ());
        dress(&mut s.world().entity_mut(entity));
    })
}

/// The wall's pattern as an upright image.
fn image(s: &mut SceneBuilder) -> Handle<Image> {
    let side = 512;
    let texels = (0..side * side).flat_map(|i| {
        let at = Vec2::new((i % side) as f32 + 0.5, (side - 1 - i / side) as f32 + 0.5);
        let light = f16::from_f32(pattern(at / side as f32));
        [light, light, light, f16::ONE].map(f16::to_le_bytes)
    });
    let size = Extent3d {
        width: side,
        height: side,
        depth_or_array_layers: 1,
    };
    let image = Image::new(
        size,
        TextureDimension::D2,
        texels.flatten().collect(),
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    s.world().resource_mut::<Assets<Image>>().add(image)
}

/// Renders a mirror beneath a wall, a ball and a box, and compares it with the truth.
pub fn mirror(size: UVec2, dress: impl FnOnce(&mut EntityWorldMut)) -> MirrorSeen {
    let mut headless = mirror_app(size, 0.0, dress);
    headless.settle();
    headless.frames(6);
    show_mirror(&mut headless)
}

/// Renders the mirror of an app and compares it with the truth.
pub fn show_mirror(headless: &mut Headless) -> MirrorSeen {
    let seen = look(headless);
    compare(headless, seen)
}

/// Compares the last picture of an app's mirror with the truth.
pub fn compare(headless: &mut Headless, seen: Seen) -> MirrorSeen {
    let size = seen.light.size;
    let world = headless.world();
    let mut cameras = world.query::<(&Camera, &GlobalTransform)>();
    let (camera, transform) = cameras.single(world).expect("one camera");
    // Reflected light at a pixel, and true if the picture shows its source too.
    let mirrored = |ray: Ray3d| -> Option<(f32, bool)> {
        let distance = ray.intersect_plane(Vec3::ZERO, InfinitePlane3d::new(Vec3::Y))?;
        if meet(ray).is_some_and(|met| met.distance < distance) {
            return None;
        }
        let direction = *ray.direction * Vec3::new(1.0, -1.0, 1.0);
        let on = Ray3d::new(ray.get_point(distance), Dir3::new(direction).ok()?);
        let met = meet(on)?;
        let place = on.get_point(met.distance);
        let at = camera.world_to_viewport(transform, place).ok();
        let is_in_picture = at.is_some_and(|at| {
            at.cmpgt(Vec2::splat(1.0)).all() && at.cmplt(size.as_vec2() - 1.0).all()
        });
        let back = at.and_then(|at| camera.viewport_to_world(transform, at).ok());
        let is_seen = back.is_some_and(|back| {
            let first = meet(back).map_or(0.0, |first| first.distance);
            // Surfaces seen at a grazing angle cover hardly any pixels.
            let is_facing = met.normal.dot(*back.direction) < -0.2;
            is_facing && first > place.distance(back.origin) - 1e-2
        });
        Some((met.light, is_in_picture && is_seen))
    };
    let truths: Vec<Option<(f32, bool)>> = seen.rays().iter().map(|ray| mirrored(*ray)).collect();
    let differences = truths.iter().zip(&seen.light.texels).map(|(truth, texel)| {
        let off = truth.map_or(
            0.0,
            |(light, is_found)| {
                if is_found { texel[1] - light } else { 0.0 }
            },
        );
        [0.5 + off; 4]
    });
    let width = size.x as usize;
    seen.like(differences.collect())
        .save("mirror_difference", 1.0);
    let (mut everywhere, mut inside, mut count) = (Vec::new(), Vec::new(), 0);
    for (i, truth) in truths.iter().enumerate() {
        let Some((light, is_found)) = *truth else {
            continue;
        };
        count += 1;
        if !is_found {
            continue;
        }
        let difference = seen.light.texels[i][1] - light;
        everywhere.push(difference);
        let around = [i.wrapping_sub(width), i.wrapping_sub(1), i + 1, i + width];
        let is_smooth = around.iter().all(|j| {
            let other = truths.get(*j).copied().flatten();
            other.is_some_and(|(other, is_found)| is_found && (other - light).abs() < 0.05)
        });
        if is_smooth {
            inside.push(difference);
        }
    }
    MirrorSeen {
        share: everywhere.len() as f32 / count.max(1) as f32,
        everywhere: Errors::of(everywhere),
        inside: Errors::of(inside),
        seen,
    }
}

/// Switches `camera` to Bevy's deferred renderer and reflections, without a lower limit of roughness.
pub fn with_bevys_reflections(camera: &mut EntityWorldMut) {
    camera.remove::<LeanDeferred>();
    camera.insert(ScreenSpaceReflections {
        min_perceptual_roughness: 0.0..0.0,
        ..default()
    });
    camera.world_scope(|world| {
        world.insert_resource(DefaultOpaqueRendererMethod::deferred());
    });
}

/// An upright glowing quad above a floor.
#[derive(Clone, Copy)]
pub struct GlowingQuad {
    pub size: Vec2,
    /// Height of its lower edge above the floor.
    pub height: f32,
    pub light: f32,
}

impl GlowingQuad {
    /// A quad whose lower edge touches the floor.
    const WALL: Self = Self {
        size: Vec2::new(1.6, 0.9),
        height: 0.0,
        light: 1.0,
    };
}

/// A rough metal floor's picture of a glowing quad that touches it. Errors are of light, of which the quad has 1.
pub fn rough_floor(
    size: UVec2,
    roughness: f32,
    dress: impl FnOnce(&mut EntityWorldMut),
) -> (Seen, Errors) {
    rough_floor_under(GlowingQuad::WALL, size, roughness, dress)
}

/// A rough metal floor's picture of `quad`.
pub fn rough_floor_under(
    quad: GlowingQuad,
    size: UVec2,
    roughness: f32,
    dress: impl FnOnce(&mut EntityWorldMut),
) -> (Seen, Errors) {
    let mut headless = build(size, |s| {
        s.mesh(
            Rectangle::from_size(quad.size),
            surface(0.0, quad.light),
            Transform::from_xyz(0.0, quad.height + quad.size.y / 2.0, 0.0),
        );
        let floor = Plane3d::default().mesh().size(12.0, 12.0);
        s.mesh(floor, metal(roughness), Transform::default());
        let from = Transform::from_xyz(0.0, 1.2, 3.0);
        let from = from.looking_at(Vec3::new(0.0, 0.3, 0.0), Vec3::Y);
        let entity = camera(s, from, 0.0, ());
        dress(&mut s.world().entity_mut(entity));
    });
    let seen = see(&mut headless, 6);
    let world = headless.world();
    let mut cameras = world.query_filtered::<&GlobalTransform, With<Camera3d>>();
    let eye = cameras.single(world).expect("one camera").translation();
    let mut texels = vec![[0.5; 4]; seen.light.texels.len()];
    let differences: Vec<f32> = seen
        .on_plane(Vec3::ZERO, Vec3::Y)
        .filter(|(pixel, place, _)| {
            // Every third pixel along both axes, in front of the quad.
            pixel.x % 3 == 0
                && pixel.y % 3 == 0
                && (0.02..1.8).contains(&place.z)
                && place.x.abs() < 1.5
        })
        .map(|(pixel, place, found)| {
            let off = found - lobe_of_quad(quad, place, eye, roughness);
            let first = (pixel.y * size.x + pixel.x) as usize;
            for i in (0..9).map(|i| first + i % 3 + i / 3 * size.x as usize) {
                if let Some(texel) = texels.get_mut(i) {
                    *texel = [0.5 + off; 4];
                }
            }
            off
        })
        .collect();
    let name = format!("rough_{roughness}_{}_difference", quad.height);
    seen.like(texels).save(&name, 1.0);
    (seen, Errors::of(differences))
}

/// Light that a metal floor reflects from a glowing quad at `place` towards `eye`: the integral of GGX over the quad, with Smith's
/// correlated shadowing and Fresnel 1.
fn lobe_of_quad(quad: GlowingQuad, place: Vec3, eye: Vec3, roughness: f32) -> f32 {
    // Integrates over the visible microfacets of the lobe: exact for narrow lobes too.
    let view = (eye - place).normalize();
    // Tangent space: the world's y is z.
    let v = Vec3::new(view.x, -view.z, view.y);
    let alpha = roughness * roughness;
    let side = 64;
    let sum: f32 = (0..side * side)
        .map(|i| {
            let u = (Vec2::new((i % side) as f32, (i / side) as f32) + 0.5) / side as f32;
            let sample = sample_lobe(v, alpha, u);
            let l = sample.direction;
            let direction = Vec3::new(l.x, l.z, -l.y);
            let distance = -place.z / direction.z;
            let at = place + direction * distance;
            let up = quad.height..quad.height + quad.size.y;
            let hits = distance > 0.0 && at.x.abs() < quad.size.x / 2.0 && up.contains(&at.y);
            if hits { sample.weight } else { 0.0 }
        })
        .sum();
    quad.light * sum / (side * side) as f32
}

/// Directional albedo of a rough metal: below 1 by the light lost to multiple scattering between microfacets.
pub fn sent_on(cosine: f32, roughness: f32) -> f32 {
    // Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces": the integral over half vectors.
    let (alpha, side) = (roughness * roughness, 256);
    let v = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    let a2 = alpha * alpha;
    let mut sum = 0.0;
    for i in 0..side {
        for j in 0..side {
            let (theta, phi) = (
                (i as f32 + 0.5) / side as f32 * FRAC_PI_2,
                (j as f32 + 0.5) / side as f32 * TAU,
            );
            let h = Vec3::new(
                theta.sin() * phi.cos(),
                theta.sin() * phi.sin(),
                theta.cos(),
            );
            let l = 2.0 * v.dot(h) * h - v;
            if l.z <= 0.0 || v.dot(h) <= 0.0 {
                continue;
            }
            let spread = 1.0 - (1.0 - a2) * h.z * h.z;
            let distribution = a2 / (PI * spread * spread);
            let root = |z: f32| (a2 + (1.0 - a2) * z * z).sqrt();
            let visible = 0.5 / (l.z * root(v.z) + v.z * root(l.z));
            // Change of variables: dl = 4 (v·h) dh.
            sum += distribution * visible * l.z * 4.0 * v.dot(h) * theta.sin();
        }
    }
    sum * FRAC_PI_2 * TAU / (side * side) as f32
}
