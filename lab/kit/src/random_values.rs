//! Random values for the fields of any settings, including hostile ones, and random toggling of components.

use core::ops::RangeInclusive;

use bevy::{
    prelude::*,
    reflect::{
        PartialReflect, ReflectMut, TypeInfo,
        enums::{DynamicEnum, DynamicVariant, Enum, VariantInfo},
        list::List,
        structs::DynamicStruct,
        tuple::DynamicTuple,
    },
};
use bevy_lean_deferred::prelude::*;

use crate::random::Random;

const HOSTILE: [f32; 9] = [
    0.0,
    -0.0,
    -1.0,
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    1e-38,
    65504.0,
];

const HOSTILE_COUNTS: [u32; 4] = [0, 1, 1000, u32::MAX];

/// Constraints on random values.
#[derive(Clone, Copy)]
pub struct Values<'a> {
    /// One number in so many is hostile; 0 for none.
    pub hostile: usize,
    pub images: &'a [Handle<Image>],
    /// Names of fields that keep their values.
    pub kept: &'a [&'a str],
}

impl Values<'_> {
    /// A number near `present`, or between 0 and 1, or a hostile one.
    fn number(&self, present: f32, random: &mut Random) -> f32 {
        if self.hostile > 0 && random.below(self.hostile) == 0 {
            HOSTILE[random.below(HOSTILE.len())]
        } else if random.below(2) == 0 {
            random.unit()
        } else {
            present * random.range(-2.0, 2.0).exp()
        }
    }

    fn count(&self, random: &mut Random) -> u32 {
        if self.hostile > 0 && random.below(self.hostile) == 0 {
            HOSTILE_COUNTS[random.below(HOSTILE_COUNTS.len())]
        } else {
            1 + random.below(8) as u32
        }
    }

    fn image(&self, random: &mut Random) -> Option<Handle<Image>> {
        (!self.images.is_empty()).then(|| self.images[random.below(self.images.len())].clone())
    }

    /// Changes one of this crate's components, chosen at random. Returns its new state; none if the camera lacks that component.
    pub fn change_lean(&self, camera: &mut EntityWorldMut, random: &mut Random) -> Option<String> {
        macro_rules! change {
            ($settings:ty) => {{
                let mut settings = camera.get_mut::<$settings>()?;
                self.change(&mut *settings, random);
                format!("{:?}", *settings)
            }};
        }
        Some(match random.below(6) {
            0 => change!(LeanDeferred),
            1 => change!(LeanScreenSpaceAmbientOcclusion),
            2 => change!(LeanAutoExposure),
            3 => change!(LeanScreenSpaceGi),
            4 => change!(LeanScreenSpaceReflections),
            _ => change!(LeanSubsurfaceScattering),
        })
    }

    /// Changes one or two fields of a struct of settings, or of its struct of advanced ones.
    pub fn change(&self, settings: &mut dyn PartialReflect, random: &mut Random) {
        let ReflectMut::Struct(fields) = settings.reflect_mut() else {
            return self.set(settings, random);
        };
        for _ in 0..=random.below(2) {
            let index = random.below(fields.field_len());
            let name = fields.name_at(index);
            let is_kept = name.is_none_or(|name| self.kept.contains(&name));
            let has_settings = name == Some("advanced");
            match fields.field_at_mut(index) {
                Some(field) if has_settings => self.change(field, random),
                Some(field) if !is_kept => self.set(field, random),
                _ => {}
            }
        }
    }

    /// Changes a value in all of its fields. Values of unsupported types stay unchanged.
    fn set(&self, value: &mut dyn PartialReflect, random: &mut Random) {
        if let Some(number) = value.try_downcast_mut::<f32>() {
            *number = self.number(*number, random);
        } else if let Some(flag) = value.try_downcast_mut::<bool>() {
            *flag = random.below(2) == 0;
        } else if let Some(range) = value.try_downcast_mut::<RangeInclusive<f32>>() {
            let [start, end] = [*range.start(), *range.end()].map(|at| self.number(at, random));
            *range = start..=end;
        } else if let Some(image) = value.try_downcast_mut::<Option<Handle<Image>>>() {
            *image = self.image(random).filter(|_| random.below(2) == 0);
        } else if let Some(image) = value.try_downcast_mut::<Handle<Image>>() {
            if let Some(other) = self.image(random) {
                *image = other;
            }
        } else if let Some(count) = value.try_downcast_mut::<u32>() {
            *count = self.count(random);
        } else if let Some(color) = value.try_downcast_mut::<Color>() {
            let [red, green, blue, alpha] = [0; 4].map(|_| self.number(1.0, random));
            *color = Color::linear_rgba(red, green, blue, alpha);
        } else {
            match value.reflect_mut() {
                ReflectMut::Struct(fields) => {
                    for index in 0..fields.field_len() {
                        if let Some(field) = fields.field_at_mut(index) {
                            self.set(field, random);
                        }
                    }
                }
                ReflectMut::Enum(choice) => self.choose(choice, random),
                ReflectMut::List(list) => self.fill(list, random),
                _ => {}
            }
        }
    }

    /// Chooses one of the variants, or changes the fields of the present one if that variant has fields of unsupported types.
    fn choose(&self, choice: &mut dyn Enum, random: &mut Random) {
        let info = choice.get_represented_enum_info();
        let index = random.below(info.map_or(1, |info| info.variant_len()));
        let variant = info.and_then(|info| info.variant_at(index));
        if let Some(other) = variant.and_then(|variant| self.variant(variant, random)) {
            choice.apply(&other);
            return;
        }
        for index in 0..choice.field_len() {
            if let Some(field) = choice.field_at_mut(index) {
                self.set(field, random);
            }
        }
    }

    /// Replaces a list's items by up to four others.
    fn fill(&self, list: &mut dyn List, random: &mut Random) {
        let info = list.get_represented_list_info();
        let Some(item) = info.and_then(|info| info.item_info()) else {
            return;
        };
        _ = list.drain();
        for _ in 0..random.below(5) {
            if let Some(value) = self.made(item, random) {
                list.push(value);
            }
        }
    }

    fn variant(&self, info: &VariantInfo, random: &mut Random) -> Option<DynamicEnum> {
        let fields = match info {
            VariantInfo::Unit(_) => DynamicVariant::Unit,
            VariantInfo::Tuple(info) => {
                let mut fields = DynamicTuple::default();
                for field in info.iter() {
                    fields.insert_boxed(self.made(field.type_info()?, random)?);
                }
                DynamicVariant::Tuple(fields)
            }
            VariantInfo::Struct(info) => {
                let mut fields = DynamicStruct::default();
                for field in info.iter() {
                    fields.insert_boxed(field.name(), self.made(field.type_info()?, random)?);
                }
                DynamicVariant::Struct(fields)
            }
        };
        Some(DynamicEnum::new(info.name(), fields))
    }

    /// Makes a value of a type; none if it has fields of unsupported types.
    fn made(&self, info: &TypeInfo, random: &mut Random) -> Option<Box<dyn PartialReflect>> {
        if info.is::<f32>() {
            return Some(Box::new(self.number(1.0, random)));
        } else if info.is::<u32>() {
            return Some(Box::new(self.count(random)));
        } else if info.is::<bool>() {
            return Some(Box::new(random.below(2) == 0));
        } else if info.is::<Handle<Image>>() {
            return Some(Box::new(self.image(random)?));
        }
        match info {
            TypeInfo::Struct(info) => {
                let mut made = DynamicStruct::default();
                for field in info.iter() {
                    made.insert_boxed(field.name(), self.made(field.type_info()?, random)?);
                }
                Some(Box::new(made))
            }
            TypeInfo::Enum(info) => {
                let variant = info.variant_at(random.below(info.variant_len()))?;
                Some(Box::new(self.variant(variant, random)?))
            }
            _ => None,
        }
    }
}

/// Removes a component, or inserts its default.
pub fn toggle<C: Component + Default>(entity: &mut EntityWorldMut) -> String {
    toggle_between(entity, C::default())
}

/// Removes a component, or inserts this one.
pub fn toggle_between<C: Component>(entity: &mut EntityWorldMut, component: C) -> String {
    let had = entity.contains::<C>();
    if had {
        entity.remove::<C>();
    } else {
        entity.insert(component);
    }
    format!("{}: {}", core::any::type_name::<C>(), !had)
}
