use bevy::{
    asset::RenderAssetUsages,
    camera::{Exposure, Hdr},
    core_pipeline::tonemapping::Tonemapping,
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    light::{
        AmbientLight, ClusteredDecal, EnvironmentMapLight, IrradianceVolume, LightProbe, RectLight,
    },
    prelude::*,
    render::render_resource::{
        Extent3d, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
    },
};

use crate::headless::Headless;

/// Spawns the parts of a scene.
pub struct SceneBuilder<'a> {
    pub headless: &'a mut Headless,
}

impl SceneBuilder<'_> {
    pub fn world(&mut self) -> &mut World {
        self.headless.world()
    }

    pub fn add<A: Asset>(&mut self, asset: impl Into<A>) -> Handle<A> {
        self.world().resource_mut::<Assets<A>>().add(asset.into())
    }

    pub fn spawn(&mut self, bundle: impl Bundle) -> Entity {
        self.world().spawn(bundle).id()
    }

    /// Spawns a camera on the app's target with HDR and without MSAA, as `LeanDeferred` needs it, so that forward is comparable.
    pub fn camera(&mut self, transform: Transform, extra: impl Bundle) -> Entity {
        let target = self.headless.render_target();
        self.world()
            .spawn((
                Camera3d::default(),
                Hdr,
                Msaa::Off,
                target,
                Tonemapping::Reinhard,
                transform,
                extra,
            ))
            .id()
    }

    /// Spawns the usual camera, above and in front of the scene.
    pub fn default_camera(&mut self, extra: impl Bundle) -> Entity {
        self.camera(default_camera_transform(), extra)
    }

    pub fn mesh(
        &mut self,
        mesh: impl Into<Mesh>,
        material: impl Into<StandardMaterial>,
        transform: Transform,
    ) -> Entity {
        let mesh = self.add::<Mesh>(mesh);
        let material = self.add::<StandardMaterial>(material);
        self.spawn((Mesh3d(mesh), MeshMaterial3d(material), transform))
    }

    pub fn floor(&mut self) -> Entity {
        self.mesh(
            Plane3d::default().mesh().size(12.0, 12.0),
            StandardMaterial {
                base_color: Color::srgb(0.55, 0.5, 0.45),
                perceptual_roughness: 0.7,
                ..default()
            },
            Transform::default(),
        )
    }

    /// A floor and five solids, from rough dielectric to smooth metal.
    pub fn solids(&mut self) {
        self.floor();
        let ball = Sphere::new(0.6).mesh().uv(48, 24);
        self.mesh(
            ball.clone(),
            material((0.8, 0.2, 0.15), 0.0, 0.4),
            Transform::from_xyz(-2.2, 0.6, 0.4),
        );
        self.mesh(
            Cuboid::new(1.0, 1.2, 1.0),
            material((0.2, 0.5, 0.8), 0.0, 0.8),
            Transform::from_xyz(-0.7, 0.6, -0.8).with_rotation(Quat::from_rotation_y(0.5)),
        );
        self.mesh(
            Torus::new(0.25, 0.6),
            material((0.9, 0.75, 0.3), 1.0, 0.3),
            Transform::from_xyz(0.7, 0.6, 0.7).with_rotation(Quat::from_rotation_x(1.1)),
        );
        self.mesh(
            Capsule3d::new(0.4, 0.8),
            material((0.3, 0.7, 0.35), 0.3, 0.5),
            Transform::from_xyz(2.0, 0.8, -0.4),
        );
        self.mesh(
            Cylinder::new(0.5, 1.0),
            material((0.95, 0.95, 0.95), 1.0, 0.15),
            Transform::from_xyz(0.8, 0.5, -1.9),
        );
    }

    /// A floor with a ball, a box and a slanted card of one material, with tangents if it uses them.
    pub fn samples(&mut self, material: StandardMaterial) {
        self.floor();
        let needs_tangents = material.normal_map_texture.is_some() || material.depth_map.is_some();
        let material = self.add::<StandardMaterial>(material);
        for (mut mesh, transform) in [
            (
                Sphere::new(0.8).mesh().uv(48, 24),
                Transform::from_xyz(-1.7, 0.8, 0.3),
            ),
            (
                Cuboid::from_length(1.2).into(),
                Transform::from_xyz(0.1, 0.6, -0.5).with_rotation(Quat::from_rotation_y(0.5)),
            ),
            (
                Rectangle::new(1.6, 1.6).into(),
                Transform::from_xyz(1.8, 0.8, 0.5).with_rotation(Quat::from_euler(
                    EulerRot::YXZ,
                    -0.5,
                    -0.3,
                    0.2,
                )),
            ),
        ] {
            if needs_tangents {
                mesh.generate_tangents()
                    .expect("these meshes have all that tangents need");
            }
            let mesh = self.add::<Mesh>(mesh);
            self.spawn((Mesh3d(mesh), MeshMaterial3d(material.clone()), transform));
        }
    }

    /// A floor with balls of `subject` that lean solids intersect, occlude and are occluded by.
    pub fn among_lean(&mut self, subject: StandardMaterial) {
        self.floor();
        let clay = material((0.2, 0.5, 0.8), 0.0, 0.6);
        for (size, position) in [
            (Vec3::new(6.0, 1.4, 0.3), Vec3::new(0.0, 0.7, -1.6)),
            (Vec3::new(0.25, 1.6, 0.25), Vec3::new(-1.2, 0.8, 1.6)),
            (Vec3::new(1.0, 1.0, 1.0), Vec3::new(0.5, 0.5, 0.6)),
            (Vec3::new(3.6, 0.3, 0.3), Vec3::new(0.2, 0.6, 0.2)),
        ] {
            self.mesh(
                Cuboid::from_size(size),
                clay.clone(),
                Transform::from_translation(position),
            );
        }
        let ball = Sphere::new(0.7)
            .mesh()
            .uv(48, 24)
            .with_generated_tangents()
            .expect("a sphere has all that tangents need");
        for x in [-1.4, 0.3, 1.9] {
            self.mesh(
                ball.clone(),
                subject.clone(),
                Transform::from_xyz(x, 0.7, 0.2),
            );
        }
    }

    pub fn sun(&mut self, shadow_maps_enabled: bool) -> Entity {
        self.spawn((
            DirectionalLight {
                illuminance: 6_000.0,
                shadow_maps_enabled,
                ..default()
            },
            Transform::from_xyz(2.0, 4.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
        ))
    }

    /// An image of `size` × `size` texels from a function of u and v from 0 to 1.
    pub fn image(
        &mut self,
        size: u32,
        format: TextureFormat,
        texel: impl Fn(f32, f32) -> [u8; 4],
    ) -> Handle<Image> {
        let data = (0..size * size)
            .flat_map(|i| {
                let (x, y) = (i % size, i / size);
                texel(
                    (x as f32 + 0.5) / size as f32,
                    (y as f32 + 0.5) / size as f32,
                )
            })
            .collect();
        self.add(Image::new(
            Extent3d {
                width: size,
                height: size,
                depth_or_array_layers: 1,
            },
            TextureDimension::D2,
            data,
            format,
            RenderAssetUsages::default(),
        ))
    }

    /// As [`image`](Self::image), tiled outside 0 to 1.
    pub fn tiled_image(
        &mut self,
        size: u32,
        format: TextureFormat,
        texel: impl Fn(f32, f32) -> [u8; 4],
    ) -> Handle<Image> {
        let handle = self.image(size, format, texel);
        let mut images = self.world().resource_mut::<Assets<Image>>();
        images.get_mut(&handle).expect("just added").sampler =
            ImageSampler::Descriptor(ImageSamplerDescriptor {
                address_mode_u: ImageAddressMode::Repeat,
                address_mode_v: ImageAddressMode::Repeat,
                ..ImageSamplerDescriptor::linear()
            });
        handle
    }

    /// An 8 × 8 checkerboard of two colours, tiled.
    pub fn checker(&mut self, even: [u8; 4], odd: [u8; 4]) -> Handle<Image> {
        self.tiled_image(64, TextureFormat::Rgba8UnormSrgb, |u, v| {
            if ((u * 8.0) as u32 + (v * 8.0) as u32).is_multiple_of(2) {
                even
            } else {
                odd
            }
        })
    }

    /// A tangent-space normal map of 8 × 8 round bumps.
    pub fn bumps(&mut self) -> Handle<Image> {
        self.tiled_image(128, TextureFormat::Rgba8Unorm, |u, v| {
            let slope = |x: f32| (x * 8.0 * std::f32::consts::TAU).sin() * 0.5;
            let normal = Vec3::new(slope(u), slope(v), 1.0).normalize() * 127.5 + 127.5;
            [normal.x as u8, normal.y as u8, normal.z as u8, 255]
        })
    }

    /// A cube map with one colour per face, brighter upwards. Each mip level halves their difference from grey.
    pub fn cube_map(&mut self) -> Handle<Image> {
        const FACES: [[f32; 3]; 6] = [
            [0.9, 0.5, 0.4],
            [0.4, 0.6, 0.9],
            [0.9, 0.9, 1.0],
            [0.2, 0.2, 0.15],
            [0.5, 0.9, 0.5],
            [0.8, 0.7, 0.4],
        ];
        const GREY: [f32; 3] = [0.6, 0.6, 0.58];
        let size = 8u32;
        let levels = size.ilog2() + 1;
        let mut data = Vec::new();
        for face in FACES {
            for level in 0..levels {
                let size = size >> level;
                let contrast = 0.5f32.powi(level as i32);
                for i in 0..size * size {
                    let shade = 0.7 + 0.3 * (i / size) as f32 / size as f32;
                    let channel = |i: usize| GREY[i] + (face[i] - GREY[i]) * contrast;
                    data.extend([0, 1, 2].map(|i| (channel(i) * shade * 255.0) as u8));
                    data.push(255);
                }
            }
        }
        let mut image = Image::new_uninit(
            Extent3d {
                width: size,
                height: size,
                depth_or_array_layers: 6,
            },
            TextureDimension::D2,
            TextureFormat::Rgba8Unorm,
            RenderAssetUsages::default(),
        );
        image.data = Some(data);
        image.texture_descriptor.mip_level_count = levels;
        image.texture_view_descriptor = Some(TextureViewDescriptor {
            dimension: Some(TextureViewDimension::Cube),
            ..default()
        });
        self.add(image)
    }

    /// Light of [`cube_map`](Self::cube_map), for a camera or a probe.
    pub fn environment_map(&mut self, intensity: f32) -> EnvironmentMapLight {
        let map = self.cube_map();
        EnvironmentMapLight {
            diffuse_map: map.clone(),
            specular_map: map,
            intensity,
            ..default()
        }
    }

    /// Light of [`irradiance_voxels`](Self::irradiance_voxels), for a probe.
    pub fn irradiance_volume(&mut self, intensity: f32) -> IrradianceVolume {
        IrradianceVolume {
            voxels: self.irradiance_voxels(),
            intensity,
            ..default()
        }
    }

    /// Spawns a light probe over the whole scene.
    pub fn probe(&mut self, light: impl Bundle) {
        self.spawn((
            LightProbe::default(),
            light,
            Transform::from_scale(Vec3::splat(9.0)),
        ));
    }

    /// Spawns 64 lamps of three kinds, most of which reach only a part of the scene. A few cast shadows.
    pub fn lamps(&mut self) {
        for index in 0..64u32 {
            let at = |factor: u32| (index * factor % 64) as f32 / 63.0;
            let place = Vec3::new(6.0 * at(29) - 3.0, 0.3 + 1.6 * at(13), 4.0 * at(51) - 2.5);
            let color = Color::srgb(0.4 + 0.6 * at(5), 0.4 + 0.6 * at(11), 0.5 + 0.5 * at(7));
            let shadow_maps_enabled = index.is_multiple_of(31);
            let range = 0.8 + 2.0 * at(17);
            if index % 3 == 0 {
                self.spawn((
                    SpotLight {
                        color,
                        intensity: 2_000.0,
                        range: 1.5 * range,
                        outer_angle: 0.3 + 0.6 * at(23),
                        inner_angle: 0.1,
                        shadow_maps_enabled,
                        ..default()
                    },
                    Transform::from_translation(place)
                        .looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y),
                ));
            } else {
                self.spawn((
                    PointLight {
                        color,
                        intensity: 700.0,
                        range,
                        radius: if index % 3 == 1 { 0.0 } else { 0.15 },
                        shadow_maps_enabled,
                        ..default()
                    },
                    Transform::from_translation(place),
                ));
            }
        }
    }

    /// Spawns a rectangle light that faces the middle of the scene from above and in front.
    pub fn rect_light(&mut self) {
        self.spawn((
            RectLight {
                intensity: 40_000.0,
                width: 2.0,
                height: 1.0,
                ..default()
            },
            Transform::from_xyz(0.0, 2.5, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
        ));
    }

    /// Spawns a checkerboard decal, slanted over the middle of the scene.
    pub fn decal(&mut self, scale: Vec3) -> Entity {
        let checker = self.checker([240, 60, 40, 255], [40, 60, 240, 90]);
        self.spawn((
            ClusteredDecal {
                base_color_texture: Some(checker),
                ..default()
            },
            Transform::from_xyz(0.0, 0.5, 0.5)
                .with_rotation(Quat::from_rotation_x(-1.2))
                .with_scale(scale),
        ))
    }

    /// A 2 × 2 × 2 irradiance volume, in the layout that Bevy reads (six faces stacked two by three).
    pub fn irradiance_voxels(&mut self) -> Handle<Image> {
        let (width, height, depth) = (2u32, 4u32, 6u32);
        let data: Vec<u8> = (0..width * height * depth)
            .flat_map(|i| {
                let shade = |k: u32| (60 + (i * k) % 180) as u8;
                [shade(37), shade(53), shade(71), 255]
            })
            .collect();
        self.add(Image::new(
            Extent3d {
                width,
                height,
                depth_or_array_layers: depth,
            },
            TextureDimension::D3,
            data,
            TextureFormat::Rgba8Unorm,
            RenderAssetUsages::default(),
        ))
    }
}

pub fn default_camera_transform() -> Transform {
    Transform::from_xyz(-1.5, 2.8, 5.2).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y)
}

/// Indoor exposure, at which hundreds of lumens or lux are visible.
pub fn indoor() -> Exposure {
    Exposure::INDOOR
}

pub fn material(srgb: (f32, f32, f32), metallic: f32, roughness: f32) -> StandardMaterial {
    StandardMaterial {
        base_color: Color::srgb(srgb.0, srgb.1, srgb.2),
        metallic,
        perceptual_roughness: roughness,
        ..default()
    }
}

/// Ambient light bright enough to tell surfaces in shadow apart.
pub fn ambient() -> AmbientLight {
    AmbientLight {
        brightness: 500.0,
        ..default()
    }
}
