//! Culling keeps each light that contributes to a surface of a tile, or to its back: the shipped WGSL on the device, against each pixel of
//! the tile in f64.

use std::cell::Cell;

use bevy::math::{DVec2, DVec3, Mat4, Quat, UVec2, Vec2, Vec3, Vec4, Vec4Swizzles};
use bevy_lean_deferred::shader_library::reconstruction::position::{ProjectionKind, projection_of};
use kit::{
    compute::{Compute, Kernel},
    reference::shader_library::reconstruction::position::{ndc_of_fragment, view_position},
    shipped_wgsl,
    wgsl::WgslModule,
};
use proptest::{
    prelude::*,
    test_runner::{TestCaseError, TestRunner},
};

use super::config;

const SIDE: u32 = 8;
const VIEWPORT: [f32; 4] = [16.0, 8.0, 1920.0, 1080.0];
/// Lights per dispatch.
const BATCH: usize = 256;
const BATCHES: u32 = 256;

/// Replaces Bevy's bindings by the inputs of one invocation.
const BINDINGS: &str = "
#define_import_path bevy_pbr::mesh_view_bindings

struct View {
    view_from_clip: mat4x4<f32>,
    view_from_world: mat4x4<f32>,
    world_from_view: mat4x4<f32>,
    world_position: vec3<f32>,
    main_pass_viewport: vec4<f32>,
}

struct Light {
    light_custom_data: vec4<f32>,
    color_inverse_square_range: vec4<f32>,
    position_radius: vec4<f32>,
    flags: u32,
}

struct Lights {
    data: array<Light, 1>,
}

var<private> view: View;
var<private> clustered_lights: Lights;
";

const KERNEL: &str = "
#import bevy_lean_deferred::lighting::lights::reach::{box_of_tile, may_reach}
#import bevy_pbr::mesh_view_bindings as bindings

fn row(input: array<u32, 70>, first: u32) -> vec4<f32> {
    var words = input;
    return bitcast<vec4<f32>>(vec4(words[first], words[first + 1u], words[first + 2u], words[first + 3u]));
}

fn matrix(input: array<u32, 70>, first: u32) -> mat4x4<f32> {
    return mat4x4(row(input, first), row(input, first + 4u), row(input, first + 8u), row(input, first + 12u));
}

fn kernel(input: array<u32, 70>) -> array<u32, 1> {
    bindings::view.view_from_clip = matrix(input, 0u);
    bindings::view.view_from_world = matrix(input, 16u);
    bindings::view.world_from_view = matrix(input, 53u);
    bindings::view.world_position = row(input, 32u).xyz;
    bindings::view.main_pass_viewport = row(input, 36u);
    bindings::clustered_lights.data[0].light_custom_data = row(input, 40u);
    bindings::clustered_lights.data[0].color_inverse_square_range = vec4(1.0, 1.0, 1.0, row(input, 44u).w);
    bindings::clustered_lights.data[0].position_radius = vec4(row(input, 44u).xyz, 0.0);
    bindings::clustered_lights.data[0].flags = input[52];
    let corner = vec2(input[48], input[49]);
    let bounds = box_of_tile(corner, row(input, 48u).zw, bitcast<f32>(input[69]));
    return array(u32(may_reach(bounds, 0u)));
}
";

const SPOT: u32 = 1 << 1;
const Y_NEGATIVE: u32 = 1 << 2;

/// A tile, and a light near one of its surfaces.
#[derive(Clone, Debug)]
struct Case {
    /// First pixel of the tile, in the viewport.
    tile: UVec2,
    /// Depths of the nearest and the furthest surface, as shares; others are in between.
    depths: [f32; 2],
    /// Pixel and depth of the surface that the light is near.
    pixel: UVec2,
    depth: f32,
    /// Range of the light.
    range: f32,
    /// Distance of the light from the surface, in ranges.
    distance: f32,
    direction: Vec3,
    /// Outer angle of a spot light, and the angle between its axis and the surface as a multiple of it.
    cone: Option<(f32, f32)>,
    camera: Vec3,
    turn: Quat,
    /// Scale of the camera.
    scale: Vec3,
    /// Distance behind the surfaces at which transmitted light is gathered, in metres, and its direction.
    thickness: f32,
    inward: Vec3,
}

fn direction() -> impl Strategy<Value = Vec3> {
    [-1.0..1.0f32, -1.0..1.0f32, -1.0..1.0f32]
        .prop_map(|v| Vec3::from(v).try_normalize().unwrap_or(Vec3::Y))
}

/// Scales of cameras that are children of a scaled entity.
fn scale() -> impl Strategy<Value = Vec3> {
    let even = (-3.0..3.0f32).prop_map(|log| Vec3::splat(log.exp2()));
    let uneven = [0.3..3.0f32, 0.3..3.0f32, -3.0..-0.3f32].prop_map(Vec3::from);
    prop_oneof![8 => Just(Vec3::ONE), 3 => even, 1 => uneven]
}

fn case() -> impl Strategy<Value = Case> {
    let tile = (0..240u32, 0..135u32).prop_map(|(x, y)| UVec2::new(x, y) * SIDE);
    let pixel = (0..SIDE, 0..SIDE).prop_map(|(x, y)| UVec2::new(x, y));
    let depth = || prop_oneof![Just(0.0f32), Just(1.0), 0.0..1.0f32];
    let cone = proptest::option::of((0.01..1.57f32, 0.0..1.3f32));
    let camera = (
        direction(),
        prop_oneof![Just(0.0f32), Just(30.0), Just(20_000.0)],
    )
        .prop_map(|(d, far)| d * far);
    let thickness = prop_oneof![3 => Just(0.0f32), 1 => (-6.0..4.0f32).prop_map(f32::exp2)];
    (
        (tile, pixel, [depth(), depth()], depth()),
        (-6.0..9.0f32, 0.0..1.3f32, direction(), cone),
        (camera, direction(), 0.0..3.0f32, scale()),
        (thickness, direction()),
    )
        .prop_map(
            |(
                (tile, pixel, depths, depth),
                light,
                (camera, axis, angle, scale),
                (thickness, inward),
            )| Case {
                tile,
                pixel,
                depths,
                depth,
                range: light.0.exp2(),
                distance: light.1,
                direction: light.2,
                cone: light.3,
                camera,
                turn: Quat::from_axis_angle(axis, angle),
                scale,
                thickness,
                inward,
            },
        )
}

/// The numbers of a case with a projection.
struct Setting {
    world_from_view: Mat4,
    view_from_clip: Mat4,
    depths: Vec2,
    /// Positions in the world where light is gathered, in front and behind.
    surfaces: Vec<DVec3>,
    /// Position in the world, as the GPU has it.
    light: Vec3,
    spot: Option<Spot>,
}

struct Spot {
    /// Direction in the world, as the GPU has it.
    direction: Vec3,
    scale: f32,
    offset: f32,
}

/// Distance at a share of the visible range: logarithmic from the near plane to 10 km, or linear to the far plane.
fn distance_at(share: f64, is_perspective: bool) -> f64 {
    if is_perspective {
        0.1 * (share * 16.6).exp2()
    } else {
        1000.0 * share
    }
}

impl Setting {
    fn new(case: &Case, clip_from_view: Mat4) -> Self {
        let is_perspective = clip_from_view.w_axis.w == 0.0;
        let clip = clip_from_view.as_dmat4();
        // Position seen at a pixel, at a share of the visible range.
        let position = |pixel: UVec2, share: f64| {
            let viewport = VIEWPORT.map(f64::from);
            let uv = (pixel.as_dvec2() + 0.5) / DVec2::new(viewport[2], viewport[3]);
            let ndc = uv * DVec2::new(2.0, -2.0) + DVec2::new(-1.0, 1.0);
            let z = -distance_at(share, is_perspective);
            let w = clip.z_axis.w * z + clip.w_axis.w;
            let xy = (ndc * w - (clip.z_axis * z + clip.w_axis).truncate().truncate())
                / DVec2::new(clip.x_axis.x, clip.y_axis.y);
            xy.extend(z)
        };
        let depth = |position: &DVec3| {
            let p = clip * position.extend(1.0);
            (p.z / p.w) as f32
        };
        let [near, far] = case.depths;
        let share = |part: f32| f64::from(near + (far - near) * part);
        let parts = [0.0, 0.3, 0.7, 1.0, case.depth];
        let pixels = (0..SIDE * SIDE).map(|i| case.tile + UVec2::new(i % SIDE, i / SIDE));
        let seen: Vec<(UVec2, f32)> = pixels
            .flat_map(|pixel| parts.map(|part| (pixel, depth(&position(pixel, share(part))))))
            // Excludes positions in front of an oblique near plane.
            .filter(|(_, depth)| (0.0..=1.0).contains(depth))
            .collect();
        let depths = seen.iter().map(|(_, depth)| *depth);
        let depths = Vec2::new(
            depths.clone().fold(1.0, f32::min),
            depths.fold(0.0, f32::max),
        );
        // As lighting reconstructs them, from depths of limited precision.
        let view_from_clip = clip_from_view.inverse();
        let found = |(pixel, depth): &(UVec2, f32)| {
            let viewport = Vec4::from(VIEWPORT);
            let ndc = ndc_of_fragment(pixel.as_vec2() + 0.5 + viewport.xy(), viewport);
            let kind = projection_of(clip_from_view);
            view_position(kind, view_from_clip, ndc.extend(*depth)).as_dvec3()
        };
        let world_from_view =
            Mat4::from_scale_rotation_translation(case.scale, case.turn, case.camera);
        let in_world = |position| world_from_view.as_dmat4().transform_point3(position);
        let back = (case.inward * case.thickness).as_dvec3();
        let surfaces = seen.iter().map(found).map(in_world);
        let surfaces = surfaces.flat_map(|front| [front, front + back]).collect();
        let beside = in_world(position(case.tile + case.pixel, share(case.depth))) + back;
        let light = beside + (case.direction * case.range * case.distance).as_dvec3();
        let spot = case.cone.map(|(outer, off)| {
            let axis = case.direction.any_orthonormal_vector();
            let direction = Quat::from_axis_angle(axis, outer * off) * -case.direction;
            // As Bevy computes it, with an inner angle that is nearly the outer one.
            let scale = 1.0 / ((0.95 * outer).cos() - outer.cos()).max(1e-4);
            Spot {
                direction,
                scale,
                offset: -outer.cos() * scale,
            }
        });
        Self {
            world_from_view,
            view_from_clip,
            depths,
            surfaces,
            light: light.as_vec3(),
            spot,
        }
    }

    /// True if the light contributes to any of the surfaces.
    fn is_lit(&self, range: f32) -> bool {
        let inverse_square_range = f64::from(1.0 / (range * range));
        self.surfaces.iter().any(|surface| {
            let to_light = self.light.as_dvec3() - *surface;
            let is_near = to_light.length_squared() * inverse_square_range < 1.0;
            is_near
                && self.spot.as_ref().is_none_or(|spot| {
                    let cosine = -spot.direction.as_dvec3().dot(to_light.normalize_or_zero());
                    cosine * f64::from(spot.scale) + f64::from(spot.offset) > 0.0
                })
        })
    }

    fn words(&self, case: &Case) -> [u32; 70] {
        let mut words = [0; 70];
        let mut put = |first: usize, numbers: &[f32]| {
            for (word, number) in words[first..].iter_mut().zip(numbers) {
                *word = number.to_bits();
            }
        };
        put(0, &self.view_from_clip.to_cols_array());
        put(16, &self.world_from_view.inverse().to_cols_array());
        put(53, &self.world_from_view.to_cols_array());
        put(32, &case.camera.to_array());
        put(36, &VIEWPORT);
        put(44, &self.light.to_array());
        put(47, &[1.0 / (case.range * case.range)]);
        put(50, &self.depths.to_array());
        put(69, &[case.thickness]);
        let mut flags = 0;
        if let Some(spot) = &self.spot {
            let d = spot.direction;
            put(40, &[d.x, d.z, spot.scale, spot.offset]);
            flags = SPOT;
            if d.y < 0.0 {
                flags |= Y_NEGATIVE;
            }
        }
        words[48] = case.tile.x + VIEWPORT[0] as u32;
        words[49] = case.tile.y + VIEWPORT[1] as u32;
        words[52] = flags;
        words
    }
}

/// A function of a shipped module whose other imports are not needed.
fn function(source: &str, name: &str) -> String {
    let begin = source.find(&format!("fn {name}(")).expect("it has one");
    let length = source[begin..].find("\n}\n").expect("it ends");
    source[begin..begin + length + 3].into()
}

fn kernel(compute: &Compute, kind: ProjectionKind) -> Kernel<'_, 70, 1> {
    const CLUSTERED_LIGHT: &str = include_str!("../../../src/lighting/lights/clustered_light.wgsl");
    let spot_direction = function(CLUSTERED_LIGHT, "spot_direction").replace(
        "mesh_view_types::POINT_LIGHT_FLAGS_SPOT_LIGHT_Y_NEGATIVE",
        &format!("{Y_NEGATIVE}u"),
    );
    let clustered_light = format!(
        "#define_import_path bevy_lean_deferred::lighting::lights::clustered_light
        {spot_direction}
        fn is_spot_light(flags: u32) -> bool {{ return (flags & {SPOT}u) != 0u; }}"
    );
    let module = |path, source| WgslModule { path, source };
    let modules = [
        module("bindings.wgsl", BINDINGS),
        module("clustered_light.wgsl", clustered_light.leak()),
        shipped_wgsl!("shader_library/reconstruction/position.wgsl"),
        shipped_wgsl!("shader_library/tiles.wgsl"),
        shipped_wgsl!("lighting/lights/reach.wgsl"),
    ];
    let defs: Vec<(&str, u32)> = kind.shader_def().map(|def| (def, 1)).into_iter().collect();
    compute.kernel_with(&modules, KERNEL, &defs)
}

/// Also checks that of the lights that contribute nothing, a share is culled, as culling gains nothing otherwise: among surfaces that
/// transmit nothing. Transmission moves the bounds by up to 16 m, many times the range of most of these lights.
fn check(name: &str, clip_from_view: Mat4, least_culled: f64) {
    let compute = Compute::new();
    let kernel = kernel(&compute, projection_of(clip_from_view));
    let (dark, culled) = (Cell::new([0; 2]), Cell::new([0; 2]));
    let mut runner = TestRunner::new(config(BATCHES));
    let cases = proptest::collection::vec(case(), 1..=BATCH);
    let result = runner.run(&cases, |cases| {
        let settings: Vec<Setting> = cases
            .iter()
            .map(|case| Setting::new(case, clip_from_view))
            .collect();
        let words: Vec<[u32; 70]> = cases
            .iter()
            .zip(&settings)
            .map(|(case, setting)| setting.words(case))
            .collect();
        for ((case, setting), [reaches]) in cases.iter().zip(&settings).zip(kernel.run(&words)) {
            let is_lit = setting.is_lit(case.range);
            if is_lit && reaches == 0 {
                return Err(TestCaseError::fail(format!("culled: {case:?}")));
            }
            let count = |counts: &Cell<[usize; 2]>, is_one: bool| {
                let mut both = counts.get();
                both[usize::from(case.thickness > 0.0)] += usize::from(is_one);
                counts.set(both);
            };
            count(&dark, !is_lit);
            count(&culled, reaches == 0);
        }
        Ok(())
    });
    let ([dark, dark_behind], [culled, culled_behind]) = (dark.get(), culled.get());
    println!(
        "{name}: culled {culled} of {dark} lights that contribute nothing, {culled_behind} of {dark_behind} with transmission"
    );
    if let Err(error) = result {
        panic!("{name}: {error}");
    }
    assert!(culled as f64 >= least_culled * dark as f64);
}

#[test]
fn perspective() {
    let projection = Mat4::perspective_infinite_reverse_rh(1.0, 16.0 / 9.0, 0.1);
    check("perspective", projection, 0.25);
}

#[test]
fn off_centre() {
    let mut projection = Mat4::perspective_infinite_reverse_rh(0.5, 16.0 / 9.0, 0.1);
    projection.z_axis.x = 0.3;
    projection.z_axis.y = -0.2;
    check("off centre", projection, 0.25);
}

#[test]
fn orthographic() {
    let projection = Mat4::orthographic_rh(-8.0, 8.0, -4.5, 4.5, 1000.0, 0.0);
    check("orthographic", projection, 0.25);
}

/// Oblique near planes, as for the picture in a mirror or in water, clipped at its surface.
#[test]
fn near_planes_that_are_askew() {
    for (x, y, least_culled) in [(0.02, -0.01, 0.1), (-0.3, 0.6, 0.0)] {
        let mut projection = Mat4::perspective_infinite_reverse_rh(1.0, 16.0 / 9.0, 0.1);
        projection.x_axis.z = x;
        projection.y_axis.z = y;
        check("askew", projection, least_culled);
    }
}
