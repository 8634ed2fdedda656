//! Shader definitions of `forward.wgsl`, and of `light.wgsl` in shaders of apps: those of Bevy's pipeline, and those of the light
//! functions.

use bevy::shader::ShaderDefVal;

use crate::{gpu::shader_defs::name_of, lighting::implied::implied_by};

/// Definitions that all these pipelines have. Their loops visit lights of every kind, as Bevy's do: a pipeline per kind of material is
/// compiled, however the lights of the scene change.
pub const ALWAYS: [&str; 6] = [
    "FORWARD_MESH",
    "SPOT_LIGHTS",
    "SPHERE_LIGHTS",
    "DIRECTIONAL_SHADOW_MAPS",
    "POINT_SHADOW_MAPS",
    "SPOT_SHADOW_MAPS",
];

/// Definitions that follow from one of Bevy's.
const WITH_BEVYS: [(&str, &str); 2] = [
    ("PCSS_SAMPLERS_AVAILABLE", "SOFT_SHADOWS"),
    ("LIGHTMAP", "LIGHTMAPPED_SURFACES"),
];

/// Turns the definitions of Bevy's pipeline into those of the crate's, for a mesh with these `layers` if the view has light layers, and
/// with reflections if it `reflects`.
pub fn extend(definitions: &mut Vec<ShaderDefVal>, layers: Option<u32>, reflects: bool) {
    let has = |name: &str| definitions.iter().any(|other| name_of(other) == name);
    // Bevy's shader ignores contact shadows there.
    let drops_contact_shadows = !has("DEPTH_PREPASS");
    let with_bevys = WITH_BEVYS.into_iter().filter(|(bevys, _)| has(bevys));
    let mut names: Vec<&str> = ALWAYS.into_iter().collect();
    names.extend(with_bevys.map(|(_, own)| own));
    names.extend(layers.map(|_| "LIGHT_LAYERS"));
    names.extend(reflects.then_some("FORWARD_REFLECTIONS"));
    let implied: Vec<&str> = names
        .iter()
        .flat_map(|name| implied_by(name))
        .copied()
        .collect();
    for name in implied {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    // The material may have called `define_lean_lighting`.
    names.retain(|name| !has(name));
    if drops_contact_shadows {
        definitions.retain(|definition| name_of(definition) != "CONTACT_SHADOWS");
    }
    definitions.extend(names.into_iter().map(ShaderDefVal::from));
    definitions.extend(layers.map(|layers| ShaderDefVal::UInt("MESH_LAYERS".into(), layers)));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn extended(bevys: &[&str], layers: Option<u32>, reflects: bool) -> Vec<String> {
        let mut definitions = bevys.iter().map(|name| (*name).into()).collect();
        extend(&mut definitions, layers, reflects);
        definitions
            .iter()
            .map(|definition| name_of(definition).into())
            .collect()
    }

    #[test]
    fn definitions_follow_from_bevys() {
        let plain = extended(&["CONTACT_SHADOWS"], None, false);
        for name in ["FORWARD_MESH", "SHADOWS", "GEOMETRIC_NORMAL"] {
            assert_eq!(plain.iter().filter(|other| *other == name).count(), 1);
        }
        for name in [
            "CONTACT_SHADOWS",
            "SOFT_SHADOWS",
            "LIGHT_LAYERS",
            "FORWARD_REFLECTIONS",
            "INDIRECT_LIGHT",
        ] {
            assert!(!plain.iter().any(|other| other == name), "{name}");
        }
        let mut twice = vec!["FORWARD_MESH".into()];
        extend(&mut twice, None, false);
        let count = |name| twice.iter().filter(|other| name_of(other) == name).count();
        assert_eq!(["FORWARD_MESH", "SHADOWS"].map(count), [1, 1]);
        let bevys = [
            "CONTACT_SHADOWS",
            "DEPTH_PREPASS",
            "LIGHTMAP",
            "PCSS_SAMPLERS_AVAILABLE",
        ];
        let more = extended(&bevys, Some(5), true);
        for name in [
            "CONTACT_SHADOWS",
            "LIGHTMAPPED_SURFACES",
            "SOFT_SHADOWS",
            "LIGHT_LAYERS",
            "MESH_LAYERS",
            "FORWARD_REFLECTIONS",
            "INDIRECT_SPECULAR",
            "INDIRECT_LIGHT",
        ] {
            assert!(more.iter().any(|other| other == name), "{name}");
        }
    }
}
