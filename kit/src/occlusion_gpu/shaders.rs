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
use crate::{compute::WgslModule, shader_files::shader_file};

macro_rules! shader {
    ($path:literal) => {
        WgslModule {
            path: concat!("src/", $path),
            source: include_str!(concat!("../../../src/", $path)),
        }
    };
}

/// The modules that `gather.wgsl` and `merge.wgsl` import, in the order of their own imports.
const MODULES: [WgslModule; 12] = [
    shader!("shader_library/layout.wgsl"),
    shader!("shader_library/tiles.wgsl"),
    shader!("shader_library/reconstruction/position.wgsl"),
    shader!("shader_library/reconstruction/normal.wgsl"),
    shader!("ambient_occlusion/view.wgsl"),
    shader!("shader_library/horizon.wgsl"),
    shader!("shader_library/rounding.wgsl"),
    shader!("shader_library/reconstruction/normal_from_depth.wgsl"),
    shader!("ambient_occlusion/bindings.wgsl"),
    shader!("ambient_occlusion/hbao.wgsl"),
    shader!("ambient_occlusion/hdao.wgsl"),
    shader!("ambient_occlusion/filter.wgsl"),
];

pub(super) fn gather() -> Cow<'static, str> {
    shader_file(&shader!("ambient_occlusion/gather.wgsl"))
}

pub(super) fn merge() -> Cow<'static, str> {
    shader_file(&shader!("ambient_occlusion/merge.wgsl"))
}

impl OcclusionGpu {
    pub(super) fn shader(
        &self,
        source: &str,
        defs: HashMap<String, ShaderDefValue>,
    ) -> wgpu::ShaderModule {
        let mut key: Vec<String> = defs.iter().map(|def| format!("{def:?}")).collect();
        key.sort();
        let mut shaders = self.shaders.lock().expect("no test panics in here");
        let shader = shaders.entry((source.to_owned(), key));
        shader.or_insert_with(|| self.compose(source, defs)).clone()
    }

    fn compose(&self, source: &str, defs: HashMap<String, ShaderDefValue>) -> wgpu::ShaderModule {
        let mut composer = Composer::default();
        composer.validate = false;
        for module in MODULES {
            let added = composer
                .add_composable_module(ComposableModuleDescriptor {
                    source: &shader_file(&module),
                    file_path: module.path,
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
