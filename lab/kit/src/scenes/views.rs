//! Cameras: projections, viewports, clearing, prepasses and post-processing.

use bevy::{
    anti_alias::{fxaa::Fxaa, smaa::Smaa, taa::TemporalAntiAliasing},
    camera::{CameraProjection, ClearColorConfig, ScalingMode, SubCameraView, Viewport},
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass},
    material::OpaqueRendererMethod,
    math::Vec3A,
    post_process::{
        bloom::Bloom,
        dof::{DepthOfField, DepthOfFieldMode},
    },
    prelude::*,
    render::{occlusion_culling::OcclusionCulling, view::NoIndirectDrawing},
};

use super::{
    Scene, SceneBuilder,
    build::{ambient, default_camera_transform, material},
};

pub const SCENES: &[Scene] = &[
    Scene::new("orthographic", |s| {
        scene(s);
        s.default_camera(Projection::Orthographic(OrthographicProjection {
            scaling_mode: ScalingMode::FixedVertical {
                viewport_height: 5.0,
            },
            ..OrthographicProjection::default_3d()
        }));
    }),
    // Jitter shears the projection.
    Scene::new("orthographic_taa", |s| {
        scene(s);
        let projection = Projection::Orthographic(OrthographicProjection {
            scaling_mode: ScalingMode::FixedVertical {
                viewport_height: 5.0,
            },
            ..OrthographicProjection::default_3d()
        });
        s.default_camera((projection, TemporalAntiAliasing::default()));
    })
    .allow(
        44.0,
        "TAA bounds colours by those around them, also by what is off",
    )
    .nightly(),
    Scene::new("off_center_projection", |s| {
        scene(s);
        s.default_camera(Projection::custom(OffCenter(
            PerspectiveProjection::default(),
        )));
    }),
    Scene::new("sub_camera_view", |s| {
        scene(s);
        s.default_camera(Camera {
            sub_camera_view: Some(SubCameraView {
                full_size: UVec2::new(640, 480),
                offset: Vec2::new(200.0, 130.0),
                size: UVec2::new(320, 240),
            }),
            ..default()
        });
    }),
    Scene::new("viewport", |s| {
        scene(s);
        s.default_camera(view(0, UVec2::new(37, 21), UVec2::new(201, 155)));
    }),
    Scene::new("viewport_with_prepass", |s| {
        scene(s);
        s.default_camera((
            view(0, UVec2::new(37, 21), UVec2::new(201, 155)),
            DepthPrepass,
        ));
    })
    .nightly(),
    Scene::new("split_screen", |s| {
        scene(s);
        s.default_camera(view(0, UVec2::ZERO, UVec2::new(159, 240)));
        s.camera(
            Transform::from_xyz(3.0, 1.5, 3.0).looking_at(Vec3::Y * 0.5, Vec3::Y),
            view(1, UVec2::new(159, 0), UVec2::new(161, 240)),
        );
    })
    .nightly(),
    Scene::new("clear_custom", |s| {
        scene(s);
        s.default_camera(Camera {
            clear_color: ClearColorConfig::Custom(Color::srgb(0.9, 0.5, 0.2)),
            ..default()
        });
    }),
    Scene::new("clear_none_over_another_camera", |s| {
        scene(s);
        s.default_camera(());
        s.camera(
            Transform::from_xyz(3.0, 1.5, 3.0).looking_at(Vec3::Y * 0.5, Vec3::Y),
            Camera {
                order: 1,
                clear_color: ClearColorConfig::None,
                ..default()
            },
        );
    }),
    Scene::new("viewport_clear_none", |s| {
        scene(s);
        s.default_camera(());
        s.camera(
            Transform::from_xyz(3.0, 1.5, 3.0).looking_at(Vec3::Y * 0.5, Vec3::Y),
            Camera {
                clear_color: ClearColorConfig::None,
                ..view(1, UVec2::new(11, 13), UVec2::new(101, 91))
            },
        );
    })
    .nightly(),
    Scene::new("near_plane_0_001", |s| {
        scene(s);
        s.mesh(
            Sphere::new(0.004),
            material((0.2, 0.8, 0.3), 0.0, 0.5),
            Transform::from_translation(
                default_camera_transform().transform_point(Vec3::new(0.004, 0.002, -0.02)),
            ),
        );
        s.default_camera(Projection::Perspective(PerspectiveProjection {
            near: 0.001,
            ..default()
        }));
    }),
    Scene::new("one_metre_to_one_kilometre", |s| {
        s.mesh(
            Plane3d::default().mesh().size(3000.0, 3000.0),
            material((0.5, 0.5, 0.45), 0.0, 0.8),
            Transform::default(),
        );
        for i in 0..8 {
            let distance = 2.0f32.powf(i as f32 * 1.4);
            s.mesh(
                Cuboid::from_length(distance * 0.2),
                material((0.8, 0.1 * i as f32, 0.2), 0.0, 0.5),
                Transform::from_xyz(
                    distance * (0.15 * i as f32 - 0.5),
                    distance * 0.1,
                    -distance,
                ),
            );
        }
        s.sun(true);
        s.camera(
            Transform::from_xyz(0.0, 0.6, 0.5).looking_to(Vec3::NEG_Z, Vec3::Y),
            (
                ambient(),
                Projection::Perspective(PerspectiveProjection {
                    far: 2000.0,
                    ..default()
                }),
            ),
        );
    }),
    // The camera of a planar mirror.
    Scene::new("invert_culling", |s| {
        scene(s);
        s.camera(
            default_camera_transform(),
            (
                Camera {
                    invert_culling: true,
                    ..default()
                },
                Projection::custom(Mirrored(PerspectiveProjection::default())),
            ),
        );
    }),
    Scene::new("bloom", |s| {
        scene(s);
        s.mesh(
            Sphere::new(0.3),
            StandardMaterial {
                emissive: LinearRgba::rgb(20.0, 8.0, 2.0),
                ..default()
            },
            Transform::from_xyz(0.0, 1.6, 0.0),
        );
        s.default_camera(Bloom::NATURAL);
    }),
    Scene::new("depth_of_field_gaussian", |s| {
        scene(s);
        s.default_camera(depth_of_field(DepthOfFieldMode::Gaussian));
    })
    .nightly(),
    Scene::new("depth_of_field_bokeh", |s| {
        scene(s);
        s.default_camera(depth_of_field(DepthOfFieldMode::Bokeh));
    }),
    Scene::new("fxaa", |s| {
        scene(s);
        s.default_camera(Fxaa::default());
    }),
    Scene::new("smaa", |s| {
        scene(s);
        s.default_camera(Smaa::default());
    })
    .nightly(),
    Scene::new("taa", |s| {
        scene(s);
        s.default_camera(TemporalAntiAliasing::default());
    }),
    Scene::new("gizmos", |s| {
        scene(s);
        s.default_camera(());
        s.headless.app.add_systems(Update, |mut gizmos: Gizmos| {
            gizmos.sphere(Vec3::new(-0.7, 0.6, -0.8), 0.8, Color::srgb(1.0, 1.0, 0.0));
            gizmos.line(
                Vec3::new(-3.0, 0.2, -1.0),
                Vec3::new(3.0, 1.2, 1.0),
                Color::WHITE,
            );
        });
    }),
    Scene::new("depth_prepass", |s| {
        scene(s);
        forward_ball(s);
        s.default_camera(DepthPrepass);
    })
    .nightly(),
    Scene::new("normal_prepass", |s| {
        scene(s);
        forward_ball(s);
        s.default_camera(NormalPrepass);
    })
    .nightly(),
    Scene::new("motion_vector_prepass", |s| {
        scene(s);
        forward_ball(s);
        s.default_camera(MotionVectorPrepass);
    })
    .nightly(),
    Scene::new("all_prepasses", |s| {
        scene(s);
        forward_ball(s);
        s.default_camera((DepthPrepass, NormalPrepass, MotionVectorPrepass));
    }),
    Scene::new("occlusion_culling", |s| {
        scene(s);
        forward_ball(s);
        for i in 0..20 {
            s.mesh(
                Sphere::new(0.2),
                material((0.9, 0.9, 0.2), 0.0, 0.5),
                Transform::from_xyz(i as f32 * 0.3 - 3.0, 0.2, -2.5),
            );
        }
        s.default_camera((DepthPrepass, OcclusionCulling));
    }),
    Scene::new("no_indirect_drawing", |s| {
        scene(s);
        forward_ball(s);
        s.default_camera(NoIndirectDrawing);
    })
    .nightly(),
    Scene::new("no_indirect_drawing_with_prepass", |s| {
        scene(s);
        forward_ball(s);
        s.default_camera((NoIndirectDrawing, DepthPrepass));
    }),
    // Not `Atmosphere`: llvmpipe (Mesa's software Vulkan) crashes on it, with any renderer.
];

fn scene(s: &mut SceneBuilder) {
    s.solids();
    s.sun(true);
}

/// An emissive ball in Bevy's forward pass, among the lean solids.
fn forward_ball(s: &mut SceneBuilder) {
    s.mesh(
        Sphere::new(0.6),
        StandardMaterial {
            emissive: LinearRgba::rgb(0.3, 0.1, 0.3),
            opaque_render_method: OpaqueRendererMethod::Forward,
            ..material((0.5, 0.2, 0.6), 0.0, 0.5)
        },
        Transform::from_xyz(-0.2, 0.6, 0.3),
    );
}

fn view(order: isize, physical_position: UVec2, physical_size: UVec2) -> Camera {
    Camera {
        order,
        viewport: Some(Viewport {
            physical_position,
            physical_size,
            ..default()
        }),
        ..default()
    }
}

fn depth_of_field(mode: DepthOfFieldMode) -> DepthOfField {
    DepthOfField {
        mode,
        focal_distance: 4.0,
        aperture_f_stops: 0.02,
        max_depth: 20.0,
        ..default()
    }
}

/// A perspective projection followed by `matrix`.
macro_rules! changed_perspective {
    ($(#[$doc:meta])* $name:ident, $matrix:expr) => {
        $(#[$doc])*
        #[derive(Clone, Debug)]
        struct $name(PerspectiveProjection);

        impl CameraProjection for $name {
            fn get_clip_from_view(&self) -> Mat4 {
                $matrix * self.0.get_clip_from_view()
            }

            fn get_clip_from_view_for_sub(&self, sub_view: &SubCameraView) -> Mat4 {
                $matrix * self.0.get_clip_from_view_for_sub(sub_view)
            }

            fn update(&mut self, width: f32, height: f32) {
                self.0.update(width, height);
            }

            fn far(&self) -> f32 {
                self.0.far()
            }

            fn get_frustum_corners(&self, z_near: f32, z_far: f32) -> [Vec3A; 8] {
                self.0.get_frustum_corners(z_near, z_far)
            }
        }
    };
}

changed_perspective! {
    /// The view axis meets the picture right of and below the middle.
    OffCenter,
    Mat4::from_translation(Vec3::new(0.3, -0.2, 0.0))
}

changed_perspective! {
    /// Mirrored left to right.
    Mirrored,
    Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0))
}
