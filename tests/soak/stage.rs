//! Content of the app, and its initial state.

use bevy::{
    camera::{Camera3dDepthTextureUsage, RenderTarget},
    light::{DirectionalLightShadowMap, PointLightShadowMap},
    mesh::skinning::SkinnedMesh,
    prelude::*,
    render::render_resource::TextureUsages,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    headless::{Headless, target_image},
    scenes::SceneBuilder,
};

pub const SIZES: [UVec2; 5] = [
    UVec2::new(96, 64),
    UVec2::new(64, 96),
    UVec2::new(33, 17),
    UVec2::new(3, 5),
    UVec2::new(1, 1),
];

/// Index of the target that keeps its size.
pub const STEADY: usize = 2;

pub struct Stage {
    pub headless: Headless,
    /// True if cameras have effects of this crate.
    pub is_lean: bool,
    pub meshes: Vec<Entity>,
    pub lights: Vec<Entity>,
    pub cameras: Vec<Entity>,
    /// Probes, decals, and meshes with joints or morph targets.
    pub surroundings: Vec<Entity>,
    /// Render targets of cameras, and their sizes.
    pub targets: Vec<(Handle<Image>, UVec2)>,
    /// Images for materials.
    pub images: Vec<Handle<Image>>,
}

impl Stage {
    pub fn new(is_lean: bool, is_synchronous: bool) -> Self {
        let size = SIZES[0];
        let mut headless = Headless::with_compilation(size, is_synchronous, |app| {
            app.insert_resource(DirectionalLightShadowMap { size: 128 })
                .insert_resource(PointLightShadowMap { size: 64 });
        });
        let first = headless.target.clone();
        let mut images = headless.world().resource_mut::<Assets<Image>>();
        let [second, steady] = [0; 2].map(|_| images.add(target_image(size)));
        let mut s = SceneBuilder {
            headless: &mut headless,
        };
        let images = vec![
            s.checker([255, 255, 255, 255], [20, 20, 60, 255]),
            s.checker([255, 0, 0, 0], [0, 255, 0, 255]),
        ];
        let mut stage = Self {
            headless,
            is_lean,
            meshes: Vec::new(),
            lights: Vec::new(),
            cameras: Vec::new(),
            surroundings: Vec::new(),
            targets: vec![(first, size), (second, size), (steady, size)],
            images,
        };
        stage.fill();
        stage
    }

    pub fn world(&mut self) -> &mut World {
        self.headless.world()
    }

    pub fn builder(&mut self) -> SceneBuilder<'_> {
        SceneBuilder {
            headless: &mut self.headless,
        }
    }

    pub fn entity(&mut self, entity: Entity) -> EntityWorldMut<'_> {
        self.world().entity_mut(entity)
    }

    /// Spawns solids, a sun and a camera.
    pub fn fill(&mut self) {
        self.builder().solids();
        let mut meshes = self.world().query_filtered::<Entity, With<Mesh3d>>();
        self.meshes = meshes.iter(self.headless.world()).collect();
        let sun = self.builder().sun(true);
        self.lights = vec![sun];
        self.add_camera(0);
    }

    pub fn clear(&mut self) {
        let all = [&mut self.meshes, &mut self.lights, &mut self.cameras];
        let all: Vec<Entity> = all.into_iter().flat_map(std::mem::take).collect();
        for entity in all {
            self.world().despawn(entity);
        }
        for entity in std::mem::take(&mut self.surroundings) {
            self.despawn_with_joints(entity);
        }
    }

    pub fn despawn_with_joints(&mut self, entity: Entity) {
        let joints = self.entity(entity).take::<SkinnedMesh>();
        self.world().despawn(entity);
        // The others are children of the first.
        if let Some(first) = joints.and_then(|skin| skin.joints.first().copied()) {
            self.world().despawn(first);
        }
    }

    pub fn add_camera(&mut self, target: usize) {
        let target = self.targets[target].0.clone();
        let order = self.cameras.len() as isize;
        let usages = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let camera = self.builder().default_camera(());
        self.entity(camera).insert((
            Camera3d {
                depth_texture_usages: Camera3dDepthTextureUsage::from(usages),
                ..default()
            },
            Camera { order, ..default() },
            RenderTarget::from(target),
        ));
        if self.is_lean {
            self.entity(camera)
                .insert((LeanDeferred::default(), LeanSubsurfaceScattering::default()));
        }
        self.cameras.push(camera);
    }

    /// True if a camera's target keeps its size.
    pub fn is_steady(&mut self, camera: Entity) -> bool {
        let steady = self.targets[STEADY].0.clone();
        let target = self.entity(camera).get::<RenderTarget>().cloned();
        target.is_some_and(|target| target.as_image() == Some(&steady))
    }

    pub fn resize(&mut self, target: usize, size: UVec2) {
        self.targets[target].1 = size;
        let handle = self.targets[target].0.clone();
        let mut images = self.world().resource_mut::<Assets<Image>>();
        _ = images.insert(&handle, target_image(size));
        // Bevy does not notice a resized target by itself.
        for camera in self.cameras.clone() {
            if let Some(mut projection) = self.entity(camera).get_mut::<Projection>() {
                projection.set_changed();
            }
        }
    }
}
