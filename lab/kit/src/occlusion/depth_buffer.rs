//! Depth buffers of a scene, and the ground truth per pixel.

use bevy::math::{DVec2, UVec2, Vec3};

use super::{camera::Camera, geometry::Scene, solids::Hit};

/// Ray-cast through pixel centres. Rows run downwards, as in a texture.
pub struct DepthBuffer {
    pub camera: Camera,
    /// Values of a depth attachment: 0 in the sky.
    pub depths: Vec<f32>,
    /// World-space hits, before rounding.
    pub hits: Vec<Option<Hit>>,
}

/// Pixels of a picture and their centres, row by row.
pub fn pixels(size: UVec2) -> impl Iterator<Item = (UVec2, DVec2)> {
    (0..size.y)
        .flat_map(move |y| (0..size.x).map(move |x| UVec2::new(x, y)))
        .map(|pixel| (pixel, pixel.as_dvec2() + 0.5))
}

impl DepthBuffer {
    pub fn new(camera: Camera, scene: &Scene) -> Self {
        let (depths, hits) = pixels(camera.size)
            .map(|(_, center)| {
                let (origin, direction) = camera.ray(center);
                let hit = scene.hit(origin, direction);
                let depth = hit.map(|hit| camera.depth(camera.near() + hit.distance));
                match depth.filter(|depth| *depth > 0.0) {
                    Some(depth) => (depth as f32, hit),
                    None => (0.0, None),
                }
            })
            .unzip();
        Self {
            camera,
            depths,
            hits,
        }
    }

    pub fn size(&self) -> UVec2 {
        self.camera.size
    }

    /// View-space normals.
    pub fn normals(&self) -> Vec<Option<Vec3>> {
        let view_from_world = self.camera.world_from_view.inverse();
        let to_view = |hit: &Hit| {
            view_from_world
                .transform_vector3(hit.normal)
                .normalize()
                .as_vec3()
        };
        self.hits
            .iter()
            .map(|hit| hit.as_ref().map(to_view))
            .collect()
    }

    /// Occlusion within `radius`, where a closed form is known.
    pub fn truth(&self, scene: &Scene, radius: f64) -> Vec<Option<f32>> {
        self.hits
            .iter()
            .map(|hit| Some(scene.occlusion(hit.as_ref()?, radius)? as f32))
            .collect()
    }

    /// Surface pixels at least `border` pixels inside the picture, whose neighbourhood of `radius` is in the picture too. A radius of 0
    /// excludes only the border.
    pub fn interior(&self, border: u32, radius: f64) -> Vec<bool> {
        let view_from_world = self.camera.world_from_view.inverse();
        pixels(self.size())
            .zip(&self.hits)
            .map(|((pixel, _), hit)| {
                let inside = pixel.cmpge(UVec2::splat(border)).all()
                    && (pixel + border).cmplt(self.size()).all();
                inside
                    && hit.is_some_and(|hit| {
                        let position = view_from_world.transform_point3(hit.point);
                        self.camera.shows_sphere(position, radius)
                    })
            })
            .collect()
    }
}
