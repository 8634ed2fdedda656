//! The reasons for which Bevy's fragment shader lights a mesh in Bevy's passes.

use core::fmt;

use bevy::{material::descriptor::RenderPipelineDescriptor, prelude::*};

use crate::gpu::shader_defs::name_of;

/// The reason that Bevy's fragment shader lights a mesh of a lean view, in place of the crate's. Its text completes the sentence
/// "Bevy lights the mesh: …". `docs/limits.md` lists those that a lean view can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BevyLitReason {
    /// The fragment shader of the material is not that of `StandardMaterial`.
    OtherShader,
    /// Specular transmission reads the picture behind the mesh.
    SpecularTransmission,
    /// Clearcoat, and a normal map of the base or of the coat: the light functions have one normal.
    TwoNormals,
    /// Two of clearcoat, anisotropy and diffuse transmission: the light functions have the terms of one shading model.
    TwoModels,
    /// Anisotropy on a mesh without tangents, which forward gives a look of its own.
    NoTangents,
    /// The mesh has no normals, and forward lights with undefined ones.
    NoNormals,
    /// A forward decal.
    ForwardDecal,
    /// The view has order-independent transparency.
    OrderIndependentTransparency,
    /// The view has MSAA.
    Multisampled,
    /// A pipeline of another layout than Bevy's meshes have.
    OtherLayout,
}

/// Definitions of materials whose light has terms of its own.
pub(super) const SHADING_MODELS: [&str; 3] = [
    "STANDARD_MATERIAL_CLEARCOAT",
    "STANDARD_MATERIAL_ANISOTROPY",
    "STANDARD_MATERIAL_DIFFUSE_TRANSMISSION",
];

/// True if a material has the terms of more than one of them.
pub(super) fn has_two_models(has: impl Fn(&'static str) -> bool) -> bool {
    SHADING_MODELS
        .map(has)
        .into_iter()
        .filter(|has| *has)
        .count()
        > 1
}

/// True if the fragment shader of a material calls the light functions, which `define_lean_lighting` was called for, and its pipeline has
/// what Bevy's meshes have beside it.
pub(super) fn calls_light_functions(descriptor: &RenderPipelineDescriptor) -> bool {
    let Some(fragment) = &descriptor.fragment else {
        return false;
    };
    let has = |name| {
        let mut definitions = fragment.shader_defs.iter();
        definitions.any(|definition| name_of(definition) == name)
    };
    has("FORWARD_MESH")
        && !has("OIT_ENABLED")
        && !has("MULTISAMPLED")
        && descriptor.layout.len() == BEVYS_GROUPS
}

/// Number of bind groups of Bevy's meshes: view, arrays of the view, mesh, material.
pub(super) const BEVYS_GROUPS: usize = 4;

impl BevyLitReason {
    /// The reason for a pipeline of Bevy's, if there is any. `standard` is the fragment shader of `StandardMaterial`.
    pub(super) fn of(
        descriptor: &RenderPipelineDescriptor,
        standard: AssetId<Shader>,
    ) -> Option<Self> {
        let fragment = descriptor.fragment.as_ref()?;
        let has = |name| {
            let mut definitions = fragment.shader_defs.iter();
            definitions.any(|definition| name_of(definition) == name)
        };
        let has_normal_map =
            has("STANDARD_MATERIAL_NORMAL_MAP") || has("STANDARD_MATERIAL_CLEARCOAT_NORMAL_MAP");
        let reasons = [
            (fragment.shader.id() != standard, Self::OtherShader),
            (
                has("STANDARD_MATERIAL_SPECULAR_TRANSMISSION"),
                Self::SpecularTransmission,
            ),
            (
                has("STANDARD_MATERIAL_CLEARCOAT") && has_normal_map,
                Self::TwoNormals,
            ),
            (has_two_models(has), Self::TwoModels),
            (
                has("STANDARD_MATERIAL_ANISOTROPY") && !has("VERTEX_TANGENTS"),
                Self::NoTangents,
            ),
            (!has("VERTEX_NORMALS"), Self::NoNormals),
            (has("FORWARD_DECAL"), Self::ForwardDecal),
            (has("OIT_ENABLED"), Self::OrderIndependentTransparency),
            (has("MULTISAMPLED"), Self::Multisampled),
            (descriptor.layout.len() != BEVYS_GROUPS, Self::OtherLayout),
        ];
        let mut reasons = reasons.into_iter();
        reasons.find_map(|(holds, reason)| holds.then_some(reason))
    }
}

impl fmt::Display for BevyLitReason {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::OtherShader => "its fragment shader is not that of `StandardMaterial`",
            Self::SpecularTransmission => "its material has specular transmission",
            Self::TwoNormals => "its material has clearcoat and a normal map",
            Self::TwoModels => {
                "its material has two of clearcoat, anisotropy and diffuse transmission"
            }
            Self::NoTangents => "its material is anisotropic and its mesh has no tangents",
            Self::NoNormals => "it has no normals",
            Self::ForwardDecal => "it is a forward decal",
            Self::OrderIndependentTransparency => "the view has order-independent transparency",
            Self::Multisampled => "the view has MSAA",
            Self::OtherLayout => "its pipeline has other bind groups than Bevy's meshes",
        })
    }
}

#[cfg(test)]
mod tests {
    use bevy::{asset::uuid_handle, material::descriptor::FragmentState};

    use super::*;

    const STANDARD: Handle<Shader> = uuid_handle!("6b1c0f0e-3d0f-4b0a-8a39-0c4f6e4f4a11");

    fn descriptor(shader: Handle<Shader>, definitions: &[&str]) -> RenderPipelineDescriptor {
        RenderPipelineDescriptor {
            layout: vec![default(); BEVYS_GROUPS],
            fragment: Some(FragmentState {
                shader,
                shader_defs: definitions.iter().map(|name| (*name).into()).collect(),
                ..default()
            }),
            ..default()
        }
    }

    fn reason(definitions: &[&str]) -> Option<BevyLitReason> {
        let definitions = [definitions, &["VERTEX_NORMALS", "DISTANCE_FOG"]].concat();
        BevyLitReason::of(&descriptor(STANDARD, &definitions), STANDARD.id())
    }

    #[test]
    fn what_the_light_functions_cannot_light_is_lit_by_bevy() {
        use BevyLitReason as Reason;
        assert_eq!(reason(&[]), None);
        assert_eq!(reason(&["STANDARD_MATERIAL_NORMAL_MAP"]), None);
        assert_eq!(reason(&["STANDARD_MATERIAL_CLEARCOAT"]), None);
        let coat = "STANDARD_MATERIAL_CLEARCOAT";
        for map in [
            "STANDARD_MATERIAL_NORMAL_MAP",
            "STANDARD_MATERIAL_CLEARCOAT_NORMAL_MAP",
        ] {
            assert_eq!(reason(&[coat, map]), Some(Reason::TwoNormals));
        }
        for other in [
            "STANDARD_MATERIAL_DIFFUSE_TRANSMISSION",
            "STANDARD_MATERIAL_ANISOTROPY",
        ] {
            assert_eq!(reason(&[coat, other]), Some(Reason::TwoModels));
        }
        let anisotropy = "STANDARD_MATERIAL_ANISOTROPY";
        assert_eq!(reason(&[anisotropy]), Some(Reason::NoTangents));
        assert_eq!(reason(&[anisotropy, "VERTEX_TANGENTS"]), None);
        for (name, expected) in [
            (
                "STANDARD_MATERIAL_SPECULAR_TRANSMISSION",
                Reason::SpecularTransmission,
            ),
            ("FORWARD_DECAL", Reason::ForwardDecal),
            ("OIT_ENABLED", Reason::OrderIndependentTransparency),
            ("MULTISAMPLED", Reason::Multisampled),
        ] {
            assert_eq!(reason(&[name]), Some(expected));
        }
        let bare = descriptor(STANDARD, &[]);
        assert_eq!(
            BevyLitReason::of(&bare, STANDARD.id()),
            Some(Reason::NoNormals)
        );
        let other = descriptor(Handle::default(), &["VERTEX_NORMALS"]);
        assert_eq!(
            BevyLitReason::of(&other, STANDARD.id()),
            Some(Reason::OtherShader)
        );
        let mut more_groups = descriptor(STANDARD, &["VERTEX_NORMALS"]);
        more_groups.layout.push(default());
        assert_eq!(
            BevyLitReason::of(&more_groups, STANDARD.id()),
            Some(Reason::OtherLayout)
        );
    }

    #[test]
    fn the_documentation_lists_all_reasons() {
        let limits = include_str!("../../../docs/limits.md");
        for reason in [
            BevyLitReason::OtherShader,
            BevyLitReason::SpecularTransmission,
            BevyLitReason::TwoNormals,
            BevyLitReason::TwoModels,
            BevyLitReason::NoTangents,
            BevyLitReason::NoNormals,
            BevyLitReason::ForwardDecal,
            BevyLitReason::OrderIndependentTransparency,
        ] {
            assert!(limits.contains(&reason.to_string()), "{reason}");
        }
    }
}
