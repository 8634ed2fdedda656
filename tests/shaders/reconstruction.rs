//! From depth back to positions and motion: the shipped WGSL on the device against its Rust twin, and both against f64.

use bevy::math::{DVec3, DVec4, Mat4, Quat, Vec2, Vec3, Vec4, Vec4Swizzles};
use bevy_lean_deferred::shader_library::reconstruction::position::{
    ProjectionKind, normalized, projection_of,
};
use kit::{
    compute::Compute,
    random::Random,
    reference::shader_library::reconstruction::{
        motion::motion_at_rest,
        position::{SMALLEST_DEPTH, homogeneous_position, ndc_of_fragment, view_position},
    },
    shipped_wgsl,
    wgsl::WgslModule,
};

const MODULES: [WgslModule; 4] = [
    shipped_wgsl!("shader_library/layout.wgsl"),
    shipped_wgsl!("shader_library/layout/motion.wgsl"),
    shipped_wgsl!("shader_library/reconstruction/position.wgsl"),
    shipped_wgsl!("shader_library/reconstruction/motion.wgsl"),
];

const READ: &str = "
fn number(bits: u32) -> f32 {
    return bitcast<f32>(bits);
}
";

/// Reads the first words of `bits` as `m`.
const READ_MATRIX: &str = "var words = bits;
    var m: mat4x4<f32>;
    for (var i = 0u; i < 16u; i++) {
        m[i / 4u][i % 4u] = number(words[i]);
    }";

const SIZE: Vec2 = Vec2::new(3840.0, 2160.0);

fn bits<const N: usize>(numbers: impl IntoIterator<Item = f32>) -> [u32; N] {
    let words: Vec<u32> = numbers.into_iter().map(f32::to_bits).collect();
    words.try_into().expect("as many numbers as words")
}

/// Projections of each kind.
fn projections() -> Vec<(&'static str, Mat4)> {
    let perspective = Mat4::perspective_infinite_reverse_rh(1.0, SIZE.x / SIZE.y, 0.1);
    let mut jittered = perspective;
    jittered.z_axis.x = 0.01;
    jittered.z_axis.y = -0.3;
    let mut oblique = perspective;
    oblique.x_axis.z = 0.2;
    oblique.y_axis.z = -0.1;
    vec![
        ("perspective", perspective),
        ("off centre", jittered),
        (
            "mirrored",
            Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)) * perspective,
        ),
        ("far plane", Mat4::perspective_rh(1.0, 1.5, 1000.0, 0.1)),
        (
            "orthographic",
            Mat4::orthographic_rh(-8.0, 10.0, -3.0, 5.0, 100.0, -20.0),
        ),
        ("oblique", oblique),
    ]
}

/// Each projection as it is and with temporal jitter, with the kind that it has without jitter.
fn with_jitter() -> impl Iterator<Item = (String, ProjectionKind, Mat4)> {
    projections()
        .into_iter()
        .flat_map(|(name, clip_from_view)| {
            let kind = projection_of(clip_from_view);
            let mut jittered = clip_from_view;
            jittered.z_axis.x += 0.002;
            jittered.z_axis.y -= 0.001;
            [
                (name.to_owned(), kind, clip_from_view),
                (format!("{name}, jittered"), kind, jittered),
            ]
        })
}

fn view_from_pixel(clip_from_view: Mat4) -> Mat4 {
    let ndc_from_pixel = Mat4::from_translation(Vec3::new(-1.0, 1.0, 0.0))
        * Mat4::from_scale(Vec3::new(2.0 / SIZE.x, -2.0 / SIZE.y, 1.0));
    normalized(clip_from_view.inverse() * ndc_from_pixel)
}

/// The definition for positions of this kind.
fn define(kind: ProjectionKind) -> String {
    kind.shader_def()
        .map_or(String::new(), |name| format!("#define {name}"))
}

/// Error relative to the largest component of `truth`.
fn relative_error(found: Vec3, truth: DVec3) -> f64 {
    (found.as_dvec3() - truth).abs().max_element() / truth.abs().max_element()
}

#[test]
fn positions_are_those_of_the_full_matrix() {
    let compute = Compute::new();
    let mut random = Random::new(11);
    for (name, kind, clip_from_view) in with_jitter() {
        let define = define(kind);
        let z = match kind {
            ProjectionKind::Perspective => "reconstruction::view_z(m, vec4(p.z)).w",
            _ => "reconstruction::view_position(m, p).z",
        };
        let source = format!(
            "{define}
#import bevy_lean_deferred::reconstruction::position as reconstruction
{READ}
fn kernel(bits: array<u32, 19>) -> array<u32, 4> {{
    {READ_MATRIX}
    let p = vec3(number(words[16]), number(words[17]), number(words[18]));
    let position = bitcast<vec3<u32>>(reconstruction::view_position(m, p));
    return array(position.x, position.y, position.z, bitcast<u32>({z}));
}}"
        );
        let kernel = compute.kernel::<19, 4>(&MODULES, &source);
        let matrix = view_from_pixel(clip_from_view);
        let points: Vec<Vec3> = (0..100_000)
            .map(|_| {
                let depth = 10f32.powf(random.range(-6.0, 0.0));
                Vec3::new(random.range(0.0, SIZE.x), random.range(0.0, SIZE.y), depth)
            })
            .collect();
        let inputs: Vec<[u32; 19]> = points
            .iter()
            .map(|p| bits(matrix.to_cols_array().into_iter().chain(p.to_array())))
            .collect();
        let exact = matrix.as_dmat4();
        // Orthographic positions are sums of an offset and a term as large.
        let reach = match kind {
            ProjectionKind::Orthographic => exact.w_axis.abs().max_element(),
            _ => 0.0,
        };
        let mut largest = 0.0f64;
        for (p, device) in points.into_iter().zip(kernel.run(&inputs)) {
            let [x, y, z, z_alone] = device.map(f32::from_bits);
            let truth = exact.project_point3(p.as_dvec3());
            let distance = truth.abs().max_element().max(reach);
            // Digits are lost where w is a small difference of large numbers, as far behind an oblique near plane.
            let parts = exact.row(3) * p.as_dvec3().extend(1.0);
            let digits_lost = parts.abs().element_sum() / parts.element_sum().abs();
            for found in [Vec3::new(x, y, z), view_position(kind, matrix, p)] {
                let error = (found.as_dvec3() - truth).abs().max_element() / distance / digits_lost;
                largest = largest.max(error);
                assert!(error < 1e-6, "{name}, {p}: {found}, not {truth}");
            }
            let z_error = (f64::from(z_alone) - truth.z).abs() / distance / digits_lost;
            assert!(z_error < 1e-6, "{name}, {p}: {z_alone}, not {}", truth.z);
        }
        println!("{name:24} {kind:?}: off by {largest:.1e} of the distance at most");
    }
}

/// Steps from a position lead to the positions seen beside it.
#[test]
fn steps_lead_to_positions_beside() {
    let compute = Compute::new();
    let mut random = Random::new(23);
    for (name, kind, clip_from_view) in with_jitter() {
        let define = define(kind);
        let source = format!(
            "{define}
#import bevy_lean_deferred::reconstruction::position as reconstruction
{READ}
fn kernel(bits: array<u32, 22>) -> array<u32, 4> {{
    {READ_MATRIX}
    let p = vec3(number(words[16]), number(words[17]), number(words[18]));
    let step = vec3(number(words[19]), number(words[20]), number(words[21]) - p.z);
    let ray = reconstruction::ray_at(m, p.xy);
    let position = reconstruction::position_on(m, ray, p.z);
    let led = reconstruction::homogeneous_steps(m, position) * step;
    let w = reconstruction::w_at(m, ray, p.z) + led.w;
    let found = bitcast<vec4<u32>>(vec4(led.xyz / w, w));
    return array(found.x, found.y, found.z, found.w);
}}"
        );
        let kernel = compute.kernel::<22, 4>(&MODULES, &source);
        let matrix = view_from_pixel(clip_from_view);
        let exact = matrix.as_dmat4();
        let pairs: Vec<[Vec3; 2]> = (0..100_000)
            .map(|_| {
                let depth = 10f32.powf(random.range(-4.0, -0.5));
                let from = Vec3::new(random.range(0.0, SIZE.x), random.range(0.0, SIZE.y), depth);
                let step = Vec3::new(
                    random.range(-200.0, 200.0),
                    random.range(-200.0, 200.0),
                    0.0,
                );
                let to = (from + step.round()).with_z(depth * random.range(0.5, 2.0));
                [from, to]
            })
            .collect();
        let inputs: Vec<[u32; 22]> = pairs
            .iter()
            .map(|[from, to]| {
                let step = (to - from).with_z(to.z);
                let numbers = matrix.to_cols_array().into_iter();
                bits(numbers.chain(from.to_array()).chain(step.to_array()))
            })
            .collect();
        let mut largest = 0.0f64;
        for ([from, to], device) in pairs.into_iter().zip(kernel.run(&inputs)) {
            let [x, y, z, w] = device.map(f32::from_bits);
            let [begin, end] = [from, to].map(|p| exact.project_point3(p.as_dvec3()));
            let parts = [from, to].map(|p| exact.row(3) * p.as_dvec3().extend(1.0));
            let digits_lost = parts.map(|w| w.abs().element_sum() / w.element_sum().abs());
            let digits_lost = digits_lost[0].max(digits_lost[1]);
            let off = (Vec3::new(x, y, z).as_dvec3() - (end - begin)).length();
            let error = off / (end - begin).length() / digits_lost;
            largest = largest.max(error);
            assert!(error < 1e-5, "{name}, {from} to {to}: off by {error}");
            let w_error = (f64::from(w) / parts[1].element_sum() - 1.0).abs() / digits_lost;
            assert!(w_error < 2e-6, "{name}, {to}: w is off by {w_error}");
        }
        println!("{name:24} {kind:?}: off by {largest:.1e} of the way at most");
    }
}

/// Depths that no surface has, and NaN.
#[test]
fn hostile_depths_stay_what_they_are() {
    let compute = Compute::new();
    let source = format!(
        "#import bevy_lean_deferred::reconstruction::position::{{SMALLEST_DEPTH, view_position}}
{READ}
fn kernel(bits: array<u32, 17>) -> array<u32, 3> {{
    {READ_MATRIX}
    let p = vec3(0.25, -0.5, max(number(words[16]), SMALLEST_DEPTH));
    let position = bitcast<vec3<u32>>(view_position(m, p));
    return array(position.x, position.y, position.z);
}}"
    );
    let kernel = compute.kernel::<17, 3>(&MODULES, &source);
    for (name, clip_from_view) in projections() {
        let view_from_clip = clip_from_view.inverse();
        for depth in [0.0, -0.0, f32::MIN_POSITIVE, 1e-30, -1.0, 1.0] {
            let words = view_from_clip.to_cols_array().into_iter().chain([depth]);
            let [x, y, z] = kernel.run(&[bits(words)])[0].map(f32::from_bits);
            let device = Vec3::new(x, y, z);
            let p = Vec3::new(0.25, -0.5, depth.max(SMALLEST_DEPTH));
            let twin = view_position(ProjectionKind::Other, view_from_clip, p);
            for position in [device, twin] {
                assert!(
                    position.length_squared().is_finite(),
                    "{name} at depth {depth}: {position}"
                );
            }
            assert!(
                relative_error(device, twin.as_dvec3()) < 1e-5,
                "{name} at depth {depth}: {device}, not {twin}"
            );
        }
    }
}

#[test]
fn fragments_lie_where_their_viewport_says() {
    let compute = Compute::new();
    let source = format!(
        "#import bevy_lean_deferred::reconstruction::position::ndc_of_fragment
{READ}
fn kernel(bits: array<u32, 6>) -> array<u32, 2> {{
    let fragment = vec2(number(bits[0]), number(bits[1]));
    let viewport = vec4(number(bits[2]), number(bits[3]), number(bits[4]), number(bits[5]));
    let ndc = bitcast<vec2<u32>>(ndc_of_fragment(fragment, viewport));
    return array(ndc.x, ndc.y);
}}"
    );
    let kernel = compute.kernel::<6, 2>(&MODULES, &source);
    let mut random = Random::new(12);
    let cases: Vec<(Vec2, Vec4)> = (0..100_000)
        .map(|_| {
            let mut whole = |limit: usize| random.below(limit) as f32;
            let viewport = Vec4::new(
                whole(4000),
                whole(4000),
                1.0 + whole(4000),
                1.0 + whole(4000),
            );
            let inside = Vec2::new(whole(viewport.z as usize), whole(viewport.w as usize));
            (viewport.xy() + inside + 0.5, viewport)
        })
        .collect();
    let inputs: Vec<[u32; 6]> = cases
        .iter()
        .map(|(fragment, viewport)| {
            bits(fragment.to_array().into_iter().chain(viewport.to_array()))
        })
        .collect();
    for ((fragment, viewport), device) in cases.into_iter().zip(kernel.run(&inputs)) {
        let uv = (fragment.as_dvec2() - viewport.xy().as_dvec2()) / viewport.zw().as_dvec2();
        let truth = [uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0];
        let twin = ndc_of_fragment(fragment, viewport).to_array();
        for found in [device.map(f32::from_bits), twin] {
            for (found, truth) in found.into_iter().zip(truth) {
                assert!(
                    (f64::from(found) - truth).abs() < 5e-7,
                    "{fragment} of {viewport}: {found}, not {truth}"
                );
            }
        }
    }
}

/// Matrices of a camera, and of the same camera in the previous frame.
struct Cameras {
    view_from_clip: Mat4,
    world_from_view: Mat4,
    clip_from_world: Mat4,
    previous_clip_from_world: Mat4,
}

impl Cameras {
    fn random(random: &mut Random, farthest: f32) -> Self {
        let clip_from_view = Mat4::perspective_infinite_reverse_rh(1.0, SIZE.x / SIZE.y, 0.1);
        let mut vector = |scale: f32| {
            let mut component = || random.range(-scale, scale);
            Vec3::new(component(), component(), component())
        };
        let position = vector(farthest);
        let rotation = Quat::from_scaled_axis(vector(2.0));
        let world_from_view = Mat4::from_rotation_translation(rotation, position);
        let previous = Mat4::from_rotation_translation(
            rotation * Quat::from_scaled_axis(vector(0.02)),
            position + vector(0.1),
        );
        Self {
            view_from_clip: clip_from_view.inverse(),
            world_from_view,
            clip_from_world: clip_from_view * world_from_view.inverse(),
            previous_clip_from_world: clip_from_view * previous.inverse(),
        }
    }

    fn numbers(&self) -> impl Iterator<Item = f32> {
        [
            self.view_from_clip,
            self.world_from_view,
            self.clip_from_world,
            self.previous_clip_from_world,
        ]
        .into_iter()
        .flat_map(|matrix| matrix.to_cols_array())
    }

    /// Exact motion by these very matrices, and the tolerance for f32: the digits that positions lose far from the origin.
    fn truth(&self, ndc: Vec3) -> ([f64; 2], f64) {
        let exact = |matrix: Mat4, p: DVec4| -> DVec4 { matrix.as_dmat4() * p };
        let view = exact(self.view_from_clip, ndc.as_dvec3().extend(1.0));
        let world = exact(self.world_from_view, view);
        let now = exact(self.clip_from_world, world);
        let before = exact(self.previous_clip_from_world, world);
        let motion = now.xy() / now.w - before.xy() / before.w;
        // The translation of `clip_from_world` is as long as the camera's distance from the origin, and is rounded like everything else.
        let camera = self.world_from_view.w_axis.as_dvec4().xyz().length() * view.w.abs();
        let nearness = now.w.abs().min(before.w.abs());
        let lost = (world.xyz().length() + camera) / nearness * (1.0 + motion.length());
        (
            [motion.x * 0.5, motion.y * -0.5],
            16.0 * f64::from(f32::EPSILON) * (1.0 + lost),
        )
    }
}

#[test]
fn surfaces_at_rest_move_as_their_cameras_say() {
    let compute = Compute::new();
    let source = format!(
        "#import bevy_lean_deferred::reconstruction::motion::motion_at_rest
#import bevy_lean_deferred::reconstruction::position::homogeneous_position
{READ}
fn kernel(bits: array<u32, 67>) -> array<u32, 2> {{
    var words = bits;
    var m: array<mat4x4<f32>, 4>;
    for (var i = 0u; i < 64u; i++) {{
        m[i / 16u][(i / 4u) % 4u][i % 4u] = number(words[i]);
    }}
    let ndc = vec3(number(words[64]), number(words[65]), number(words[66]));
    let motion = motion_at_rest(homogeneous_position(m[0], ndc), m[1], m[2], m[3]);
    return array(bitcast<u32>(motion.x), bitcast<u32>(motion.y));
}}"
    );
    let kernel = compute.kernel::<67, 2>(&MODULES, &source);
    let mut random = Random::new(13);
    for farthest in [0.0, 10.0, 1e4] {
        let cases: Vec<(Cameras, Vec3)> = (0..20_000)
            .map(|i| {
                let cameras = Cameras::random(&mut random, farthest);
                // From one metre to ten kilometres; also the sky, infinitely far away.
                let depth = if i % 16 == 0 {
                    0.0
                } else {
                    10f32.powf(random.range(-5.0, -1.0))
                };
                let ndc = Vec3::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), depth);
                (cameras, ndc)
            })
            .collect();
        let inputs: Vec<[u32; 67]> = cases
            .iter()
            .map(|(cameras, ndc)| bits(cameras.numbers().chain(ndc.to_array())))
            .collect();
        let mut largest = 0.0f64;
        for ((cameras, ndc), device) in cases.iter().zip(kernel.run(&inputs)) {
            let (truth, tolerance) = cameras.truth(*ndc);
            let twin = motion_at_rest(
                homogeneous_position(cameras.view_from_clip, *ndc),
                cameras.world_from_view,
                cameras.clip_from_world,
                cameras.previous_clip_from_world,
            );
            for found in [device.map(f32::from_bits), twin.to_array()] {
                for (found, truth) in found.into_iter().zip(truth) {
                    let error = (f64::from(found) - truth).abs();
                    largest = largest.max(error);
                    assert!(error < tolerance, "{ndc}: {found}, not {truth}");
                }
            }
        }
        println!("{farthest:6} m from the origin: off by {largest:.1e} of the picture at most");
    }
}
