//! `--set Component.field=value`: settings of the camera on the command line.

use bevy::{
    prelude::*,
    reflect::{TypeRegistration, TypeRegistry},
};

use super::{fields, panel::cameras};

/// Applies settings in their order. An error ends the app.
pub fn apply_all(world: &mut World, settings: &[String]) {
    for setting in settings {
        if let Err(error) = apply(world, setting) {
            eprintln!("error: --set {setting}: {error}");
            world.write_message(AppExit::error());
        }
    }
}

/// Applies a setting. The error tells what was expected.
pub fn apply(world: &mut World, setting: &str) -> Result<(), String> {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let name = setting.split(['.', '=']).next().unwrap_or_default();
    let component = registry.get_with_short_type_path(name);
    let component = component.ok_or_else(|| format!("there is no component {name}"))?;
    let mut all = cameras(world).into_iter();
    all.try_for_each(|camera| {
        apply_to(&mut world.entity_mut(camera), component, setting, &registry)
    })
}

fn apply_to(
    camera: &mut EntityWorldMut,
    registration: &TypeRegistration,
    setting: &str,
    registry: &TypeRegistry,
) -> Result<(), String> {
    let (path, text) = (setting.split_once('='))
        .ok_or("expected Component.field=value, Component=on or Component=off")?;
    let path = path.split_once('.').map_or("", |(_, path)| path);
    let component = registration.data::<ReflectComponent>();
    let component = component.ok_or("this is no component")?;
    if path.is_empty() && text == "off" {
        component.remove(camera);
        return Ok(());
    }
    if !component.contains(&*camera) {
        let default = registration.data::<ReflectDefault>();
        let default = default.ok_or("this component has no defaults")?.default();
        component.insert(camera, default.as_partial_reflect(), registry);
    }
    if path.is_empty() && text == "on" {
        return Ok(());
    }
    let mut value = component.reflect_mut(camera).ok_or("it was not inserted")?;
    let names = fields::list(value.as_partial_reflect()).into_iter();
    let names: Vec<String> = names.map(|(name, _)| name).collect();
    let field = value.reflect_path_mut(path);
    let field = field.map_err(|_| format!("expected one of {}", names.join(", ")))?;
    fields::set(field, text, registry)
}
