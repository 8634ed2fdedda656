//! Applies changes of a camera's settings to other cameras of its target.
//!
//! In Bevy, cameras of one target share a main texture if they request equal ones, and depth if they have equal `Msaa`.
//! Those with and without `Hdr` are counted separately to decide which is drawn first. A change to one camera is
//! therefore applied to those with equal settings too, as long as both render to that target.

use bevy::{
    camera::{CompositingSpace, Hdr, NormalizedRenderTarget, RenderTarget},
    core_pipeline::tonemapping::Tonemapping,
    platform::collections::HashSet,
    prelude::*,
    window::PrimaryWindow,
};

use super::{
    needs::{CameraNeeds, Need, PartnerNeeds},
    record::{AppSettings, CameraOverrides},
};

/// On a camera: the other cameras of its target for whose effects it was changed.
#[derive(Component)]
pub(crate) struct Partners(Vec<Tie>);

/// Settings that a camera shared with another one before that was changed. Later changes by the app do not dissolve the
/// tie.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Tie {
    with: Entity,
    same_msaa: bool,
    /// True if each cleared a main texture of its own. In a shared one, the later camera would clear the output of the
    /// earlier.
    own_textures: bool,
}

/// A camera that is rendered.
struct Seat {
    camera: Entity,
    target: NormalizedRenderTarget,
    /// Part of the target that it covers; `None` for all of it.
    viewport: Option<URect>,
    settings: AppSettings,
    space: Option<CompositingSpace>,
    order: isize,
    clears: bool,
    /// Needs of its own effects for which it was changed.
    changed: Vec<Need>,
}

impl Seat {
    fn of(camera: EntityRef, world: &World, primary_window: Option<Entity>) -> Option<Self> {
        let needs = world.resource::<CameraNeeds>();
        let overrides = camera.get::<CameraOverrides>();
        let rendered = camera.get::<Camera>().filter(|camera| camera.is_active)?;
        Some(Self {
            camera: camera.id(),
            target: camera.get::<RenderTarget>()?.normalize(primary_window)?,
            viewport: rendered.viewport.as_ref().map(|viewport| {
                let corner = viewport.physical_position;
                URect::from_corners(corner, corner.saturating_add(viewport.physical_size))
            }),
            settings: AppSettings::of(camera, world.components())?,
            space: camera.get().copied(),
            order: rendered.order,
            clears: !matches!(rendered.clear_color, ClearColorConfig::None),
            changed: [Need::WithoutMsaa, Need::Hdr]
                .into_iter()
                .filter(|need| {
                    needs.has(camera, *need)
                        && overrides.is_some_and(|overrides| overrides.holds(camera, *need))
                })
                .collect(),
        })
    }

    /// True if one camera draws over the other. Cameras of a split screen do not, and keep their settings.
    fn overlaps(&self, other: &Self) -> bool {
        self.target == other.target
            && match (self.viewport, other.viewport) {
                (Some(one), Some(other)) => !one.intersect(other).is_empty(),
                _ => true,
            }
    }

    /// Returns `None` if only one of them has `Hdr`: such cameras never drew over one another.
    fn tie(&self, other: &Self) -> Option<Tie> {
        let later = if (self.order, self.camera) > (other.order, other.camera) {
            self
        } else {
            other
        };
        let shares_texture = self.settings == other.settings && self.space == other.space;
        (self.settings.hdr == other.settings.hdr).then_some(Tie {
            with: other.camera,
            same_msaa: self.settings.msaa == other.settings.msaa,
            own_textures: later.clears && !shares_texture,
        })
    }

    /// True if effects of `other` require that this camera meets `need`.
    fn must_fit(&self, need: Need, tie: &Tie, other: &Self) -> bool {
        match need {
            Need::WithoutMsaa => tie.same_msaa && other.changed.contains(&need),
            Need::Hdr => other.changed.contains(&need),
            // It suffices that one of the two has it.
            Need::OwnTexture => {
                tie.own_textures && (self.changed.is_empty() || self.camera > other.camera)
            }
        }
    }

    /// The cameras to which this one has ties. Existing ties (`before`) stay as they are.
    fn partners<'a>(&self, leaders: &[&'a Self], before: &[Tie]) -> Vec<(Tie, &'a Self)> {
        (leaders.iter())
            .filter(|other| self.camera != other.camera && self.overlaps(other))
            .filter_map(|&other| {
                let tie = before.iter().find(|tie| tie.with == other.camera);
                Some((tie.copied().or_else(|| self.tie(other))?, other))
            })
            .collect()
    }
}

type CameraChanged = (
    Changed<Camera>,
    Changed<RenderTarget>,
    Changed<Msaa>,
    Changed<Hdr>,
    Changed<CameraOverrides>,
);

/// True if some camera has overrides and partners may have appeared or disappeared.
pub(crate) fn are_cameras_changed(
    overridden: Query<(), Or<(With<CameraOverrides>, With<Partners>)>>,
    changed: Query<(), (With<Camera>, Or<CameraChanged>)>,
    windows: Query<(), Added<PrimaryWindow>>,
    mut removed: (
        RemovedComponents<Camera>,
        RemovedComponents<RenderTarget>,
        RemovedComponents<Hdr>,
        RemovedComponents<CameraOverrides>,
        RemovedComponents<PrimaryWindow>,
    ),
) -> bool {
    let removed = removed.0.read().count()
        + removed.1.read().count()
        + removed.2.read().count()
        + removed.3.read().count()
        + removed.4.read().count();
    !overridden.is_empty() && (removed > 0 || !changed.is_empty() || !windows.is_empty())
}

/// Applies the changes of cameras to others of their target, once, and reverts them when the former are gone.
pub(crate) fn fit_partners(
    mut commands: Commands,
    world: &World,
    cameras: Query<EntityRef, With<Camera>>,
    primary_window: Query<Entity, With<PrimaryWindow>>,
    mut told: Local<HashSet<(Entity, Need)>>,
) {
    told.retain(|(camera, _)| cameras.contains(*camera));
    let primary_window = primary_window.iter().next();
    let seats: Vec<(EntityRef, Option<Seat>)> = cameras
        .iter()
        .map(|camera| (camera, Seat::of(camera, world, primary_window)))
        .collect();
    let leaders: Vec<&Seat> = (seats.iter().filter_map(|(_, seat)| seat.as_ref()))
        .filter(|seat| !seat.changed.is_empty())
        .collect();
    for (camera, seat) in &seats {
        let ties_before = camera.get::<Partners>().map_or(&[][..], |ties| &ties.0);
        let needs_before = (camera.get::<PartnerNeeds>()).map_or(&[][..], |needs| &needs.0);
        let partners = (seat.as_ref()).map_or(vec![], |seat| seat.partners(&leaders, ties_before));
        let who_needs = |need| {
            let seat = seat.as_ref()?;
            (partners.iter()).find(|(tie, other)| seat.must_fit(need, tie, other))
        };
        let mut needs = vec![Need::WithoutMsaa, Need::Hdr, Need::OwnTexture];
        needs.retain(|need| who_needs(*need).is_some());
        let ties: Vec<Tie> = partners.iter().map(|(tie, _)| *tie).collect();
        if ties == ties_before && needs == needs_before {
            continue;
        }
        let mut new = needs.clone();
        new.retain(|need| !needs_before.contains(need));
        for need in &new {
            if let Some((_, other)) = who_needs(*need)
                && let Some(loss) = loss(*camera, *need, cameras.get(other.camera).ok())
                && told.insert((camera.id(), *need))
            {
                warn!(
                    "Camera {} is rendered {loss}, because the effects of camera {} on the same target need that. Give one of them a target of its \
                     own to avoid it.",
                    camera.id(),
                    other.camera
                );
            }
        }
        commands
            .entity(camera.id())
            .queue_silenced(move |mut camera: EntityWorldMut| {
                if ties.is_empty() {
                    camera.remove::<(Partners, PartnerNeeds)>();
                } else {
                    camera.insert((Partners(ties), PartnerNeeds(needs)));
                }
                CameraOverrides::change(&mut camera, |overrides, camera| {
                    for need in new {
                        overrides.fit(camera, need);
                    }
                    overrides.give_back(camera);
                });
            });
    }
}

/// Describes the loss of quality in the picture of `camera` when it is changed for `other`.
fn loss(camera: EntityRef, need: Need, other: Option<EntityRef>) -> Option<&'static str> {
    let tonemaps = |camera: EntityRef| camera.get().is_some_and(Tonemapping::is_enabled);
    match need {
        Need::WithoutMsaa => {
            let has_msaa = camera.get::<Msaa>().is_some_and(|msaa| *msaa != Msaa::Off);
            (has_msaa && camera.contains::<Camera3d>()).then_some("without Msaa")
        }
        Need::Hdr => {
            let both_tonemap = tonemaps(camera) && other.is_some_and(tonemaps);
            (both_tonemap && !camera.contains::<Hdr>()).then_some(
                "with Hdr (both tonemap all of the picture, unless the first has Tonemapping::None)",
            )
        }
        Need::OwnTexture => None,
    }
}
