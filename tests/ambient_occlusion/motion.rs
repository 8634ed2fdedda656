//! Temporal stability, and stability at the border of the picture.

use std::{f64::consts::FRAC_PI_8, rc::Rc};

use bevy::math::{DMat4, DVec2, DVec3, IVec2};
use bevy_lean_deferred::{
    effects::ambient_occlusion::LeanScreenSpaceAmbientOcclusion,
    view::{LeanQuality, LeanResolution},
};

use crate::views::{RADIUS, SIZE, Seen, View, run_by, sphere, wall};
use kit::{
    occlusion::{errors::Errors, geometry::Geometry, solids::Hit},
    occlusion_gpu::{OcclusionGpu, Path},
    skipped::occlusion_by_compute,
};

struct Frame {
    seen: Rc<Seen>,
    occlusion: Vec<f32>,
}

impl Frame {
    fn new(gpu: &OcclusionGpu, settings: &LeanScreenSpaceAmbientOcclusion, seen: Rc<Seen>) -> Self {
        Self::by(gpu.path(), gpu, settings, seen)
    }

    fn by(
        path: Path,
        gpu: &OcclusionGpu,
        settings: &LeanScreenSpaceAmbientOcclusion,
        seen: Rc<Seen>,
    ) -> Self {
        let occlusion = run_by(path, gpu, settings, &seen.image).filtered;
        Self { seen, occlusion }
    }

    /// Occlusion of a surface point, interpolated; `None` beside another surface or outside the picture.
    fn at(&self, point: DVec3, normal: DVec3) -> Option<f32> {
        let camera = &self.seen.buffer.camera;
        let position = camera.world_from_view.inverse().transform_point3(point);
        let place = camera.pixel(position) - 0.5;
        let (corner, part) = (place.floor(), place - place.floor());
        let size = self.seen.buffer.size();
        let mut sum = 0.0;
        for i in 0..4 {
            let offset = IVec2::new(i & 1, i >> 1);
            let pixel = corner.as_ivec2() + offset;
            if pixel.cmplt(IVec2::ZERO).any() || pixel.cmpge(size.as_ivec2()).any() {
                return None;
            }
            let index = (pixel.y as u32 * size.x + pixel.x as u32) as usize;
            let hit = self.seen.buffer.hits[index].as_ref()?;
            if hit.normal.dot(normal) < 0.999 {
                return None;
            }
            let weight = DVec2::select(offset.cmpeq(IVec2::ONE), part, 1.0 - part);
            sum += weight.element_product() * f64::from(self.occlusion[index]);
        }
        Some(sum as f32)
    }

    /// Differences of the next frame at this frame's surface points.
    fn change(&self, next: &Frame, mask: &[bool]) -> Errors {
        let hits = self.seen.buffer.hits.iter();
        let after: Vec<Option<f32>> = hits
            .map(|hit| {
                let hit = hit.as_ref()?;
                next.at(hit.point, hit.normal)
            })
            .collect();
        let before: Vec<Option<f32>> = self.occlusion.iter().copied().map(Some).collect();
        Errors::measure_sparse(&after, &before, mask)
    }
}

/// Turns the camera to its right by `angle` radians.
fn turned(mut view: View, angle: f64) -> View {
    view.camera.world_from_view *= DMat4::from_rotation_y(-angle);
    view
}

/// Angle of a pixel in the middle of the picture, in radians.
fn pixel_angle() -> f64 {
    FRAC_PI_8.tan() / (0.5 * f64::from(SIZE.y))
}

/// While the camera turns by 0.4 pixels per frame, occlusion hardly changes at each surface point. On the sphere only its outlines and its
/// shadow are occluded.
#[test]
fn occlusion_stays_where_it_is_while_the_camera_turns() {
    use LeanResolution::{Full, Half};
    let gpu = OcclusionGpu::new();
    let views: [fn() -> View; 2] = [wall, sphere];
    let seen = views.map(|view| {
        let seen = |i| {
            let angle = 0.4 * f64::from(i) * pixel_angle();
            Rc::new(turned(view(), angle).seen())
        };
        (0..8).map(seen).collect::<Vec<_>>()
    });
    for (resolution, quality, largest) in [
        (Full, LeanQuality::Low, [0.0135, 0.035]),
        (Full, LeanQuality::Medium, [0.0095, 0.0365]),
        (Full, LeanQuality::High, [0.0075, 0.029]),
        (Half, LeanQuality::Medium, [0.0130, 0.033]),
    ] {
        let settings = LeanScreenSpaceAmbientOcclusion {
            resolution,
            quality,
            ..LeanScreenSpaceAmbientOcclusion::default()
        };
        for ((view, seen), largest) in views.iter().zip(&seen).zip(largest) {
            let frame = |seen: &Rc<Seen>| Frame::new(&gpu, &settings, seen.clone());
            let frames: Vec<Frame> = seen.iter().map(frame).collect();
            let changes = frames
                .windows(2)
                .map(|pair| pair[0].change(&pair[1], &pair[0].seen.shade(0.0)));
            let (rms, p99) = changes.fold((0.0f64, 0.0f64), |(rms, p99), change| {
                (rms.max(change.rmse), p99.max(change.p99))
            });
            println!(
                "{}, {quality:?}, {resolution:?}: RMS from frame to frame at most {rms:.4}, p99 {p99:.4}",
                view().name
            );
            assert!(rms <= largest);
        }
    }
}

/// Close to the camera, where distant samples are from lattices of pixels, no more changes than if all were dense.
#[test]
fn lattices_do_not_flicker_while_the_camera_turns() {
    let Some(gpu) = occlusion_by_compute() else {
        return;
    };
    let seen = [0.0, 0.1].map(|pixels| {
        let view = turned(wall(), pixels * pixel_angle());
        Rc::new(view.with_size(4 * SIZE.with_x(SIZE.y)).seen())
    });
    for quality in [LeanQuality::Low, LeanQuality::Medium, LeanQuality::High] {
        let settings = LeanScreenSpaceAmbientOcclusion {
            quality,
            ..LeanScreenSpaceAmbientOcclusion::default()
        };
        let [lattices, dense] = [Path::Compute, Path::Raster].map(|path| {
            let [first, next] =
                (seen.each_ref()).map(|seen| Frame::by(path, &gpu, &settings, seen.clone()));
            first.change(&next, &first.seen.shade(0.0))
        });
        println!("{quality:?}: {lattices}; dense: {dense}");
        assert!(lattices.rmse <= 1.1 * dense.rmse && lattices.p99 <= 1.1 * dense.p99);
    }
}

/// A wall seen from above leaves the picture on the left: the floor beside it loses its occlusion gradually.
#[test]
fn occluders_leave_the_picture_gradually() {
    const EYE: f64 = 3.0;
    let gpu = OcclusionGpu::new();
    // A frame in which the wall's foot is `inside` pixels from the border.
    let frame = |inside: i32| {
        let pixel = pixel_angle() * EYE;
        let x = (0.5 * f64::from(SIZE.x) - f64::from(inside)) * pixel;
        let wall = Geometry::Wall { height: 0.5 };
        let view = View::new("low wall", wall, [x, EYE, 0.0], [x, 0.0, 0.0]);
        let seen = Rc::new(view.seen());
        Frame::new(&gpu, &LeanScreenSpaceAmbientOcclusion::default(), seen)
    };
    let in_shade = |hit: &Option<Hit>| {
        hit.is_some_and(|hit| hit.normal.y > 0.5 && (0.0..RADIUS).contains(&hit.point.x))
    };
    let mut before = frame(48);
    for inside in (-2..48).step_by(2).rev() {
        let next = frame(inside);
        let shade: Vec<bool> = before.seen.buffer.hits.iter().map(in_shade).collect();
        let change = before.change(&next, &shade);
        let errors = Errors::measure(&before.occlusion, &before.seen.truth, &shade);
        println!(
            "wall {inside} pixels inside: change of the mean {:+.4}, RMS {:.4}, largest {:.4}; mean {:.4}, beside the \
             closed form RMSE {:.4}, bias {:+.4}",
            change.bias, change.rmse, change.largest, errors.mean, errors.rmse, errors.bias
        );
        assert!(change.bias.abs() <= 0.021 && change.rmse <= 0.056 && change.largest <= 0.35);
        before = next;
    }
}
