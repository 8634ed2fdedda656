//! Scenes with known occlusion, in world space: Y is up, and cameras are outside the solids.

use std::f64::consts::FRAC_PI_2;

use bevy::math::DVec3;

use super::{
    closed_forms::{
        box_corner_within, floor_under_sphere, pit, pit_within, tilted_plane, trench_within,
        v_groove_within, wall, wall_sector,
    },
    solids::{Hit, Solid},
};

/// Lengths in metres, angles in radians.
#[derive(Clone, Copy, Debug)]
pub enum Geometry {
    Plane {
        point: DVec3,
        normal: DVec3,
    },
    /// A floor at y = 0 for x > 0, a wall at x = 0 and a plateau on top of it. `height` may be infinite.
    Wall {
        height: f64,
    },
    /// Two infinite faces that meet along the Z axis, open upwards.
    Groove {
        /// Less than π.
        interior_angle: f64,
    },
    /// A floor at y = 0 for x, z > 0, walls at x = 0 and z = 0 and a plateau on top. `height` may be infinite.
    Corner {
        height: f64,
    },
    /// Around the Y axis, with its floor at y = 0.
    Pit {
        pit_radius: f64,
        depth: f64,
    },
    /// Along the Z axis, with its floor at y = 0 for |x| < width / 2.
    Trench {
        width: f64,
        depth: f64,
    },
    /// A floor at y = 0 and the sphere's centre on the Y axis.
    Sphere {
        sphere_radius: f64,
        /// Height of the centre, at least the radius.
        height: f64,
    },
    /// An infinite upright pole of square section around the Y axis, with its front at z = 0, in front of a wall at z = -`gap`. Nothing
    /// occludes the wall within a radius less than `gap` - `thickness`: a halo around the pole is an error.
    Pole {
        thickness: f64,
        gap: f64,
    },
    /// An infinite upright prism around the Y axis. It is convex, so nothing occludes it.
    FacetedCylinder {
        cylinder_radius: f64,
        facets: u32,
    },
    /// A floor at y = 0 for x < 0 and, from x = 0 on, `steps` steps up along X, the last of which is infinite.
    Staircase {
        tread: f64,
        riser: f64,
        steps: u32,
    },
}

/// A [`Geometry`] that rays can hit.
#[derive(Clone, Debug)]
pub struct Scene {
    pub geometry: Geometry,
    solids: Vec<Solid>,
}

impl Scene {
    pub fn new(geometry: Geometry) -> Self {
        const FAR: f64 = f64::INFINITY;
        let floor = Solid::ground(0.0);
        let solids = match geometry {
            Geometry::Plane { point, normal } => vec![Solid::half_space(point, normal)],
            Geometry::Wall { height } => vec![
                floor,
                Solid::cuboid(DVec3::splat(-FAR), DVec3::new(0.0, height, FAR)),
            ],
            Geometry::Groove { interior_angle } => {
                let (sin, cos) = (0.5 * interior_angle).sin_cos();
                [-cos, cos]
                    .map(|x| Solid::half_space(DVec3::ZERO, DVec3::new(x, sin, 0.0)))
                    .to_vec()
            }
            Geometry::Corner { height } => vec![
                floor,
                Solid::cuboid(DVec3::splat(-FAR), DVec3::new(0.0, height, FAR)),
                Solid::cuboid(DVec3::splat(-FAR), DVec3::new(FAR, height, 0.0)),
            ],
            Geometry::Pit { pit_radius, depth } => vec![
                floor,
                Solid::Bored {
                    radius: pit_radius,
                    height: depth,
                },
            ],
            Geometry::Trench { width, depth } => vec![
                floor,
                Solid::cuboid(DVec3::splat(-FAR), DVec3::new(-0.5 * width, depth, FAR)),
                Solid::cuboid(
                    DVec3::new(0.5 * width, -FAR, -FAR),
                    DVec3::new(FAR, depth, FAR),
                ),
            ],
            Geometry::Sphere {
                sphere_radius,
                height,
            } => vec![
                floor,
                Solid::Sphere {
                    center: DVec3::Y * height,
                    radius: sphere_radius,
                },
            ],
            Geometry::Pole { thickness, gap } => vec![
                Solid::half_space(DVec3::NEG_Z * gap, DVec3::Z),
                Solid::cuboid(
                    DVec3::new(-0.5 * thickness, -FAR, -thickness),
                    DVec3::new(0.5 * thickness, FAR, 0.0),
                ),
            ],
            Geometry::FacetedCylinder {
                cylinder_radius,
                facets,
            } => vec![Solid::prism(cylinder_radius, facets)],
            Geometry::Staircase {
                tread,
                riser,
                steps,
            } => (0..steps)
                .map(f64::from)
                .map(|step| {
                    Solid::cuboid(
                        DVec3::new(step * tread, -FAR, -FAR),
                        DVec3::new(FAR, (step + 1.0) * riser, FAR),
                    )
                })
                .chain([floor])
                .collect(),
        };
        Self { geometry, solids }
    }

    /// The first surface on a ray.
    pub fn hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let hits = self
            .solids
            .iter()
            .filter_map(|solid| solid.hit(origin, direction));
        hits.min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// Occlusion within `radius` at a hit, if it is known in closed form. `radius` may be infinite.
    pub fn occlusion(&self, hit: &Hit, radius: f64) -> Option<f64> {
        let (point, normal) = (hit.point, hit.normal);
        let faces_up = normal.y > 0.5;
        match self.geometry {
            Geometry::Plane { .. } | Geometry::FacetedCylinder { .. } => Some(0.0),
            Geometry::Wall { height } => Some(match faces_up {
                true if point.x > 0.0 => wall(point.x, height, radius),
                true => 0.0,
                false => wall(point.y, f64::INFINITY, radius),
            }),
            Geometry::Groove { interior_angle } => {
                let from_edge = point.x.hypot(point.y);
                Some(v_groove_within(interior_angle, from_edge, radius))
            }
            Geometry::Corner { height } => Some(match faces_up {
                true if point.x.min(point.z) > 0.0 => {
                    box_corner_within(point.x, point.z, height, radius)
                }
                true => 0.0,
                false => {
                    let other_wall = if normal.x > 0.5 { point.z } else { point.x };
                    corner_wall(point.y, height, other_wall, radius)
                }
            }),
            Geometry::Pit { pit_radius, depth } => {
                let offset = point.x.hypot(point.z);
                match faces_up {
                    true if offset >= pit_radius => Some(0.0),
                    true if radius == f64::INFINITY => Some(pit(pit_radius, depth, offset)),
                    true => Some(pit_within(pit_radius, depth, offset, radius)),
                    false => None,
                }
            }
            Geometry::Trench { width, depth } => match faces_up {
                true if point.x.abs() > 0.5 * width => Some(0.0),
                true => Some(trench_within(width, depth, point.x + 0.5 * width, radius)),
                false => trench_side(width, depth, point.y, radius),
            },
            Geometry::Sphere {
                sphere_radius,
                height,
            } => {
                let on_floor = point.y <= 1e-9 * height;
                Some(if on_floor {
                    let offset = point.x.hypot(point.z);
                    floor_under_sphere(sphere_radius, height, offset, radius)
                } else {
                    tilted_plane((-normal.y).clamp(-1.0, 1.0).acos(), point.y, radius)
                })
            }
            Geometry::Pole { thickness, gap } => (radius <= gap - thickness).then_some(0.0),
            Geometry::Staircase {
                tread,
                riser,
                steps,
            } if faces_up => {
                let step = (point.x / tread).floor();
                let from_riser = (step + 1.0) * tread - point.x;
                match step + 1.0 {
                    next if next >= f64::from(steps) => Some(0.0),
                    next if next >= 0.0 => Some(wall(from_riser, riser, radius)),
                    // From further out on the floor, higher steps are visible above the first.
                    _ => None,
                }
            }
            Geometry::Staircase { tread, riser, .. } => {
                Some(stair_riser(tread, riser, point.y, radius))
            }
        }
    }
}

/// A wall of a box corner as high as the other wall; `above_floor` and `from_wall` are the distances to the floor and the other wall.
fn corner_wall(above_floor: f64, height: f64, from_wall: f64, radius: f64) -> f64 {
    let sector = |distance, beside: f64| {
        wall_sector(distance, f64::INFINITY, radius, beside.atan2(distance))
    };
    // The floor extends to infinity away from the other wall, which ends at the top.
    wall_sector(above_floor, f64::INFINITY, radius, FRAC_PI_2)
        + sector(above_floor, from_wall)
        + sector(from_wall, above_floor)
        + sector(from_wall, height - above_floor)
}

/// A side of a trench. If the radius reaches the other side, a closed form is known only for an infinite radius.
fn trench_side(width: f64, depth: f64, above_floor: f64, radius: f64) -> Option<f64> {
    if radius <= width {
        Some(wall(above_floor, width, radius))
    } else if radius == f64::INFINITY {
        let below_top = depth - above_floor;
        Some(0.5 * (1.0 + below_top / below_top.hypot(width)))
    } else {
        None
    }
}

/// A riser of a staircase, at `above_floor`.
fn stair_riser(tread: f64, riser: f64, above_floor: f64, radius: f64) -> f64 {
    let above_tread = above_floor % riser;
    let floor = |height| wall(above_floor, height, radius);
    if above_tread == above_floor {
        return floor(f64::INFINITY);
    }
    // Beyond the edge of the tread below, which hides all lower treads, the floor extends to the horizon.
    let hidden_floor = floor(tread * above_floor / above_tread);
    wall(above_tread, tread, radius) + floor(f64::INFINITY) - hidden_floor
}
