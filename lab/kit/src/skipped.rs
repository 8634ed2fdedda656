//! Announces what tests cannot show on the chosen device. `tests/drivers.sh` counts such lines.

use bevy::render::{
    RenderApp,
    batching::gpu_preprocessing::{GpuPreprocessingMode, GpuPreprocessingSupport},
    renderer::RenderDevice,
};
use bevy_lean_deferred::effects::subsurface::missing_for_scattering;
use wgpu::{Features, Limits};

use crate::{
    device::BINDING_ARRAYS,
    gpu,
    headless::Headless,
    occlusion_gpu::{OcclusionGpu, Path},
    own_process::in_own_process,
};

/// True if a device with these limits supports subsurface scattering. Says so if not.
pub fn has_room_for_scattering(limits: &Limits) -> bool {
    let missing = missing_for_scattering(limits);
    if let Some(missing) = missing {
        println!("skipped: subsurface scattering: the device lacks {missing}");
    }
    missing.is_none()
}

/// As [`in_own_process`], on devices that support subsurface scattering.
pub fn where_light_scatters<F: FnOnce()>(body: F) {
    let (_, device, _) = gpu::request(Features::empty());
    if has_room_for_scattering(&device.limits()) {
        in_own_process(body);
    }
}

/// `None` on devices whose compute shaders cannot store ambient occlusion. Says so there.
pub fn occlusion_by_compute() -> Option<OcclusionGpu> {
    let gpu = OcclusionGpu::new();
    if gpu.path() == Path::Raster {
        println!("skipped: occlusion by compute: the device has no storage textures of its format");
        return None;
    }
    Some(gpu)
}

/// True if a part of a test is skipped for want of binding arrays. Says so if it is.
pub fn skips_without_binding_arrays(device: &RenderDevice, part: &str) -> bool {
    let skips = !device.features().contains(BINDING_ARRAYS);
    if skips {
        println!("skipped: {part}: the device has no binding arrays");
    }
    skips
}

/// A test's bound: `there` on SwiftShader, for the `reason` that is printed, and `elsewhere` on all others.
pub fn on_swiftshader<T>(there: T, elsewhere: T, reason: &str) -> T {
    if !gpu::is_swiftshader() {
        return elsewhere;
    }
    println!("skipped: the usual bound: {reason}");
    there
}

/// True if the device can cull occluded meshes. Says so if not.
pub fn culls_what_is_hidden(headless: &Headless) -> bool {
    let world = headless.app.sub_app(RenderApp).world();
    let support = world.resource::<GpuPreprocessingSupport>();
    let culls = support.max_supported_mode == GpuPreprocessingMode::Culling;
    if !culls {
        println!(
            "skipped: occlusion culling: the device cannot draw as many meshes as it finds itself"
        );
    }
    culls
}
