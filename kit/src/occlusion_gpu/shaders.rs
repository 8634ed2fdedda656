//! The shipped shaders, composed as the crate composes them.

use std::{borrow::Cow, collections::HashMap};

use bevy::math::Mat4;
use bevy_lean_deferred::ambient_occlusion::{
    LeanAmbientOcclusion, OcclusionFilter as Filter, OcclusionFormat, OcclusionKernel,
    OcclusionQuality, OcclusionResolution,
};
use bevy_lean_deferred::shader_library::reconstruction::position::projection_of;
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
};

use super::OcclusionGpu;

/// The modules that `gather.wgsl` and `merge.wgsl` import, in the order of their own imports.
const MODULES: [(&str, &str); 12] = [
    (
        "layout.wgsl",
        include_str!("../../../src/shader_library/layout.wgsl"),
    ),
    (
        "tiles.wgsl",
        include_str!("../../../src/shader_library/tiles.wgsl"),
    ),
    (
        "position.wgsl",
        include_str!("../../../src/shader_library/reconstruction/position.wgsl"),
    ),
    (
        "normal.wgsl",
        include_str!("../../../src/shader_library/reconstruction/normal.wgsl"),
    ),
    (
        "view.wgsl",
        include_str!("../../../src/ambient_occlusion/view.wgsl"),
    ),
    (
        "horizon.wgsl",
        include_str!("../../../src/shader_library/horizon.wgsl"),
    ),
    (
        "rounding.wgsl",
        include_str!("../../../src/shader_library/rounding.wgsl"),
    ),
    (
        "normal_from_depth.wgsl",
        include_str!("../../../src/shader_library/reconstruction/normal_from_depth.wgsl"),
    ),
    (
        "bindings.wgsl",
        include_str!("../../../src/ambient_occlusion/bindings.wgsl"),
    ),
    (
        "hbao.wgsl",
        include_str!("../../../src/ambient_occlusion/hbao.wgsl"),
    ),
    (
        "hdao.wgsl",
        include_str!("../../../src/ambient_occlusion/hdao.wgsl"),
    ),
    (
        "filter.wgsl",
        include_str!("../../../src/ambient_occlusion/filter.wgsl"),
    ),
];
pub(super) const GATHER: &str = include_str!("../../../src/ambient_occlusion/gather.wgsl");
pub(super) const MERGE: &str = include_str!("../../../src/ambient_occlusion/merge.wgsl");

impl OcclusionGpu {
    pub(super) fn shader(
        &self,
        source: &'static str,
        defs: HashMap<String, ShaderDefValue>,
    ) -> wgpu::ShaderModule {
        let mut key: Vec<String> = defs.iter().map(|def| format!("{def:?}")).collect();
        key.sort();
        let mut shaders = self.shaders.lock().expect("no test panics in here");
        let shader = shaders.entry((source, key));
        shader.or_insert_with(|| self.compose(source, defs)).clone()
    }

    fn compose(
        &self,
        source: &'static str,
        defs: HashMap<String, ShaderDefValue>,
    ) -> wgpu::ShaderModule {
        let mut composer = Composer::default();
        composer.validate = false;
        for (path, source) in MODULES {
            let added = composer
                .add_composable_module(ComposableModuleDescriptor {
                    source,
                    file_path: path,
                    ..Default::default()
                })
                .map(|_| ());
            if let Err(error) = added {
                panic!("{}", error.emit_to_string(&composer));
            }
        }
        let composed = composer.make_naga_module(NagaModuleDescriptor {
            source,
            file_path: "occlusion.wgsl",
            shader_defs: defs,
            ..Default::default()
        });
        let module = composed.unwrap_or_else(|error| panic!("{}", error.emit_to_string(&composer)));
        self.device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: None,
                source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
            })
    }
}

/// As the crate compiles the gather for `settings`, on a camera without a G-buffer.
pub(super) fn gather_definitions(
    settings: &LeanAmbientOcclusion,
    clip_from_view: Mat4,
) -> HashMap<String, ShaderDefValue> {
    let divisor = if settings.resolution == OcclusionResolution::Half {
        2
    } else {
        1
    };
    let (slices, steps) = settings.quality.samples();
    let mut values = vec![("DIVISOR", divisor)];
    if !matches!(settings.quality, OcclusionQuality::Custom { .. }) {
        values.extend([("SLICES", slices), ("STEPS", steps)]);
    }
    let mut defs: HashMap<_, _> = values
        .into_iter()
        .map(|(name, value)| (name.to_string(), ShaderDefValue::UInt(value)))
        .collect();
    let flags = [
        (settings.kernel == OcclusionKernel::Hdao, "HDAO"),
        (settings.thickness < 1.0, "THIN"),
        (settings.has_wide_pattern(), "WIDE_PATTERN"),
        (settings.format == OcclusionFormat::Float16, "FLOAT16"),
    ];
    insert_flags(&mut defs, &flags);
    let projection = projection_of(clip_from_view).shader_def();
    defs.extend(projection.map(|name| (name.into(), ShaderDefValue::Bool(true))));
    defs
}

/// Whether the crate's compute pass reads depths once for a workgroup.
pub(super) fn shares_depths(settings: &LeanAmbientOcclusion) -> bool {
    settings.kernel == OcclusionKernel::Hbao && settings.resolution == OcclusionResolution::Full
}

/// As the crate compiles the filter, for its debug view.
pub(super) fn filter_definitions(
    settings: &LeanAmbientOcclusion,
) -> HashMap<String, ShaderDefValue> {
    let half = settings.resolution == OcclusionResolution::Half;
    let filter = settings.filter;
    let mut defs = HashMap::new();
    let flags = [
        (true, "DEBUG_VIEW"),
        (half, "OCCLUSION_HALF"),
        (
            !half && matches!(filter, Filter::Flat | Filter::FlatEdgeAware),
            "OCCLUSION_FLAT",
        ),
        (settings.has_wide_pattern(), "OCCLUSION_WIDE"),
        (filter.is_edge_aware(), "OCCLUSION_EDGE_AWARE"),
    ];
    insert_flags(&mut defs, &flags);
    defs
}

fn insert_flags(defs: &mut HashMap<String, ShaderDefValue>, flags: &[(bool, &str)]) {
    for (condition, name) in flags {
        if *condition {
            defs.insert((*name).into(), ShaderDefValue::Bool(true));
        }
    }
}
