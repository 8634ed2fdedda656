//! Slabs with subsurface scattering of a known profile.

use bevy::{
    asset::RenderAssetUsages,
    image::ImageSampler,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_lean_deferred::{material_extension::SubsurfaceAlbedo, prelude::*};
use half::f16;

use crate::{
    analytic_light::{Errors, Seen, camera, show},
    reference::{
        effects::subsurface::profile::share_beside,
        shading_models::subsurface::{
            pack_subsurface, unpack_subsurface_color, unpack_subsurface_path,
        },
    },
    scenes::SceneBuilder,
};

/// Scattering distances of skin per channel, relative to the longest.
pub const SKIN: LinearRgba = LinearRgba::rgb(1.0, 0.35, 0.2);
/// Side length in metres.
pub const SLAB: f32 = 4.0;

/// A white slab with this mean free path in metres, scaled per channel by `color`.
pub fn slab(color: LinearRgba, mean_free_path: f32) -> ExtendedStandardMaterial {
    ExtendedStandardMaterial {
        base: StandardMaterial {
            base_color: Color::WHITE,
            reflectance: 0.0,
            perceptual_roughness: 1.0,
            ..default()
        },
        extension: ShadingExtension::Subsurface {
            color: color.into(),
            mean_free_path,
            albedo: SubsurfaceAlbedo::BeforeScattering,
        },
    }
}

/// Mean free paths per channel as the G-buffer stores them, in metres.
pub fn stored_paths(color: LinearRgba, mean_free_path: f32) -> Vec3 {
    let arguments = pack_subsurface(color.to_vec3(), mean_free_path, true);
    unpack_subsurface_color(arguments) * unpack_subsurface_path(arguments)
}

/// A texture of `side` × `side` texels; `light` maps a texel's centre, 0 to 1 from the upper left corner, to its value.
pub fn pattern(s: &mut SceneBuilder, side: u32, light: impl Fn(Vec2) -> f32) -> Handle<Image> {
    let texels = (0..side * side).flat_map(|i| {
        let at = Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
        let light = f16::from_f32(light(at));
        [light, light, light, f16::ONE].map(f16::to_le_bytes)
    });
    let mut image = Image::new(
        Extent3d {
            width: side,
            height: side,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        texels.flatten().collect(),
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.sampler = ImageSampler::nearest();
    s.world().resource_mut::<Assets<Image>>().add(image)
}

/// Light that leaves at so many mean free paths from an edge of light, positive on its lit side, where incident light is 1.
pub fn beside_edge(paths_away: f32) -> f32 {
    0.5 + 0.5 * share_beside(paths_away.abs()) * paths_away.signum()
}

/// A slab that faces z under uniform light, of which it lets in the share `light`, from the upper left corner.
pub fn patterned(
    s: &mut SceneBuilder,
    mut material: ExtendedStandardMaterial,
    transform: Transform,
    light: impl Fn(Vec2) -> f32,
) {
    material.base.base_color_texture = Some(pattern(s, 1024, light));
    let mesh = s.add::<Mesh>(Rectangle::new(SLAB, SLAB));
    let material = s.add::<ExtendedStandardMaterial>(material);
    s.world()
        .spawn((Mesh3d(mesh), MeshMaterial3d(material), transform));
}

/// Lit in the right half of the slab.
pub fn step(at: Vec2) -> f32 {
    f32::from(at.x > 0.5)
}

/// Errors per channel against the profile beside an edge of light on a slab at the origin, within eight mean free paths of it.
pub fn beside(seen: &Seen, normal: Vec3, paths: Vec3) -> [Errors; 3] {
    let along = Vec3::Y.cross(normal).normalize();
    [0, 1, 2].map(|channel| {
        let width = seen.light.size.x;
        let differences = seen
            .on_plane(Vec3::ZERO, normal)
            .filter_map(|(pixel, place, _)| {
                let away = place.dot(along) / paths[channel];
                let found = seen.light.texels[(pixel.y * width + pixel.x) as usize][channel];
                (away.abs() < 8.0 && place.y.abs() < 0.4).then(|| found - beside_edge(away))
            });
        Errors::of(differences)
    })
}

/// An edge of light on a slab seen from 2 m.
pub fn edge(size: UVec2, color: LinearRgba, path: f32, effect: impl Bundle) -> [Errors; 3] {
    let (_, seen) = show(size, 2, |s| {
        patterned(s, slab(color, path), default(), step);
        camera(s, Transform::from_xyz(0.0, 0.0, 2.0), 1.0, effect);
    });
    seen.save("edge", 0.9);
    beside(&seen, Vec3::Z, stored_paths(color, path))
}
