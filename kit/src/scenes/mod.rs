//! Scenes built in code, small enough for a software renderer.

pub mod boxes;
pub mod build;
mod forward_materials;
mod lights;
pub mod materials;
pub mod meshes;
pub mod special_materials;
mod views;

pub use build::SceneBuilder;

/// A scene and how exactly it must match Bevy's forward renderer.
pub struct Scene {
    pub name: &'static str,
    /// Least PSNR in dB. Below [`LEAST_PSNR`] only with a reason.
    pub least_psnr: f64,
    /// Why it may be below.
    pub reason: &'static str,
    /// What it is about is seen on devices with binding arrays only.
    pub needs_binding_arrays: bool,
    pub build: fn(&mut SceneBuilder),
}

/// What a scene must reach unless it says why not.
pub const LEAST_PSNR: f64 = 45.0;

impl Scene {
    const fn new(name: &'static str, build: fn(&mut SceneBuilder)) -> Self {
        Self {
            name,
            least_psnr: LEAST_PSNR,
            reason: "",
            needs_binding_arrays: false,
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
}

/// All of them, by what they are about.
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
