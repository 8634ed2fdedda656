//! Lightmaps of a level.

use std::{collections::HashMap, path::Path};

use bevy::{
    gltf::{GltfMaterialExtras, GltfMeshExtras},
    image::ImageLoaderSettings,
    pbr::Lightmap,
    prelude::*,
};
use serde::Deserialize;

use super::loading::wait_for;
use crate::headless::Headless;

/// The `extras` of a mesh or a material in the glTF file.
#[derive(Deserialize)]
struct Extras {
    /// Name of a file in the folder of lightmaps.
    lightmap: String,
}

fn lightmap_file(extras: &str) -> Option<String> {
    let extras: Extras = serde_json::from_str(extras).ok()?;
    Some(extras.lightmap)
}

/// Adds the lightmaps in `folder` to the meshes that name them, or whose materials do. Returns the number of these meshes.
pub(super) fn add_lightmaps(
    headless: &mut Headless,
    folder: &Path,
    exposure: Option<f32>,
) -> Result<usize, String> {
    let world = headless.world();
    let mut meshes = world.query::<(
        Entity,
        &MeshMaterial3d<StandardMaterial>,
        Option<&GltfMaterialExtras>,
        Option<&GltfMeshExtras>,
    )>();
    let named: Vec<_> = meshes
        .iter(world)
        .filter_map(|(mesh, material, of_material, of_mesh)| {
            let of_mesh = of_mesh.and_then(|extras| lightmap_file(&extras.value));
            let file = of_mesh.or_else(|| lightmap_file(&of_material?.value))?;
            Some((mesh, material.id(), file))
        })
        .collect();
    let mut images = HashMap::<String, Handle<Image>>::new();
    for (mesh, material, file) in &named {
        let image = images.entry(file.clone()).or_insert_with(|| {
            let assets = world.resource::<AssetServer>().load_builder();
            assets
                .with_settings(|settings: &mut ImageLoaderSettings| settings.is_srgb = false)
                .load(folder.join(file))
        });
        let lightmap = Lightmap {
            image: image.clone(),
            ..default()
        };
        world.entity_mut(*mesh).insert(lightmap);
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        if let (Some(exposure), Some(mut material)) = (exposure, materials.get_mut(*material)) {
            material.lightmap_exposure = exposure;
        }
    }
    for (file, image) in &images {
        wait_for(headless, image, &folder.join(file))?;
    }
    Ok(named.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extras_name_a_file_or_none() {
        assert_eq!(
            lightmap_file(r#"{ "lightmap": "a.png", "other": 1 }"#).as_deref(),
            Some("a.png")
        );
        assert_eq!(lightmap_file(r#"{ "other": 1 }"#), None);
        assert_eq!(lightmap_file("7"), None);
    }
}
