//! The textures and the uniform that an effect provides for the reflections of forward meshes.

use bevy::{
    prelude::*,
    render::render_resource::{Sampler, ShaderType, TextureView, UniformBuffer},
};

use crate::shader_library::distance_fog::FogUniform;

/// On a view: forward meshes trace reflections, through textures that an effect keeps for its own rays.
///
/// The effect inserts it before [`LeanViewSystems`](crate::view::LeanViewSystems), and fills it in before
/// `prepare_forward_groups` in each frame, also while it has no history yet.
#[derive(Component, Default)]
pub struct ForwardReflections {
    /// Parameters of the rays.
    pub uniform: UniformBuffer<ForwardReflectionUniform>,
    /// `None` before the first frame.
    pub textures: Option<ForwardReflectionTextures>,
}

/// Textures of [`ForwardReflections`].
pub struct ForwardReflectionTextures {
    /// Hi-z cells of this frame's opaque depth.
    pub hi_z: TextureView,
    /// Light and distances of the last frame, with mips.
    pub history: TextureView,
    /// Interpolates within and between mips.
    pub history_sampler: Sampler,
}

/// Uniform of rays from forward meshes. `bindings.wgsl` has the documentation.
#[derive(ShaderType, Reflect, Clone, Copy, Debug, Default)]
#[reflect(no_auto_register)]
pub struct ForwardReflectionUniform {
    pub pixel_from_view: Mat4,
    pub view_from_world: Mat4,
    pub last_pixel_from_view: Mat4,
    pub last_distance: Vec4,
    pub fog: FogUniform,
    pub history_size: Vec2,
    pub last_viewport_size: Vec2,
    pub viewport_size: UVec2,
    pub steps: u32,
    pub is_orthographic: u32,
    pub pixels_per_metre: f32,
    pub edge_metres: f32,
    pub metres_per_unit: f32,
    pub thickness: f32,
    pub edge_fade: f32,
    pub max_roughness: f32,
    pub intensity: f32,
    pub exposure_ratio: f32,
}
