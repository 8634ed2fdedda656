//! The table of shading models.

use bevy::prelude::*;

/// Bits of a shading model's arguments.
pub const ARGUMENT_BITS: u32 = 17;

/// Largest channel of an unlit colour that is stored.
pub const LARGEST_UNLIT: f32 = 32768.0;

/// Reflection model of a surface, one per pixel. Forward draws materials that need two at once.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq, Hash)]
#[repr(u8)]
pub enum ShadingModel {
    /// Base colour, metallic, roughness.
    #[default]
    Plain = 0,
    /// Entering light scatters and leaves elsewhere. Lit as [`Plain`](Self::Plain), then scattered.
    Subsurface = 1,
    /// Highlights stretched along a tangent.
    Anisotropy = 2,
    /// A highlight along the silhouette.
    Rim = 3,
    /// A second, clear lobe on top.
    Clearcoat = 4,
    /// Light on the back side is transmitted to the front.
    DiffuseTransmission = 5,
    /// The base colour, regardless of light.
    Unlit = 6,
}

/// A row of [`MODELS`].
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// The model; as a number, what the specialization word stores.
    pub model: ShadingModel,
    /// The name of that number in `specialization.wgsl` and, in lower case, of the model's files.
    pub name: &'static str,
    /// The definition with which lighting is compiled for surfaces of the model, if it lights them by code of their own.
    pub shader_def: Option<&'static str>,
    /// Bits of the arguments. An unlit surface has none: its colour takes most of the word.
    pub argument_bits: u32,
    /// Colour of a special model in [`DebugView::ShadingModel`](crate::DebugView::ShadingModel).
    pub debug_color: Option<[f32; 3]>,
}

/// All shading models, in the order of their numbers.
pub const MODELS: [Model; 7] = [
    Model {
        model: ShadingModel::Plain,
        name: "PLAIN",
        shader_def: None,
        argument_bits: 0,
        debug_color: None,
    },
    Model {
        model: ShadingModel::Subsurface,
        name: "SUBSURFACE",
        shader_def: None,
        argument_bits: 17,
        debug_color: Some([0.9, 0.4, 0.3]),
    },
    Model {
        model: ShadingModel::Anisotropy,
        name: "ANISOTROPY",
        shader_def: Some("STANDARD_MATERIAL_ANISOTROPY"),
        argument_bits: 17,
        debug_color: Some([0.9, 0.8, 0.1]),
    },
    Model {
        model: ShadingModel::Rim,
        name: "RIM",
        shader_def: Some("SHADING_MODEL_RIM"),
        argument_bits: 17,
        debug_color: Some([0.2, 0.8, 0.9]),
    },
    Model {
        model: ShadingModel::Clearcoat,
        name: "CLEARCOAT",
        shader_def: Some("STANDARD_MATERIAL_CLEARCOAT"),
        argument_bits: 16,
        debug_color: Some([0.1, 0.2, 0.9]),
    },
    Model {
        model: ShadingModel::DiffuseTransmission,
        name: "DIFFUSE_TRANSMISSION",
        shader_def: Some("STANDARD_MATERIAL_DIFFUSE_TRANSMISSION"),
        argument_bits: 17,
        debug_color: Some([0.2, 0.8, 0.2]),
    },
    Model {
        model: ShadingModel::Unlit,
        name: "UNLIT",
        shader_def: None,
        argument_bits: 0,
        debug_color: Some([0.8, 0.1, 0.8]),
    },
];

const _: () = {
    let mut number = 0;
    while number < MODELS.len() {
        assert!(MODELS[number].model as usize == number);
        assert!(MODELS[number].argument_bits <= ARGUMENT_BITS);
        number += 1;
    }
};
