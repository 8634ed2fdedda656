//! Changes to meshes, materials and lights.

use bevy::{
    asset::RenderAssetUsages,
    camera::visibility::{NoFrustumCulling, RenderLayers},
    light::{NotShadowCaster, NotShadowReceiver},
    material::OpaqueRendererMethod,
    mesh::{PrimitiveTopology, VertexAttributeValues},
    pbr::{Lightmap, material_uses_bindless_resources},
    prelude::*,
    render::render_resource::Face,
};
use bevy_lean_deferred::{material_extension::SubsurfaceAlbedo, prelude::*};
use kit::{
    random::Random,
    random_values::{Values, toggle, toggle_between},
};

use crate::stage::Stage;

const MOST_MESHES: usize = 16;
const MOST_LIGHTS: usize = 8;

/// Fields of materials that never change: loop counts, values that each compile another pipeline, and explicit `Deferred`, for which Bevy
/// 0.19.1 panics on cameras that have another prepass than `DeferredPrepass` (`queue_prepass_material_meshes`).
const KEPT: [&str; 5] = [
    "opaque_render_method",
    "max_parallax_layer_count",
    "parallax_mapping_method",
    "depth_bias",
    "deferred_lighting_pass_id",
];

fn one_of<T: Copy>(random: &mut Random, list: &[T]) -> Option<T> {
    (!list.is_empty()).then(|| list[random.below(list.len())])
}

/// Makes one change and returns its description.
pub fn change(stage: &mut Stage, random: &mut Random) -> String {
    match random.below(20) {
        0..3 => spawn_mesh(stage, random),
        3..5 => despawn_mesh(stage, random),
        5..8 => change_mesh(stage, random),
        8..10 => move_mesh(stage, random),
        10..14 => change_material(stage, random),
        14 => spawn_light(stage, random),
        15 => despawn_light(stage, random),
        _ => change_light(stage, random),
    }
}

fn transform(random: &mut Random) -> Transform {
    let mut axis = || random.range(-2.0, 2.0);
    let place = Vec3::new(axis(), axis().abs(), axis());
    let turn = Quat::from_rotation_y(axis());
    Transform::from_translation(place).with_rotation(turn)
}

/// A random shape, sometimes flawed on purpose, and its description.
fn mesh(random: &mut Random) -> (Mesh, String) {
    let (shape, flaw) = (random.below(5), random.below(12));
    let mut mesh: Mesh = match shape {
        0 => Cuboid::default().into(),
        1 => Sphere::new(0.6).mesh().uv(16, 8),
        2 => Plane3d::default().mesh().size(2.0, 2.0).into(),
        3 => Torus::default().into(),
        _ => Capsule3d::default().into(),
    };
    match flaw {
        0 => _ = mesh.remove_attribute(Mesh::ATTRIBUTE_NORMAL),
        1 => _ = mesh.remove_attribute(Mesh::ATTRIBUTE_UV_0),
        2 => _ = mesh.generate_tangents(),
        3 => {
            for name in [Mesh::ATTRIBUTE_NORMAL, Mesh::ATTRIBUTE_POSITION] {
                if let Some(VertexAttributeValues::Float32x3(values)) = mesh.attribute_mut(name) {
                    for value in values.iter_mut().step_by(7) {
                        *value = [f32::NAN; 3];
                    }
                }
            }
        }
        // Drivers place even larger ones differently: only their corners are exact.
        4 => mesh = mesh.scaled_by(Vec3::splat(1e4)),
        5 => {
            mesh = mesh.scaled_by(Vec3::new(1.0, 0.0, 1.0));
            // Otherwise some have no length, and forward's result for those depends on the driver.
            let normals = vec![[0.0, 1.0, 0.0]; mesh.count_vertices()];
            mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
        }
        6 => {
            let count = mesh.count_vertices();
            mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, vec![[0.5, 1.0, 0.2, 0.8]; count]);
        }
        7 => {
            mesh = Mesh::new(
                PrimitiveTopology::TriangleList,
                RenderAssetUsages::default(),
            )
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, Vec::<[f32; 3]>::new())
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, Vec::<[f32; 3]>::new())
        }
        // Lightmaps need these.
        8 | 9 => {
            if let Some(uvs) = mesh.attribute(Mesh::ATTRIBUTE_UV_0).cloned() {
                mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, uvs);
            }
        }
        _ => {}
    }
    (mesh, format!("shape {shape}, flaw {flaw}"))
}

fn values(images: &[Handle<Image>]) -> Values<'_> {
    Values {
        hostile: 12,
        images,
        kept: &KEPT,
    }
}

fn standard_material(stage: &Stage, random: &mut Random) -> StandardMaterial {
    let mut material = StandardMaterial::default();
    values(&stage.images).change(&mut material, random);
    if random.below(4) == 0 {
        material.cull_mode = [None, Some(Face::Front), Some(Face::Back)][random.below(3)];
    }
    if random.below(4) == 0 {
        material.alpha_mode = AlphaMode::Mask(random.unit());
    }
    if random.below(6) == 0 {
        material.opaque_render_method = OpaqueRendererMethod::Forward;
    }
    // With binding arrays Bevy 0.19.1 alone sometimes draws a new material with the values of a removed one. For these two the G-buffer
    // follows the app's values, so it would differ from forward.
    if material_uses_bindless_resources::<StandardMaterial>(stage.headless.device()) {
        material.specular_transmission = 0.0;
        material.diffuse_transmission = 0.0;
    }
    material
}

fn extension(random: &mut Random) -> ShadingExtension {
    let mut number = || {
        if random.below(12) == 0 {
            f32::NAN
        } else {
            random.unit()
        }
    };
    let color = Color::linear_rgb(number(), number(), number());
    match random.below(3) {
        0 => ShadingExtension::None,
        1 => ShadingExtension::Rim {
            color,
            exponent: random.range(0.0, 20.0),
        },
        _ => ShadingExtension::Subsurface {
            color,
            mean_free_path: random.unit().powi(4),
            albedo: [
                SubsurfaceAlbedo::AfterScattering,
                SubsurfaceAlbedo::BeforeScattering,
            ][random.below(2)],
        },
    }
}

fn set_material(stage: &mut Stage, entity: Entity, random: &mut Random) -> String {
    let base = standard_material(stage, random);
    let mut description = format!("{base:?}");
    if random.below(3) == 0 {
        let extension = extension(random);
        description = format!("{extension:?} of {description}");
        let material = ExtendedStandardMaterial { base, extension };
        let material = stage.builder().add::<ExtendedStandardMaterial>(material);
        let mut entity = stage.entity(entity);
        entity.remove::<MeshMaterial3d<StandardMaterial>>();
        entity.insert(MeshMaterial3d(material));
    } else {
        let material = stage.builder().add::<StandardMaterial>(base);
        let mut entity = stage.entity(entity);
        entity.remove::<MeshMaterial3d<ExtendedStandardMaterial>>();
        entity.insert(MeshMaterial3d(material));
    }
    description
}

fn spawn_mesh(stage: &mut Stage, random: &mut Random) -> String {
    if stage.meshes.len() >= MOST_MESHES {
        return despawn_mesh(stage, random);
    }
    let (mesh, what) = mesh(random);
    let mesh = stage.builder().add::<Mesh>(mesh);
    let entity = stage.builder().spawn((Mesh3d(mesh), transform(random)));
    let material = set_material(stage, entity, random);
    stage.meshes.push(entity);
    format!("a mesh comes ({what}), of {material}")
}

fn despawn_mesh(stage: &mut Stage, random: &mut Random) -> String {
    if stage.meshes.len() > 2 {
        let entity = stage.meshes.swap_remove(random.below(stage.meshes.len()));
        stage.world().despawn(entity);
    }
    "a mesh goes".into()
}

fn change_mesh(stage: &mut Stage, random: &mut Random) -> String {
    let Some(entity) = one_of(random, &stage.meshes) else {
        return String::new();
    };
    match random.below(8) {
        0 => {
            let (mesh, what) = mesh(random);
            let mesh = stage.builder().add::<Mesh>(mesh);
            stage.entity(entity).insert(Mesh3d(mesh));
            format!("another shape ({what})")
        }
        1 => {
            // Replaces the mesh in place.
            let handle = stage.entity(entity).get::<Mesh3d>().map(|m| m.0.clone());
            if let Some(handle) = handle {
                let mut meshes = stage.world().resource_mut::<Assets<Mesh>>();
                let (mesh, what) = mesh(random);
                _ = meshes.insert(&handle, mesh);
                return format!("a shape that changes ({what})");
            }
            String::new()
        }
        2 => {
            let layers = RenderLayers::from_layers(&[random.below(3), random.below(3)]);
            stage.entity(entity).insert(layers.clone());
            format!("layers of a mesh: {layers:?}")
        }
        3 => {
            let is_visible = random.below(2) == 0;
            stage.entity(entity).insert(if is_visible {
                Visibility::Inherited
            } else {
                Visibility::Hidden
            });
            format!("visible: {is_visible}")
        }
        4 => toggle::<NotShadowReceiver>(&mut stage.entity(entity)),
        5 => toggle::<NotShadowCaster>(&mut stage.entity(entity)),
        6 => {
            let lightmap = Lightmap {
                image: stage.images[random.below(stage.images.len())].clone(),
                bicubic_sampling: random.below(2) == 0,
                ..default()
            };
            toggle_between(&mut stage.entity(entity), lightmap)
        }
        _ => toggle::<NoFrustumCulling>(&mut stage.entity(entity)),
    }
}

fn move_mesh(stage: &mut Stage, random: &mut Random) -> String {
    let Some(entity) = one_of(random, &stage.meshes) else {
        return String::new();
    };
    let mut to = transform(random);
    to.scale = match random.below(6) {
        0 => Vec3::ZERO,
        1 => Vec3::new(-1.0, 1.0, 1.0),
        2 => Vec3::splat(50.0),
        _ => Vec3::ONE,
    };
    stage.entity(entity).insert(to);
    format!("a mesh moves: {to:?}")
}

fn change_material(stage: &mut Stage, random: &mut Random) -> String {
    let Some(entity) = one_of(random, &stage.meshes) else {
        return String::new();
    };
    if random.below(3) == 0 {
        return set_material(stage, entity, random);
    }
    // Changes the material in place.
    let images = stage.images.clone();
    let entity = stage.entity(entity);
    let standard = entity.get::<MeshMaterial3d<StandardMaterial>>();
    let Some(handle) = standard.map(|material| material.0.clone()) else {
        let extended = entity.get::<MeshMaterial3d<ExtendedStandardMaterial>>();
        let Some(handle) = extended.map(|material| material.0.clone()) else {
            return String::new();
        };
        let mut materials = entity
            .into_world_mut()
            .resource_mut::<Assets<ExtendedStandardMaterial>>();
        if let Some(mut material) = materials.get_mut(&handle) {
            material.extension = extension(random);
            values(&images).change(&mut material.base, random);
            return format!("{:?} of {:?}", material.extension, material.base);
        }
        return String::new();
    };
    let mut materials = entity
        .into_world_mut()
        .resource_mut::<Assets<StandardMaterial>>();
    if let Some(mut material) = materials.get_mut(&handle) {
        values(&images).change(&mut *material, random);
        return format!("{:?}", *material);
    }
    String::new()
}

fn spawn_light(stage: &mut Stage, random: &mut Random) -> String {
    if stage.lights.len() >= MOST_LIGHTS {
        return despawn_light(stage, random);
    }
    let place = transform(random).looking_at(Vec3::ZERO, Vec3::Y);
    let shadow_maps_enabled = random.below(2) == 0;
    let mut s = stage.builder();
    let (light, name) = match random.below(4) {
        0 => (
            s.spawn((
                DirectionalLight {
                    shadow_maps_enabled,
                    ..default()
                },
                place,
            )),
            "a sun",
        ),
        1 => (
            s.spawn((
                SpotLight {
                    shadow_maps_enabled,
                    ..default()
                },
                place,
            )),
            "a spot light",
        ),
        2 => (
            s.spawn((RectLight::default(), place)),
            "a rectangle of light",
        ),
        _ => (
            s.spawn((
                PointLight {
                    shadow_maps_enabled,
                    ..default()
                },
                place,
            )),
            "a point light",
        ),
    };
    stage.lights.push(light);
    format!("{name} comes, with shadows: {shadow_maps_enabled}")
}

fn despawn_light(stage: &mut Stage, random: &mut Random) -> String {
    if !stage.lights.is_empty() {
        let light = stage.lights.swap_remove(random.below(stage.lights.len()));
        stage.world().despawn(light);
    }
    "a light goes".into()
}

fn change_light(stage: &mut Stage, random: &mut Random) -> String {
    let Some(light) = one_of(random, &stage.lights) else {
        return String::new();
    };
    if random.below(4) == 0 {
        let layers = RenderLayers::layer(random.below(3));
        stage.entity(light).insert(layers.clone());
        return format!("layers of a light: {layers:?}");
    }
    let values = Values {
        hostile: 12,
        images: &[],
        // Without these surfaces shadow themselves, at places that depend on the last bits of the normal.
        kept: &["shadow_depth_bias", "shadow_normal_bias"],
    };
    let mut entity = stage.entity(light);
    if let Some(mut light) = entity.get_mut::<PointLight>() {
        values.change(&mut *light, random);
        format!("{:?}", *light)
    } else if let Some(mut light) = entity.get_mut::<SpotLight>() {
        values.change(&mut *light, random);
        format!("{:?}", *light)
    } else if let Some(mut light) = entity.get_mut::<DirectionalLight>() {
        values.change(&mut *light, random);
        format!("{:?}", *light)
    } else if let Some(mut light) = entity.get_mut::<RectLight>() {
        values.change(&mut *light, random);
        format!("{:?}", *light)
    } else {
        String::new()
    }
}
