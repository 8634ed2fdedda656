//! Constants for binding numbers, and layouts built from them.

use bevy::render::render_resource::{
    BindGroupLayoutDescriptor, BindGroupLayoutEntryBuilder, ShaderStages,
};

/// Defines a constant per binding, named like the shader's variable, and a table of them with which
/// `tests/shaders/twins.rs` compares both.
macro_rules! binding_numbers {
    ($($name:ident = $number:literal,)*) => {
        $(
            #[doc = concat!("`@binding(", $number, ")`")]
            pub const $name: u32 = $number;
        )*
        /// All bindings by name.
        pub const ALL: &[(&str, u32)] = &[$((stringify!($name), $number)),*];
    };
}

pub(crate) use binding_numbers;

/// Builds a layout of `entries`, each with its number, all visible to `stages`.
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
