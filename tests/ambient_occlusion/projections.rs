//! Occlusion in unusual projections.

use bevy::{
    camera::{CameraProjection, PerspectiveProjection},
    math::{DMat4, DVec3, Mat4, UVec2, Vec3, Vec4},
};
use bevy_lean_deferred::{
    effects::ambient_occlusion::LeanScreenSpaceAmbientOcclusion,
    shader_library::reconstruction::position::{ProjectionKind, projection_of},
};

use crate::views::{ORTHOGRAPHIC, SIZE, Seen, corner, crop, difference, groove, kinds, run, wall};
use kit::occlusion_gpu::{DepthImage, OcclusionGpu};

#[test]
fn orthographic_views_are_as_exact() {
    let gpu = OcclusionGpu::new();
    for (view, largest) in [(wall(), 0.030), (groove(), 0.024), (corner(), 0.038)] {
        let view = view.with_projection(ORTHOGRAPHIC);
        let seen = view.seen();
        let occlusion = run(
            &gpu,
            &LeanScreenSpaceAmbientOcclusion::default(),
            &seen.image,
        )
        .filtered;
        let errors = seen.errors(&occlusion);
        println!("{}: {errors}", view.name);
        assert!(errors.rmse <= largest);
    }
}

/// A part of a picture rendered as a view of its own, with an off-centre projection, equals that part of the whole.
#[test]
fn projections_may_be_off_centre() {
    /// At least the radius, in pixels.
    const BORDER: u32 = 32;
    const PART: (UVec2, UVec2) = (UVec2::new(136, 80), UVec2::new(208, 120));
    let gpu = OcclusionGpu::new();
    let size = UVec2::new(480, 272);
    let (origin, part) = PART;
    for (view, name) in [
        (wall(), "perspective"),
        (wall().with_projection(ORTHOGRAPHIC), "orthographic"),
    ] {
        let seen = view.with_size(size).seen_within(0.0);
        let scale = size.as_vec2() / part.as_vec2();
        let middle = (origin.as_vec2() + 0.5 * part.as_vec2()) / size.as_vec2() * 2.0 - 1.0;
        let shift = -middle * scale;
        let part_from_whole = Mat4::from_cols(
            Vec4::X * scale.x,
            Vec4::Y * scale.y,
            Vec4::Z,
            Vec4::new(shift.x, -shift.y, 0.0, 1.0),
        );
        let image = DepthImage::new(
            crop(&seen.image.depth, size.x, origin, part),
            part,
            part_from_whole * seen.image.clip_from_view,
        );
        assert!(projection_of(image.clip_from_view) != ProjectionKind::Other);
        for settings in kinds() {
            // Less than a quarter of the part's height, the limit of a radius.
            let settings = LeanScreenSpaceAmbientOcclusion {
                radius: 0.2,
                ..settings
            };
            let whole = run(&gpu, &settings, &seen.image).filtered;
            let own = run(&gpu, &settings, &image).filtered;
            let inside = |picture: &[f32], width, origin: UVec2| {
                crop(picture, width, origin + BORDER, part - 2 * BORDER)
            };
            let errors = difference(
                &inside(&own, part.x, UVec2::ZERO),
                &inside(&whole, size.x, origin),
            );
            println!(
                "{name}, {:?}, {:?}: {errors}",
                settings.advanced.kernel, settings.resolution
            );
            assert!(errors.mean > 0.01 && errors.rmse < 1e-4);
        }
    }
}

/// The same surfaces, with the depths of another matrix.
fn with_matrix(seen: &Seen, clip_from_view: Mat4) -> DepthImage {
    let view_from_world = seen.buffer.camera.world_from_view.inverse();
    let matrix = DMat4::from_cols_array(&clip_from_view.to_cols_array().map(f64::from));
    let depth = |point: DVec3| {
        let clip = matrix * view_from_world.transform_point3(point).extend(1.0);
        (clip.z / clip.w) as f32
    };
    let hits = seen.buffer.hits.iter();
    let depths = hits.map(|hit| hit.as_ref().map_or(0.0, |hit| depth(hit.point)));
    DepthImage::new(depths.collect(), seen.image.size, clip_from_view)
}

#[test]
fn other_projections_give_the_same() {
    let gpu = OcclusionGpu::new();
    let seen = wall().seen();
    let usual = seen.image.clip_from_view;
    let oblique = PerspectiveProjection {
        fov: std::f32::consts::FRAC_PI_4,
        aspect_ratio: SIZE.x as f32 / SIZE.y as f32,
        near: 0.1,
        near_clip_plane: Vec4::new(0.3, -0.2, -0.93, -0.5),
        ..PerspectiveProjection::default()
    };
    let far_plane = Mat4::perspective_rh(
        std::f32::consts::FRAC_PI_4,
        SIZE.x as f32 / SIZE.y as f32,
        50.0,
        0.1,
    );
    for (name, matrix, kind, largest) in [
        ("scaled by 2", usual * 2.0, ProjectionKind::Other, 1e-4),
        (
            "finite far plane",
            far_plane,
            ProjectionKind::Perspective,
            1e-4,
        ),
        // Beside creases the neighbour with the nearer depth may be another one under this matrix.
        (
            "oblique near plane",
            oblique.get_clip_from_view(),
            ProjectionKind::Other,
            0.014,
        ),
    ] {
        assert_eq!(projection_of(matrix), kind, "{name}");
        let image = with_matrix(&seen, matrix);
        for settings in kinds() {
            let other = run(&gpu, &settings, &image).filtered;
            let usual = run(&gpu, &settings, &seen.image).filtered;
            let errors = difference(&other, &usual);
            let rmse = [&other, &usual].map(|occlusion| seen.errors(occlusion).rmse);
            println!(
                "{name}, {:?}, {:?}: {errors}; to the closed form {rmse:.4?}",
                settings.advanced.kernel, settings.resolution
            );
            assert!(errors.rmse <= largest && rmse[0] <= 1.02 * rmse[1]);
        }
    }
}

/// Projections may be mirrored, as for planar mirrors.
#[test]
fn projections_may_mirror() {
    let gpu = OcclusionGpu::new();
    let seen = corner().seen();
    let rows = || seen.image.depth.chunks(SIZE.x as usize);
    let flip_x = |row: &[f32]| row.iter().rev().copied().collect::<Vec<_>>();
    let mirrored: [(Vec<f32>, _); 2] = [
        (rows().flat_map(flip_x).collect(), Vec3::new(-1.0, 1.0, 1.0)),
        (
            rows().rev().flatten().copied().collect(),
            Vec3::new(1.0, -1.0, 1.0),
        ),
    ];
    let usual = seen.errors(
        &run(
            &gpu,
            &LeanScreenSpaceAmbientOcclusion::default(),
            &seen.image,
        )
        .filtered,
    );
    for (depth, scale) in mirrored {
        let matrix = Mat4::from_scale(scale) * seen.image.clip_from_view;
        let image = DepthImage::new(depth, SIZE, matrix);
        let occlusion = run(&gpu, &LeanScreenSpaceAmbientOcclusion::default(), &image).filtered;
        let rows = occlusion.chunks(SIZE.x as usize);
        let occlusion: Vec<f32> = if scale.x < 0.0 {
            rows.flat_map(flip_x).collect()
        } else {
            rows.rev().flatten().copied().collect()
        };
        let errors = seen.errors(&occlusion);
        println!("mirrored by {scale}: {errors}; as it is: {usual}");
        assert!((errors.rmse - usual.rmse).abs() <= 0.02 * usual.rmse);
    }
}
