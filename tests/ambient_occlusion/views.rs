//! Views of scenes with known occlusion, and the shipped shaders run over them.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use bevy::math::{DVec3, UVec2};
use bevy_lean_deferred::{
    effects::ambient_occlusion::{
        LeanScreenSpaceAmbientOcclusion, LeanScreenSpaceAmbientOcclusionAdvanced as Advanced,
        OcclusionFilter, OcclusionKernel,
    },
    view::LeanResolution,
};

use kit::{
    occlusion::{
        camera::{Camera, Projection},
        depth_buffer::DepthBuffer,
        errors::Errors,
        geometry::{Geometry, Scene},
        integrator::{Integrator, Sampling},
        solids::Hit,
    },
    occlusion_gpu::{DepthImage, Occlusion, OcclusionGpu, Path},
};

/// The default of [`LeanScreenSpaceAmbientOcclusion::radius`]: 30 to 60 pixels in the views below.
pub const RADIUS: f64 = 0.5;
pub const SIZE: UVec2 = UVec2::new(480, 270);
pub const PERSPECTIVE: Projection = Projection::Perspective {
    fov_y: FRAC_PI_4,
    near: 0.1,
};
pub const ORTHOGRAPHIC: Projection = Projection::Orthographic {
    height: 3.2,
    near: 0.0,
    far: 20.0,
};
pub const TALL: f64 = f64::INFINITY;

/// A scene in front of a camera.
pub struct View {
    pub name: &'static str,
    pub scene: Scene,
    pub camera: Camera,
}

impl View {
    /// A perspective view at [`SIZE`].
    pub fn new(name: &'static str, geometry: Geometry, eye: [f64; 3], target: [f64; 3]) -> Self {
        Self {
            name,
            scene: Scene::new(geometry),
            camera: look(eye.into(), target.into(), PERSPECTIVE, SIZE),
        }
    }

    pub fn with_projection(mut self, projection: Projection) -> Self {
        self.camera.projection = projection;
        self
    }

    pub fn with_size(mut self, size: UVec2) -> Self {
        self.camera.size = size;
        self
    }

    pub fn seen(&self) -> Seen {
        self.seen_within(RADIUS)
    }

    /// The view's depth buffer, and the truth within `radius`.
    pub fn seen_within(&self, radius: f64) -> Seen {
        let buffer = DepthBuffer::new(self.camera, &self.scene);
        Seen {
            truth: buffer.truth(&self.scene, radius),
            mask: buffer.interior(2, radius),
            image: depth_image(&buffer),
            buffer,
        }
    }
}

pub fn look(eye: DVec3, target: DVec3, projection: Projection, size: UVec2) -> Camera {
    // Not exactly along Y, so that cameras may look straight down.
    let up = DVec3::new(0.0, 1.0, -1e-3);
    Camera::looking_at(eye, target, up, projection, size)
}

pub fn depth_image(buffer: &DepthBuffer) -> DepthImage {
    DepthImage::new(
        buffer.depths.clone(),
        buffer.size(),
        buffer.camera.clip_from_view().as_mat4(),
    )
}

/// A view's depth buffer and its ground truth.
pub struct Seen {
    pub buffer: DepthBuffer,
    pub image: DepthImage,
    /// Closed forms, where they are known.
    pub truth: Vec<Option<f32>>,
    /// Pixels of surfaces whose possible occluders are all in the picture.
    pub mask: Vec<bool>,
}

impl Seen {
    /// Errors against the closed form.
    pub fn errors(&self, occlusion: &[f32]) -> Errors {
        Errors::measure(occlusion, &self.truth, &self.mask)
    }

    /// Pixels of the mask with more than `least` true occlusion.
    pub fn shade(&self, least: f32) -> Vec<bool> {
        let truth = self.truth.iter().map(|truth| truth.unwrap_or(0.0));
        let pixels = truth.zip(&self.mask);
        pixels.map(|(truth, mask)| *mask && truth > least).collect()
    }

    /// Restricts the mask to hits that satisfy a condition.
    pub fn only(mut self, condition: impl Fn(&Hit) -> bool) -> Self {
        for (mask, hit) in self.mask.iter_mut().zip(&self.buffer.hits) {
            *mask &= hit.as_ref().is_some_and(&condition);
        }
        self
    }

    /// The converged integral of the depth buffer, at every `stride`-th pixel of every `stride`-th row.
    pub fn integral(&self, stride: u32) -> Vec<Option<f32>> {
        let integrator =
            Integrator::new(self.buffer.camera, &self.buffer.depths, Sampling::CONVERGED);
        integrator.occlusions(&self.buffer.normals(), RADIUS, stride)
    }
}

pub fn wall() -> View {
    let wall = Geometry::Wall { height: TALL };
    View::new("tall wall", wall, [3.0, 2.5, 3.0], [0.0, 0.3, 0.0])
}

pub fn groove() -> View {
    let groove = Geometry::Groove {
        interior_angle: FRAC_PI_2,
    };
    View::new("groove of 90°", groove, [0.0, 4.0, 2.0], [0.0, 0.3, 0.0])
}

pub fn corner() -> View {
    let corner = Geometry::Corner { height: TALL };
    View::new("corner", corner, [3.0, 2.5, 3.5], [0.0, 0.3, 0.0])
}

pub fn pit() -> View {
    let pit = Geometry::Pit {
        pit_radius: 0.8,
        depth: 0.4,
    };
    View::new("pit", pit, [0.0, 3.5, 0.5], [0.0; 3])
}

pub fn trench() -> View {
    let trench = Geometry::Trench {
        width: 1.2,
        depth: 0.5,
    };
    View::new("trench", trench, [0.0, 3.5, 0.5], [0.0; 3])
}

pub fn stairs() -> View {
    let stairs = Geometry::Staircase {
        tread: 0.25,
        riser: 0.15,
        steps: 6,
    };
    View::new("stairs", stairs, [-1.0, 3.0, 0.3], [0.7, 0.4, 0.0])
}

pub fn sphere() -> View {
    let sphere = Geometry::Sphere {
        sphere_radius: 0.5,
        height: 0.6,
    };
    View::new("sphere", sphere, [0.0, 2.0, 4.0], [0.0; 3])
}

/// A plane seen at `tilt` from its normal, `distance` away.
pub fn plane(tilt: f64, distance: f64) -> View {
    let (sin, cos) = tilt.sin_cos();
    let plane = Geometry::Plane {
        point: DVec3::ZERO,
        normal: DVec3::new(0.3 * sin, 0.954 * sin, cos),
    };
    View::new("plane", plane, [0.0, 0.0, distance], [0.0; 3])
}

/// All kernels at both resolutions.
pub fn kinds() -> impl Iterator<Item = LeanScreenSpaceAmbientOcclusion> {
    let kernels = [OcclusionKernel::Hbao, OcclusionKernel::Hdao];
    kernels.into_iter().flat_map(|kernel| {
        let advanced = Advanced {
            kernel,
            ..Advanced::default()
        };
        [LeanResolution::Full, LeanResolution::Half].map(|resolution| {
            LeanScreenSpaceAmbientOcclusion {
                resolution,
                advanced,
                ..LeanScreenSpaceAmbientOcclusion::default()
            }
        })
    })
}

/// [`kinds`] with all filters.
pub fn kinds_and_filters() -> impl Iterator<Item = LeanScreenSpaceAmbientOcclusion> {
    kinds().flat_map(|settings| {
        let filters = OcclusionFilter::ALL.into_iter();
        let filters =
            filters.flat_map(|filter| [false, true].map(|edge_aware| (filter, edge_aware)));
        filters.map(
            move |(filter, edge_aware)| LeanScreenSpaceAmbientOcclusion {
                advanced: Advanced {
                    filter,
                    edge_aware,
                    ..settings.advanced
                },
                ..settings
            },
        )
    })
}

/// The part of a picture that starts at `origin`.
pub fn crop<T: Copy>(picture: &[T], width: u32, origin: UVec2, size: UVec2) -> Vec<T> {
    let row = |y: u32| {
        let start = ((origin.y + y) * width + origin.x) as usize;
        &picture[start..start + size.x as usize]
    };
    (0..size.y).flat_map(row).copied().collect()
}

/// Errors of `result` against `reference`.
pub fn difference(result: &[f32], reference: &[f32]) -> Errors {
    let reference: Vec<_> = reference.iter().copied().map(Some).collect();
    Errors::measure(result, &reference, &vec![true; result.len()])
}

/// As `OcclusionGpu::run`; panics if any output is not a number from 0 to 1.
pub fn run(
    gpu: &OcclusionGpu,
    settings: &LeanScreenSpaceAmbientOcclusion,
    image: &DepthImage,
) -> Occlusion {
    run_by(gpu.path(), gpu, settings, image)
}

pub fn run_by(
    path: Path,
    gpu: &OcclusionGpu,
    settings: &LeanScreenSpaceAmbientOcclusion,
    image: &DepthImage,
) -> Occlusion {
    let occlusion = gpu.run_by(path, settings, image);
    for (stage, values) in [
        ("gathered", &occlusion.gathered),
        ("filtered", &occlusion.filtered),
    ] {
        let wrong = values.iter().find(|x| !(0.0..=1.0).contains(*x));
        assert_eq!(wrong, None, "{stage}, with {settings:?}");
    }
    let texels = match settings.resolution {
        LeanResolution::Full => image.viewport.1,
        LeanResolution::Half => (image.viewport.1 + 1) / 2,
    };
    assert_eq!(occlusion.gathered.len(), texels.element_product() as usize);
    occlusion
}
