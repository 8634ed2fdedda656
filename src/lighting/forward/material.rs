//! Lets shaders of apps light by the light functions.

use bevy::render::render_resource::RenderPipelineDescriptor;

use super::{definitions::extend, reasons::has_two_models};
use crate::gpu::shader_defs::name_of;

/// Lets the fragment shader of a material light by this crate's light functions in Bevy's passes, on cameras of any kind: call it in
/// `specialize` of the material or of its extension, and `apply_lean_lighting` in the shader in place of Bevy's `apply_pbr_lighting`.
///
/// The functions skip lights that do not reach a pixel before they compute anything else; the light is the same. They leave out
/// specular transmission, and take `N` for the normal of a clear coat. Light layers apply to meshes of `StandardMaterial` only.
/// Pipelines of prepasses stay as they are, as do those of materials with two of clearcoat, anisotropy and diffuse transmission, since
/// the functions have the terms of one of them: set their definitions before the call, as a `StandardMaterial` that is extended has
/// done. There, and without the call, `apply_lean_lighting` is `apply_pbr_lighting`.
///
/// ```
/// use bevy::{
///     mesh::MeshVertexBufferLayoutRef,
///     pbr::{Material, MaterialPipeline, MaterialPipelineKey},
///     prelude::*,
///     reflect::TypePath,
///     render::render_resource::{
///         AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError,
///     },
///     shader::ShaderRef,
/// };
/// use bevy_lean_deferred::lighting::define_lean_lighting;
///
/// /// Water that shows what is below it.
/// #[derive(Asset, AsBindGroup, TypePath, Clone)]
/// struct Lagoon {
///     #[uniform(0)]
///     color: LinearRgba,
/// }
///
/// impl Material for Lagoon {
///     fn fragment_shader() -> ShaderRef {
///         "shaders/lagoon.wgsl".into()
///     }
///
///     fn alpha_mode(&self) -> AlphaMode {
///         AlphaMode::Blend
///     }
///
///     fn specialize(
///         _: &MaterialPipeline,
///         descriptor: &mut RenderPipelineDescriptor,
///         _: &MeshVertexBufferLayoutRef,
///         _: MaterialPipelineKey<Self>,
///     ) -> Result<(), SpecializedMeshPipelineError> {
///         define_lean_lighting(descriptor);
///         Ok(())
///     }
/// }
/// ```
///
/// ```wgsl
/// // assets/shaders/lagoon.wgsl
/// #import bevy_lean_deferred::lighting::forward::light::apply_lean_lighting
/// #import bevy_pbr::{
///     forward_io::{FragmentOutput, VertexOutput},
///     pbr_fragment::pbr_input_from_vertex_output,
///     pbr_functions::main_pass_post_lighting_processing,
/// }
///
/// @group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> color: vec4<f32>;
///
/// @fragment
/// fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
///     var pbr_input = pbr_input_from_vertex_output(in, is_front, false);
///     pbr_input.material.base_color = color;
///     pbr_input.material.perceptual_roughness = 0.1;
///     let lit = apply_lean_lighting(pbr_input);
///     return FragmentOutput(main_pass_post_lighting_processing(pbr_input, lit));
/// }
/// ```
pub fn define_lean_lighting(descriptor: &mut RenderPipelineDescriptor) {
    let Some(fragment) = &mut descriptor.fragment else {
        return;
    };
    let has = |name| {
        let mut definitions = fragment.shader_defs.iter();
        definitions.any(|definition| name_of(definition) == name)
    };
    if !has(PREPASS) && !has_two_models(has) {
        extend(&mut fragment.shader_defs, None, false);
    }
}

/// Bevy's definition in pipelines of prepasses.
const PREPASS: &str = "PREPASS_PIPELINE";

#[cfg(test)]
mod tests {
    use bevy::material::descriptor::FragmentState;

    use super::*;
    use crate::lighting::forward::reasons::SHADING_MODELS;

    fn is_lit(definitions: &[&str]) -> bool {
        let mut descriptor = RenderPipelineDescriptor {
            fragment: Some(FragmentState {
                shader_defs: definitions.iter().map(|name| (*name).into()).collect(),
                ..Default::default()
            }),
            ..Default::default()
        };
        define_lean_lighting(&mut descriptor);
        let fragment = descriptor.fragment.expect("it was set");
        let mut after = fragment.shader_defs.iter();
        after.any(|definition| name_of(definition) == "FORWARD_MESH")
    }

    #[test]
    fn prepasses_and_surfaces_of_two_models_stay_as_they_are() {
        assert!(is_lit(&[]));
        assert!(!is_lit(&[PREPASS]));
        assert!(SHADING_MODELS.into_iter().all(|model| is_lit(&[model])));
        assert!(!is_lit(&SHADING_MODELS[..2]));
    }
}
