//! Rim light and subsurface scattering of `ShadingExtension` are drawn into the G-buffer and match forward.

use bevy::{
    core_pipeline::oit::OrderIndependentTransparencySettings,
    light::AmbientLight,
    pbr::PreparedMaterial,
    platform::collections::HashSet,
    prelude::*,
    render::{
        RenderApp, erased_render_asset::ErasedRenderAssets, render_resource::AsBindGroup,
        renderer::RenderDevice,
    },
};
use bevy_lean_deferred::{
    gbuffer::GBufferTargets, lighting::CompiledLighting, material_extension::SubsurfaceAlbedo,
    prelude::*, view::ActiveLeanView,
};
use kit::{
    headless::{Headless, Picture},
    lean::{build, compile_lighting, is_lit_by_general, judge, report, set_lean, settled, show},
    metrics::difference,
    own_process::in_own_process,
    scenes::{LEAST_PSNR, SceneBuilder, special_materials::put_lightmaps},
};

const SIZE: UVec2 = UVec2::new(320, 240);

/// Stricter than other scenes: a rim that is a fifth too dark still reaches 45 to 48 dB.
const LEAST_RIM_PSNR: f64 = 50.0;

/// Light that surrounds the balls.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Surroundings {
    Ambient,
    EnvironmentMap,
    IrradianceVolume,
}

/// A saturated, a white and a wide rim.
const RIMS: [ShadingExtension; 3] = [
    rim(Color::srgb(1.0, 0.5, 0.2), 4.0),
    rim(Color::WHITE, 2.0),
    rim(Color::srgb(0.3, 0.8, 1.0), 1.0),
];

const SUBSURFACES: [ShadingExtension; 3] = [
    subsurface(Color::srgb(0.9, 0.3, 0.2), 0.001),
    subsurface(Color::srgb(0.9, 0.8, 0.7), 0.02),
    subsurface(Color::WHITE, 1.0),
];

const fn rim(color: Color, exponent: f32) -> ShadingExtension {
    ShadingExtension::Rim { color, exponent }
}

const fn subsurface(color: Color, mean_free_path: f32) -> ShadingExtension {
    ShadingExtension::Subsurface {
        color,
        mean_free_path,
        albedo: SubsurfaceAlbedo::AfterScattering,
    }
}

fn balls(
    s: &mut SceneBuilder,
    extensions: [ShadingExtension; 3],
    change: fn(&mut StandardMaterial),
) {
    let mesh = s.add::<Mesh>(Sphere::new(0.8).mesh().uv(64, 32));
    for (extension, x) in extensions.into_iter().zip([-1.9, 0.0, 1.9]) {
        let mut base = StandardMaterial {
            base_color: Color::srgb(0.3, 0.25, 0.2),
            perceptual_roughness: 0.7,
            ..default()
        };
        change(&mut base);
        let material =
            s.add::<ExtendedStandardMaterial>(ExtendedStandardMaterial { base, extension });
        s.spawn((
            Mesh3d(mesh.clone()),
            MeshMaterial3d(material),
            Transform::from_xyz(x, 0.8, 0.0),
        ));
    }
}

/// Three balls on a floor in the sun, with surroundings.
fn scene(
    s: &mut SceneBuilder,
    surroundings: Surroundings,
    extensions: [ShadingExtension; 3],
    change: fn(&mut StandardMaterial),
) {
    s.floor();
    s.sun(true);
    balls(s, extensions, change);
    let ambient = AmbientLight {
        brightness: 700.0,
        ..default()
    };
    // Without scattering, as forward.
    let camera = s.default_camera(ambient);
    match surroundings {
        Surroundings::Ambient => {}
        Surroundings::EnvironmentMap => {
            let light = s.environment_map(900.0);
            s.world().entity_mut(camera).insert(light);
        }
        Surroundings::IrradianceVolume => {
            let volume = s.irradiance_volume(1500.0);
            s.probe(volume);
        }
    }
}

/// Optional targets of the only lean view.
fn targets(headless: &mut Headless) -> GBufferTargets {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query::<&ActiveLeanView>();
    views.single(world).expect("one lean view").targets
}

fn forward(
    headless: &mut Headless,
    surroundings: Surroundings,
    extensions: [ShadingExtension; 3],
    change: fn(&mut StandardMaterial),
) -> Picture {
    show(headless, |s| scene(s, surroundings, extensions, change));
    settled(headless)
}

fn compare(
    headless: &mut Headless,
    name: &str,
    surroundings: Surroundings,
    extensions: [ShadingExtension; 3],
    change: fn(&mut StandardMaterial),
    expected: GBufferTargets,
) -> Result<(), String> {
    let forward = forward(headless, surroundings, extensions, change);
    set_lean(headless, true);
    let lean = settled(headless);
    assert_eq!(targets(headless), expected, "{name}");
    let name = format!("{name}_{surroundings:?}").to_lowercase();
    let has_rims = extensions == RIMS;
    let least_psnr = if has_rims { LEAST_RIM_PSNR } else { LEAST_PSNR };
    judge(&name, &forward, &lean, least_psnr)
}

const ALL: [Surroundings; 3] = [
    Surroundings::Ambient,
    Surroundings::EnvironmentMap,
    Surroundings::IrradianceVolume,
];

#[test]
fn extensions_match_forward() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        rims_match_forward(headless);
        subsurface_matches_forward_and_the_plain_base(headless);
    });
}

/// General pipelines have irradiance volumes. Rims of views without any reflect the environment map all the same.
#[test]
fn general_pipelines_light_rims_without_volumes() {
    in_own_process(|| {
        let headless = &mut Headless::with(SIZE, |app| {
            compile_lighting(app, CompiledLighting::General);
        });
        let result = compare(
            headless,
            "general_rim",
            Surroundings::EnvironmentMap,
            RIMS,
            |_| {},
            GBufferTargets::SPECIALIZATION,
        );
        assert!(is_lit_by_general(headless));
        report([result]);
    });
}

#[test]
#[ignore = "nightly: combines extensions with lightmaps and special bases"]
fn extensions_of_further_surfaces_match_forward() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        rims_before_lightmaps_match_forward(headless);
        rims_show(headless);
        other_bases_match_forward(headless);
    });
}

fn rims_match_forward(headless: &mut Headless) {
    let through = GBufferTargets::SPECIALIZATION;
    report(ALL.map(|surroundings| compare(headless, "rim", surroundings, RIMS, |_| {}, through)));
    report([compare(
        headless,
        "rim_emissive",
        Surroundings::EnvironmentMap,
        RIMS,
        |base| base.emissive = LinearRgba::rgb(0.0, 0.1, 0.05),
        GBufferTargets::EMISSIVE.union(GBufferTargets::SPECIALIZATION),
    )]);
}

/// Surfaces without a lightmap have light from their surroundings, though their tiles contain lightmapped surfaces.
fn rims_before_lightmaps_match_forward(headless: &mut Headless) {
    show(headless, |s| {
        scene(s, Surroundings::IrradianceVolume, RIMS, |_| {});
        let wall = s.mesh(
            Rectangle::new(12.0, 6.0),
            StandardMaterial {
                lightmap_exposure: 1500.0,
                ..default()
            },
            Transform::from_xyz(0.0, 3.0, -1.5),
        );
        put_lightmaps(s, &[wall], false);
    });
    let forward = settled(headless);
    set_lean(headless, true);
    let lean = settled(headless);
    report([judge(
        "rim_before_lightmap",
        &forward,
        &lean,
        LEAST_RIM_PSNR,
    )]);
}

fn subsurface_matches_forward_and_the_plain_base(headless: &mut Headless) {
    for surroundings in [Surroundings::Ambient, Surroundings::EnvironmentMap] {
        let through = GBufferTargets::SPECIALIZATION;
        report([compare(
            headless,
            "subsurface",
            surroundings,
            SUBSURFACES,
            |_| {},
            through,
        )]);
        let none = [ShadingExtension::None; 3];
        let [plain, subsurface] = [none, SUBSURFACES]
            .map(|extensions| forward(headless, surroundings, extensions, |_| {}));
        assert!(plain == subsurface, "forward shows the base");
    }
}

/// Rims are visible, so that the other tests fail if neither renderer draws them.
fn rims_show(headless: &mut Headless) {
    for surroundings in ALL {
        let [plain, rims] = [[ShadingExtension::None; 3], RIMS]
            .map(|extensions| forward(headless, surroundings, extensions, |_| {}));
        let psnr = difference(&plain, &rims).psnr;
        println!("{surroundings:?}: {psnr:.1} dB without rims");
        assert!(psnr < 35.0, "{surroundings:?}: {psnr:.1} dB");
    }
}

/// Bases that are special themselves, and bases without an extension, match forward.
fn other_bases_match_forward(headless: &mut Headless) {
    let none = [ShadingExtension::None; 3];
    let surroundings = Surroundings::EnvironmentMap;
    report([
        compare(
            headless,
            "none",
            surroundings,
            none,
            |_| {},
            GBufferTargets::empty(),
        ),
        compare(
            headless,
            "none_clearcoat",
            surroundings,
            none,
            |base| base.clearcoat = 1.0,
            GBufferTargets::SPECIALIZATION,
        ),
        compare(
            headless,
            "rim_clearcoat",
            surroundings,
            RIMS,
            |base| base.clearcoat = 1.0,
            GBufferTargets::empty(),
        ),
        compare(
            headless,
            "rim_unlit",
            surroundings,
            RIMS,
            |base| base.unlit = true,
            GBufferTargets::empty(),
        ),
    ]);
}

/// Cards of one material behind one another; the nearest is first in the order of drawing.
fn blended(s: &mut SceneBuilder, extended: bool) {
    s.solids();
    let card = s.add::<Mesh>(Rectangle::new(3.0, 1.6));
    for (z, color) in [
        (2.0, Color::srgba(0.9, 0.2, 0.1, 0.5)),
        (1.0, Color::srgba(0.1, 0.8, 0.2, 0.5)),
        (1.5, Color::srgba(0.1, 0.2, 0.9, 0.7)),
    ] {
        let base = StandardMaterial {
            base_color: color,
            alpha_mode: AlphaMode::Blend,
            ..default()
        };
        let place = Transform::from_xyz(0.3 * z, 0.8, z);
        if extended {
            let extension = ShadingExtension::None;
            let material =
                s.add::<ExtendedStandardMaterial>(ExtendedStandardMaterial { base, extension });
            s.spawn((Mesh3d(card.clone()), MeshMaterial3d(material), place));
        } else {
            let material = s.add::<StandardMaterial>(base);
            s.spawn((Mesh3d(card.clone()), MeshMaterial3d(material), place));
        }
    }
    s.sun(false);
    s.default_camera(OrderIndependentTransparencySettings::default());
}

/// Also on cameras that sort transparent fragments per pixel.
#[test]
fn blended_materials_match_their_base() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        let [base, extended] = [false, true].map(|extended| {
            show(headless, |s| blended(s, extended));
            let forward = settled(headless);
            set_lean(headless, true);
            [forward, settled(headless)]
        });
        report([
            judge("blended_forward", &base[0], &extended[0], 60.0),
            judge("blended_lean", &base[1], &extended[1], 60.0),
            judge("blended", &extended[0], &extended[1], LEAST_PSNR),
        ]);
    });
}

/// Materials with an extension share a bind group where `StandardMaterial`s do.
#[test]
fn materials_share_a_bind_group() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            scene(s, Surroundings::Ambient, RIMS, |_| {});
            balls(s, SUBSURFACES, |_| {});
        });
        headless.settle();
        let world = headless.app.sub_app_mut(RenderApp).world_mut();
        if !StandardMaterial::bindless_supported(world.resource::<RenderDevice>()) {
            println!("skipped: bindless materials: the device has no binding arrays");
            return;
        }
        let extended = core::any::TypeId::of::<ExtendedStandardMaterial>();
        let materials = world.resource::<ErasedRenderAssets<PreparedMaterial>>();
        let groups: Vec<_> = (materials.iter())
            .filter(|(id, _)| id.type_id() == extended)
            .map(|(_, material)| material.binding.group.0)
            .collect();
        assert_eq!(groups.len(), 6);
        let distinct: HashSet<_> = groups.iter().copied().collect();
        assert_eq!(distinct.len(), 1, "{groups:?}");
    });
}
