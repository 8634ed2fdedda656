//! The screen-space integral against closed forms, with all occluders in the picture and with hidden ones.

use std::f64::consts::{FRAC_PI_2, PI};

use bevy::math::{DVec3, UVec2};
use kit::occlusion::{
    camera::{Camera, Projection},
    depth_buffer::DepthBuffer,
    errors::Errors,
    geometry::{Geometry, Scene},
    integrator::{Integrator, Sampling},
};

const SIZE: UVec2 = UVec2::new(256, 192);
const STRIDE: u32 = 4;
/// 30 to 50 pixels in the pictures below.
const RADIUS: f64 = 0.5;
const INF: f64 = f64::INFINITY;

const PERSPECTIVE: Projection = Projection::Perspective {
    fov_y: 0.9,
    near: 0.1,
};
const ORTHOGRAPHIC: Projection = Projection::Orthographic {
    height: 3.0,
    near: 0.0,
    far: 20.0,
};

struct View {
    scene: Scene,
    eye: DVec3,
    target: DVec3,
}

impl View {
    fn new(geometry: Geometry, eye: [f64; 3], target: [f64; 3]) -> Self {
        Self {
            scene: Scene::new(geometry),
            eye: eye.into(),
            target: target.into(),
        }
    }

    fn depth_buffer(&self, projection: Projection, size: UVec2) -> DepthBuffer {
        let up = DVec3::new(0.0, 1.0, -0.1);
        let camera = Camera::looking_at(self.eye, self.target, up, projection, size);
        DepthBuffer::new(camera, &self.scene)
    }

    /// Errors of the integral of the depth buffer, at every `stride`-th pixel whose radius is in the picture.
    fn errors(&self, projection: Projection, size: UVec2, stride: u32) -> Errors {
        let buffer = self.depth_buffer(projection, size);
        let integrator = Integrator::new(buffer.camera, &buffer.depths, Sampling::CONVERGED);
        Errors::measure_sparse(
            &integrator.occlusions(&buffer.normals(), RADIUS, stride),
            &buffer.truth(&self.scene, RADIUS),
            &buffer.interior(2, RADIUS),
        )
    }
}

fn tilted_plane() -> View {
    let plane = Geometry::Plane {
        point: DVec3::ZERO,
        normal: DVec3::new(0.3, 1.0, 0.2),
    };
    View::new(plane, [0.5, 2.0, 2.0], [0.0; 3])
}

fn grazed_plane() -> View {
    let plane = Geometry::Plane {
        point: DVec3::ZERO,
        normal: DVec3::Y,
    };
    View::new(plane, [0.0, 0.8, 4.0], [0.0; 3])
}

fn wall(height: f64) -> View {
    View::new(Geometry::Wall { height }, [2.0, 2.0, 1.0], [0.0; 3])
}

fn groove(interior_angle: f64) -> View {
    let groove = Geometry::Groove { interior_angle };
    View::new(groove, [0.3, 3.0, 0.5], [0.0, 0.2, 0.0])
}

fn corner() -> View {
    View::new(Geometry::Corner { height: INF }, [2.0, 2.0, 1.6], [0.0; 3])
}

/// In perspective from above, both sides are visible.
fn trench() -> View {
    let trench = Geometry::Trench {
        width: 1.0,
        depth: 0.4,
    };
    View::new(trench, [0.0, 3.0, 0.0], [0.0; 3])
}

fn pit() -> View {
    let pit = Geometry::Pit {
        pit_radius: 0.7,
        depth: 0.4,
    };
    View::new(pit, [0.0, 3.0, 0.0], [0.0; 3])
}

fn stairs() -> View {
    let stairs = Geometry::Staircase {
        tread: 0.4,
        riser: 0.2,
        steps: 5,
    };
    View::new(stairs, [-1.0, 3.0, 0.0], [0.8, 0.5, 0.0])
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn planes_are_not_occluded() {
    let far = Projection::Orthographic {
        height: 3.0,
        near: 0.0,
        far: 1000.0,
    };
    for view in [tilted_plane(), grazed_plane()] {
        // In f32, the far plane limits the resolution of an orthographic depth buffer.
        for (projection, bound) in [(PERSPECTIVE, 1e-8), (ORTHOGRAPHIC, 1e-8), (far, 1e-5)] {
            let errors = view.errors(projection, SIZE, STRIDE);
            println!(
                "{projection:?}: mean {:.1e}, largest {:.1e}",
                errors.mean, errors.largest
            );
            assert!(
                errors.largest < bound,
                "{projection:?}: {:e}",
                errors.largest
            );
        }
    }
}

/// Visible occluders are integrated within these bounds of RMSE and bias, in either projection.
#[test]
#[ignore = "nightly: tests the tests' reference"]
fn visible_occluders_are_found() {
    for (name, view, rmse, bias) in [
        ("tall wall", wall(INF), 0.005, 0.0015),
        ("low wall", wall(0.3), 0.005, 0.0015),
        ("groove of 60°", groove(PI / 3.0), 0.005, 0.0015),
        ("groove of 90°", groove(FRAC_PI_2), 0.005, 0.0015),
        ("groove of 120°", groove(2.0 * PI / 3.0), 0.003, 0.001),
        ("corner", corner(), 0.005, 0.0015),
        ("stairs", stairs(), 0.007, 0.0015),
    ] {
        for projection in [PERSPECTIVE, ORTHOGRAPHIC] {
            let errors = view.errors(projection, SIZE, STRIDE);
            println!("{name}: {errors}");
            assert!(
                errors.rmse < rmse && errors.bias.abs() < bias,
                "{name}: {errors}"
            );
        }
    }
    for (name, view) in [("trench", trench()), ("pit", pit())] {
        let errors = view.errors(PERSPECTIVE, SIZE, STRIDE);
        println!("{name}: {errors}");
        assert!(
            errors.rmse < 0.0065 && errors.bias.abs() < 0.004,
            "{name}: {errors}"
        );
    }
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn nothing_far_or_convex_occludes() {
    let pole = Geometry::Pole {
        thickness: 0.03,
        gap: 1.0,
    };
    let cylinder = Geometry::FacetedCylinder {
        cylinder_radius: 0.5,
        facets: 8,
    };
    for geometry in [pole, cylinder] {
        let errors =
            View::new(geometry, [0.0, 0.5, 2.0], [0.0; 3]).errors(PERSPECTIVE, SIZE, STRIDE);
        println!("{geometry:?}: {errors}");
        assert!(errors.largest < 1e-6, "{geometry:?}: {errors}");
    }
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn errors_are_what_they_say() {
    let truth: Vec<Option<f32>> = (0..300).map(|i| (i % 3 != 0).then_some(0.25)).collect();
    let mut mask = vec![true; 300];
    mask[1] = false;
    let mut result = vec![0.5; 300];
    result[2] = 0.0;
    let errors = Errors::measure(&result, &truth, &mask);
    assert_eq!(errors.count, 199);
    assert!((errors.bias - 0.25 * 197.0 / 199.0).abs() < 1e-9);
    assert!((errors.mean - 0.5 * 198.0 / 199.0).abs() < 1e-9);
    assert_eq!(
        (errors.rmse, errors.p99, errors.largest),
        (0.25, 0.25, 0.25)
    );

    result.fill(0.25);
    result[2] = 1.25;
    let errors = Errors::measure(&result, &truth, &mask);
    assert_eq!((errors.p99, errors.largest), (0.0, 1.0));
    assert!((errors.rmse - (1.0f64 / 199.0).sqrt()).abs() < 1e-9);
}
