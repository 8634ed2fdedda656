//! Scenes built in code, small enough for a software renderer.

pub mod boxes;
pub mod build;
pub mod forward_materials;
mod lights;
pub mod materials;
pub mod meshes;
pub mod special_materials;
mod views;

pub use build::SceneBuilder;

/// A scene and its tolerance against Bevy's forward renderer.
pub struct Scene {
    pub name: &'static str,
    /// Least PSNR in dB. Below [`LEAST_PSNR`] only with a `reason`.
    pub least_psnr: f64,
    /// Reason for a `least_psnr` below [`LEAST_PSNR`].
    pub reason: &'static str,
    /// True if only devices with binding arrays show the scene's subject.
    pub needs_binding_arrays: bool,
    /// True if the scene combines or repeats what other scenes and tests show, and is left to nightly tests.
    pub is_nightly: bool,
    pub build: fn(&mut SceneBuilder),
}

/// Least PSNR in dB, unless a scene gives a reason.
pub const LEAST_PSNR: f64 = 45.0;

impl Scene {
    const fn new(name: &'static str, build: fn(&mut SceneBuilder)) -> Self {
        Self {
            name,
            least_psnr: LEAST_PSNR,
            reason: "",
            needs_binding_arrays: false,
            is_nightly: false,
            build,
        }
    }

    const fn allow(mut self, least_psnr: f64, reason: &'static str) -> Self {
        self.least_psnr = least_psnr;
        self.reason = reason;
        self
    }

    const fn needs_binding_arrays(mut self) -> Self {
        self.needs_binding_arrays = true;
        self
    }

    const fn nightly(mut self) -> Self {
        self.is_nightly = true;
        self
    }
}

/// Those of `scenes` that every test run shows.
pub fn daily(scenes: &'static [Scene]) -> impl Iterator<Item = &'static Scene> + Clone {
    scenes.iter().filter(|scene| !scene.is_nightly)
}

/// Those of `scenes` that only nightly tests show.
pub fn nightly(scenes: &'static [Scene]) -> impl Iterator<Item = &'static Scene> + Clone {
    scenes.iter().filter(|scene| scene.is_nightly)
}

/// All scenes, by subject.
pub const ALL: [&[Scene]; 6] = [
    LIGHTS,
    MATERIALS,
    FORWARD_MATERIALS,
    SPECIAL_MATERIALS,
    MESHES,
    VIEWS,
];
pub const LIGHTS: &[Scene] = lights::SCENES;
pub const MATERIALS: &[Scene] = materials::SCENES;
pub const FORWARD_MATERIALS: &[Scene] = forward_materials::SCENES;
pub const SPECIAL_MATERIALS: &[Scene] = special_materials::SCENES;
pub const MESHES: &[Scene] = meshes::SCENES;
pub const VIEWS: &[Scene] = views::SCENES;
