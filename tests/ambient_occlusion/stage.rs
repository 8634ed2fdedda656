//! Bevy scenes whose pictures are read back as the main texture stores them.

use std::sync::{Arc, Mutex};

use bevy::{
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
    render::{
        gpu_readback::{Readback, ReadbackComplete},
        render_resource::TextureFormat,
    },
};
use bevy_lean_deferred::{DebugView, LeanDebugView, LeanScreenSpaceAmbientOcclusion};

use half::f16;
use kit::{
    headless::{Headless, target_image_of},
    scenes::SceneBuilder,
};

/// Rows of this many pixels are copied without padding.
pub const SIZE: UVec2 = UVec2::new(256, 192);

pub struct Stage {
    pub headless: Headless,
    pub camera: Entity,
}

impl Stage {
    /// A scene with the usual camera.
    pub fn new(build: impl FnOnce(&mut SceneBuilder)) -> Self {
        Self::with_size(SIZE, build)
    }

    pub fn with_size(size: UVec2, build: impl FnOnce(&mut SceneBuilder)) -> Self {
        let mut headless = Headless::new(size);
        let target = target_image_of(size, TextureFormat::Rgba16Float);
        headless.target = headless.world().resource_mut::<Assets<Image>>().add(target);
        let mut scene = SceneBuilder {
            headless: &mut headless,
        };
        build(&mut scene);
        let camera = scene.default_camera(());
        let mut stage = Self { headless, camera };
        stage.keep_colors(camera);
        stage
    }

    /// Disables tone mapping and dither, so that the lit colours are read back.
    pub fn keep_colors(&mut self, camera: Entity) {
        self.entity(camera)
            .insert((Tonemapping::None, DebandDither::Disabled));
    }

    pub fn entity(&mut self, entity: Entity) -> EntityWorldMut<'_> {
        self.headless.world().entity_mut(entity)
    }

    pub fn insert(&mut self, bundle: impl Bundle) -> &mut Self {
        let camera = self.camera;
        self.entity(camera).insert(bundle);
        self
    }

    pub fn remove<B: Bundle>(&mut self) -> &mut Self {
        let camera = self.camera;
        self.entity(camera).remove::<B>();
        self
    }

    /// The picture with `settings` on the camera.
    pub fn picture_with(&mut self, settings: LeanScreenSpaceAmbientOcclusion) -> Colors {
        self.insert(settings);
        self.picture()
    }

    /// Occlusion alone: visibility in all colours.
    pub fn visibility(&mut self, settings: LeanScreenSpaceAmbientOcclusion) -> Colors {
        self.insert(LeanDebugView::from(DebugView::AmbientOcclusion));
        let visibility = self.picture_with(settings);
        self.remove::<LeanDebugView>();
        visibility
    }

    pub fn resized(&mut self, size: UVec2) -> &mut Self {
        self.headless.size = size;
        let target = self.headless.target.id();
        let mut images = self.headless.world().resource_mut::<Assets<Image>>();
        _ = images.insert(target, target_image_of(size, TextureFormat::Rgba16Float));
        self
    }

    /// Reads the target back, once all is loaded.
    pub fn picture(&mut self) -> Colors {
        self.headless.settle();
        let read = Arc::new(Mutex::new(None));
        let sink = read.clone();
        let readback = Readback::texture(self.headless.target.clone());
        let reader = self
            .headless
            .world()
            .spawn(readback)
            .observe(move |event: On<ReadbackComplete>| {
                *sink.lock().unwrap() = Some(event.data.clone());
            })
            .id();
        for _ in 0..100 {
            self.headless.frames(1);
            if let Some(bytes) = read.lock().unwrap().take() {
                self.headless.world().despawn(reader);
                return Colors::new(&bytes, self.headless.size);
            }
        }
        panic!("no picture came back within 100 frames");
    }
}

/// Decodes half precision, finite and not negative, as colours are; anything else becomes NaN.
fn half(bits: u16) -> f32 {
    let value = f16::from_bits(bits);
    if value.is_finite() && value.is_sign_positive() {
        value.to_f32()
    } else {
        f32::NAN
    }
}

/// A half-precision picture.
#[derive(Clone, PartialEq)]
pub struct Colors {
    pub size: UVec2,
    bits: Vec<[u16; 4]>,
}

impl Colors {
    fn new(bytes: &[u8], size: UVec2) -> Self {
        let words: Vec<u16> = bytes
            .chunks(2)
            .map(|b| u16::from_le_bytes([b[0], b[1]]))
            .collect();
        let bits = words.as_chunks().0.to_vec();
        assert_eq!(bits.len(), size.element_product() as usize);
        Self { size, bits }
    }

    pub fn len(&self) -> usize {
        self.bits.len()
    }

    pub fn rgb(&self, i: usize) -> Vec3 {
        let [r, g, b, _] = self.bits[i].map(half);
        Vec3::new(r, g, b)
    }

    pub fn same_pixel(&self, other: &Self, i: usize) -> bool {
        self.bits[i] == other.bits[i]
    }

    pub fn same_alpha(&self, other: &Self) -> bool {
        let mut pairs = self.bits.iter().zip(&other.bits);
        pairs.all(|(a, b)| a[3] == b[3])
    }

    /// Number of pixels that satisfy a condition.
    pub fn count(&self, condition: impl Fn(usize) -> bool) -> usize {
        (0..self.len()).filter(|i| condition(*i)).count()
    }

    /// Number of differing pixels.
    pub fn different(&self, other: &Self) -> usize {
        self.count(|i| !self.same_pixel(other, i))
    }

    /// The same picture, black outside a rectangle.
    pub fn within(&self, rect: URect) -> Self {
        let mut part = self.clone();
        for (i, bits) in part.bits.iter_mut().enumerate() {
            let pixel = UVec2::new(i as u32 % self.size.x, i as u32 / self.size.x);
            if pixel.cmplt(rect.min).any() || pixel.cmpge(rect.max).any() {
                *bits = [0; 4];
            }
        }
        part
    }

    /// In a picture of [visibility](Stage::visibility): pixels that are open like all of their neighbours, so that they have no occlusion
    /// at all.
    pub fn open(&self) -> Vec<bool> {
        let (width, height) = (self.size.x as usize, self.size.y as usize);
        let is_open = |x: usize, y: usize| {
            (y.saturating_sub(1)..(y + 2).min(height)).all(|y| {
                (x.saturating_sub(1)..(x + 2).min(width))
                    .all(|x| self.rgb(y * width + x) == Vec3::ONE)
            })
        };
        (0..self.len())
            .map(|i| is_open(i % width, i / width))
            .collect()
    }
}
