//! Device limits that compute shaders use are in the table of needed limits of their effect.

use bevy_lean_deferred::{
    activation::{self, NeededLimit},
    effects::{self, ambient_occlusion, auto_exposure, subsurface},
};
use naga::{
    AddressSpace, ImageClass, ShaderStage, TypeInner,
    proc::Layouter,
    valid::{Capabilities, ValidationFlags, Validator},
};
use wgpu::Limits;

use super::shaders::{self, Composed};

/// Tables of needed limits for the shader `file`. All effects on lean cameras need the first.
fn tables(file: &str) -> Vec<&'static [NeededLimit]> {
    if file.starts_with("effects/auto_exposure/") {
        return vec![auto_exposure::NEEDED_LIMITS];
    }
    if file.starts_with("effects/ambient_occlusion/") {
        return vec![ambient_occlusion::COMPUTE_LIMITS];
    }
    let of_effect = if file.starts_with("effects/subsurface/") {
        subsurface::NEEDED_LIMITS
    } else if file.starts_with("effects/") {
        effects::NEEDED_LIMITS
    } else {
        &[]
    };
    vec![activation::NEEDED_LIMITS, of_effect]
}

/// Limits of a device that has what `tables` require, and of all else what WebGPU guarantees.
fn least(tables: &[&[NeededLimit]]) -> Limits {
    let mut limits = Limits::default();
    for (name, field) in FIELDS {
        let needed = tables.iter().copied().flatten();
        let needed = needed.filter(|needed| needed.name == name);
        *field(&mut limits) = needed.map(|needed| needed.least).max().unwrap_or(0);
    }
    limits
}

type Field = fn(&mut Limits) -> &mut u32;

/// Limits that are compared.
const FIELDS: [(&str, Field); 5] = [
    ("max_compute_invocations_per_workgroup", |limits| {
        &mut limits.max_compute_invocations_per_workgroup
    }),
    ("max_compute_workgroup_size_x", |limits| {
        &mut limits.max_compute_workgroup_size_x
    }),
    ("max_compute_workgroup_storage_size", |limits| {
        &mut limits.max_compute_workgroup_storage_size
    }),
    ("max_storage_buffers_per_shader_stage", |limits| {
        &mut limits.max_storage_buffers_per_shader_stage
    }),
    ("max_storage_textures_per_shader_stage", |limits| {
        &mut limits.max_storage_textures_per_shader_stage
    }),
];

/// Every device with workgroups has this much shared memory, in bytes.
const FREE_STORAGE: u32 = 1024;

/// Limits that the compute entry point of a shader uses, in the order of [`FIELDS`]; `None` if it has none.
fn used(composed: &Composed) -> Option<[u32; FIELDS.len()]> {
    let module = &composed.module;
    let index = (module.entry_points.iter()).position(|e| e.stage == ShaderStage::Compute)?;
    let [x, y, z] = module.entry_points[index].workgroup_size;
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(module)
        .expect("it is valid");
    let info = info.get_entry_point(index);
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).expect("it has a layout");
    let (mut storage, mut buffers, mut textures) = (0, 0, 0);
    for (handle, variable) in module.global_variables.iter() {
        if info[handle].is_empty() {
            continue;
        }
        match variable.space {
            AddressSpace::WorkGroup => {
                storage += layouter[variable.ty].size.next_multiple_of(16);
            }
            AddressSpace::Storage { .. } => buffers += 1,
            AddressSpace::Handle => {
                let inner = &module.types[variable.ty].inner;
                let is_storage = matches!(
                    inner,
                    TypeInner::Image {
                        class: ImageClass::Storage { .. },
                        ..
                    }
                );
                textures += u32::from(is_storage);
            }
            _ => {}
        }
    }
    let storage = if storage < FREE_STORAGE { 0 } else { storage };
    Some([x * y * z, x, storage, buffers, textures])
}

#[test]
fn the_tables_of_needs_have_what_shaders_use() {
    let plain = shaders::lighting(&["LIGHT_LAYERS", "GBUFFER_VISIBILITY_MASK", "LISTED_VARIANTS"]);
    let mut failures = Vec::new();
    let mut check = |composed: &Composed, tables: &[&[NeededLimit]]| {
        let Some(used) = used(composed) else {
            return;
        };
        println!("{}: {used:?}", composed.file);
        let mut least = least(tables);
        for ((name, field), used) in FIELDS.into_iter().zip(used) {
            let least = *field(&mut least);
            if used > least {
                failures.push(format!("{}: {name} of {used}, not {least}", composed.file));
            }
        }
    };
    check(&plain, &[activation::NEEDED_LIMITS]);
    for composed in shaders::all() {
        let mut tables = tables(composed.file);
        // Lighting of scattering surfaces writes more.
        if composed.file.starts_with("lighting/") {
            tables.push(subsurface::NEEDED_LIMITS);
        }
        check(composed, &tables);
    }
    assert!(failures.is_empty(), "{failures:#?}");
}
