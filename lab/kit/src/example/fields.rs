//! Fields of components by reflection: listed as text, changed by a step, set from text.

use core::{ops::RangeInclusive, str::FromStr};

use bevy::{
    prelude::*,
    reflect::{
        ReflectMut, ReflectRef, TypeInfo, TypeRegistry,
        enums::{DynamicEnum, DynamicVariant, VariantInfo},
        structs::DynamicStruct,
        tuple::DynamicTuple,
    },
};

/// First number of a new variant of an enum, and the step away from 0.
const FIRST: f32 = 0.1;
/// Numbers nearer to 0 become 0.
const LEAST: f32 = 0.01;
/// Factor of a step.
const FACTOR: f32 = 1.25;

/// Paths and values of all fields that can be changed, in order. Those of nested structs and of enums follow their owner.
pub fn list(value: &dyn PartialReflect) -> Vec<(String, String)> {
    let mut fields = Vec::new();
    collect(value, String::new(), &mut fields);
    fields
}

fn collect(value: &dyn PartialReflect, path: String, fields: &mut Vec<(String, String)>) {
    let inside = |name: &str| match path.as_str() {
        "" => name.to_owned(),
        path => format!("{path}.{name}"),
    };
    if let Some(text) = text(value) {
        fields.push((path.clone(), text));
    }
    match value.reflect_ref() {
        ReflectRef::Struct(value) => {
            for (name, field) in value.iter_fields() {
                collect(field, inside(name), fields);
            }
        }
        ReflectRef::Enum(value) => {
            for (index, field) in value.iter_fields().enumerate() {
                let name = field
                    .name()
                    .map_or_else(|| index.to_string(), str::to_owned);
                collect(field.value(), inside(&name), fields);
            }
        }
        _ => {}
    }
}

/// The value of a field that can be changed.
fn text(value: &dyn PartialReflect) -> Option<String> {
    if let Some(number) = value.try_downcast_ref::<f32>() {
        // Steps by a factor have more decimals than are of interest.
        return Some(((number * 1000.0).round() / 1000.0).to_string());
    }
    if let Some(count) = value.try_downcast_ref::<u32>() {
        return Some(count.to_string());
    }
    if let Some(is_on) = value.try_downcast_ref::<bool>() {
        return Some(if *is_on { "on" } else { "off" }.into());
    }
    if let Some(range) = value.try_downcast_ref::<RangeInclusive<f32>>() {
        return Some(format!("{}..{}", range.start(), range.end()));
    }
    // Handles are enums, too.
    let info = value.get_represented_type_info()?;
    match value.reflect_ref() {
        ReflectRef::Enum(value) if !info.type_path().starts_with("bevy_asset::") => {
            Some(kebab_case(value.variant_name()))
        }
        _ => None,
    }
}

/// `GeometricNormal` becomes `geometric-normal`.
pub fn kebab_case(name: &str) -> String {
    let mut text = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !text.is_empty() {
            text.push('-');
        }
        text.extend(letter.to_lowercase());
    }
    text
}

/// Changes a field: numbers by a factor, counts by 2, enums to the next variant or, unless `forward`, to the one before. Variants
/// without first values are skipped.
pub fn step(field: &mut dyn PartialReflect, forward: bool, registry: &TypeRegistry) {
    if let Some(number) = field.try_downcast_mut::<f32>() {
        *number = step_number(*number, forward);
        return;
    }
    if let Some(count) = field.try_downcast_mut::<u32>() {
        *count = match forward {
            true => count.saturating_mul(2).max(1),
            false => *count / 2,
        };
        return;
    }
    if let Some(is_on) = field.try_downcast_mut::<bool>() {
        *is_on = !*is_on;
        return;
    }
    let ReflectRef::Enum(value) = field.reflect_ref() else {
        return;
    };
    let Some(info) = value.get_represented_enum_info() else {
        return;
    };
    let (count, index) = (info.variant_len(), value.variant_index());
    for step in 1..count {
        let step = if forward { step } else { count - step };
        if let Some(variant) = info.variant_at((index + step) % count)
            && set_variant(field, variant, registry).is_ok()
        {
            return;
        }
    }
}

fn step_number(number: f32, up: bool) -> f32 {
    let changed = match (number, up) {
        (0.0, true) => FIRST,
        (0.0, false) => -FIRST,
        _ if (number > 0.0) == up => number * FACTOR,
        _ => number / FACTOR,
    };
    if changed.abs() < LEAST { 0.0 } else { changed }
}

/// Sets a field from text, as [`list`] writes it. The error tells what was expected.
pub fn set(
    field: &mut dyn PartialReflect,
    text: &str,
    registry: &TypeRegistry,
) -> Result<(), String> {
    if let Some(number) = field.try_downcast_mut::<f32>() {
        *number = parse(text)?;
        return Ok(());
    }
    if let Some(count) = field.try_downcast_mut::<u32>() {
        *count = parse(text)?;
        return Ok(());
    }
    if let Some(is_on) = field.try_downcast_mut::<bool>() {
        *is_on = match text {
            "on" => true,
            "off" => false,
            _ => return Err(format!("{text}: expected on or off")),
        };
        return Ok(());
    }
    if let Some(range) = field.try_downcast_mut::<RangeInclusive<f32>>() {
        let (low, high) = text.split_once("..").ok_or("expected LOW..HIGH")?;
        *range = parse(low)?..=parse(high)?;
        return Ok(());
    }
    let ReflectRef::Enum(value) = field.reflect_ref() else {
        return Err("this field cannot be set from text".into());
    };
    let info = value.get_represented_enum_info().ok_or("a dynamic enum")?;
    let variant_named = |name: &str| {
        let mut variants = info.iter();
        variants.find(|variant| kebab_case(variant.name()) == name.to_lowercase())
    };
    if let Some(variant) = variant_named(text) {
        return set_variant(field, variant, registry);
    }
    // The content of an option.
    if let Some(some) = info.variant("Some") {
        set_variant(field, some, registry)?;
        if let ReflectMut::Enum(value) = field.reflect_mut()
            && let Some(content) = value.field_at_mut(0)
        {
            return set(content, text, registry);
        }
    }
    let names: Vec<String> = info
        .iter()
        .map(|variant| kebab_case(variant.name()))
        .collect();
    Err(format!("{text}: expected one of {}", names.join(", ")))
}

fn parse<T: FromStr<Err: core::fmt::Display>>(text: &str) -> Result<T, String> {
    text.parse::<T>()
        .map_err(|error| format!("{text}: {error}"))
}

/// Sets an enum to a variant, whose fields get first values. An error if one of them has no first value.
fn set_variant(
    field: &mut dyn PartialReflect,
    variant: &VariantInfo,
    registry: &TypeRegistry,
) -> Result<(), String> {
    let fields = match variant {
        VariantInfo::Unit(_) => Some(DynamicVariant::Unit),
        VariantInfo::Tuple(info) => {
            let values = info.iter().map(|field| first(field.type_info()?, registry));
            let values: Option<DynamicTuple> = values.collect();
            values.map(DynamicVariant::Tuple)
        }
        VariantInfo::Struct(info) => {
            let fields = info.iter().map(|field| (field.name(), field.type_info()));
            first_struct(fields, registry).map(DynamicVariant::Struct)
        }
    };
    let name = variant.name();
    let fields = fields.ok_or_else(|| format!("{name} has a field without a default"))?;
    field
        .try_apply(&DynamicEnum::new(name, fields))
        .map_err(|error| error.to_string())
}

/// The first value of a field of a new variant.
fn first(info: &'static TypeInfo, registry: &TypeRegistry) -> Option<Box<dyn PartialReflect>> {
    if info.is::<f32>() {
        return Some(Box::new(FIRST));
    }
    if info.is::<u32>() {
        return Some(Box::new(1_u32));
    }
    if let Some(default) = registry.get_type_data::<ReflectDefault>(info.type_id()) {
        return Some(default.default().into_partial_reflect());
    }
    let fields = info.as_struct().ok()?.iter();
    let fields = fields.map(|field| (field.name(), field.type_info()));
    Some(Box::new(first_struct(fields, registry)?))
}

fn first_struct(
    fields: impl Iterator<Item = (&'static str, Option<&'static TypeInfo>)>,
    registry: &TypeRegistry,
) -> Option<DynamicStruct> {
    let mut values = DynamicStruct::default();
    for (name, info) in fields {
        values.insert_boxed(name, first(info?, registry)?);
    }
    Some(values)
}
