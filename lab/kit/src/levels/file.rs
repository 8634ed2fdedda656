//! The files of a level: its glTF file, and `level.json` beside it.

use std::path::{Path, PathBuf};

use bevy::{camera::Exposure, prelude::*};
use figures::json::read_json;
use serde::{Deserialize, de::IgnoredAny};

use crate::example::model::check_file;

/// Metres per frame: 3 m/s.
const STEP: f32 = 0.05;
/// Radians per frame: 60 degrees per second.
const TURN: f32 = core::f32::consts::PI / 180.0;

/// A camera at `position` that looks at `target`, in metres.
#[derive(Deserialize, Clone, Copy, Debug, PartialEq)]
pub struct View {
    pub position: [f32; 3],
    pub target: [f32; 3],
}

impl View {
    pub fn transform(&self) -> Transform {
        Transform::from_translation(self.position.into()).looking_at(self.target.into(), Vec3::Y)
    }

    /// The camera after `frames` of a walk that turns to the left, at 60 frames per second.
    pub fn walked(&self, frames: usize) -> Transform {
        let mut camera = self.transform();
        for _ in 0..frames {
            let step = camera.forward() * STEP;
            camera.translation += step;
            camera.rotate_y(TURN);
        }
        camera
    }

    pub(super) fn of(transform: &Transform) -> Self {
        let position = transform.translation;
        Self {
            position: position.to_array(),
            target: (position + *transform.forward()).to_array(),
        }
    }
}

/// Reads a JSON list of views.
pub fn read_views(path: &Path) -> Result<Vec<View>, String> {
    read_json(path)
}

/// Indices of `count` of `views`, evenly spread; of all if there are fewer.
pub fn evenly_spread(views: usize, count: usize) -> Vec<usize> {
    let count = count.min(views);
    (0..count).map(|index| index * views / count).collect()
}

/// Directional light from far away, with a shadow map.
#[derive(Deserialize, Clone, Copy, Debug)]
pub(super) struct Sun {
    /// Linear.
    pub color: [f32; 3],
    /// Direction of any length.
    pub to_sun: [f32; 3],
    /// Illuminance of a surface that faces the sun.
    pub lux: f32,
}

/// The content of `level.json`. All of it is optional.
#[derive(Deserialize, Default, Debug)]
#[serde(default)]
pub(super) struct LevelFile {
    pub name: Option<String>,
    /// [`Exposure::ev100`] of the camera.
    pub ev100: Option<f32>,
    /// [`StandardMaterial::lightmap_exposure`] of the lightmapped materials.
    pub lightmap_exposure: Option<f32>,
    pub suns: Vec<Sun>,
    /// Ambient light in cd/m², linear.
    pub ambient: Option<[f32; 3]>,
    /// Colour behind all meshes, linear, as the camera shows it.
    pub sky: Option<[f32; 3]>,
    pub views: Vec<View>,
    /// Licence of pictures of the level.
    pub licence: Option<IgnoredAny>,
}

/// A level on disk.
#[derive(Debug)]
pub struct Level {
    pub name: String,
    /// The glTF file, as an absolute path.
    pub(super) path: PathBuf,
    pub(super) file: LevelFile,
    /// False for a glTF file alone.
    pub(super) has_file: bool,
}

impl Level {
    /// Reads `level.json` beside a .gltf or .glb file, if it exists. The name of the level is in there; otherwise it is that of the glTF
    /// file.
    pub fn open(path: &str) -> Result<Self, String> {
        check_file(path)?;
        let path = std::path::absolute(path).map_err(|error| format!("{path}: {error}"))?;
        let beside = path.with_file_name("level.json");
        let has_file = beside.exists();
        let file = match has_file {
            true => read_json(&beside)?,
            false => LevelFile::default(),
        };
        let stem = path.file_stem().unwrap_or_default();
        Ok(Self {
            name: (file.name.clone()).unwrap_or_else(|| stem.to_string_lossy().into_owned()),
            path,
            file,
            has_file,
        })
    }

    /// Exposure of the camera; Bevy's default without one in `level.json`.
    pub fn exposure(&self) -> Exposure {
        let ev100 = self.file.ev100;
        ev100.map_or(Exposure::default(), |ev100| Exposure { ev100 })
    }

    /// The file with the credits that pictures of the level need.
    pub fn credits(&self) -> Option<PathBuf> {
        (self.file.licence.is_some()).then(|| self.path.with_file_name("level.json"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_spread_over_the_whole_list() {
        assert_eq!(evenly_spread(10, 3), [0, 3, 6]);
        assert_eq!(evenly_spread(2, 5), [0, 1]);
        assert_eq!(evenly_spread(0, 3), [0; 0]);
        assert_eq!(evenly_spread(4, 0), [0; 0]);
    }

    #[test]
    fn a_walk_turns_left() {
        let view = View {
            position: [0.0; 3],
            target: [0.0, 0.0, -1.0],
        };
        let camera = view.walked(90);
        assert!(camera.forward().abs_diff_eq(Vec3::NEG_X, 1e-4));
        // A quarter of a circle of radius STEP / TURN.
        let radius = STEP / TURN;
        let corner = Vec3::new(-radius, 0.0, -radius);
        assert!(camera.translation.abs_diff_eq(corner, 0.1));
    }

    #[test]
    fn a_view_looks_at_its_target() {
        let json = r#"{ "position": [1, 2, 3], "target": [1, 2, -5] }"#;
        let view: View = serde_json::from_str(json).unwrap();
        let transform = view.transform();
        assert_eq!(transform.translation, Vec3::new(1.0, 2.0, 3.0));
        assert!(transform.forward().abs_diff_eq(Vec3::NEG_Z, 1e-6));
    }
}
