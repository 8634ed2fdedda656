//! A crate of others each: its plugins, and something that it draws.

use bevy::prelude::*;
use kit::scenes::SceneBuilder;

pub struct Tried {
    /// Name of the feature.
    pub name: &'static str,
    /// Package whose version counts.
    pub package: &'static str,
    pub shows: &'static str,
    /// Advice for apps, in Markdown.
    pub to_do: &'static str,
    pub plugins: fn(&mut App),
    /// Inserts the components that cameras need.
    pub camera: fn(&mut EntityWorldMut),
    pub spawn: fn(&mut SceneBuilder),
}

impl Tried {
    const fn new(package: &'static str, shows: &'static str) -> Self {
        Self {
            name: package,
            package,
            shows,
            to_do: "nothing",
            plugins: |_| {},
            camera: |_| {},
            spawn: |_| {},
        }
    }
}

/// The crates whose features are on.
pub fn all() -> Vec<Tried> {
    vec![
        #[cfg(feature = "avian3d")]
        avian(),
        #[cfg(feature = "bevy_dev_tools")]
        grid(),
        #[cfg(feature = "bevy_egui")]
        egui(),
        #[cfg(feature = "bevy_firework")]
        firework(),
        #[cfg(feature = "bevy_hanabi")]
        hanabi(),
        #[cfg(feature = "bevy_mod_outline")]
        outline(),
        #[cfg(feature = "bevy_rich_text3d")]
        text(),
        #[cfg(feature = "bevy_sprite3d")]
        sprite(),
        #[cfg(feature = "bevy_vector_shapes")]
        shapes(),
        #[cfg(feature = "bevy_voxel_world")]
        voxels::stairs(),
        #[cfg(feature = "bevy_water")]
        water(),
        #[cfg(feature = "wireframe")]
        wireframe(),
    ]
}

/// Bevy's own, which draws lines.
#[cfg(feature = "wireframe")]
fn wireframe() -> Tried {
    use bevy::pbr::wireframe::{Wireframe, WireframePlugin};

    Tried {
        name: "wireframe",
        plugins: |app| {
            app.add_plugins(WireframePlugin::default());
        },
        spawn: |scene| {
            let ball = scene.mesh(Sphere::new(0.8), Color::WHITE, above());
            scene.world().entity_mut(ball).insert(Wireframe);
        },
        ..Tried::new("bevy", "the lines of a sphere (`WireframePlugin`)")
    }
}

/// The debug drawing of colliders.
#[cfg(feature = "avian3d")]
fn avian() -> Tried {
    use avian3d::prelude::*;

    Tried {
        plugins: |app| {
            app.add_plugins((PhysicsPlugins::default(), PhysicsDebugPlugin));
        },
        spawn: |scene| {
            scene.spawn((RigidBody::Static, Collider::sphere(0.8), above()));
        },
        ..Tried::new("avian3d", "the outline of a collider")
    }
}

/// The infinite grid.
#[cfg(feature = "bevy_dev_tools")]
fn grid() -> Tried {
    use bevy_dev_tools::infinite_grid::{InfiniteGrid, InfiniteGridPlugin};

    Tried {
        plugins: |app| {
            app.add_plugins(InfiniteGridPlugin);
        },
        spawn: |scene| {
            scene.spawn((InfiniteGrid, Transform::from_xyz(0.0, 0.3, 0.0)));
        },
        ..Tried::new("bevy_dev_tools", "`InfiniteGrid`")
    }
}

#[cfg(feature = "bevy_egui")]
fn egui() -> Tried {
    use bevy_egui::{EguiContexts, EguiGlobalSettings, EguiPlugin, EguiPrimaryContextPass, egui};

    fn window(mut contexts: EguiContexts) -> Result {
        egui::Window::new("egui").show(contexts.ctx_mut()?, |ui| ui.label("a window"));
        Ok(())
    }
    Tried {
        camera: |camera| {
            camera.insert(bevy_egui::PrimaryEguiContext);
        },
        plugins: |app| {
            app.add_plugins(EguiPlugin::default())
                .insert_resource(EguiGlobalSettings {
                    auto_create_primary_context: false,
                    ..default()
                })
                .add_systems(EguiPrimaryContextPass, window);
        },
        ..Tried::new("bevy_egui", "a window")
    }
}

#[cfg(feature = "bevy_firework")]
fn firework() -> Tried {
    use bevy_firework::{
        core::{EmissionPacing, EmissionSettings, ParticleSettings, ParticleSpawner},
        curve::FireworkGradient,
        emission_shape::EmissionShape,
        plugin::ParticleSystemPlugin,
    };
    use bevy_utilitarian::prelude::{RandF32, RandValue};

    Tried {
        camera: |camera| {
            camera.insert(bevy::core_pipeline::prepass::DepthPrepass);
        },
        plugins: |app| {
            app.add_plugins(ParticleSystemPlugin::default());
        },
        spawn: |scene| {
            scene.spawn((
                ParticleSpawner {
                    particle_settings: vec![ParticleSettings {
                        initial_scale: RandF32::constant(0.2),
                        acceleration: Vec3::ZERO,
                        base_color: FireworkGradient::constant(LinearRgba::rgb(0.1, 0.02, 0.02)),
                        pbr: true,
                        ..default()
                    }],
                    emission_settings: vec![EmissionSettings {
                        emission_pacing: EmissionPacing::rate(60.0),
                        emission_shape: EmissionShape::Sphere(0.8),
                        ..default()
                    }],
                    ..default()
                },
                above(),
            ));
        },
        ..Tried::new("bevy_firework", "lit particles")
    }
}

#[cfg(feature = "bevy_hanabi")]
fn hanabi() -> Tried {
    use bevy_hanabi::prelude::*;

    Tried {
        plugins: |app| {
            app.add_plugins(HanabiPlugin);
        },
        spawn: |scene| {
            let writer = ExprWriter::new();
            let position = SetPositionSphereModifier {
                center: writer.lit(Vec3::ZERO).expr(),
                radius: writer.lit(0.8).expr(),
                dimension: ShapeDimension::Volume,
            };
            let age = SetAttributeModifier::new(Attribute::AGE, writer.lit(0.0).expr());
            let lifetime = SetAttributeModifier::new(Attribute::LIFETIME, writer.lit(60.0).expr());
            let effect =
                EffectAsset::new(256, SpawnerSettings::rate(200.0.into()), writer.finish())
                    .init(position)
                    .init(age)
                    .init(lifetime)
                    .render(SizeOverLifetimeModifier {
                        gradient: bevy_hanabi::Gradient::constant(Vec3::splat(0.08)),
                        screen_space_size: false,
                    });
            let effect = scene.add::<EffectAsset>(effect);
            scene.spawn((ParticleEffect::new(effect), above()));
        },
        ..Tried::new("bevy_hanabi", "particles of the GPU")
    }
}

#[cfg(feature = "bevy_mod_outline")]
fn outline() -> Tried {
    use bevy_mod_outline::{OutlinePlugin, OutlineVolume};

    Tried {
        to_do: "[spawn cameras with `Hdr` and `Msaa::Off`](limits.md#cameras)",
        plugins: |app| {
            app.add_plugins(OutlinePlugin::EXTRUDE_VERTEX);
        },
        spawn: |scene| {
            let ball = scene.mesh(Sphere::new(0.8), Color::WHITE, above());
            scene.world().entity_mut(ball).insert(OutlineVolume {
                visible: true,
                width: 5.0,
                colour: Color::srgb(1.0, 0.5, 0.0),
            });
        },
        ..Tried::new("bevy_mod_outline", "the outline of a sphere")
    }
}

#[cfg(feature = "bevy_rich_text3d")]
fn text() -> Tried {
    use bevy_rich_text3d::{Text3d, Text3dPlugin, Text3dStyling, TextAtlas};

    Tried {
        plugins: |app| {
            app.add_plugins(Text3dPlugin {
                load_system_fonts: true,
                ..default()
            });
        },
        spawn: |scene| {
            let material = scene.add::<StandardMaterial>(StandardMaterial {
                base_color_texture: Some(TextAtlas::DEFAULT_IMAGE),
                alpha_mode: AlphaMode::Mask(0.5),
                cull_mode: None,
                ..default()
            });
            scene.spawn((
                Text3d::new("Text in 3D"),
                Text3dStyling {
                    world_scale: Some(Vec2::splat(0.6)),
                    ..default()
                },
                Mesh3d::default(),
                MeshMaterial3d(material),
                above(),
            ));
        },
        ..Tried::new("bevy_rich_text3d", "a line of text")
    }
}

#[cfg(feature = "bevy_sprite3d")]
fn sprite() -> Tried {
    use bevy_sprite3d::prelude::*;

    Tried {
        plugins: |app| {
            app.add_plugins(Sprite3dPlugin);
        },
        spawn: |scene| {
            let image = scene.checker([255, 80, 20, 255], [20, 80, 255, 255]);
            scene.spawn((
                Sprite3d {
                    pixels_per_metre: 64.0,
                    alpha_mode: AlphaMode::Mask(0.5),
                    ..default()
                },
                Sprite { image, ..default() },
                above(),
            ));
        },
        ..Tried::new("bevy_sprite3d", "an image that stands in the scene")
    }
}

#[cfg(feature = "bevy_vector_shapes")]
fn shapes() -> Tried {
    use bevy_vector_shapes::prelude::*;

    fn draw(mut painter: ShapePainter) {
        painter.transform = above();
        painter.color = Color::srgb(1.0, 0.5, 0.0);
        painter.hollow = true;
        painter.circle(0.8);
    }
    Tried {
        plugins: |app| {
            app.add_plugins(ShapePlugin::default())
                .add_systems(Update, draw);
        },
        ..Tried::new("bevy_vector_shapes", "a ring")
    }
}

#[cfg(feature = "bevy_voxel_world")]
mod voxels {
    use bevy_voxel_world::prelude::*;

    use super::*;

    /// Voxels in three steps, below the floor's edge.
    #[derive(Resource, Clone, Default)]
    pub struct Stairs;

    impl VoxelWorldConfig for Stairs {
        type MaterialIndex = u8;
        type ChunkUserBundle = ();

        fn spawning_distance(&self) -> u32 {
            2
        }

        fn voxel_lookup_delegate(&self) -> VoxelLookupDelegate<u8> {
            Box::new(|_, _, _| {
                Box::new(|at, _| match at.y < 3 && at.z < -3 - at.y && at.z > -8 {
                    true => WorldVoxel::Solid(0),
                    false => WorldVoxel::Air,
                })
            })
        }
    }

    pub fn stairs() -> Tried {
        Tried {
            camera: |camera| {
                camera.insert(VoxelWorldCamera::<Stairs>::default());
            },
            plugins: |app| {
                app.add_plugins(VoxelWorldPlugin::with_config(Stairs));
            },
            ..Tried::new("bevy_voxel_world", "three steps of voxels")
        }
    }
}

#[cfg(feature = "bevy_water")]
fn water() -> Tried {
    use bevy_water::{WaterPlugin, WaterQuality, WaterSettings};

    Tried {
        camera: |camera| {
            camera.insert(bevy::core_pipeline::prepass::DepthPrepass);
        },
        plugins: |app| {
            app.insert_resource(WaterSettings {
                height: 0.3,
                amplitude: 0.2,
                water_quality: WaterQuality::High,
                spawn_tiles: Some(UVec2::new(2, 2)),
                ..default()
            })
            .add_plugins(WaterPlugin);
        },
        ..Tried::new("bevy_water", "waves")
    }
}

/// Above the solids.
fn above() -> Transform {
    Transform::from_xyz(0.0, 1.8, 0.0)
}
