//! Depth buffers of surfaces with known normals, ray-cast in f64 and stored in f32 as a depth attachment would.

use bevy::math::{DMat3, DQuat, DVec2, DVec3, IVec2, Mat4, Vec2, Vec3, Vec4Swizzles as _};

pub const WIDTH: i32 = 640;
pub const HEIGHT: i32 = 480;
const NEAR: f64 = 0.1;
/// Far plane of the orthographic lens.
const FAR: f64 = 1000.0;
const FOV_Y: f64 = core::f64::consts::FRAC_PI_3;
/// Metres from the centre to the upper edge of the orthographic view.
const ORTHOGRAPHIC_HALF_HEIGHT: f64 = 4.0;
/// Twin of the constant in `lighting.wgsl`.
const SMALLEST_DEPTH: f32 = 1e-30;
/// Depth of the background.
const SKY: f32 = 0.0;

/// A lens at the origin that looks along -Z.
#[derive(Clone, Copy, Debug)]
pub enum Lens {
    /// Reversed and infinite depth, as in Bevy.
    Perspective,
    /// Reversed depth.
    Orthographic,
}

impl Lens {
    pub const ALL: [Self; 2] = [Self::Perspective, Self::Orthographic];

    fn view_from_clip(self) -> Mat4 {
        let aspect = WIDTH as f32 / HEIGHT as f32;
        let clip_from_view = match self {
            Self::Perspective => {
                Mat4::perspective_infinite_reverse_rh(FOV_Y as f32, aspect, NEAR as f32)
            }
            Self::Orthographic => {
                let y = ORTHOGRAPHIC_HALF_HEIGHT as f32;
                let x = y * aspect;
                Mat4::orthographic_rh(-x, x, -y, y, FAR as f32, 0.0)
            }
        };
        clip_from_view.inverse()
    }

    /// Origin and direction of the ray through the centre of `pixel`; at parameter t its -z is t.
    fn ray(self, pixel: IVec2) -> (DVec3, DVec3) {
        let size = DVec2::new(f64::from(WIDTH), f64::from(HEIGHT));
        let uv = (pixel.as_dvec2() + 0.5) / size;
        let (x, y) = (2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
        let aspect = size.x / size.y;
        match self {
            Self::Perspective => {
                let tan = (FOV_Y / 2.0).tan();
                (DVec3::ZERO, DVec3::new(x * aspect * tan, y * tan, -1.0))
            }
            Self::Orthographic => {
                let half = ORTHOGRAPHIC_HALF_HEIGHT;
                (DVec3::new(x * aspect * half, y * half, 0.0), DVec3::NEG_Z)
            }
        }
    }

    /// The view-space position of `depth` at `pixel`, as in `lighting.wgsl`.
    pub fn position(self, pixel: IVec2, depth: f32) -> Vec3 {
        let uv = (pixel.as_vec2() + 0.5) / Vec2::new(WIDTH as f32, HEIGHT as f32);
        let ndc = uv * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
        let position = self.view_from_clip() * ndc.extend(depth.max(SMALLEST_DEPTH)).extend(1.0);
        position.xyz() / position.w
    }

    /// Stored depth of a surface whose -z is `distance`.
    fn depth(self, distance: f64) -> f32 {
        match self {
            Self::Perspective => (NEAR / distance) as f32,
            Self::Orthographic => (1.0 - distance / FAR) as f32,
        }
    }
}

/// A ray hit: parameter and outward normal.
type Hit = Option<(f64, DVec3)>;

#[derive(Clone, Copy, Debug)]
pub enum Scene {
    /// Level, 1 m to 1 km away.
    Floor,
    /// Two tilted cylinders, 2 and 4 pixels thick, in front of a wall.
    ThinPoles,
    Boxes,
    Sphere,
}

impl Scene {
    pub const ALL: [Self; 4] = [Self::Floor, Self::ThinPoles, Self::Boxes, Self::Sphere];

    fn hit(self, lens: Lens, ray: (DVec3, DVec3)) -> Hit {
        match self {
            Self::Floor => floor(lens, ray),
            Self::ThinPoles => nearest([
                cylinder(
                    ray,
                    DVec3::new(0.0, 0.0, -3.0),
                    DVec3::new(0.2, 1.0, 0.1),
                    0.008,
                ),
                cylinder(
                    ray,
                    DVec3::new(0.5, 0.0, -4.0),
                    DVec3::new(-0.3, 1.0, -0.2),
                    0.02,
                ),
                plane(ray, DVec3::new(0.0, 0.0, -8.0), DVec3::new(0.3, 0.2, 1.0)),
            ]),
            Self::Boxes => nearest([
                cuboid(ray, DVec3::new(-1.0, 0.0, -4.0), DVec3::splat(0.7), 0.5),
                cuboid(
                    ray,
                    DVec3::new(0.8, 0.3, -5.0),
                    DVec3::new(0.4, 1.5, 0.6),
                    1.1,
                ),
                cuboid(
                    ray,
                    DVec3::new(0.5, -0.8, -3.0),
                    DVec3::new(0.5, 0.1, 0.3),
                    2.3,
                ),
                plane(ray, DVec3::new(0.0, -1.5, 0.0), DVec3::Y),
            ]),
            Self::Sphere => nearest([
                sphere(ray, DVec3::new(0.0, 0.0, -4.0), 1.5),
                plane(ray, DVec3::new(0.0, -1.5, 0.0), DVec3::Y),
            ]),
        }
    }
}

fn nearest<const N: usize>(hits: [Hit; N]) -> Hit {
    let hits = hits.into_iter().flatten();
    hits.min_by(|(a, _), (b, _)| a.total_cmp(b))
}

fn plane((origin, direction): (DVec3, DVec3), point: DVec3, normal: DVec3) -> Hit {
    let normal = normal.normalize();
    let t = (point - origin).dot(normal) / direction.dot(normal);
    (t > NEAR && t < FAR).then_some((t, normal))
}

/// In perspective it starts 1 m away at the lower edge of the picture; the orthographic lens looks down at it slightly.
fn floor(lens: Lens, ray: (DVec3, DVec3)) -> Hit {
    match lens {
        Lens::Perspective => plane(ray, DVec3::NEG_Y * (FOV_Y / 2.0).tan(), DVec3::Y),
        Lens::Orthographic => plane(ray, DVec3::NEG_Z * 400.0, DVec3::new(0.0, 50.0, 1.0)),
    }
}

/// The nearer root of `a t² + 2 b t + c`.
fn nearer_root(a: f64, b: f64, c: f64) -> Option<f64> {
    let discriminant = b * b - a * c;
    let t = (-b - discriminant.max(0.0).sqrt()) / a;
    (discriminant > 0.0 && t > NEAR).then_some(t)
}

fn sphere((origin, direction): (DVec3, DVec3), center: DVec3, radius: f64) -> Hit {
    let o = origin - center;
    let t = nearer_root(
        direction.length_squared(),
        o.dot(direction),
        o.length_squared() - radius * radius,
    )?;
    Some((t, (o + t * direction) / radius))
}

fn cylinder((origin, direction): (DVec3, DVec3), point: DVec3, axis: DVec3, radius: f64) -> Hit {
    let axis = axis.normalize();
    let across = |v: DVec3| v - v.dot(axis) * axis;
    let (o, d) = (across(origin - point), across(direction));
    let t = nearer_root(
        d.length_squared(),
        o.dot(d),
        o.length_squared() - radius * radius,
    )?;
    Some((t, (o + t * d) / radius))
}

/// A box turned by `angle` about a slanted axis.
fn cuboid((origin, direction): (DVec3, DVec3), center: DVec3, half: DVec3, angle: f64) -> Hit {
    let axis = DVec3::new(0.3, 1.0, 0.2).normalize();
    let turn = DMat3::from_quat(DQuat::from_axis_angle(axis, angle));
    let (o, d) = (
        turn.transpose() * (origin - center),
        turn.transpose() * direction,
    );
    let enter = (-half * d.signum() - o) / d;
    let leave = (half * d.signum() - o) / d;
    let t = enter.max_element();
    (t > NEAR && t < leave.min_element()).then(|| {
        let entered = DVec3::select(enter.cmpeq(DVec3::splat(t)), -d.signum(), DVec3::ZERO);
        (t, turn * entered)
    })
}

/// Depths of a scene as rasterised, and the true normals.
pub struct DepthBuffer {
    depths: Vec<f32>,
    normals: Vec<Option<DVec3>>,
    lens: Lens,
}

impl DepthBuffer {
    pub fn render(scene: Scene, lens: Lens) -> Self {
        let hits: Vec<_> = (0..WIDTH * HEIGHT)
            .map(|i| {
                let ray = lens.ray(IVec2::new(i % WIDTH, i / WIDTH));
                let (t, normal) = scene.hit(lens, ray)?;
                // Like the reconstructed one, which can only face the viewer.
                let normal = if normal.dot(ray.1) > 0.0 {
                    -normal
                } else {
                    normal
                };
                Some((t, normal))
            })
            .collect();
        Self {
            depths: hits
                .iter()
                .map(|hit| hit.map_or(SKY, |(t, _)| lens.depth(t)))
                .collect(),
            normals: hits
                .iter()
                .map(|hit| hit.map(|(_, normal)| normal))
                .collect(),
            lens,
        }
    }

    fn index(pixel: IVec2) -> usize {
        (pixel.y * WIDTH + pixel.x) as usize
    }

    fn contains(pixel: IVec2) -> bool {
        pixel.cmpge(IVec2::ZERO).all() && pixel.cmplt(IVec2::new(WIDTH, HEIGHT)).all()
    }

    /// Depth at `pixel`; outside the picture one that is never chosen, as in `lighting.wgsl`.
    pub fn depth(&self, pixel: IVec2) -> f32 {
        if Self::contains(pixel) {
            self.depths[Self::index(pixel)]
        } else {
            1e9
        }
    }

    /// View-space position at `pixel`, as in `lighting.wgsl`.
    pub fn position(&self, pixel: IVec2) -> Vec3 {
        self.lens.position(pixel, self.depth(pixel))
    }

    /// The true normal at `pixel`, facing the viewer, or `None` in the sky.
    pub fn normal(&self, pixel: IVec2) -> Option<DVec3> {
        self.normals[Self::index(pixel)]
    }
}
