//! The levels of the last frame, on the device against their Rust twin.

use bevy::{
    camera::{CameraProjection, PerspectiveProjection},
    math::{Mat4, UVec2, Vec3, Vec4},
    render::render_resource::{ShaderType, encase::UniformBuffer},
};
use bevy_lean_deferred::{
    effects::history::binding_numbers as numbers,
    shader_library::reconstruction::position::{ProjectionKind, view_from_pixel},
};
use half::f16;
use kit::{
    gpu,
    random::Random,
    reference::shader_library::reconstruction::position::view_position,
    shader_files::shader_file,
    shipped_wgsl,
    wgsl::{Definitions, WgslModule, compile},
};
use naga_oil::compose::ShaderDefValue;
use wgpu::{
    BindGroupEntry, BindingResource, BufferUsages, Device, Queue, Texture, TextureFormat,
    TextureUsages, TextureView,
};

const MODULES: [WgslModule; 5] = [
    shipped_wgsl!("shader_library/layout.wgsl"),
    shipped_wgsl!("shader_library/layout/light.wgsl"),
    shipped_wgsl!("shader_library/reconstruction/position.wgsl"),
    shipped_wgsl!("shader_library/tiles.wgsl"),
    shipped_wgsl!("effects/shown_exposure.wgsl"),
];
const LEVELS_WGSL: WgslModule = shipped_wgsl!("effects/history/levels.wgsl");

/// Size of the picture, origin and size of the view in it, and size of the view's levels.
const PICTURE: UVec2 = UVec2::new(150, 90);
const ORIGIN: UVec2 = UVec2::new(5, 3);
const VIEW: UVec2 = UVec2::new(130, 70);
const SIZE: UVec2 = UVec2::new(192, 128);
/// As in the shader.
const MOST_WHITES: f32 = 1024.0;
/// In stops, as the picture is shown: the brightest light kept is 2.
const SHOWN_EXPOSURE: f32 = 9.0;
const NO_SURFACE: f32 = 65504.0;

const STORED_AT: [u32; 4] = [
    numbers::LEVEL_0,
    numbers::LEVEL_1,
    numbers::LEVEL_2,
    numbers::LEVEL_3,
];

/// Twin of the shader's struct.
#[derive(ShaderType)]
struct View {
    view_from_pixel: Mat4,
    viewport_origin: UVec2,
    viewport_size: UVec2,
    units_per_metre: f32,
}

/// Results of the main passes: light, and depth in steps of 1/65535.
struct Left {
    light: Vec<[f32; 3]>,
    depth: Vec<u16>,
}

impl Left {
    /// A quarter of the lights is hostile, and a quarter of the depths is the sky's.
    fn random(random: &mut Random) -> Self {
        let hostile = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            65504.0,
            -1.0,
            0.0,
            6e-8,
        ];
        let count = PICTURE.element_product() as usize;
        let light = (0..count).map(|_| {
            [(); 3].map(|()| {
                if random.below(12) == 0 {
                    hostile[random.below(hostile.len())]
                } else {
                    f16::from_f32(random.range(0.0, 3.0)).to_f32()
                }
            })
        });
        let light = light.collect();
        let depth = (0..count).map(|_| match random.below(4) {
            0 => 0,
            _ => random.bits() as u16,
        });
        Self {
            light,
            depth: depth.collect(),
        }
    }
}

/// The first level at a position of the view. Beyond the view its last pixels are repeated.
fn first_level(left: &Left, view: &View, place: UVec2) -> Vec4 {
    let inside = place.min(VIEW - 1);
    let pixel = ORIGIN + inside;
    let i = (pixel.x + PICTURE.x * pixel.y) as usize;
    let light = Vec3::from(left.light[i]);
    let sum = light.x + light.y + light.z;
    let number = if sum.is_nan() { Vec3::ZERO } else { light };
    let finite = number.clamp(Vec3::ZERO, Vec3::splat(65504.0));
    let largest = MOST_WHITES * (-SHOWN_EXPOSURE).exp2();
    let bounded = finite * (largest / finite.max_element().max(1e-6)).min(1.0);
    let distance = match left.depth[i] {
        0 => NO_SURFACE,
        depth => {
            let place = inside.as_vec2() + 0.5;
            let at = place.extend(f32::from(depth) / 65535.0);
            -view_position(ProjectionKind::Other, view.view_from_pixel, at).z * view.units_per_metre
        }
    };
    bounded.extend(distance.min(NO_SURFACE))
}

/// Mean of four texels of the previous level.
fn mean(texels: [Vec4; 4]) -> Vec4 {
    texels.into_iter().sum::<Vec4>() / 4.0
}

/// Light of surfaces, and their share.
fn share(texel: Vec4) -> Vec4 {
    if texel.w == NO_SURFACE {
        Vec4::ZERO
    } else {
        texel.truncate().extend(1.0)
    }
}

/// Levels that the device made, each row by row.
type Levels = [Vec<Vec4>; 7];

struct History {
    device: Device,
    queue: Queue,
    color: TextureView,
    depth: TextureView,
    view: wgpu::Buffer,
    shown_exposure: wgpu::Buffer,
}

impl History {
    fn new(left: &Left, view: &View) -> Self {
        let (_, device, queue) = gpu::request(wgpu::Features::empty());
        let write = |format, texel: u32, bytes: &[u8]| {
            let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
            let texture = gpu::texture(&device, PICTURE, format, usage);
            let layout = wgpu::TexelCopyBufferLayout {
                bytes_per_row: Some(texel * PICTURE.x),
                ..Default::default()
            };
            queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
            texture.create_view(&Default::default())
        };
        let light = left.light.iter().flat_map(|[r, g, b]| [*r, *g, *b, 1.0]);
        let light: Vec<u8> = light.flat_map(|x| f16::from_f32(x).to_le_bytes()).collect();
        let depth: Vec<u8> = left.depth.iter().flat_map(|d| d.to_le_bytes()).collect();
        let mut bytes = UniformBuffer::new(Vec::new());
        bytes.write(view).expect("it fits");
        let uniform = |bytes: &[u8]| {
            let uniform = device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: bytes.len() as u64,
                usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            queue.write_buffer(&uniform, 0, bytes);
            uniform
        };
        let stops: Vec<u8> = [SHOWN_EXPOSURE, 0.0, 0.0, 0.0]
            .into_iter()
            .flat_map(f32::to_le_bytes)
            .collect();
        Self {
            color: write(TextureFormat::Rgba16Float, 8, &light),
            depth: write(TextureFormat::Depth16Unorm, 2, &depth),
            view: uniform(bytes.as_ref()),
            shown_exposure: uniform(&stops),
            device,
            queue,
        }
    }

    /// Runs one dispatch, which reads `color` and stores to `levels`.
    fn dispatch(
        &self,
        shader_def: Option<&str>,
        color: &TextureView,
        levels: &[Texture],
        workgroups: UVec2,
    ) {
        let definitions = shader_def.map(|name| (name.into(), ShaderDefValue::Bool(true)));
        let definitions = Definitions::from_iter(definitions);
        let reads_picture = shader_def != Some("OF_LEVEL");
        let source = shader_file(&LEVELS_WGSL);
        let pipeline = self
            .device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: None,
                layout: None,
                module: &compile(&self.device, &MODULES, &source, definitions),
                entry_point: Some("main"),
                compilation_options: Default::default(),
                cache: None,
            });
        let views: Vec<_> = levels
            .iter()
            .map(|level| level.create_view(&Default::default()))
            .collect();
        let texture = |binding, view| BindGroupEntry {
            binding,
            resource: BindingResource::TextureView(view),
        };
        let stored = STORED_AT.into_iter().zip(&views);
        let mut entries: Vec<_> = stored
            .map(|(number, level)| texture(number, level))
            .collect();
        entries.push(texture(numbers::COLOR_TEXTURE, color));
        if reads_picture {
            entries.push(texture(numbers::DEPTH_TEXTURE, &self.depth));
            for (binding, buffer) in [
                (numbers::VIEW, &self.view),
                (numbers::SHOWN_EXPOSURE, &self.shown_exposure),
            ] {
                entries.push(BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                });
            }
        }
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(workgroups.x, workgroups.y, 1);
        }
        self.queue.submit([encoder.finish()]);
    }

    fn levels(&self, make: impl FnOnce(&[Texture])) -> Levels {
        let usage = TextureUsages::STORAGE_BINDING
            | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_SRC;
        let textures: [_; 7] = core::array::from_fn(|level| {
            gpu::texture(
                &self.device,
                SIZE >> level as u32,
                TextureFormat::Rgba16Float,
                usage,
            )
        });
        make(&textures);
        textures.map(|texture| {
            let bytes = gpu::read_texture(&self.device, &self.queue, &texture);
            let halves = bytes.as_chunks::<2>().0;
            let halves: Vec<f32> = halves
                .iter()
                .map(|half| f16::from_le_bytes(*half).to_f32())
                .collect();
            let texels = halves.as_chunks::<4>().0;
            texels.iter().map(|texel| Vec4::from(*texel)).collect()
        })
    }
}

/// Tolerates rounding to half floats once or twice, in either direction; the smallest may become 0.
fn assert_close(level: usize, place: UVec2, found: Vec4, expected: Vec4) {
    let off = (found - expected).abs();
    let most = 0.002 * expected.abs() + 7e-5;
    assert!(
        off.cmple(most).all(),
        "level {level} at {place}: {found} for {expected}"
    );
}

fn check(left: &Left, view: &View, levels: &Levels) {
    let places =
        |size: UVec2| (0..size.y).flat_map(move |y| (0..size.x).map(move |x| UVec2::new(x, y)));
    for (place, found) in places(SIZE).zip(&levels[0]) {
        let expected = first_level(left, view, place);
        assert_close(0, place, *found, expected);
    }
    for level in 1..7 {
        let size = SIZE >> level as u32;
        for (place, found) in places(size).zip(&levels[level]) {
            let below = [UVec2::ZERO, UVec2::X, UVec2::Y, UVec2::ONE].map(|beside| {
                let place = 2 * place + beside;
                match level {
                    1 => share(first_level(left, view, place)),
                    _ => levels[level - 1][(place.x + 2 * size.x * place.y) as usize],
                }
            });
            assert_close(level, place, *found, mean(below));
        }
    }
}

#[test]
fn levels_are_means_of_surfaces() {
    let left = Left::random(&mut Random::new(5));
    let projection = PerspectiveProjection {
        aspect_ratio: 130.0 / 70.0,
        ..Default::default()
    };
    let view = View {
        view_from_pixel: view_from_pixel(projection.get_clip_from_view(), VIEW),
        viewport_origin: ORIGIN,
        viewport_size: VIEW,
        units_per_metre: 0.25,
    };
    let history = History::new(&left, &view);
    let levels = history.levels(|levels| {
        history.dispatch(None, &history.color, &levels[..4], SIZE / 16);
        let last = levels[3].create_view(&Default::default());
        let workgroups = (SIZE / 8).map(|texels| texels.div_ceil(16));
        history.dispatch(Some("OF_LEVEL"), &last, &levels[4..], workgroups);
    });
    check(&left, &view, &levels);
}
