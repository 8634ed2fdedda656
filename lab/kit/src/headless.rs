//! Bevy without a window: frames are stepped by hand and read back.

use std::time::{Duration, Instant};

use crate::{
    device::{render_plugin, render_plugin_within},
    gpu::{device_of, keep_drivers_loaded, read_texture},
    log_watch::LogWatch,
    shader_files::read_shader_files,
};
use bevy::{
    app::{PluginGroupBuilder, PluginsState},
    asset::{RenderAssetUsages, UnapprovedPathMode},
    camera::RenderTarget,
    light::{DirectionalLightShadowMap, PointLightShadowMap},
    prelude::*,
    render::{
        RenderApp,
        render_asset::RenderAssets,
        render_resource::{
            Extent3d, PipelineCache, PollType, Texture, TextureDimension, TextureFormat,
            TextureUsages,
        },
        renderer::{RenderAdapterInfo, RenderDevice, RenderQueue},
        texture::GpuImage,
    },
    time::TimeUpdateStrategy,
    window::ExitCondition,
    winit::WinitPlugin,
};
use bevy_lean_deferred::{LeanDeferredPlugins, lighting::CompiledLighting};
use figures::time::Device;
use wgpu::Limits;

/// Simulated time between two frames.
pub const FRAME_TIME: Duration = Duration::from_micros(16_667);

/// Time limit of [`Headless::settle`]: drivers may take this long to compile in the background, over many short frames.
const PATIENCE: Duration = Duration::from_secs(120);
/// Consecutive frames without pipeline requests after which an app counts as settled.
const QUIET_FRAMES: usize = 3;

/// An app that renders to an image. Unless told otherwise, it compiles pipelines in the frame that requests them, and no
/// general ones of lighting (`LEAN_LIGHTING`).
pub struct Headless {
    pub app: App,
    pub target: Handle<Image>,
    pub size: UVec2,
}

impl Headless {
    /// An app with [`small_shadow_maps`].
    pub fn new(size: UVec2) -> Self {
        Self::with(size, small_shadow_maps)
    }

    /// As [`new`](Self::new); `configure` may add plugins.
    pub fn with(size: UVec2, configure: impl FnOnce(&mut App)) -> Self {
        Self::with_compilation(size, true, configure)
    }

    /// As [`with`](Self::with). Unless `synchronous`, compilation may take any number of frames, as in apps.
    pub fn with_compilation(
        size: UVec2,
        synchronous: bool,
        configure: impl FnOnce(&mut App),
    ) -> Self {
        let mut app = App::new();
        app.add_plugins((
            Self::default_plugins().set(render_plugin(synchronous)),
            LeanDeferredPlugins,
        ));
        Self::from_app(size, app, configure)
    }

    /// As [`with`](Self::with), on a device whose limits are no better than `limits`.
    pub fn within(limits: Limits, size: UVec2, configure: impl FnOnce(&mut App)) -> Self {
        let mut app = App::new();
        app.add_plugins((
            Self::default_plugins().set(render_plugin_within(limits)),
            LeanDeferredPlugins,
        ));
        Self::from_app(size, app, configure)
    }

    /// Bevy's default plugins, set up for headless apps.
    pub fn default_plugins() -> PluginGroupBuilder {
        DefaultPlugins
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            .set(render_plugin(true))
            .set(AssetPlugin {
                file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets").into(),
                // Benches may name a file anywhere.
                unapproved_path_mode: UnapprovedPathMode::Allow,
                ..default()
            })
            .set(bevy::log::LogPlugin {
                // At warnings: wgpu's of Bevy's deferred lighting, which compares depth for equality.
                filter:
                    "warn,wgpu_hal=error,wgpu_core::validation=error,bevy_render::renderer=error"
                        .into(),
                custom_layer: |_| Some(Box::new(LogWatch)),
                ..default()
            })
            .disable::<WinitPlugin>()
            .disable::<bevy::render::pipelined_rendering::PipelinedRenderingPlugin>()
    }

    /// Wraps an app that has all its plugins but those that `configure` adds.
    pub fn from_app(size: UVec2, mut app: App, configure: impl FnOnce(&mut App)) -> Self {
        app.insert_resource(TimeUpdateStrategy::ManualDuration(FRAME_TIME));
        read_shader_files(&mut app);
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app.insert_resource(compiled_lighting());
        }
        configure(&mut app);

        keep_drivers_loaded();
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();

        let target = app
            .world_mut()
            .resource_mut::<Assets<Image>>()
            .add(target_image(size));
        Self { app, target, size }
    }

    pub fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// Render target of this app's cameras.
    pub fn render_target(&self) -> RenderTarget {
        self.target.clone().into()
    }

    pub fn frames(&mut self, count: usize) {
        for _ in 0..count {
            self.frame();
        }
    }

    /// Runs one frame and waits until the GPU has finished it: without a window nothing else throttles the CPU.
    pub fn frame(&mut self) {
        self.app.update();
        if let Err(error) = self.device().poll(PollType::wait_indefinitely()) {
            warn!("waiting for the GPU: {error}");
        }
    }

    /// Runs frames until no pipeline is compiling or requested, plus a few: Bevy acts some frames later on what the GPU reports, such as
    /// the number of lights in its clusters.
    pub fn settle(&mut self) {
        let mut quiet = 0;
        let mut asked_for = self.pipelines().pipelines().count();
        let started = Instant::now();
        let mut frames = 0;
        while frames < 2000 || started.elapsed() < PATIENCE {
            frames += 1;
            self.frame();
            let pipelines = self.pipelines();
            let before = core::mem::replace(&mut asked_for, pipelines.pipelines().count());
            let is_quiet = pipelines.waiting_pipelines().count() == 0 && asked_for == before;
            quiet = if is_quiet { quiet + 1 } else { 0 };
            if quiet >= QUIET_FRAMES {
                return;
            }
        }
        panic!("pipelines still waiting after {frames} frames");
    }

    pub fn device(&self) -> &RenderDevice {
        self.app.sub_app(RenderApp).world().resource()
    }

    /// Name of the adapter.
    pub fn adapter(&self) -> String {
        let render_world = self.app.sub_app(RenderApp).world();
        render_world.resource::<RenderAdapterInfo>().name.clone()
    }

    /// Adapter and driver, for figures.
    pub fn adapter_and_driver(&self) -> Device {
        let render_world = self.app.sub_app(RenderApp).world();
        device_of(render_world.resource::<RenderAdapterInfo>())
    }

    /// True while requested pipelines are not compiled.
    pub fn is_compiling(&self) -> bool {
        self.pipelines().waiting_pipelines().next().is_some()
    }

    fn pipelines(&self) -> &PipelineCache {
        self.app.sub_app(RenderApp).world().resource()
    }

    /// Renders the next frame and reads it back: 8-bit sRGB, four bytes per pixel.
    pub fn capture(&mut self) -> Picture {
        self.frame();
        self.picture()
    }

    /// Pictures of `count` consecutive frames; `change` runs on the world before each.
    pub fn film(
        &mut self,
        count: usize,
        mut change: impl FnMut(&mut World, usize),
    ) -> Vec<Picture> {
        (0..count)
            .map(|frame| {
                change(self.world(), frame);
                self.capture()
            })
            .collect()
    }

    /// Content of the target after the last frame.
    fn picture(&self) -> Picture {
        self.picture_of(&self.target)
    }

    /// Content of a target of the same format after the last frame.
    pub fn picture_of(&self, target: &Handle<Image>) -> Picture {
        let render_world = self.app.sub_app(RenderApp).world();
        let images = render_world.resource::<RenderAssets<GpuImage>>();
        let image = images.get(target).expect("the target is there");
        let size = image.texture.size();
        Picture {
            size: UVec2::new(size.width, size.height),
            rgba: self.read(&image.texture),
        }
    }

    /// Reads a texture of the render world, row by row.
    pub fn read(&self, texture: &Texture) -> Vec<u8> {
        let render_world = self.app.sub_app(RenderApp).world();
        let device = render_world.resource::<RenderDevice>().wgpu_device();
        read_texture(device, render_world.resource::<RenderQueue>(), texture)
    }
}

/// The lighting pipelines that `LEAN_LIGHTING` names: `general` or `all`. Without it those that fit, because each pipeline takes a
/// software renderer a second or more.
fn compiled_lighting() -> CompiledLighting {
    let name = std::env::var("LEAN_LIGHTING").unwrap_or_default();
    match name.as_str() {
        "" => CompiledLighting::Fitting,
        "general" => CompiledLighting::General,
        "all" => CompiledLighting::All,
        _ => panic!("LEAN_LIGHTING is general or all, and not {name}"),
    }
}

/// Halves Bevy's shadow maps: a software renderer would spend a quarter of its time on the full ones.
pub fn small_shadow_maps(app: &mut App) {
    app.insert_resource(DirectionalLightShadowMap { size: 1024 })
        .insert_resource(PointLightShadowMap { size: 512 });
}

/// An sRGB image that can be rendered to and read back.
pub fn target_image(size: UVec2) -> Image {
    target_image_of(size, TextureFormat::Rgba8UnormSrgb)
}

/// As [`target_image`], in any format.
pub fn target_image_of(size: UVec2, format: TextureFormat) -> Image {
    let texel = format.block_copy_size(None).expect("one plane");
    let mut image = Image::new_fill(
        Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        &vec![0; texel as usize],
        format,
        RenderAssetUsages::default(),
    );
    image.texture_descriptor.usage =
        TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC | TextureUsages::TEXTURE_BINDING;
    image
}

/// An 8-bit sRGB picture.
#[derive(Clone, PartialEq)]
pub struct Picture {
    pub size: UVec2,
    pub rgba: Vec<u8>,
}

impl Picture {
    /// The part inside `rect`.
    pub fn crop(&self, rect: URect) -> Self {
        let rgba = (rect.min.y..rect.max.y)
            .flat_map(|y| {
                let row = y * self.size.x;
                let [from, to] = [rect.min.x, rect.max.x].map(|x| (row + x) as usize * 4);
                &self.rgba[from..to]
            })
            .copied()
            .collect();
        let size = rect.size();
        Self { size, rgba }
    }

    /// The left half of this picture and the right half of another of the same size, with a line between them.
    pub fn split(&self, right: &Self) -> Self {
        assert_eq!(self.size, right.size);
        let middle = self.size.x as usize / 2;
        let mut rgba = self.rgba.clone();
        let row_bytes = self.size.x as usize * 4;
        for (row, other) in (rgba.chunks_mut(row_bytes)).zip(right.rgba.chunks(row_bytes)) {
            row[middle * 4..].copy_from_slice(&other[middle * 4..]);
            row[middle.saturating_sub(1) * 4..][..4].fill(255);
            row[middle * 4..][..4].fill(255);
        }
        Self {
            size: self.size,
            rgba,
        }
    }

    /// This picture and another of the same size, beside each other.
    pub fn beside(&self, right: &Self) -> Self {
        assert_eq!(self.size, right.size);
        let row_bytes = self.size.x as usize * 4;
        let rows = (self.rgba.chunks(row_bytes)).zip(right.rgba.chunks(row_bytes));
        Self {
            size: self.size * UVec2::new(2, 1),
            rgba: rows
                .flat_map(|(left, right)| [left, right].concat())
                .collect(),
        }
    }

    /// Writes a PNG; panics if that fails.
    pub fn save(&self, path: impl AsRef<std::path::Path>) {
        let path = path.as_ref();
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).expect("the folder of a picture can be made");
        }
        self.try_save(path).expect("a PNG can be written");
    }

    /// Writes a PNG.
    pub fn try_save(&self, path: impl AsRef<std::path::Path>) -> Result<(), String> {
        let image = Image::new(
            Extent3d {
                width: self.size.x,
                height: self.size.y,
                depth_or_array_layers: 1,
            },
            TextureDimension::D2,
            self.rgba.clone(),
            TextureFormat::Rgba8UnormSrgb,
            RenderAssetUsages::default(),
        );
        let image = image
            .try_into_dynamic()
            .map_err(|error| error.to_string())?;
        image
            .to_rgb8()
            .save(path)
            .map_err(|error| error.to_string())
    }
}
