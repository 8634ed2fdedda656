//! Words of the G-buffer, from any bits that a float may have. (`layout.rs` and `layout_optional.rs` test that the shaders pack as these
//! twins do.)

use bevy::math::{Vec2, Vec3};
use kit::reference::{
    shader_library::layout::{
        Surface, albedo_exponent, albedo_limit,
        light::{LARGEST_LIGHT, pack_light, unpack_light},
        motion::{LARGEST_MOTION, pack_motion, unpack_motion},
        pack,
        specialization::{
            pack_specialization, unpack_arguments, unpack_reflectance, unpack_shading_model,
            with_arguments,
        },
        unpack,
    },
    shading_models::{anisotropy, clearcoat, diffuse_transmission, rim, subsurface, unlit},
};
use proptest::prelude::*;

use super::config;

/// Largest angle between a normal and its direction as stored, in radians (0.0395°, as `layout/accuracy.rs` measures).
const LARGEST_ANGLE: f64 = 6.95e-4;

/// Any float, including NaN, infinities and subnormal numbers.
fn any_float() -> impl Strategy<Value = f32> {
    prop_oneof![
        3 => 0.0..=1.0f32,
        2 => -10.0..10.0f32,
        2 => any::<u32>().prop_map(f32::from_bits),
        1 => Just(f32::NAN),
        1 => Just(f32::INFINITY),
        1 => Just(f32::MIN_POSITIVE / 2.0),
    ]
}

fn any_vector() -> impl Strategy<Value = Vec3> {
    [any_float(), any_float(), any_float()].prop_map(Vec3::from)
}

/// The number from 0 to `largest` that is stored for `x`.
fn valid(x: f32, largest: f32) -> f32 {
    if x.is_nan() {
        0.0
    } else {
        x.clamp(0.0, largest)
    }
}

fn valid_color(color: Vec3, largest: f32) -> Vec3 {
    if (color.x + color.y + color.z).is_nan() {
        Vec3::ZERO
    } else {
        color.clamp(Vec3::ZERO, Vec3::splat(largest))
    }
}

fn is_share(x: f32) -> bool {
    (0.0..=1.0).contains(&x)
}

proptest! {
    #![proptest_config(config(4096))]

    #[test]
    fn surfaces_are_near_what_was_packed(
        albedo in any_vector(),
        normal in any_vector(),
        [metallic, occlusion, perceptual_roughness] in [any_float(), any_float(), any_float()],
        has_mesh_normal in any::<bool>(),
    ) {
        let surface =
            Surface { albedo, metallic, occlusion, normal, perceptual_roughness, has_mesh_normal };
        let stored = unpack(pack(&surface));
        // Error of square roots: half a step, which the exponent makes smaller.
        let roots = |color: Vec3| Vec3::new(color.x.sqrt(), color.y.sqrt(), color.z.sqrt());
        let exact = valid_color(albedo, 1.0);
        let off = (roots(stored.albedo) - roots(exact)).abs();
        let step = albedo_limit(albedo_exponent(exact)).sqrt() / 127.0;
        prop_assert!(off.max_element() <= 0.501 * step, "{off}");
        prop_assert!((stored.metallic - valid(metallic, 1.0)).abs() <= 0.501 / 20.0);
        let occlusion_steps = match stored.metallic {
            0.0 => 71.0,
            1.0 => 39.0,
            _ => 11.0,
        };
        prop_assert!((stored.occlusion - valid(occlusion, 1.0)).abs() <= 0.501 / occlusion_steps);
        prop_assert!(
            (stored.perceptual_roughness - valid(perceptual_roughness, 1.0)).abs() <= 0.501 / 255.0
        );
        prop_assert_eq!(stored.has_mesh_normal, has_mesh_normal);
        prop_assert!((stored.normal.length() - 1.0).abs() < 1e-5, "{}", stored.normal);
        let exact = normal.as_dvec3().normalize_or_zero();
        if normal.is_finite() && normal.abs().element_sum() < 7e37 && normal.abs().max_element() > 1e-29 {
            let angle = exact.cross(stored.normal.as_dvec3()).length();
            prop_assert!(exact.dot(stored.normal.as_dvec3()) > 0.0 && angle < LARGEST_ANGLE, "{angle}");
        }
        let again = unpack(pack(&stored));
        // A direction on the octahedron's edges has more than one word.
        prop_assert!(again.normal.distance(stored.normal) < 1e-6);
        let normal = stored.normal;
        prop_assert_eq!(Surface { normal, ..again }, stored, "what is stored is stored as it is");
    }

    #[test]
    fn any_word_is_a_surface(words in any::<[u32; 2]>()) {
        let surface = unpack(words);
        prop_assert!(surface.albedo.to_array().into_iter().all(is_share));
        prop_assert!(is_share(surface.metallic) && is_share(surface.occlusion));
        prop_assert!(is_share(surface.perceptual_roughness));
        prop_assert!((surface.normal.length() - 1.0).abs() < 1e-5, "{}", surface.normal);
    }

    #[test]
    fn light_is_near_what_was_packed(color in any_vector(), scale in -20..20i32) {
        let color = color * (scale as f32).exp2();
        let stored = unpack_light(pack_light(color));
        let exact = valid_color(color, LARGEST_LIGHT);
        let allowed = (exact.max_element() / 511.0).max(3.1e-8);
        let off = (stored - exact).abs().max_element();
        prop_assert!(off <= allowed, "{stored} for {exact}");
        prop_assert_eq!(unpack_light(pack_light(stored)), stored);
    }

    #[test]
    fn brighter_light_is_not_darker(dark in 0.0..70000.0f32, more in 1.0..2.0f32) {
        let [dark, bright] = [dark, dark * more].map(|x| unpack_light(pack_light(Vec3::splat(x))).x);
        prop_assert!(bright >= dark, "{bright} for more than {dark}");
    }

    #[test]
    fn motion_is_near_what_was_packed(x in any_float(), y in any_float()) {
        let exact = [x, y].map(|part| if part.is_nan() { 0.0 } else { part });
        let exact = Vec2::from(exact).clamp(Vec2::splat(-LARGEST_MOTION), Vec2::splat(LARGEST_MOTION));
        let stored = unpack_motion(pack_motion(Vec2::new(x, y)));
        // Half a step of a half float.
        let allowed = (exact.abs() / 2048.0).max(Vec2::splat(3e-8));
        prop_assert!((stored - exact).abs().cmple(allowed).all(), "{stored} for {exact}");
        prop_assert!(pack_motion(-stored) == pack_motion(stored) ^ 0x8000_8000);
    }

    #[test]
    fn a_specialization_holds_all_its_parts(
        reflectance in any_float(),
        shading_model in 0..8u32,
        arguments in any::<u32>(),
    ) {
        let word = pack_specialization(reflectance, shading_model, 0);
        let with = with_arguments(word, arguments);
        prop_assert_eq!(unpack_shading_model(with), shading_model);
        prop_assert_eq!(unpack_reflectance(with), unpack_reflectance(word));
        prop_assert!(unpack_reflectance(word).is_finite());
        let again = with_arguments(word, unpack_arguments(with));
        prop_assert_eq!(again, with);
    }

    #[test]
    fn arguments_of_shading_models_are_finite(
        color in any_vector(),
        tangent in any_vector(),
        normal in any_vector(),
        [a, b] in [any_float(), any_float()],
    ) {
        let normal = unpack(pack(&Surface {
            normal,
            albedo: Vec3::ZERO,
            metallic: 0.0,
            occlusion: 0.0,
            perceptual_roughness: 0.0,
            has_mesh_normal: true,
        }))
        .normal;
        let coat = clearcoat::pack_clearcoat(a, b);
        prop_assert!(is_share(clearcoat::unpack_clearcoat_strength(coat)));
        prop_assert!(is_share(clearcoat::unpack_clearcoat_roughness(coat)));

        let stretched = anisotropy::pack_anisotropy(a, tangent, normal);
        prop_assert!(is_share(anisotropy::unpack_anisotropy_strength(stretched)));
        let along = anisotropy::unpack_anisotropy_tangent(stretched, normal);
        prop_assert!((along.length() - 1.0).abs() < 1e-4, "{along}");
        prop_assert!(along.dot(normal).abs() < 1e-3, "{along} on {normal}");

        let thin = diffuse_transmission::pack_diffuse_transmission(a, b, true);
        prop_assert!(is_share(diffuse_transmission::unpack_transmission(thin)));
        prop_assert!(diffuse_transmission::unpack_thickness(thin) >= 0.0);
        prop_assert!(diffuse_transmission::unpack_thickness(thin).is_finite());
        prop_assert!(diffuse_transmission::unpack_receives_shadows(thin));

        let edge = rim::pack_rim(color, a);
        prop_assert!(rim::unpack_rim_color(edge).to_array().into_iter().all(is_share));
        prop_assert!(rim::unpack_rim_exponent(edge) > 0.0 && rim::unpack_rim_exponent(edge).is_finite());

        let skin = subsurface::pack_subsurface(color, a, false);
        prop_assert!(subsurface::unpack_subsurface_color(skin).to_array().into_iter().all(is_share));
        prop_assert!(subsurface::unpack_subsurface_path(skin) >= 0.0);
        prop_assert!(subsurface::unpack_subsurface_path(skin).is_finite());
        prop_assert!(!subsurface::unpack_subsurface_colors_before(skin));

        let plain = unlit::unpack_unlit(unlit::pack_unlit(color, 0));
        prop_assert!(plain.is_finite() && plain.min_element() >= 0.0, "{plain}");
    }
}
