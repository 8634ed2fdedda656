//! Names for the bindings of bind groups, and layouts made of them.

use bevy::render::render_resource::{
    BindGroupLayoutDescriptor, BindGroupLayoutEntryBuilder, ShaderStages,
};

/// Defines a constant for each binding, named as the variable of the shaders, and a table of them, by which
/// `tests/shaders/twins.rs` compares both.
macro_rules! binding_numbers {
    ($($name:ident = $number:literal,)*) => {
        $(
            #[doc = concat!("`@binding(", $number, ")`")]
            pub const $name: u32 = $number;
        )*
        /// All of them.
        pub const ALL: &[(&str, u32)] = &[$((stringify!($name), $number)),*];
    };
}

pub(crate) use binding_numbers;

/// A layout of `entries`, each with its number, all for `stages`.
pub(crate) fn layout(
    label: &'static str,
    stages: ShaderStages,
    entries: impl IntoIterator<Item = (u32, BindGroupLayoutEntryBuilder)>,
) -> BindGroupLayoutDescriptor {
    let entries: Vec<_> = entries
        .into_iter()
        .map(|(binding, entry)| entry.build(binding, stages))
        .collect();
    BindGroupLayoutDescriptor::new(label, &entries)
}
