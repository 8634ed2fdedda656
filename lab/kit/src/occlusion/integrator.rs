//! The converged screen-space integral of a depth buffer: the result of horizon-based ambient occlusion with unlimited samples and
//! precision (Jimenez, Wu, Pesce and Jarabo 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion", with cosine weights and
//! horizons of infinite thickness).
//!
//! Slices are spread evenly about the view direction of each pixel, not on the screen, so that perspective is exact. Samples are the
//! nearest pixels' centres, without interpolation; points beyond the radius do not count. Occlusion is measured from the tangent plane, so
//! that it is 0 on a plane.

use std::f64::consts::{FRAC_PI_2, PI};

use bevy::math::{DVec2, DVec3, UVec2, Vec3};

use super::{
    camera::{Camera, Projection},
    depth_buffer::pixels,
};

#[derive(Clone, Copy, Debug)]
pub struct Sampling {
    pub slices: u32,
    /// Samples on each of a slice's two sides, spread evenly on the screen. No pixel is skipped if the radius spans at most this many.
    pub steps: u32,
}

impl Sampling {
    pub const CONVERGED: Self = Self {
        slices: 64,
        steps: 64,
    };
}

pub struct Integrator {
    camera: Camera,
    /// View-space positions; `None` in the sky.
    positions: Vec<Option<DVec3>>,
    sampling: Sampling,
}

impl Integrator {
    /// Integrates a depth buffer as a depth attachment holds it.
    pub fn new(camera: Camera, depths: &[f32], sampling: Sampling) -> Self {
        let positions = pixels(camera.size)
            .zip(depths)
            .map(|((_, center), depth)| camera.position(center, f64::from(*depth)))
            .collect();
        Self {
            camera,
            positions,
            sampling,
        }
    }

    /// Occlusion within `radius` at every `stride`-th pixel of every `stride`-th row that has a normal.
    pub fn occlusions(
        &self,
        normals: &[Option<Vec3>],
        radius: f64,
        stride: u32,
    ) -> Vec<Option<f32>> {
        pixels(self.camera.size)
            .zip(normals)
            .map(|((pixel, _), normal)| {
                let on_grid = pixel % stride == UVec2::splat(stride / 2);
                let normal = normal.filter(|_| on_grid)?;
                Some(self.occlusion(pixel, normal.as_dvec3().normalize(), radius)? as f32)
            })
            .collect()
    }

    /// Occlusion within `radius` of a pixel whose view-space `normal` faces the viewer, or `None` in the sky.
    pub fn occlusion(&self, pixel: UVec2, normal: DVec3, radius: f64) -> Option<f64> {
        let position = self.position(pixel)?;
        let to_viewer = self.camera.viewer_direction(position);
        let (right, up) = to_viewer.any_orthonormal_pair();
        let slices = f64::from(self.sampling.slices);
        let occlusion_of = |slice: u32| {
            let (sin, cos) = (PI * (f64::from(slice) + 0.5) / slices).sin_cos();
            let along = right * cos + up * sin;
            let sides = [along, -along].map(|along| {
                let side = Side {
                    position,
                    normal,
                    to_viewer,
                    along,
                };
                side.occlusion(self.horizon(pixel, &side, radius))
            });
            sides[0] + sides[1]
        };
        Some((0..self.sampling.slices).map(occlusion_of).sum::<f64>() / slices)
    }

    fn position(&self, pixel: UVec2) -> Option<DVec3> {
        self.positions[(pixel.y * self.camera.size.x + pixel.x) as usize]
    }

    /// Cotangent of the smallest angle between the view direction and a visible point on this side, or the tangent plane.
    fn horizon(&self, center: UVec2, side: &Side, radius: f64) -> f64 {
        let tangent = side.tangent();
        let Some(skew) = side.skew() else {
            return tangent;
        };
        let start = self.camera.pixel(side.position);
        let stride = self.footprint(side, radius) / f64::from(self.sampling.steps);
        let mut horizon = tangent;
        let mut last = center;
        for step in 1..=self.sampling.steps {
            let at = start + stride * f64::from(step);
            if at.cmplt(DVec2::ZERO).any() || at.cmpge(self.camera.size.as_dvec2()).any() {
                break;
            }
            let pixel = at.as_uvec2();
            if pixel == last {
                continue;
            }
            last = pixel;
            let Some(position) = self.position(pixel) else {
                continue;
            };
            let offset = position - side.position;
            if offset.length_squared() > radius * radius {
                continue;
            }
            let in_slice = offset + skew * offset.dot(side.across());
            let along = in_slice.dot(side.along);
            if along > 0.0 {
                horizon = horizon.max(in_slice.dot(side.to_viewer) / along);
            }
        }
        horizon
    }

    /// Offset in pixels from the centre to the furthest screen position that can show something within the radius.
    fn footprint(&self, side: &Side, radius: f64) -> DVec2 {
        let start = self.camera.pixel(side.position);
        match self.camera.projection {
            Projection::Orthographic { .. } => {
                self.camera.pixel(side.position + side.along * radius) - start
            }
            Projection::Perspective { .. } => {
                let away = side.position.length();
                let diagonal = self.camera.size.as_dvec2().length();
                let tangent = (radius / away).min(1.0).asin();
                let ray = side.along * tangent.sin() - side.to_viewer * tangent.cos();
                // At most as long as the screen's diagonal, and always in front of the camera.
                let nearby = side.position + side.along * (1e-3 * away);
                let direction = (self.camera.pixel(nearby) - start).normalize();
                let length = if ray.z < -1e-3 {
                    self.camera.pixel(ray).distance(start).min(diagonal)
                } else {
                    diagonal
                };
                direction * length
            }
        }
    }
}

/// One side of a slice: the half-plane of `to_viewer` and `along`, which are perpendicular.
struct Side {
    position: DVec3,
    normal: DVec3,
    to_viewer: DVec3,
    along: DVec3,
}

impl Side {
    /// The normal of the slice.
    fn across(&self) -> DVec3 {
        self.to_viewer.cross(self.along)
    }

    /// Length of the normal in the slice, and its angle from the view direction towards this side.
    fn projected_normal(&self) -> (f64, f64) {
        let (along, to_viewer) = (self.normal.dot(self.along), self.normal.dot(self.to_viewer));
        (along.hypot(to_viewer), along.atan2(to_viewer))
    }

    /// Cotangent of the angle between the view direction and the tangent plane.
    fn tangent(&self) -> f64 {
        -self.normal.dot(self.along) / self.normal.dot(self.to_viewer)
    }

    /// Offset that moves a point at distance 1 in front of the slice into it, along the tangent plane: a pixel's centre is off the slice by
    /// up to 0.7 pixels, which must not tilt the plane. `None` if the slice is perpendicular to the normal, where its weight is 0.
    fn skew(&self) -> Option<DVec3> {
        let across = self.across();
        let height = self.normal.dot(across);
        let flat = 1.0 - height * height;
        (flat > 1e-9).then(|| (self.normal * height - across) / flat)
    }

    /// Cosine-weighted occlusion between the tangent plane and `horizon`, a cotangent.
    fn occlusion(&self, horizon: f64) -> f64 {
        let (length, normal) = self.projected_normal();
        let visible = |angle: f64| {
            0.25 * (normal.cos() - (2.0 * angle - normal).cos() + 2.0 * angle * normal.sin())
        };
        let tangent = normal + FRAC_PI_2;
        let angle = (FRAC_PI_2 - horizon.atan()).min(tangent);
        length * (visible(tangent) - visible(angle))
    }
}
