//! The textures of a `StandardMaterial` that exist only with features of Bevy, which this crate cannot see: it finds the fields by
//! reflection.

use bevy::{pbr::StandardMaterial, reflect::structs::Struct, shader::ShaderDefVal};

/// True if Bevy is built with the feature of the texture `field`.
pub(in crate::gbuffer) fn has_field(material: &StandardMaterial, field: &str) -> bool {
    material.field(field).is_some()
}

/// True if the optional texture `field` is set.
pub(in crate::gbuffer) fn has_texture(material: &StandardMaterial, field: &str) -> bool {
    material
        .field(field)
        .and_then(|value| value.reflect_ref().as_enum().ok())
        .is_some_and(|option| option.variant_name() == "Some")
}

/// Definitions with which Bevy's shaders read the feature-gated textures of a `StandardMaterial`. Bevy's prepass does
/// not set them.
pub(in crate::gbuffer) fn material_texture_defs() -> Vec<ShaderDefVal> {
    let material = StandardMaterial::default();
    [
        (
            "diffuse_transmission_texture",
            "PBR_TRANSMISSION_TEXTURES_SUPPORTED",
        ),
        (
            "clearcoat_texture",
            "PBR_MULTI_LAYER_MATERIAL_TEXTURES_SUPPORTED",
        ),
        ("anisotropy_texture", "PBR_ANISOTROPY_TEXTURE_SUPPORTED"),
        ("specular_texture", "PBR_SPECULAR_TEXTURES_SUPPORTED"),
    ]
    .into_iter()
    .filter(|(field, _)| has_field(&material, field))
    .map(|(_, name)| name.into())
    .collect()
}
