//! Random values for the fields of any settings, hostile ones too; components that come and go.

use bevy::{
    prelude::*,
    reflect::{
        PartialReflect, ReflectMut,
        enums::{DynamicEnum, DynamicVariant, VariantType},
    },
};

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

/// What values may be.
#[derive(Clone, Copy)]
pub struct Values<'a> {
    /// Of so many numbers one is hostile; 0: none.
    pub hostile: usize,
    pub images: &'a [Handle<Image>],
    /// Fields that keep what they have.
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

    /// Other values for one or two fields of what is a struct.
    pub fn change(&self, settings: &mut dyn PartialReflect, random: &mut Random) {
        let ReflectMut::Struct(fields) = settings.reflect_mut() else {
            return self.set(settings, random);
        };
        for _ in 0..=random.below(2) {
            let index = random.below(fields.field_len());
            let is_kept = fields
                .name_at(index)
                .is_none_or(|name| self.kept.contains(&name));
            if let Some(field) = fields.field_at_mut(index)
                && !is_kept
            {
                self.set(field, random);
            }
        }
    }

    /// Another value, in all of its fields. What has none that this knows of stays as it is.
    fn set(&self, value: &mut dyn PartialReflect, random: &mut Random) {
        if let Some(number) = value.try_downcast_mut::<f32>() {
            *number = self.number(*number, random);
        } else if let Some(flag) = value.try_downcast_mut::<bool>() {
            *flag = random.below(2) == 0;
        } else if let Some(image) = value.try_downcast_mut::<Option<Handle<Image>>>() {
            *image = (random.below(2) == 0 && !self.images.is_empty())
                .then(|| self.images[random.below(self.images.len())].clone());
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
                _ => {}
            }
        }
    }

    /// One of the variants that have no fields, or the present one with other values.
    fn choose(&self, choice: &mut dyn bevy::reflect::enums::Enum, random: &mut Random) {
        let Some(info) = choice.get_represented_enum_info() else {
            return;
        };
        let Some(variant) = info.variant_at(random.below(info.variant_len())) else {
            return;
        };
        if variant.variant_type() == VariantType::Unit {
            choice.apply(&DynamicEnum::new(variant.name(), DynamicVariant::Unit));
        } else if variant.name() == choice.variant_name() {
            for index in 0..choice.field_len() {
                if let Some(field) = choice.field_at_mut(index) {
                    self.set(field, random);
                }
            }
        }
    }
}

/// Takes a component away, or puts its default in.
pub fn toggle<C: Component + Default>(entity: &mut EntityWorldMut) -> String {
    toggle_between(entity, C::default())
}

/// Takes a component away, or puts this one in.
pub fn toggle_between<C: Component>(entity: &mut EntityWorldMut, component: C) -> String {
    let had = entity.contains::<C>();
    if had {
        entity.remove::<C>();
    } else {
        entity.insert(component);
    }
    format!("{}: {}", core::any::type_name::<C>(), !had)
}
