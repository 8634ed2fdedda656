//! Textures of a view, and its history.

use bevy::{
    prelude::*,
    render::{render_resource::Texture, renderer::RenderDevice, view::ExtractedView},
};

use super::pipelines::{LEVEL_COUNT, LEVELS_FORMAT, LIGHT_FORMAT, PASSES};
use crate::{
    effects::{
        history_validity::{HistoryValidity, LastFrame},
        shown_exposure::{BoundedByWhite, ShownExposure},
    },
    gpu::{
        growing_size::GrowingSize, storage_texture::StorageTexture, texture_bytes::texture_bytes,
    },
};

/// Texels per side that a workgroup of the first pass writes.
const LEVELS_SIDE: u32 = 16;
/// Texels per side of a block of the second pass.
const GATHER_SIDE: u32 = 32;
/// Workgroups that share such a block.
const PHASES: u32 = 16;
/// Texels per side that a workgroup of the third pass writes.
const FILTER_SIDE: u32 = 16;

/// Depth and light of the texels of a frame.
pub(super) struct Levels {
    pub(super) texture: StorageTexture<{ LEVEL_COUNT as usize }>,
    allocated: UVec2,
    /// Size of the viewport in texels. The texture may be larger.
    pub(super) size: UVec2,
    /// Side of a texel in pixels.
    pub(super) divisor: i32,
}

impl Levels {
    fn new(device: &RenderDevice, size: UVec2) -> Self {
        let label = "lean_deferred/effects/diffuse_gi/levels";
        Self {
            texture: StorageTexture::new(device, label, size, LEVELS_FORMAT),
            allocated: size,
            size,
            divisor: 1,
        }
    }
}

/// On a view with diffuse GI: its history, and the outputs of the passes.
#[derive(Component)]
pub struct ViewGi {
    /// Of this frame and the last one, alternating. While the resolution changes, their sizes differ.
    pub(super) levels: [Levels; 2],
    pub(super) current: usize,
    pub(super) gathered: StorageTexture,
    pub(super) output: StorageTexture,
    pub(super) growing: GrowingSize,
    /// Size of `gathered` and `output`.
    allocated: UVec2,
    /// Size of the viewport in texels. Textures may be larger.
    pub(super) texture_size: UVec2,
    pub(super) viewport_size: UVec2,
    /// Motion vectors reproject moving meshes; otherwise only the camera's motion is known.
    pub(super) has_motion: bool,
    pub(super) frames: HistoryValidity,
    pub(super) offset: u32,
    pub(super) shown_exposure: ShownExposure,
}

impl ViewGi {
    pub(super) fn new(
        device: &RenderDevice,
        view: &ExtractedView,
        texture_size: UVec2,
        frames: HistoryValidity,
    ) -> Self {
        let [gathered, output] = outputs(device, texture_size);
        Self {
            levels: [(); 2].map(|()| Levels::new(device, texture_size)),
            current: 0,
            gathered,
            output,
            growing: default(),
            allocated: texture_size,
            texture_size,
            viewport_size: UVec2::ZERO,
            has_motion: false,
            frames,
            offset: 0,
            shown_exposure: ShownExposure::new(device, view),
        }
    }

    /// True if the textures that this frame writes are allocated with this size.
    pub(super) fn is_of(&self, size: UVec2) -> bool {
        self.allocated == size && self.levels[self.current].allocated == size
    }

    /// Creates those textures anew where they have another size. The last frame's levels stay as they are.
    pub(super) fn resize(&mut self, device: &RenderDevice, size: UVec2) {
        if self.levels[self.current].allocated != size {
            self.levels[self.current] = Levels::new(device, size);
        }
        if self.allocated != size {
            [self.gathered, self.output] = outputs(device, size);
            self.allocated = size;
        }
    }

    /// Workgroups of the passes.
    pub(super) fn workgroups(&self) -> [UVec2; PASSES.len()] {
        let of = |side: u32| self.texture_size.map(|length| length.div_ceil(side));
        [
            of(LEVELS_SIDE),
            of(GATHER_SIDE) * UVec2::new(PHASES, 1),
            of(FILTER_SIDE),
        ]
    }

    /// Parameters of the last frame; `None` if its levels are invalid for this frame.
    pub fn last(&self) -> Option<&LastFrame> {
        self.frames.last()
    }

    pub(super) fn bytes(&self) -> u64 {
        self.textures().map(texture_bytes).sum::<u64>() + self.shown_exposure.bytes()
    }

    /// All textures that it holds.
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        let levels = self.levels.iter().map(|levels| &levels.texture.texture);
        levels.chain([&self.gathered.texture, &self.output.texture])
    }
}

impl BoundedByWhite for ViewGi {
    fn shown_exposure(&self) -> &ShownExposure {
        &self.shown_exposure
    }
}

/// Light before and after the filter.
fn outputs(device: &RenderDevice, size: UVec2) -> [StorageTexture; 2] {
    [
        "lean_deferred/effects/diffuse_gi/gathered",
        "lean_deferred/effects/diffuse_gi/output",
    ]
    .map(|label| StorageTexture::new(device, label, size, LIGHT_FORMAT))
}
