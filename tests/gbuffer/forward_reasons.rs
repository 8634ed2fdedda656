//! A camera with `LeanForwardMeshes` reports the meshes that forward draws, with the reasons.

use core::cmp::Reverse;
use std::collections::BTreeMap;

use bevy::{asset::uuid_handle, material::OpaqueRendererMethod, prelude::*};
use bevy_lean_deferred::{
    gbuffer::{ForwardReason, GBufferMaterial},
    prelude::*,
};
use kit::{
    foreign_material::{Palette, VoxelMaterial, VoxelPlugin, voxel_mesh},
    headless::{Headless, small_shadow_maps},
    lean::set_lean,
    own_process::in_own_process,
    scenes::{SceneBuilder, build::material},
};

const SIZE: UVec2 = UVec2::new(64, 48);

/// Most frames between a change and its report.
const PATIENCE: usize = 60;

const BROKEN: Handle<Shader> = uuid_handle!("5d4f4a4e-6a5e-4d0b-9f0c-6f3b1c0d9e47");

type Change = fn(&mut StandardMaterial);

fn out_of_range(field: &'static str, change: Change) -> (ForwardReason, Change) {
    (ForwardReason::OutOfRange(field), change)
}

/// A change of an opaque material for each reason that lies in the material alone.
fn changes() -> [(ForwardReason, Change); 18] {
    [
        (ForwardReason::Requested, |m| {
            m.opaque_render_method = OpaqueRendererMethod::Forward
        }),
        (ForwardReason::Transmissive, |m| {
            m.specular_transmission = 0.5
        }),
        (ForwardReason::DepthBias, |m| m.depth_bias = 100.0),
        out_of_range("base_color", |m| {
            m.base_color = Color::linear_rgb(1.5, 1.0, 1.0)
        }),
        out_of_range("metallic", |m| m.metallic = -0.5),
        out_of_range("perceptual_roughness", |m| m.perceptual_roughness = 1.5),
        out_of_range("emissive", |m| m.emissive = LinearRgba::rgb(1.0, -1.0, 0.0)),
        out_of_range("reflectance", |m| m.reflectance = f32::NAN),
        out_of_range("clearcoat", |m| m.clearcoat = 1.5),
        out_of_range("clearcoat_perceptual_roughness", |m| {
            m.clearcoat = 0.5;
            m.clearcoat_perceptual_roughness = 1.5;
        }),
        out_of_range("anisotropy_strength", |m| m.anisotropy_strength = 1.5),
        out_of_range("diffuse_transmission", |m| m.diffuse_transmission = 1.5),
        out_of_range("thickness", |m| {
            m.diffuse_transmission = 0.5;
            m.thickness = -1.0;
        }),
        (ForwardReason::ColoredSpecularTint, |m| {
            m.specular_tint = Color::srgb(1.0, 0.5, 0.5)
        }),
        (ForwardReason::NormalMapUnderCoat, |m| {
            m.clearcoat = 0.5;
            m.normal_map_texture = Some(Handle::default());
        }),
        (ForwardReason::NormalMapOfCoat, |m| {
            m.clearcoat = 0.5;
            m.clearcoat_normal_texture = Some(Handle::default());
        }),
        (ForwardReason::NormalMapUnderAnisotropy, |m| {
            m.anisotropy_strength = 0.5;
            m.normal_map_texture = Some(Handle::default());
        }),
        (ForwardReason::TwoShadingModels, |m| {
            m.clearcoat = 0.5;
            m.anisotropy_strength = 0.5;
        }),
    ]
}

/// Bevy draws with the whole part of a depth bias.
#[test]
fn a_depth_bias_below_one_is_none() {
    for (bias, is_carried) in [(0.5, true), (-0.9, true), (1.0, false), (-2.0, false)] {
        let material = StandardMaterial {
            depth_bias: bias,
            ..default()
        };
        assert_eq!(material.gbuffer_needs().is_ok(), is_carried, "{bias}");
    }
}

fn clay() -> StandardMaterial {
    material((0.8, 0.3, 0.2), 0.0, 0.5)
}

fn changed(change: Change) -> StandardMaterial {
    let mut material = clay();
    change(&mut material);
    material
}

/// A ball with tangents.
fn ball() -> Mesh {
    Sphere::new(0.3)
        .mesh()
        .uv(16, 8)
        .with_generated_tangents()
        .expect("a sphere has all that tangents need")
}

fn without_normals() -> Mesh {
    let mut mesh = Mesh::from(Cuboid::from_length(0.4));
    mesh.remove_attribute(Mesh::ATTRIBUTE_NORMAL);
    mesh
}

/// A lean camera that reports, and what it sees beside a floor.
struct Stage {
    headless: Headless,
    camera: Entity,
    /// Numbers of meshes that should be reported.
    expected: BTreeMap<ForwardReason, usize>,
}

impl Stage {
    fn new(configure: impl FnOnce(&mut App)) -> Self {
        let mut headless = Headless::with(SIZE, |app| {
            small_shadow_maps(app);
            configure(app);
        });
        let mut scene = SceneBuilder {
            headless: &mut headless,
        };
        scene.floor();
        scene.sun(false);
        let camera = scene.default_camera(LeanForwardMeshes::default());
        set_lean(&mut headless, true);
        headless.settle();
        Self {
            headless,
            camera,
            expected: BTreeMap::new(),
        }
    }

    fn scene(&mut self) -> SceneBuilder<'_> {
        SceneBuilder {
            headless: &mut self.headless,
        }
    }

    fn spawn<M: Material>(&mut self, mesh: Mesh, material: &Handle<M>) -> Entity {
        let mut scene = self.scene();
        let mesh = Mesh3d(scene.add::<Mesh>(mesh));
        let place = Transform::from_xyz(0.0, 0.5, 0.5);
        scene.spawn((mesh, MeshMaterial3d(material.clone()), place))
    }

    fn camera(&mut self) -> EntityWorldMut<'_> {
        self.headless.app.world_mut().entity_mut(self.camera)
    }

    fn activate(&mut self, is_active: bool) {
        let mut camera = self.camera();
        let mut camera = camera.get_mut::<Camera>().expect("it is a camera");
        camera.is_active = is_active;
    }

    fn set_material(&mut self, handle: &Handle<StandardMaterial>, material: StandardMaterial) {
        let world = self.headless.world();
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let inserted = materials.insert(handle.id(), material);
        inserted.expect("it is there already");
    }

    fn reported(&self) -> &LeanForwardMeshes {
        let world = self.headless.app.world();
        let reported = world.get::<LeanForwardMeshes>(self.camera);
        reported.expect("the camera has one")
    }

    /// Renders until the report is as expected, and some frames more: it stays.
    fn check(&mut self, what: &str) {
        let mut counts: Vec<_> = (self.expected.iter())
            .map(|(reason, count)| (*reason, *count))
            .collect();
        counts.sort_by_key(|(_, count)| Reverse(*count));
        for _ in 0..PATIENCE {
            self.headless.frames(1);
            if self.reported().counts == counts {
                break;
            }
        }
        self.headless.frames(3);
        assert_eq!(self.reported().counts, counts, "{what}");
        let total: usize = self.expected.values().sum();
        assert_eq!(self.reported().total(), total, "{what}");
    }
}

#[test]
fn a_material_names_its_reason() {
    assert_eq!(clay().gbuffer_needs(), Ok(GBufferNeeds::BASE));
    for (reason, change) in changes() {
        assert_eq!(changed(change).gbuffer_needs(), Err(reason));
        println!("{reason:?}: {reason}");
    }
    let unlit = changed(|m| {
        m.unlit = true;
        m.base_color = Color::linear_rgb(1.0, -1.0, 0.0);
    });
    let range = ForwardReason::OutOfRange("base_color");
    assert_eq!(unlit.gbuffer_needs(), Err(range));
    let text = "`base_color` of its material is out of range";
    assert!(range.to_string().starts_with(text), "{range}");
}

#[test]
fn reports_follow_materials_meshes_and_the_camera() {
    in_own_process(|| {
        let mut stage = Stage::new(|app| {
            app.add_plugins(VoxelPlugin);
        });
        stage.check("nothing yet");

        for (reason, change) in changes() {
            let material = stage.scene().add::<StandardMaterial>(changed(change));
            stage.spawn(ball(), &material);
            stage.expected.insert(reason, 1);
        }
        let anisotropic = changed(|m| m.anisotropy_strength = 0.5);
        let anisotropic = stage.scene().add::<StandardMaterial>(anisotropic);
        stage.spawn(Sphere::new(0.3).into(), &anisotropic);
        stage.expected.insert(ForwardReason::NoTangents, 1);
        let plain = stage.scene().add::<StandardMaterial>(clay());
        stage.spawn(without_normals(), &plain);
        stage.expected.insert(ForwardReason::NoNormals, 1);
        let voxels = stage.scene().add::<VoxelMaterial>(VoxelMaterial {
            base: clay(),
            extension: Palette::default(),
        });
        stage.spawn(voxel_mesh(), &voxels);
        stage.expected.insert(ForwardReason::NotRegistered, 1);
        stage.check("all reasons");
        assert_eq!(stage.reported().first.len(), 8);

        let glass = changed(|m| m.alpha_mode = AlphaMode::Blend);
        let glass = stage.scene().add::<StandardMaterial>(glass);
        let panes = [(); 3].map(|()| stage.spawn(ball(), &glass));
        stage.expected.insert(ForwardReason::Blended, 3);
        stage.check("one material of three meshes");
        let blended = (glass.id().untyped(), ForwardReason::Blended);
        assert_eq!(stage.reported().first[0], blended);

        stage.set_material(&glass, changed(|m| m.depth_bias = 100.0));
        stage.expected.remove(&ForwardReason::Blended);
        stage.expected.insert(ForwardReason::DepthBias, 4);
        stage.check("another reason");
        stage.set_material(&glass, clay());
        stage.expected.insert(ForwardReason::DepthBias, 1);
        stage.check("none any more");
        stage.set_material(&glass, changed(|m| m.alpha_mode = AlphaMode::Add));
        stage.expected.insert(ForwardReason::Blended, 3);
        stage.check("again");

        let [hidden, despawned, exchanged] = panes;
        let world = stage.headless.world();
        world.entity_mut(hidden).insert(Visibility::Hidden);
        world.entity_mut(despawned).despawn();
        let mut exchanged = world.entity_mut(exchanged);
        exchanged.insert(MeshMaterial3d(plain.clone()));
        stage.expected.remove(&ForwardReason::Blended);
        stage.check("no mesh has the material");
        let world = stage.headless.world();
        world.entity_mut(hidden).insert(Visibility::Inherited);
        stage.expected.insert(ForwardReason::Blended, 1);
        stage.check("shown again");

        let all = stage.expected.clone();
        stage.camera().insert(LeanDeferred {
            enabled: false,
            ..default()
        });
        stage.expected.clear();
        stage.check("the camera is not lean");
        stage.camera().insert(LeanDeferred::default());
        stage.expected = all.clone();
        stage.check("the camera is lean again");

        stage.camera().remove::<LeanForwardMeshes>();
        stage.headless.frames(3);
        stage.camera().insert(LeanForwardMeshes::default());
        stage.check("the component is added to a lean camera");

        stage.activate(false);
        stage.expected.clear();
        stage.check("the camera is off");
        stage.activate(true);
        stage.expected = all;
        stage.check("the camera is on");
        stage.camera().remove::<LeanDeferred>();
        stage.expected.clear();
        stage.check("the camera is Bevy's");
    });
}

fn needs_of_voxels(material: &VoxelMaterial) -> Result<GBufferNeeds, ForwardReason> {
    if material.extension.rows == [Vec4::ZERO; 4] {
        return Err(ForwardReason::Custom("its palette is empty"));
    }
    material.base.gbuffer_needs()
}

#[test]
fn materials_of_apps_have_reasons_too() {
    in_own_process(|| {
        let mut stage = Stage::new(|app| {
            app.add_plugins((
                VoxelPlugin,
                GBufferMaterialPlugin::<VoxelMaterial>::new(BROKEN, needs_of_voxels),
            ));
        });
        let broken = Shader::from_wgsl("fn broken() -> u32 { return missing; }", "broken.wgsl");
        let mut shaders = stage.headless.world().resource_mut::<Assets<Shader>>();
        let inserted = shaders.insert(BROKEN.id(), broken);
        inserted.expect("a place for a constant handle");
        for (rows, reason) in [
            ([Vec4::ONE; 4], ForwardReason::PipelineFailed),
            (
                [Vec4::ZERO; 4],
                ForwardReason::Custom("its palette is empty"),
            ),
        ] {
            let extension = Palette { rows };
            let material = VoxelMaterial {
                base: clay(),
                extension,
            };
            let material = stage.scene().add::<VoxelMaterial>(material);
            stage.spawn(voxel_mesh(), &material);
            stage.expected.insert(reason, 1);
            stage.check(&reason.to_string());
            let named = (material.id().untyped(), reason);
            assert!(stage.reported().first.contains(&named), "{reason}");
        }
    });
}
