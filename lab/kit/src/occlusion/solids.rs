//! Solids that rays can hit.

use std::{iter::zip, ops::Neg as _};

use bevy::math::DVec3;

/// Point where a ray first enters a solid.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub distance: f64,
    pub point: DVec3,
    /// Outward unit normal of the surface.
    pub normal: DVec3,
}

/// The inner side of a plane.
#[derive(Clone, Copy, Debug)]
pub struct HalfSpace {
    /// Outward unit normal.
    pub normal: DVec3,
    /// Distance of the plane from the origin along `normal`.
    pub offset: f64,
}

#[derive(Clone, Debug)]
pub enum Solid {
    /// Intersection of half-spaces.
    Convex(Vec<HalfSpace>),
    Sphere {
        center: DVec3,
        radius: f64,
    },
    /// Everything below `height`, except a bore of `radius` along the Y axis.
    Bored {
        radius: f64,
        height: f64,
    },
}

impl HalfSpace {
    /// `normal` need not be of unit length.
    pub fn new(point: DVec3, normal: DVec3) -> Self {
        let normal = normal.normalize();
        let offset = normal.dot(point);
        Self { normal, offset }
    }
}

impl Solid {
    pub fn half_space(point: DVec3, normal: DVec3) -> Self {
        Self::Convex(vec![HalfSpace::new(point, normal)])
    }

    /// Everything below `height`.
    pub fn ground(height: f64) -> Self {
        Self::half_space(DVec3::Y * height, DVec3::Y)
    }

    /// A box between two corners, which may be at infinity.
    pub fn cuboid(min: DVec3, max: DVec3) -> Self {
        let upper = zip(DVec3::AXES, max.to_array());
        let lower = zip(DVec3::AXES.map(DVec3::neg), (-min).to_array());
        let sides = upper
            .chain(lower)
            .filter(|(_, offset)| offset.is_finite())
            .map(|(normal, offset)| HalfSpace { normal, offset });
        Self::Convex(sides.collect())
    }

    /// An infinite prism about the Y axis with `facets` sides, inscribed in a cylinder of `radius`.
    pub fn prism(radius: f64, facets: u32) -> Self {
        let step = std::f64::consts::TAU / f64::from(facets);
        let sides = (0..facets).map(|i| {
            let (sin, cos) = (step * (f64::from(i) + 0.5)).sin_cos();
            HalfSpace {
                normal: DVec3::new(cos, 0.0, sin),
                offset: radius * (0.5 * step).cos(),
            }
        });
        Self::Convex(sides.collect())
    }

    /// Point where the ray enters the solid, if it begins outside.
    pub fn hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let (distance, normal) = match self {
            Self::Convex(half_spaces) => enter_convex(half_spaces, origin, direction)?,
            &Self::Sphere { center, radius } => {
                let from_center = origin - center;
                let a = direction.length_squared();
                let b = from_center.dot(direction);
                let discriminant = b * b - a * (from_center.length_squared() - radius * radius);
                let distance = (-b - positive_root(discriminant)?) / a;
                let normal = (from_center + direction * distance) / radius;
                (distance, normal)
            }
            &Self::Bored { radius, height } => enter_bored(radius, height, origin, direction)?,
        };
        (distance > 0.0).then(|| Hit {
            distance,
            point: origin + direction * distance,
            normal,
        })
    }
}

fn positive_root(square: f64) -> Option<f64> {
    (square > 0.0).then(|| square.sqrt())
}

fn enter_convex(sides: &[HalfSpace], origin: DVec3, direction: DVec3) -> Option<(f64, DVec3)> {
    let (mut enter, mut leave, mut normal) = (f64::NEG_INFINITY, f64::INFINITY, DVec3::ZERO);
    for side in sides {
        let speed = direction.dot(side.normal);
        let outside = origin.dot(side.normal) - side.offset;
        let distance = -outside / speed;
        if speed < 0.0 {
            if distance > enter {
                (enter, normal) = (distance, side.normal);
            }
        } else if speed > 0.0 {
            leave = leave.min(distance);
        } else if outside > 0.0 {
            return None;
        }
    }
    (enter < leave).then_some((enter, normal))
}

fn enter_bored(radius: f64, height: f64, origin: DVec3, direction: DVec3) -> Option<(f64, DVec3)> {
    let horizontal = DVec3::new(1.0, 0.0, 1.0);
    let top = (height - origin.y) / direction.y;
    if direction.y < 0.0 && top > 0.0 {
        let at_top = (origin + direction * top) * horizontal;
        if at_top.length() >= radius {
            return Some((top, DVec3::Y));
        }
    }
    // Leaves the bore through its side.
    let (o, d) = (origin * horizontal, direction * horizontal);
    let a = d.length_squared();
    let b = o.dot(d);
    let side = (positive_root(b * b - a * (o.length_squared() - radius * radius))? - b) / a;
    let below_top = origin.y + direction.y * side <= height;
    below_top.then(|| (side, -(o + d * side) / radius))
}
