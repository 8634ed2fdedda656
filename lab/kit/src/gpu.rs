//! A wgpu device separate from Bevy's, and textures on it.

use std::sync::OnceLock;

use bevy::{math::UVec2, tasks::block_on};
use figures::time::Device;

use crate::device::TestDevice;

/// Keeps the drivers loaded until the process ends. The loader unloads them with the last instance, and NVIDIA's, reloaded for each app, no
/// longer fits into the static thread-local storage after about 40 apps.
pub fn keep_drivers_loaded() {
    static INSTANCE: OnceLock<wgpu::Instance> = OnceLock::new();
    INSTANCE.get_or_init(|| {
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env())
    });
}

/// Requests the device that the environment names, with all its limits and the `wanted` features that it has, within [`TestDevice`].
pub fn request(wanted: wgpu::Features) -> (wgpu::AdapterInfo, wgpu::Device, wgpu::Queue) {
    let chosen = TestDevice::chosen();
    let adapter = request_adapter().unwrap_or_else(|error| panic!("no graphics adapter: {error}"));
    let (device, queue) = block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: wanted & chosen.features(adapter.features()),
        required_limits: chosen.limits(adapter.limits()),
        ..Default::default()
    }))
    .unwrap_or_else(|error| panic!("no device: {error}"));
    (adapter.get_info(), device, queue)
}

/// Limits of the chosen device.
pub fn limits() -> wgpu::Limits {
    let adapter = request_adapter().unwrap_or_else(|error| panic!("no graphics adapter: {error}"));
    TestDevice::chosen().limits(adapter.limits())
}

/// Limits of a device requested with `limits`.
pub fn limits_within(limits: &wgpu::Limits) -> wgpu::Limits {
    let adapter = request_adapter().unwrap_or_else(|error| panic!("no graphics adapter: {error}"));
    let device = block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_limits: limits.clone(),
        ..Default::default()
    }));
    let (device, _) = device.unwrap_or_else(|error| panic!("no device: {error}"));
    device.limits()
}

/// True if a GPU renders rather than a software driver.
pub fn is_there() -> bool {
    request_adapter().is_ok_and(|adapter| adapter.get_info().device_type != wgpu::DeviceType::Cpu)
}

/// True if SwiftShader renders.
pub fn is_swiftshader() -> bool {
    request_adapter().is_ok_and(|adapter| adapter.get_info().name.contains("SwiftShader"))
}

fn request_adapter() -> Result<wgpu::Adapter, wgpu::RequestAdapterError> {
    keep_drivers_loaded();
    let instance =
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
}

/// An adapter as figures record it.
pub fn device_of(adapter: &wgpu::AdapterInfo) -> Device {
    let driver = format!("{} {}", adapter.driver, adapter.driver_info);
    Device {
        adapter: adapter.name.clone(),
        driver: driver.trim().into(),
    }
}

/// Creates a texture with one mip.
pub fn texture(
    device: &wgpu::Device,
    size: UVec2,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// Reads the texels of `texture`, row by row without padding.
pub fn read_texture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Vec<u8> {
    let size = texture.size();
    let texel = texture.format().block_copy_size(None).expect("one plane");
    let used = size.width * texel;
    let row = used.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row) * u64::from(size.height),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        },
        size,
    );
    queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |mapped| {
        mapped.unwrap_or_else(|error| panic!("the texture cannot be read: {error}"));
    });
    device
        .poll(wgpu::PollType::wait_indefinitely())
        .unwrap_or_else(|error| panic!("the device did not finish: {error}"));
    buffer
        .get_mapped_range(..)
        .chunks(row as usize)
        .flat_map(|line| &line[..used as usize])
        .copied()
        .collect()
}

/// Compiles a compute shader, with the layout that it asks for.
pub fn compute_pipeline(
    device: &wgpu::Device,
    source: &str,
    entry_point: Option<&str>,
) -> wgpu::ComputePipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point,
        compilation_options: Default::default(),
        cache: None,
    })
}
