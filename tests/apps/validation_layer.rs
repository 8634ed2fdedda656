//! The validation layer, whose silence other tests require, is present and its complaints are recorded. In a process of its own, because it
//! makes the layer complain.

use bevy::{
    prelude::*,
    render::{RenderApp, renderer::RenderDevice},
};
use kit::{headless::Headless, log_watch, own_process::in_own_process};

/// Does what Vulkan forbids and every driver tolerates: creates a pool for no descriptors.
fn offend_vulkan(device: &wgpu::Device) {
    // SAFETY: only the new pool is touched, and nothing uses it.
    unsafe {
        let device = device
            .as_hal::<wgpu::hal::api::Vulkan>()
            .expect("this device is not a Vulkan one: is there a Vulkan driver?");
        let device = device.raw_device();
        if let Ok(pool) = device.create_descriptor_pool(&Default::default(), None) {
            device.destroy_descriptor_pool(pool, None);
        }
    }
}

#[test]
fn complaints_of_the_validation_layer_are_heard() {
    // `tests/drivers.sh` sets this on machines without the layer.
    if std::env::var("LEAN_TEST_LAYER").is_ok_and(|layer| layer == "none") {
        println!(
            "skipped: the validation layer: it is not there, so nothing is heard of it in any test"
        );
        return;
    }
    in_own_process(|| {
        let mut headless = Headless::new(UVec2::ONE);
        headless.frames(1);
        log_watch::assert_validation_layer_silent();

        let render_world = headless.app.sub_app(RenderApp).world();
        offend_vulkan(render_world.resource::<RenderDevice>().wgpu_device());
        let complaints = log_watch::validation_layer_complaints();
        assert!(
            complaints
                .iter()
                .any(|c| c.contains("VkDescriptorPoolCreateInfo")),
            "the Vulkan validation layer is not heard: is it installed (tests/install-debian.sh does that), and is this a \
         build with debug assertions? {complaints:?}"
        );
    });
}
