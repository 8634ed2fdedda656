//! Shader definitions by tables of conditions, and their names.

use bevy::shader::ShaderDefVal;

/// The definitions of a table whose conditions hold.
pub(crate) fn of_table(
    table: impl IntoIterator<Item = (bool, &'static str)>,
) -> impl Iterator<Item = ShaderDefVal> {
    let set = table.into_iter().filter(|(condition, _)| *condition);
    set.map(|(_, name)| name.into())
}

/// The name of a definition.
pub fn name_of(definition: &ShaderDefVal) -> &str {
    match definition {
        ShaderDefVal::Bool(name, _) | ShaderDefVal::Int(name, _) | ShaderDefVal::UInt(name, _) => {
            name
        }
    }
}
