//! The contenders.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use kit::analytic_mirrors::with_bevys_reflections;

#[derive(Clone, Copy, PartialEq)]
pub enum Contender {
    Plain,
    Occlusion,
    Gi(LeanQuality, LeanResolution),
    Reflections(LeanQuality, LeanResolution),
    /// Bevy's `ScreenSpaceReflections` on its deferred path.
    BevysReflections,
    /// Scattering beneath all surfaces, or beneath a ball that covers a tenth of the picture; without a quality, such
    /// surfaces on a camera without the effect.
    Scattering(Option<LeanQuality>, Share),
}

/// Share of the picture that scatters light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Share {
    All,
    Tenth,
}

impl Contender {
    pub fn all() -> Vec<Self> {
        use LeanResolution::{Full, Half};
        let gi = [Half, Full]
            .into_iter()
            .flat_map(|resolution| LeanQuality::ALL.map(|quality| Self::Gi(quality, resolution)));
        let reflections = [Half, Full].into_iter().flat_map(|resolution| {
            LeanQuality::ALL.map(|quality| Self::Reflections(quality, resolution))
        });
        let scattering = [Share::All, Share::Tenth].into_iter().flat_map(|share| {
            // `Medium` is as `Low`, `Ultra` as `High`.
            let qualities = [None, Some(LeanQuality::Low), Some(LeanQuality::High)];
            qualities.map(|quality| Self::Scattering(quality, share))
        });
        [Self::Plain, Self::Occlusion]
            .into_iter()
            .chain(gi)
            .chain(reflections)
            .chain([Self::BevysReflections])
            .chain(scattering)
            .collect()
    }

    pub fn is_plain(self) -> bool {
        self == Self::Plain
    }

    pub fn name(self) -> String {
        match self {
            Self::Plain => "none".into(),
            Self::Occlusion => "ambient occlusion, Medium".into(),
            Self::Gi(quality, resolution) => format!("GI, {quality:?}, {resolution:?}"),
            Self::Reflections(quality, resolution) => {
                format!("reflections, {quality:?}, {resolution:?}")
            }
            Self::BevysReflections => "Bevy's reflections".into(),
            Self::Scattering(None, share) => format!("scattering, Off, {share:?}"),
            Self::Scattering(Some(quality), share) => format!("scattering, {quality:?}, {share:?}"),
        }
    }

    /// GPU spans of the passes that only the effect has.
    pub fn spans(self) -> &'static [&'static str] {
        match self {
            Self::Plain => &[],
            Self::Occlusion => &["lean_deferred/effects/ambient_occlusion/gather"],
            Self::Gi(..) => &["lean_deferred/effects/diffuse_gi"],
            Self::Reflections(..) => &[
                "lean_deferred/effects/history",
                "lean_deferred/effects/reflections",
            ],
            Self::BevysReflections => &["ssr"],
            Self::Scattering(None, _) => &[],
            Self::Scattering(..) => &["lean_deferred/effects/subsurface"],
        }
    }

    /// GPU spans of the dispatches in those passes, if several can be timed one by one.
    pub fn stages(self) -> &'static [&'static str] {
        match self {
            Self::Gi(..) => &[
                "lean_deferred/effects/diffuse_gi/levels",
                "lean_deferred/effects/diffuse_gi/gather",
                "lean_deferred/effects/diffuse_gi/filter",
            ],
            Self::Reflections(..) => &[
                "lean_deferred/effects/history",
                "lean_deferred/effects/reflections/hi_z",
                "lean_deferred/effects/reflections/trace",
                "lean_deferred/effects/reflections/spatial_filter",
                "lean_deferred/effects/reflections/resolve",
            ],
            _ => &[],
        }
    }

    /// Bytes per pixel that the effect adds to a picture of `rows` rows: each texture once written and once read,
    /// without depth and normals.
    pub fn bytes(self, rows: u32) -> f64 {
        match self {
            Self::Plain => 0.0,
            Self::Occlusion => 2.0,
            // Lighting writes diffuse light, and the effect reads it, as words. A texel of a level has 8 bytes, and the
            // last frame's first level is read too. The gathered and the filtered light have 8 bytes per texel each.
            Self::Gi(_, resolution) => {
                let texels = match resolution {
                    LeanResolution::Full => 1.0,
                    LeanResolution::Half => 0.25,
                };
                let levels = 1.0 + 0.25 + 0.0625 + 0.015_625;
                4.0 + 4.0 + texels * 8.0 * (2.0 * levels + 1.0 + 2.0 + 2.0)
            }
            // The picture is read, written with its levels, and read again at the ends of rays. Cells have 8 bytes;
            // surfaces, rays and lobes 28. The result is written and read.
            Self::Reflections(quality, resolution) => {
                let side = reflections(quality, resolution).texel_side(rows);
                let texels = 1.0 / f64::from(side * side);
                let levels = 1.0 + 0.25 + 0.0625 + 0.015_625;
                let cells = 0.0625 + 0.003_906;
                8.0 + 8.0 * levels + 8.0 + 2.0 * 8.0 * cells + 2.0 * 28.0 * texels + 2.0 * 8.0
            }
            // The picture is read at the pixel and at the end of its ray, and written. The G-buffer is read.
            Self::BevysReflections => 3.0 * 8.0 + 16.0,
            Self::Scattering(quality, share) => {
                let share = match share {
                    Share::All => 1.0,
                    Share::Tenth => 0.1,
                };
                share * scattering_bytes(quality)
            }
        }
    }

    /// Adds the contender's components to `camera`.
    pub fn dress(self, camera: &mut EntityWorldMut) {
        match self {
            Self::Plain => {}
            Self::Occlusion => {
                camera.insert(LeanScreenSpaceAmbientOcclusion::default());
            }
            Self::Gi(quality, resolution) => {
                camera.insert(LeanScreenSpaceGi {
                    quality,
                    resolution,
                    ..default()
                });
            }
            Self::Reflections(quality, resolution) => {
                camera.insert(reflections(quality, resolution));
            }
            Self::BevysReflections => with_bevys_reflections(camera),
            Self::Scattering(quality, share) => {
                if let Some(quality) = quality {
                    camera.insert(LeanSubsurfaceScattering {
                        quality,
                        ..default()
                    });
                }
                match share {
                    Share::All => camera.world_scope(scatter_everywhere),
                    Share::Tenth => spawn_ball_before(camera),
                }
            }
        }
    }
}

fn reflections(quality: LeanQuality, resolution: LeanResolution) -> LeanScreenSpaceReflections {
    LeanScreenSpaceReflections {
        quality,
        resolution,
        ..default()
    }
}

/// Bytes per pixel whose light scatters.
fn scattering_bytes(quality: Option<LeanQuality>) -> f64 {
    if quality.is_none() {
        return 0.0;
    }
    // Light has 8 bytes; the picture and the light that leaves 16. The picture's light and every second level are
    // written, read to make the next level, and read to be scattered. The levels between are only scattered. The
    // scattered light of these levels is written and read. The picture is written.
    let (between, second) = (0.25 + 0.015_625, 0.0625);
    3.0 * 8.0 * (1.0 + second) + 2.0 * 8.0 * between + 2.0 * 8.0 * between + 2.0 * 16.0 + 8.0
}

/// In metres.
const MEAN_FREE_PATH: f32 = 0.02;

fn scattering(base: StandardMaterial, mean_free_path: f32) -> ExtendedStandardMaterial {
    ExtendedStandardMaterial {
        base,
        extension: ShadingExtension::Subsurface {
            color: LinearRgba::rgb(1.0, 0.35, 0.2).into(),
            mean_free_path,
            albedo: default(),
        },
    }
}

/// Makes all meshes scatter light.
fn scatter_everywhere(world: &mut World) {
    let mut meshes = world.query::<(Entity, &MeshMaterial3d<StandardMaterial>)>();
    let meshes: Vec<_> = meshes
        .iter(world)
        .map(|(mesh, of)| (mesh, of.0.id()))
        .collect();
    for (mesh, material) in meshes {
        let base = world.resource::<Assets<StandardMaterial>>().get(material);
        let material = scattering(base.cloned().unwrap_or_default(), MEAN_FREE_PATH);
        let material = world
            .resource_mut::<Assets<ExtendedStandardMaterial>>()
            .add(material);
        world
            .entity_mut(mesh)
            .remove::<MeshMaterial3d<StandardMaterial>>()
            .insert(MeshMaterial3d(material));
    }
}

/// Spawns a ball in front of the camera, as large as a head.
fn spawn_ball_before(camera: &mut EntityWorldMut) {
    let radius = 0.12;
    let entity = camera.id();
    camera.world_scope(|world| {
        let ball = Sphere::new(radius).mesh().uv(128, 64);
        let ball = world.resource_mut::<Assets<Mesh>>().add(ball);
        let material = scattering(Color::srgb(0.85, 0.7, 0.6).into(), 0.005);
        let material = world
            .resource_mut::<Assets<ExtendedStandardMaterial>>()
            .add(material);
        // Its radius is 0.197 of its distance.
        let place = Transform::from_xyz(0.0, 0.0, -radius / 0.197);
        let ball = (Mesh3d(ball), MeshMaterial3d(material), place);
        world.spawn((ball, ChildOf(entity)));
    });
}
