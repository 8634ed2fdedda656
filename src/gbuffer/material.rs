//! Decides which materials the G-buffer carries, and with which fragment shader.

use bevy::{
    material::OpaqueRendererMethod,
    pbr::{ExtendedMaterial, Material, MaterialExtension, StandardMaterial},
    prelude::*,
    shader::ShaderRef,
};

use super::{
    bevy::texture_defs::{has_field, has_texture},
    forward_reason::ForwardReason,
    targets::GBufferNeeds,
};
use crate::{
    shader_library::layout::LARGEST_REFLECTANCE,
    shading_models::LARGEST_UNLIT,
    view::{GBufferTargets, ShadingModel},
};

/// A [`Material`] that can be drawn into the packed G-buffer.
///
/// Implement it for your own material and add [`GBufferMaterialPlugin`](super::GBufferMaterialPlugin): its meshes are then drawn into
/// the G-buffer of every [`LeanDeferred`](crate::LeanDeferred) camera instead of by Bevy's forward pass. For a material of another crate,
/// which cannot implement this trait, [`GBufferMaterialPlugin::new`](super::GBufferMaterialPlugin::new) takes the same by value.
///
/// ```no_run
/// use bevy::{prelude::*, reflect::TypePath, render::render_resource::AsBindGroup, shader::ShaderRef};
/// use bevy_lean_deferred::{gbuffer::ForwardReason, prelude::*};
///
/// /// Dark horizontal rings around a mesh.
/// #[derive(Asset, AsBindGroup, TypePath, Clone)]
/// struct Rings {
///     /// Linear colour, and rings per metre.
///     #[uniform(0)]
///     rings: Vec4,
/// }
///
/// impl Material for Rings {
///     fn fragment_shader() -> ShaderRef {
///         "shaders/rings.wgsl".into()
///     }
/// }
///
/// impl GBufferMaterial for Rings {
///     // The same file: `PREPASS_PIPELINE` is defined when it draws into the G-buffer.
///     fn gbuffer_fragment_shader() -> ShaderRef {
///         "shaders/rings.wgsl".into()
///     }
///
///     // It emits nothing and has no special shading model: the base targets suffice.
///     fn gbuffer_needs(&self) -> Result<GBufferNeeds, ForwardReason> {
///         Ok(GBufferNeeds::BASE)
///     }
/// }
///
/// fn setup(
///     mut commands: Commands,
///     mut meshes: ResMut<Assets<Mesh>>,
///     mut materials: ResMut<Assets<Rings>>,
/// ) {
///     commands.spawn((Camera3d::default(), LeanDeferred::default(), Transform::from_xyz(0.0, 0.0, 4.0)));
///     commands.spawn(DirectionalLight::default());
///     commands.spawn((
///         Mesh3d(meshes.add(Sphere::new(1.0))),
///         MeshMaterial3d(materials.add(Rings { rings: Vec4::new(0.8, 0.3, 0.1, 4.0) })),
///     ));
/// }
///
/// App::new()
///     .add_plugins((
///         DefaultPlugins,
///         LeanDeferredPlugins,
///         MaterialPlugin::<Rings>::default(),
///         GBufferMaterialPlugin::<Rings>::default(),
///     ))
///     .add_systems(Startup, setup)
///     .run();
/// ```
///
/// ```wgsl
#[doc = include_str!("custom_material.wgsl")]
/// ```
///
/// # The shader
///
/// The shader runs in Bevy's prepass pipeline. Its inputs are `bevy_pbr::prepass_io::VertexOutput` and the material's own bind
/// group. It builds a `PbrInput` and returns `bevy_lean_deferred::gbuffer::pack::pack_pbr_input` of it and the vertex output. Alpha
/// masks and the crossfade of visibility ranges need `apply_discards` of the same module before that.
///
/// The shader is compiled once without optional targets. If the material needs some, it is also compiled with `GBUFFER_EMISSIVE`,
/// `GBUFFER_SPECIALIZATION`, `GBUFFER_MOTION` and `GBUFFER_VISIBILITY_MASK` for those that its mesh needs and the view has.
/// `pack_pbr_input` fills all of them. For meshes that do not move, `VertexOutput` has no previous position.
///
/// The vertex shader is that of the material's deferred pass ([`Material::deferred_vertex_shader`]). If it moves vertices, the
/// material needs [`GBufferTargets::MOTION`]. The example `custom_material` has water that does so.
pub trait GBufferMaterial: Material {
    /// The fragment shader for the G-buffer. The default packs a `StandardMaterial` bind group.
    fn gbuffer_fragment_shader() -> ShaderRef {
        ShaderRef::Default
    }

    /// The needs of this material. Return a reason, such as [`ForwardReason::Custom`], to have Bevy's forward pass draw
    /// it. The answer may differ after the material has changed. Blended and specularly transmissive materials are drawn
    /// by forward whatever the answer.
    fn gbuffer_needs(&self) -> Result<GBufferNeeds, ForwardReason>;
}

impl GBufferMaterial for StandardMaterial {
    /// Carries opaque and alpha-masked materials, except those with properties that no target encodes: an explicit
    /// `OpaqueRendererMethod::Forward`, specular transmission, a coloured specular tint, clearcoat or anisotropy with a
    /// normal map, clearcoat with a normal map of its own, more than one of clearcoat, anisotropy and diffuse
    /// transmission, a depth bias, and values out of range. Anisotropy also needs Bevy's feature
    /// `pbr_anisotropy_texture`, which is off by default: without it Bevy shades anisotropy differently.
    fn gbuffer_needs(&self) -> Result<GBufferNeeds, ForwardReason> {
        if self.opaque_render_method == OpaqueRendererMethod::Forward {
            return Err(ForwardReason::Requested);
        }
        if self.specular_transmission != 0.0 {
            return Err(ForwardReason::Transmissive);
        }
        // It offsets the depth from which lighting reconstructs the position. Bevy draws with its whole part.
        if self.depth_bias as i32 != 0 {
            return Err(ForwardReason::DepthBias);
        }
        let albedo = self.base_color.to_linear();
        let albedo = [albedo.red, albedo.green, albedo.blue];
        let mut needs = GBufferNeeds::BASE;
        if !self.fog_enabled {
            needs.targets |= GBufferTargets::SPECIALIZATION;
        }
        if self.unlit {
            check_range("base_color", albedo, LARGEST_UNLIT)?;
            return Ok(needs.with_shading_model(ShadingModel::Unlit));
        }

        check_range("base_color", albedo, 1.0)?;
        check_range("metallic", [self.metallic], 1.0)?;
        check_range("perceptual_roughness", [self.perceptual_roughness], 1.0)?;
        let emissive = [self.emissive.red, self.emissive.green, self.emissive.blue];
        // Negative emission cannot be encoded. NaN becomes black.
        if emissive.iter().any(|&channel| channel < 0.0) {
            return Err(ForwardReason::OutOfRange("emissive"));
        }
        if emissive != [0.0; 3] {
            needs.targets |= GBufferTargets::EMISSIVE;
        }

        let tint = self.specular_tint.to_linear();
        if [tint.red, tint.blue] != [tint.green; 2] || has_texture(self, "specular_tint_texture") {
            return Err(ForwardReason::ColoredSpecularTint);
        }
        let reflectance = self.reflectance * tint.green;
        check_range("reflectance", [reflectance], LARGEST_REFLECTANCE)?;
        if reflectance != 0.5 || has_texture(self, "specular_texture") {
            needs.targets |= GBufferTargets::SPECIALIZATION;
        }
        Ok(match self.special_shading_model()? {
            ShadingModel::Plain => needs,
            special => needs.with_shading_model(special),
        })
    }
}

/// Selects the shading model of a `StandardMaterial`.
trait SpecialShadingModel {
    /// Returns the reason that no shading model matches.
    fn special_shading_model(&self) -> Result<ShadingModel, ForwardReason>;
}

impl SpecialShadingModel for StandardMaterial {
    fn special_shading_model(&self) -> Result<ShadingModel, ForwardReason> {
        let clearcoat = self.clearcoat > 0.0;
        let anisotropy = self.anisotropy_strength > 0.0;
        let transmission = self.diffuse_transmission > 0.0;
        match (clearcoat, anisotropy, transmission) {
            (false, false, false) => Ok(ShadingModel::Plain),
            // The coat's normal is the mesh's or one of its own; only one normal is stored.
            (true, false, false) => {
                if self.normal_map_texture.is_some() {
                    return Err(ForwardReason::NormalMapUnderCoat);
                }
                if has_texture(self, "clearcoat_normal_texture") {
                    return Err(ForwardReason::NormalMapOfCoat);
                }
                check_range("clearcoat", [self.clearcoat], 1.0)?;
                let roughness = self.clearcoat_perceptual_roughness;
                check_range("clearcoat_perceptual_roughness", [roughness], 1.0)?;
                Ok(ShadingModel::Clearcoat)
            }
            // Without the feature `pbr_anisotropy_texture`, forward shades differently. Forward stretches highlights
            // along the mesh's surface, but the stored normal is that of the normal map.
            (false, true, false) => {
                if !has_field(self, "anisotropy_texture") {
                    return Err(ForwardReason::AnisotropyUnsupported);
                }
                if self.normal_map_texture.is_some() {
                    return Err(ForwardReason::NormalMapUnderAnisotropy);
                }
                check_range("anisotropy_strength", [self.anisotropy_strength], 1.0)?;
                Ok(ShadingModel::Anisotropy)
            }
            (false, false, true) => {
                check_range("diffuse_transmission", [self.diffuse_transmission], 1.0)?;
                check_range("thickness", [self.thickness], f32::INFINITY)?;
                Ok(ShadingModel::DiffuseTransmission)
            }
            _ => Err(ForwardReason::TwoShadingModels),
        }
    }
}

/// Returns an error if a value is below 0, above `largest` or NaN.
fn check_range<const N: usize>(
    field: &'static str,
    values: [f32; N],
    largest: f32,
) -> Result<(), ForwardReason> {
    let mut values = values.into_iter();
    if values.all(|value| (0.0..=largest).contains(&value)) {
        Ok(())
    } else {
        Err(ForwardReason::OutOfRange(field))
    }
}

/// A [`MaterialExtension`] of [`StandardMaterial`] whose [`ExtendedMaterial`] can be drawn into the packed G-buffer.
///
/// ```
/// use bevy::{
///     pbr::{ExtendedMaterial, MaterialExtension},
///     prelude::*,
///     reflect::TypePath,
///     render::render_resource::AsBindGroup,
///     shader::ShaderRef,
/// };
/// use bevy_lean_deferred::{gbuffer::GBufferMaterialExtension, prelude::*};
///
/// /// A blue tint.
/// #[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
/// struct Tint {
///     /// From 0 (none) to 1. Bindings up to 99 are those of `StandardMaterial`.
///     #[uniform(100)]
///     strength: f32,
/// }
///
/// impl MaterialExtension for Tint {
///     fn fragment_shader() -> ShaderRef {
///         "shaders/tint.wgsl".into()
///     }
/// }
///
/// impl GBufferMaterialExtension for Tint {
///     fn gbuffer_fragment_shader() -> ShaderRef {
///         "shaders/tint_gbuffer.wgsl".into()
///     }
/// }
///
/// type TintedMaterial = ExtendedMaterial<StandardMaterial, Tint>;
///
/// fn add_plugins(app: &mut App) {
///     app.add_plugins((
///         MaterialPlugin::<TintedMaterial>::default(),
///         GBufferMaterialPlugin::<TintedMaterial>::default(),
///     ));
/// }
/// ```
///
/// ```wgsl
/// // assets/shaders/tint_gbuffer.wgsl
/// #import bevy_lean_deferred::gbuffer::pack::{GBufferOutput, apply_discards, pack_pbr_input}
/// #import bevy_pbr::{pbr_fragment::pbr_input_from_standard_material, prepass_io::VertexOutput}
///
/// @group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> strength: f32;
///
/// @fragment
/// fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> GBufferOutput {
///     var pbr_input = pbr_input_from_standard_material(in, is_front);
///     pbr_input.material.base_color.b = mix(pbr_input.material.base_color.b, 1.0, strength);
///     apply_discards(in, &pbr_input);
///     return pack_pbr_input(pbr_input, in);
/// }
/// ```
///
/// [`GBufferMaterial`] describes the shader.
pub trait GBufferMaterialExtension: MaterialExtension {
    /// The fragment shader for the G-buffer. The default ignores the extension.
    fn gbuffer_fragment_shader() -> ShaderRef {
        ShaderRef::Default
    }

    /// Needs of the extended material, given the needs of its `base`. Not called if forward draws the base.
    fn gbuffer_needs(&self, base: GBufferNeeds) -> Result<GBufferNeeds, ForwardReason> {
        Ok(base)
    }
}

impl<E: GBufferMaterialExtension> GBufferMaterial for ExtendedMaterial<StandardMaterial, E> {
    fn gbuffer_fragment_shader() -> ShaderRef {
        E::gbuffer_fragment_shader()
    }

    fn gbuffer_needs(&self) -> Result<GBufferNeeds, ForwardReason> {
        self.extension.gbuffer_needs(self.base.gbuffer_needs()?)
    }
}
