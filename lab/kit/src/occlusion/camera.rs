//! Bevy's projections: right-handed, looking along -Z, with reversed depth.

use bevy::math::{DMat4, DVec2, DVec3, UVec2};

/// Lengths in metres, angles in radians.
#[derive(Clone, Copy, Debug)]
pub enum Projection {
    /// Has no far plane.
    Perspective { fov_y: f64, near: f64 },
    Orthographic {
        /// Height of the view volume, from the picture's lower to its upper edge.
        height: f64,
        near: f64,
        far: f64,
    },
}

/// A view of the world with square pixels. Pixel coordinates start at the upper left corner; centres are at halves.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    pub world_from_view: DMat4,
    pub projection: Projection,
    /// Picture size in pixels.
    pub size: UVec2,
}

impl Camera {
    /// A camera at `eye`, looking at `target`; `up` is up in the picture.
    pub fn looking_at(
        eye: DVec3,
        target: DVec3,
        up: DVec3,
        projection: Projection,
        size: UVec2,
    ) -> Self {
        Self {
            world_from_view: DMat4::look_at_rh(eye, target, up).inverse(),
            projection,
            size,
        }
    }

    fn aspect_ratio(&self) -> f64 {
        f64::from(self.size.x) / f64::from(self.size.y)
    }

    /// As `CameraProjection::get_clip_from_view` of Bevy's projections.
    pub fn clip_from_view(&self) -> DMat4 {
        match self.projection {
            Projection::Perspective { fov_y, near } => {
                DMat4::perspective_infinite_reverse_rh(fov_y, self.aspect_ratio(), near)
            }
            Projection::Orthographic { near, far, .. } => {
                let half = self.half_extent();
                DMat4::orthographic_rh(-half.x, half.x, -half.y, half.y, far, near)
            }
        }
    }

    /// Half the picture's extent; in perspective, at a distance of 1 m.
    fn half_extent(&self) -> DVec2 {
        let y = match self.projection {
            Projection::Perspective { fov_y, .. } => (0.5 * fov_y).tan(),
            Projection::Orthographic { height, .. } => 0.5 * height,
        };
        DVec2::new(y * self.aspect_ratio(), y)
    }

    /// The view-space position at `pixel` and `distance` along -Z.
    pub fn position_at_distance(&self, pixel: DVec2, distance: f64) -> DVec3 {
        let ndc = DVec2::new(2.0, -2.0) * pixel / self.size.as_dvec2() + DVec2::new(-1.0, 1.0);
        let xy = ndc * self.half_extent();
        match self.projection {
            Projection::Perspective { .. } => xy.extend(-1.0) * distance,
            Projection::Orthographic { .. } => xy.extend(-distance),
        }
    }

    /// The view-space position at `pixel` with `depth`, or `None` in the sky.
    pub fn position(&self, pixel: DVec2, depth: f64) -> Option<DVec3> {
        (depth > 0.0).then(|| {
            let distance = match self.projection {
                Projection::Perspective { near, .. } => near / depth,
                Projection::Orthographic { near, far, .. } => far - depth * (far - near),
            };
            self.position_at_distance(pixel, distance)
        })
    }

    /// Stored depth of a surface at `distance` along -Z; negative beyond the far plane.
    pub fn depth(&self, distance: f64) -> f64 {
        match self.projection {
            Projection::Perspective { near, .. } => near / distance,
            Projection::Orthographic { near, far, .. } => (far - distance) / (far - near),
        }
    }

    /// Pixel coordinates of a view-space position in front of the camera.
    pub fn pixel(&self, position: DVec3) -> DVec2 {
        let xy = match self.projection {
            Projection::Perspective { .. } => position.truncate() / -position.z,
            Projection::Orthographic { .. } => position.truncate(),
        };
        let ndc = xy / self.half_extent();
        (ndc * DVec2::new(0.5, -0.5) + 0.5) * self.size.as_dvec2()
    }

    /// The direction from a view-space position to the viewer.
    pub fn viewer_direction(&self, position: DVec3) -> DVec3 {
        match self.projection {
            Projection::Perspective { .. } => -position.normalize(),
            Projection::Orthographic { .. } => DVec3::Z,
        }
    }

    /// The world-space ray through `pixel`, starting at the near plane; at parameter t its view-space z is -near - t.
    pub fn ray(&self, pixel: DVec2) -> (DVec3, DVec3) {
        let near = self.near();
        let origin = self.position_at_distance(pixel, near);
        let direction = self.position_at_distance(pixel, near + 1.0) - origin;
        (
            self.world_from_view.transform_point3(origin),
            self.world_from_view.transform_vector3(direction),
        )
    }

    pub fn near(&self) -> f64 {
        match self.projection {
            Projection::Perspective { near, .. } | Projection::Orthographic { near, .. } => near,
        }
    }

    /// True if a sphere around a view-space position lies within the picture.
    pub fn shows_sphere(&self, center: DVec3, radius: f64) -> bool {
        let half = self.half_extent();
        match self.projection {
            // In the XZ and YZ planes, between the tangents from the eye.
            Projection::Perspective { .. } => [(center.x, half.x), (center.y, half.y)]
                .into_iter()
                .all(|(across, half)| {
                    let away = across.hypot(center.z);
                    away > radius
                        && across.abs().atan2(-center.z) + (radius / away).asin() <= half.atan()
                }),
            Projection::Orthographic { .. } => (center.truncate().abs() + radius).cmple(half).all(),
        }
    }
}
