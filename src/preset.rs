//! Presets: the effects of a camera and their levels, in one call.

use core::{fmt, str::FromStr};

use bevy::{
    ecs::{component::Mutable, error::warn},
    prelude::*,
};

use crate::{
    effects::{
        LeanScreenSpaceGi, LeanScreenSpaceReflections, LeanSubsurfaceScattering,
        ambient_occlusion::LeanScreenSpaceAmbientOcclusion,
    },
    view::{LeanDeferred, LeanQuality, LeanResolution, ParseLevelError, parse_level},
};

/// The effects of a camera and their levels, for menus of graphics settings.
///
/// [`apply`](Self::apply) inserts the components of these effects, with these levels, and removes those of the others:
///
/// | preset | ambient occlusion | diffuse GI | reflections | scattering | for |
/// |---|---|---|---|---|---|
/// | `Low` | `Medium`, `Half` | – | – | – | the shortest time: integrated GPUs and handhelds |
/// | `Medium` | `Medium`, `Full` | – | – | `Low` | the look of [`LeanDeferred`], with contact between surfaces |
/// | `High` | by GI | `Medium`, `Half` | `Medium`, `Half` | `High` | light that surfaces reflect, on GPUs with time for it |
/// | `Ultra` | by GI | `High`, `Half` | `High`, `Full` | `High` | stills, and GPUs with time to spare |
///
/// All of them insert [`LeanDeferred`]. Only the qualities and resolutions are set: other settings of the components stay, also
/// while a preset without the effect is applied. [`LeanAutoExposure`](crate::LeanAutoExposure) stays as it is, because it decides
/// how bright a game is, and its cost is small.
///
/// Light scatters only beneath surfaces with [`ShadingExtension::Subsurface`](crate::material_extension::ShadingExtension); elsewhere
/// this costs nothing. `docs/presets.md` has the GPU times of the presets as far as they are measured. [`LeanStatus`] tells which
/// effects the device runs, and [`LeanMemory`](crate::LeanMemory) the GPU memory that they hold.
///
/// `Display` writes `low`, `medium`, `high` or `ultra`, and `FromStr` reads these in upper or lower case. With the feature
/// `serialize`, serde stores the names of the variants. The example `settings_menu` has a button for each.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn_camera(mut commands: Commands) {
///     LeanPreset::High.apply(&mut commands.spawn(Camera3d::default()));
/// }
///
/// /// Applies the preset that a player has chosen.
/// fn choose(
///     In(preset): In<LeanPreset>,
///     camera: Single<Entity, With<Camera3d>>,
///     mut commands: Commands,
/// ) {
///     preset.apply(&mut commands.entity(*camera));
/// }
/// ```
///
/// [`LeanStatus`]: crate::LeanStatus
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[reflect(Default, Clone, PartialEq)]
#[cfg_attr(
    feature = "serialize",
    derive(serde::Serialize, serde::Deserialize),
    reflect(Serialize, Deserialize)
)]
pub enum LeanPreset {
    /// Ambient occlusion at half resolution.
    Low,
    /// Ambient occlusion, and light that scatters.
    #[default]
    Medium,
    /// Diffuse GI, reflections, and light that scatters.
    High,
    /// As [`High`](Self::High), with smaller errors, for more time.
    Ultra,
}

/// The levels of each effect; `None` without the effect.
struct Levels {
    occlusion: Option<(LeanQuality, LeanResolution)>,
    gi: Option<(LeanQuality, LeanResolution)>,
    reflections: Option<(LeanQuality, LeanResolution)>,
    scattering: Option<LeanQuality>,
}

impl LeanPreset {
    /// All presets, cheapest first.
    pub const ALL: [Self; 4] = [Self::Low, Self::Medium, Self::High, Self::Ultra];

    /// Applies the preset to `camera`.
    pub fn apply(self, camera: &mut EntityCommands) {
        camera.queue_handled(
            move |mut camera: EntityWorldMut| self.apply_to(&mut camera),
            warn,
        );
    }

    /// Applies the preset to `camera` at once.
    pub fn apply_to(self, camera: &mut EntityWorldMut) {
        camera.insert_if_new(LeanDeferred::default());
        let Levels {
            occlusion,
            gi,
            reflections,
            scattering,
        } = self.levels();
        set(
            camera,
            occlusion,
            |effect: &mut LeanScreenSpaceAmbientOcclusion, levels| {
                (effect.quality, effect.resolution) = levels;
            },
        );
        set(camera, gi, |effect: &mut LeanScreenSpaceGi, levels| {
            (effect.quality, effect.resolution) = levels;
        });
        set(
            camera,
            reflections,
            |effect: &mut LeanScreenSpaceReflections, levels| {
                (effect.quality, effect.resolution) = levels;
            },
        );
        set(
            camera,
            scattering,
            |effect: &mut LeanSubsurfaceScattering, quality| effect.quality = quality,
        );
    }

    fn levels(self) -> Levels {
        use LeanQuality::{High, Low, Medium};
        use LeanResolution::{Full, Half};
        match self {
            // Half the resolution takes less time than half the samples, and has smaller errors.
            Self::Low => Levels {
                occlusion: Some((Medium, Half)),
                gi: None,
                reflections: None,
                scattering: None,
            },
            Self::Medium => Levels {
                occlusion: Some((Medium, Full)),
                gi: None,
                reflections: None,
                scattering: Some(Low),
            },
            // GI finds the occlusion of ambient light too.
            Self::High => Levels {
                occlusion: None,
                gi: Some((Medium, Half)),
                reflections: Some((Medium, Half)),
                scattering: Some(High),
            },
            Self::Ultra => Levels {
                occlusion: None,
                gi: Some((High, Half)),
                reflections: Some((High, Full)),
                scattering: Some(High),
            },
        }
    }
}

/// Settings of an effect that a preset has removed, for the next preset that has the effect.
#[derive(Component)]
struct Removed<E>(E);

/// Sets the levels of an effect, or removes it if there are none.
fn set<E: Component<Mutability = Mutable> + Default, L>(
    camera: &mut EntityWorldMut,
    levels: Option<L>,
    set_levels: impl FnOnce(&mut E, L),
) {
    let Some(levels) = levels else {
        if let Some(effect) = camera.take::<E>() {
            camera.insert(Removed(effect));
        }
        return;
    };
    let removed = camera.take::<Removed<E>>();
    if let Some(mut effect) = camera.get_mut::<E>() {
        set_levels(&mut effect, levels);
        return;
    }
    let mut effect = removed.map_or_else(E::default, |Removed(effect)| effect);
    set_levels(&mut effect, levels);
    camera.insert(effect);
}

impl fmt::Display for LeanPreset {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
            Self::Ultra => "ultra",
        })
    }
}

impl FromStr for LeanPreset {
    type Err = ParseLevelError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        parse_level(&Self::ALL, text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for preset in LeanPreset::ALL {
            for text in [preset.to_string(), format!("{preset:?}").to_uppercase()] {
                assert_eq!(text.parse(), Ok(preset));
            }
        }
    }

    #[test]
    fn presets_insert_and_remove_effects() {
        let mut world = World::new();
        let mut camera = world.spawn_empty();
        for preset in LeanPreset::ALL.into_iter().chain([LeanPreset::Low]) {
            preset.apply_to(&mut camera);
            let has_gi = preset >= LeanPreset::High;
            assert!(camera.contains::<LeanDeferred>());
            assert_eq!(
                camera.contains::<LeanScreenSpaceAmbientOcclusion>(),
                !has_gi
            );
            assert_eq!(camera.contains::<LeanScreenSpaceGi>(), has_gi);
            assert_eq!(camera.contains::<LeanScreenSpaceReflections>(), has_gi);
            let scatters = preset >= LeanPreset::Medium;
            assert_eq!(camera.contains::<LeanSubsurfaceScattering>(), scatters);
        }
    }

    /// Those of effects that a preset removes for a time, too.
    #[test]
    fn other_settings_stay() {
        let mut world = World::new();
        let lean = LeanDeferred {
            enabled: false,
            ..default()
        };
        let gi = LeanScreenSpaceGi {
            radius: 7.0,
            ..default()
        };
        let mut camera = world.spawn((lean, gi));
        let presets = [LeanPreset::Ultra, LeanPreset::Low, LeanPreset::High];
        for preset in presets {
            preset.apply_to(&mut camera);
        }
        assert_eq!(camera.get(), Some(&lean));
        // Those of `High` are the defaults.
        assert_eq!(camera.get(), Some(&gi));

        // The app's own settings come before those that were kept.
        LeanPreset::Low.apply_to(&mut camera);
        let gi = LeanScreenSpaceGi {
            radius: 2.0,
            ..default()
        };
        camera.insert(gi);
        LeanPreset::High.apply_to(&mut camera);
        assert_eq!(camera.get(), Some(&gi));
    }

    #[test]
    fn no_preset_has_lower_levels_than_a_cheaper_one() {
        let levels = LeanPreset::ALL.map(LeanPreset::levels);
        for pair in levels.windows(2) {
            let (cheap, dear) = (&pair[0], &pair[1]);
            assert!(cheap.gi <= dear.gi);
            assert!(cheap.reflections <= dear.reflections);
            assert!(cheap.scattering <= dear.scattering);
            assert!(dear.gi.is_some() || cheap.occlusion <= dear.occlusion);
        }
    }
}
