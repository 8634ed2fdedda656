//! The reasons for which Bevy's forward pass draws a mesh of a lean camera.

use core::fmt;

use bevy::prelude::*;

/// The reason that Bevy's forward pass draws a mesh of a lean camera. Its text completes the sentence "Forward draws the
/// mesh: …", and names the change that brings the mesh into the G-buffer, if there is one. `docs/limits.md` lists them.
///
/// [`LeanForwardMeshes`](super::LeanForwardMeshes) counts the meshes of a camera by reason.
/// [`GBufferMaterial::gbuffer_needs`](super::GBufferMaterial::gbuffer_needs) returns the reason of one material.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[reflect(Clone, PartialEq, Hash)]
#[non_exhaustive]
pub enum ForwardReason {
    /// The material requests `OpaqueRendererMethod::Forward`.
    Requested,
    /// The material is blended.
    Blended,
    /// The material has specular transmission.
    Transmissive,
    /// The material has a depth bias, which offsets the depth that positions are reconstructed from.
    DepthBias,
    /// This field of the material is out of the range that the G-buffer stores.
    OutOfRange(&'static str),
    /// The specular tint of the material is coloured, or a texture. Grey ones are reflectance.
    ColoredSpecularTint,
    /// The material has clearcoat on a normal map. The normal of the coat is the mesh's, and one normal is stored.
    NormalMapUnderCoat,
    /// The clearcoat of the material has a normal map. One normal is stored.
    NormalMapOfCoat,
    /// The material has anisotropy on a normal map. Highlights are stretched along the mesh, and one normal is stored.
    NormalMapUnderAnisotropy,
    /// The material needs two special shading models. One is stored.
    TwoShadingModels,
    /// The material has anisotropy, and Bevy is built without its feature `pbr_anisotropy_texture`.
    AnisotropyUnsupported,
    /// The mesh has no normals.
    NoNormals,
    /// The material has anisotropy, and the mesh has no tangents.
    NoTangents,
    /// No [`GBufferMaterialPlugin`](super::GBufferMaterialPlugin) registers the type of the material.
    NotRegistered,
    /// The shader that draws the mesh into the G-buffer cannot be compiled.
    PipelineFailed,
    /// The pipeline of the mesh, or a target that it needs, is not ready yet. Forward draws it until then.
    Compiling,
    /// A reason of a material of the app.
    Custom(&'static str),
}

impl fmt::Display for ForwardReason {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let text = match *self {
            Self::Requested => {
                "its material requests it: set `opaque_render_method` to `Auto` or `Deferred`"
            }
            Self::Blended => "its material is blended: use `AlphaMode::Opaque` or `Mask`",
            Self::Transmissive => {
                "its material has specular transmission: set `specular_transmission` to 0"
            }
            Self::DepthBias => "its material has a depth bias: set `depth_bias` to 0",
            Self::OutOfRange(field) => {
                return write!(
                    f,
                    "`{field}` of its material is out of range: docs/limits.md has the ranges"
                );
            }
            Self::ColoredSpecularTint => {
                "its material has a coloured specular tint: use a grey one, without a texture"
            }
            Self::NormalMapUnderCoat => {
                "its material has clearcoat on a normal map: remove one of them"
            }
            Self::NormalMapOfCoat => {
                "its material has a normal map for its clearcoat: remove the map"
            }
            Self::NormalMapUnderAnisotropy => {
                "its material has anisotropy on a normal map: remove one of them"
            }
            Self::TwoShadingModels => {
                "its material combines two of clearcoat, anisotropy, diffuse transmission, unlit, \
                 and a `ShadingExtension`: keep one"
            }
            Self::AnisotropyUnsupported => {
                "its material has anisotropy: enable Bevy's feature `pbr_anisotropy_texture`"
            }
            Self::NoNormals => "it has no normals: `Mesh::compute_normals` adds them",
            Self::NoTangents => {
                "its material has anisotropy, and it has no tangents: \
                 `Mesh::generate_tangents` adds them"
            }
            Self::NotRegistered => {
                "the type of its material is not registered: add `GBufferMaterialPlugin` for it"
            }
            Self::PipelineFailed => {
                "its shader for the G-buffer cannot be compiled: the log has the error"
            }
            Self::Compiling => "its pipeline or a target is not ready yet",
            Self::Custom(reason) => reason,
        };
        f.write_str(text)
    }
}

#[cfg(test)]
mod tests {
    use bevy::reflect::{TypeInfo, Typed};

    use super::*;

    #[test]
    fn the_documentation_lists_all_reasons() {
        let TypeInfo::Enum(info) = ForwardReason::type_info() else {
            panic!("it is an enum");
        };
        let limits = include_str!("../../docs/limits.md");
        let rows = limits.lines().filter_map(|line| {
            let (name, _) = line.strip_prefix("| `")?.split_once("` |")?;
            Some(name)
        });
        let rows: Vec<_> = rows.collect();
        assert_eq!(rows, info.variant_names());
    }
}
