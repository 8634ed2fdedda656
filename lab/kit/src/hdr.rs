//! The light of a picture as half floats, before or after post-processing.

use bevy::{
    core_pipeline::{
        core_3d::main_transparent_pass_3d,
        schedule::{Core3d, Core3dSystems},
        tonemapping::{DebandDither, Tonemapping},
    },
    prelude::*,
    render::{
        RenderApp,
        render_asset::RenderAssets,
        render_resource::{
            Extent3d, Texture, TextureDataOrder, TextureDescriptor, TextureDimension,
            TextureFormat, TextureUsages, TextureView,
        },
        renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery},
        sync_world::RenderEntity,
        texture::GpuImage,
        view::{ExtractedView, ViewTarget},
    },
};
use bevy_lean_deferred::effects::DebugViewPasses;
use half::f16;

use crate::{
    headless::{Headless, target_image_of},
    lean::begin_phase,
};

/// Linear, exposed light; four channels per pixel.
#[derive(Clone, PartialEq)]
pub struct Light {
    pub size: UVec2,
    pub texels: Vec<[f32; 4]>,
}

impl Light {
    /// Number of texels that are NaN or infinite.
    pub fn not_finite(&self) -> usize {
        let are_finite = |texel: &&[f32; 4]| texel.iter().all(|x| x.is_finite());
        self.texels.len() - self.texels.iter().filter(are_finite).count()
    }
}

/// Reads an `Rgba16Float` texture.
pub fn read_light(headless: &Headless, texture: &Texture) -> Light {
    let bytes = headless.read(texture);
    let channels = bytes.as_chunks::<2>().0;
    let channels = channels.iter().map(|c| f16::from_le_bytes(*c).to_f32());
    let channels: Vec<f32> = channels.collect();
    Light {
        size: UVec2::new(texture.width(), texture.height()),
        texels: channels.as_chunks::<4>().0.to_vec(),
    }
}

/// An app whose target has half floats.
pub fn light_target_app(size: UVec2) -> Headless {
    let mut headless = Headless::new(size);
    let target = target_image_of(size, TextureFormat::Rgba16Float);
    headless.target = headless.world().resource_mut::<Assets<Image>>().add(target);
    headless
}

/// Stops a camera from changing the colours of its light, and from dithering them.
pub fn keep_colors(camera: &mut EntityWorldMut) {
    camera.insert((Tonemapping::None, DebandDither::Disabled));
}

/// Light in the target of a [`light_target_app`] after the last frame: after TAA, with [`keep_colors`] linear.
pub fn target_light(headless: &Headless) -> Light {
    let render_world = headless.app.sub_app(RenderApp).world();
    let images = render_world.resource::<RenderAssets<GpuImage>>();
    let image = images.get(&headless.target).expect("the target is there");
    read_light(headless, &image.texture)
}

/// Applies `change` to all views of 3D cameras in the render world. A camera has one from its first frame on.
pub fn change_views(headless: &mut Headless, change: impl Fn(&mut EntityWorldMut)) {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query_filtered::<Entity, (With<ExtractedView>, With<Camera3d>)>();
    let views: Vec<Entity> = views.iter(world).collect();
    for view in views {
        change(&mut world.entity_mut(view));
    }
}

/// Light of the single camera before post-processing, once all is loaded; always at the same phase of jitter and noise.
pub fn settled_light(headless: &mut Headless) -> Light {
    headless.settle();
    begin_phase(headless);
    light(headless)
}

/// Copy of a view's light before post-processing, on the view in the render world.
#[derive(Component)]
struct Kept(Texture);

/// Present in the render world once light is copied.
#[derive(Resource)]
struct KeepsLight;

fn keep_light(
    view: ViewQuery<(Entity, &ViewTarget, Option<&Kept>)>,
    device: Res<RenderDevice>,
    mut commands: Commands,
    mut ctx: RenderContext,
) {
    let (entity, target, kept) = view.into_inner();
    let source = target.main_texture();
    let copy = match kept {
        Some(kept) if kept.0.size() == source.size() => kept.0.clone(),
        _ => device.create_texture(&TextureDescriptor {
            label: Some("kit/light"),
            size: source.size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: source.format(),
            usage: TextureUsages::COPY_DST | TextureUsages::COPY_SRC,
            view_formats: &[],
        }),
    };
    ctx.command_encoder().copy_texture_to_texture(
        source.as_image_copy(),
        copy.as_image_copy(),
        source.size(),
    );
    commands.entity(entity).insert(Kept(copy));
}

/// Copies the light of all views before post-processing, from the next frame on.
pub fn keep_light_of_views(headless: &mut Headless) {
    let render_app = headless.app.sub_app_mut(RenderApp);
    if !render_app.world().contains_resource::<KeepsLight>() {
        render_app.insert_resource(KeepsLight).add_systems(
            Core3d,
            // Before volumetric fog.
            keep_light
                .in_set(Core3dSystems::MainPass)
                .after(main_transparent_pass_3d)
                .after(DebugViewPasses),
        );
    }
}

/// The copy from the last frame in which this camera rendered; none unless it is HDR.
pub fn kept_light(headless: &mut Headless, camera: Entity) -> Option<Light> {
    let view = headless.world().get::<RenderEntity>(camera)?.id();
    let world = headless.app.sub_app(RenderApp).world();
    let copy = world.get::<Kept>(view)?.0.clone();
    (copy.format() == TextureFormat::Rgba16Float).then(|| read_light(headless, &copy))
}

/// Light of the single camera before post-processing, in the frame after the next.
pub fn light(headless: &mut Headless) -> Light {
    keep_light_of_views(headless);
    headless.frames(1);
    next_light(headless)
}

/// As [`light`], but of the next frame; needs an earlier call of [`light`].
pub fn next_light(headless: &mut Headless) -> Light {
    headless.frames(1);
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut copies = world.query::<&Kept>();
    let copy = copies
        .single(world)
        .expect("one camera shows light")
        .0
        .clone();
    read_light(headless, &copy)
}

/// A uniform `Rgba16Float` texture.
pub fn even_texture(headless: &Headless, size: UVec2, texel: [f32; 4]) -> TextureView {
    float_texture(headless, size, |_| texel)
}

/// An `Rgba16Float` texture.
pub fn float_texture(
    headless: &Headless,
    size: UVec2,
    texel: impl Fn(UVec2) -> [f32; 4],
) -> TextureView {
    let world = headless.app.sub_app(RenderApp).world();
    let texels = (0..size.element_product()).map(|i| texel(UVec2::new(i % size.x, i / size.x)));
    let bytes: Vec<u8> = texels
        .flatten()
        .flat_map(|x| f16::from_f32(x).to_le_bytes())
        .collect();
    let texture = world.resource::<RenderDevice>().create_texture_with_data(
        world.resource::<RenderQueue>(),
        &TextureDescriptor {
            label: Some("kit/floats"),
            size: Extent3d {
                width: size.x,
                height: size.y,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: TextureFormat::Rgba16Float,
            usage: TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        TextureDataOrder::default(),
        &bytes,
    );
    texture.create_view(&default())
}
