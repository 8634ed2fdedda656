//! The shipped shaders, composed as the crate composes them.

use std::borrow::Cow;

use bevy::math::Mat4;
use bevy_lean_deferred::{
    effects::ambient_occlusion::{LeanScreenSpaceAmbientOcclusion, OcclusionKernel},
    shader_library::reconstruction::position::projection_of,
    view::LeanResolution,
};
use naga_oil::compose::ShaderDefValue;

use super::OcclusionGpu;
use crate::{
    shader_files::shader_file,
    wgsl::{Definitions, WgslModule, compile, key_of, numbers, wgsl},
};

/// Modules that `gather.wgsl` and `debug_view.wgsl` import, dependencies first.
const MODULES: [WgslModule; 13] = [
    wgsl!("shader_library/layout.wgsl"),
    wgsl!("shader_library/tiles.wgsl"),
    wgsl!("shader_library/reconstruction/position.wgsl"),
    wgsl!("shader_library/reconstruction/normal.wgsl"),
    wgsl!("shader_library/occlusion_filter.wgsl"),
    wgsl!("effects/ambient_occlusion/view.wgsl"),
    wgsl!("shader_library/horizon.wgsl"),
    wgsl!("shader_library/rounding.wgsl"),
    wgsl!("shader_library/reconstruction/normal_from_depth.wgsl"),
    wgsl!("effects/ambient_occlusion/bindings.wgsl"),
    wgsl!("effects/ambient_occlusion/lattice.wgsl"),
    wgsl!("effects/ambient_occlusion/hbao.wgsl"),
    wgsl!("effects/ambient_occlusion/hdao.wgsl"),
];

pub(super) fn sparse_depth() -> Cow<'static, str> {
    shader_file(&wgsl!("effects/ambient_occlusion/sparse_depth.wgsl"))
}

pub(super) fn gather() -> Cow<'static, str> {
    shader_file(&wgsl!("effects/ambient_occlusion/gather.wgsl"))
}

pub(super) fn debug_view() -> Cow<'static, str> {
    shader_file(&wgsl!("effects/ambient_occlusion/debug_view.wgsl"))
}

impl OcclusionGpu {
    pub(super) fn shader(&self, source: &str, definitions: Definitions) -> wgpu::ShaderModule {
        let mut shaders = self.shaders.lock().expect("no test panics in here");
        let shader = shaders.entry((source.to_owned(), key_of(&definitions)));
        let module = shader.or_insert_with(|| compile(&self.device, &MODULES, source, definitions));
        module.clone()
    }
}

/// Definitions of the crate's gather for `settings`, on a camera without a G-buffer.
pub(super) fn gather_definitions(
    settings: &LeanScreenSpaceAmbientOcclusion,
    clip_from_view: Mat4,
) -> Definitions {
    let (slices, steps) = settings.samples();
    let mut defs = numbers(&[("SLICES", slices), ("STEPS", steps)]);
    let flags = [
        (settings.advanced.kernel == OcclusionKernel::Hdao, "HDAO"),
        (settings.thickness.is_some(), "THIN"),
    ];
    insert_flags(&mut defs, &flags);
    let projection = projection_of(clip_from_view).shader_def();
    defs.extend(projection.map(|name| (name.into(), ShaderDefValue::Bool(true))));
    defs
}

/// True if the crate's compute pass loads depths once per workgroup.
pub(super) fn shares_depths(settings: &LeanScreenSpaceAmbientOcclusion) -> bool {
    settings.advanced.kernel == OcclusionKernel::Hbao && settings.resolution == LeanResolution::Full
}

/// Definitions of the crate's filter.
pub(super) fn filter_definitions(settings: &LeanScreenSpaceAmbientOcclusion) -> Definitions {
    let mut defs = Definitions::new();
    let flags = [
        (
            settings.resolution == LeanResolution::Half,
            "OCCLUSION_HALF",
        ),
        (settings.has_wide_pattern(), "OCCLUSION_WIDE"),
        (settings.advanced.edge_aware, "OCCLUSION_EDGE_AWARE"),
    ];
    insert_flags(&mut defs, &flags);
    defs
}

fn insert_flags(defs: &mut Definitions, flags: &[(bool, &str)]) {
    for (condition, name) in flags {
        if *condition {
            defs.insert((*name).into(), ShaderDefValue::Bool(true));
        }
    }
}
