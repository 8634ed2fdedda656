//! Structs in uniforms and storage buffers have the same layout in Rust and WGSL.

use std::collections::{BTreeMap, BTreeSet};

use bevy::{
    reflect::{TypeInfo, Typed},
    render::render_resource::{AsBindGroup, ShaderType, encase::private::StructMetadata},
};
use bevy_lean_deferred::{
    effects::{
        ambient_occlusion::OcclusionUniform,
        auto_exposure::{ExposureState, ExposureUniform},
        diffuse_gi::GiUniform,
        history::HistoryUniform,
        reflections::ReflectionUniform,
        subsurface::SubsurfaceUniform,
    },
    lighting::{LightLayersTable, LightingUniform, forward::ForwardReflectionUniform},
    material_extension::{ExtensionUniform, ShadingExtension},
    shader_library::distance_fog::FogUniform,
};
use naga::{AddressSpace, Handle, Module, Type, TypeInner};

use super::{
    shaders::{self, Composed},
    shipped::Place,
};

/// The names and offsets of a struct's fields, and its size.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Layout {
    fields: Vec<(String, u64)>,
    size: u64,
}

/// Layout of `T` in Rust.
fn layout_of<T, const N: usize>() -> Layout
where
    T: ShaderType<ExtraMetadata = StructMetadata<N>> + Typed,
{
    let TypeInfo::Struct(info) = T::type_info() else {
        panic!("{} is a struct", T::type_path());
    };
    assert_eq!(info.field_len(), N, "{}", T::type_path());
    let field = |i: usize| {
        let field = info.field_at(i).expect("it has as many");
        (field.name().to_string(), T::METADATA.offset(i))
    };
    Layout {
        fields: (0..N).map(field).collect(),
        size: T::min_size().get(),
    }
}

/// Layout of the table that Bevy fills for a bindless material: a word per resource of the range.
fn layout_of_indices() -> Layout {
    let descriptor = ShadingExtension::bindless_descriptor().expect("it is bindless");
    let [table] = &*descriptor.index_tables else {
        panic!("there is one table");
    };
    let places = table.indices.start.0..table.indices.end.0;
    assert_eq!(places.len(), 1, "and one resource in it");
    Layout {
        fields: vec![("extension".into(), 0)],
        size: 4 * places.len() as u64,
    }
}

fn structs_of_rust() -> BTreeMap<Place, Layout> {
    [
        (
            "lighting/bindings.wgsl",
            "LightingUniform",
            layout_of::<LightingUniform, _>(),
        ),
        (
            "lighting/bindings.wgsl",
            "LightLayersTable",
            layout_of::<LightLayersTable, _>(),
        ),
        (
            "lighting/forward/bindings.wgsl",
            "ForwardReflectionUniform",
            layout_of::<ForwardReflectionUniform, _>(),
        ),
        (
            "effects/ambient_occlusion/view.wgsl",
            "OcclusionUniform",
            layout_of::<OcclusionUniform, _>(),
        ),
        (
            "effects/auto_exposure/bindings.wgsl",
            "ExposureUniform",
            layout_of::<ExposureUniform, _>(),
        ),
        (
            "effects/auto_exposure/bindings.wgsl",
            "ExposureState",
            layout_of::<ExposureState, _>(),
        ),
        (
            "effects/diffuse_gi/view.wgsl",
            "GiUniform",
            layout_of::<GiUniform, _>(),
        ),
        (
            "effects/history/levels.wgsl",
            "HistoryUniform",
            layout_of::<HistoryUniform, _>(),
        ),
        (
            "effects/reflections/view.wgsl",
            "ReflectionUniform",
            layout_of::<ReflectionUniform, _>(),
        ),
        (
            "effects/subsurface/view.wgsl",
            "SubsurfaceUniform",
            layout_of::<SubsurfaceUniform, _>(),
        ),
        (
            "shader_library/distance_fog.wgsl",
            "FogUniform",
            layout_of::<FogUniform, _>(),
        ),
        (
            "material_extension/extension.wgsl",
            "Extension",
            layout_of::<ExtensionUniform, _>(),
        ),
        (
            "material_extension/extension.wgsl",
            "ExtensionIndices",
            layout_of_indices(),
        ),
    ]
    .into_iter()
    .map(|(file, name, layout)| ((file.into(), name.into()), layout))
    .collect()
}

/// Collects the crate's structs in a type, at any depth.
fn structs_in(composed: &Composed, ty: Handle<Type>, found: &mut BTreeMap<Place, Layout>) {
    let ty = &composed.module.types[ty];
    match &ty.inner {
        TypeInner::Array { base, .. } | TypeInner::BindingArray { base, .. } => {
            structs_in(composed, *base, found);
        }
        TypeInner::Struct { members, span } => {
            for member in members {
                structs_in(composed, member.ty, found);
            }
            let name = ty.name.as_deref().expect("structs have names");
            let Some(place) = composed.place(name) else {
                return;
            };
            let fields = members.iter().map(|member| {
                let name = member.name.clone().expect("fields have names");
                (name, u64::from(member.offset))
            });
            let layout = Layout {
                fields: fields.collect(),
                size: u64::from(*span),
            };
            if let Some(other) = found.insert(place.clone(), layout.clone()) {
                assert_eq!(other, layout, "{place:?} with other definitions");
            }
        }
        _ => {}
    }
}

/// Types of the variables that the application fills.
fn shared_types(module: &Module) -> impl Iterator<Item = Handle<Type>> {
    let variables = module.global_variables.iter();
    variables
        .filter(|(_, variable)| {
            matches!(
                variable.space,
                AddressSpace::Uniform | AddressSpace::Storage { .. }
            )
        })
        .map(|(_, variable)| variable.ty)
}

#[test]
fn structs_are_laid_out_alike() {
    let mut in_wgsl = BTreeMap::new();
    for composed in shaders::all() {
        for ty in shared_types(&composed.module) {
            structs_in(composed, ty, &mut in_wgsl);
        }
    }
    let in_rust = structs_of_rust();
    let names = |structs: &BTreeMap<Place, Layout>| -> BTreeSet<Place> {
        structs.keys().cloned().collect()
    };
    let (in_one, in_other) = (names(&in_wgsl), names(&in_rust));
    let only_one: Vec<&Place> = in_one.symmetric_difference(&in_other).collect();
    assert!(only_one.is_empty(), "only one side has {only_one:?}");
    for (place, layout) in &in_rust {
        assert_eq!(&in_wgsl[place], layout, "{place:?}");
    }
}
