//! Macros that define structs of system parameters and of query items, in place of Bevy's derive macros, which compile slowly.
//!
//! The derives emit bounds on resources, components and lifetimes. If those types contain types of `wgpu`, the compiler walks over
//! them to prove the bounds, which takes seconds for each derived struct.

/// Defines a struct, with the lifetimes `'w` or `'w` and `'s`, as a system parameter. It is not a `ReadOnlySystemParam`.
macro_rules! system_param {
    // Nested pairs, since tuples of parameters have at most 16 fields.
    (@nested $first:tt $($rest:tt)*) => { ($first, system_param!(@nested $($rest)*)) };
    (@nested) => { () };

    (
        $(#[$attribute:meta])*
        $vis:vis struct $name:ident<'w $(, $state:lifetime)? $(, const $constant:ident: $of:ty)?> {
            $($(#[$field_attribute:meta])* $field_vis:vis $field:ident: $type:ty,)*
        }
    ) => {
        $(#[$attribute])*
        $vis struct $name<'w $(, $state)? $(, const $constant: $of)?> {
            $($(#[$field_attribute])* $field_vis $field: $type,)*
        }

        const _: () = {
            use bevy::ecs::{
                change_detection::Tick,
                query::FilteredAccessSet,
                system::{SystemMeta, SystemParam, SystemParamValidationError},
                world::{DeferredWorld, World, unsafe_world_cell::UnsafeWorldCell},
            };

            type Fields<'w, 's $(, const $constant: $of)?> = system_param!(@nested $($type)*);

            type Named<'w, 's $(, const $constant: $of)?> = $name<'w $(, $state)? $(, $constant)?>;

            $vis struct State<$(const $constant: $of)?>(
                <Fields<'static, 'static $(, $constant)?> as SystemParam>::State,
            );

            // SAFETY: every call is forwarded to the tuple of the fields.
            unsafe impl<$(const $constant: $of)?> SystemParam for Named<'_, '_ $(, $constant)?> {
                type State = State<$($constant)?>;
                type Item<'w, 's> = Named<'w, 's $(, $constant)?>;

                fn init_state(world: &mut World) -> Self::State {
                    State(<Fields<$($constant)?> as SystemParam>::init_state(world))
                }

                fn init_access(
                    state: &Self::State,
                    meta: &mut SystemMeta,
                    accesses: &mut FilteredAccessSet,
                    world: &mut World,
                ) {
                    <Fields<$($constant)?> as SystemParam>::init_access(
                        &state.0, meta, accesses, world,
                    );
                }

                fn apply(state: &mut Self::State, meta: &SystemMeta, world: &mut World) {
                    <Fields<$($constant)?> as SystemParam>::apply(&mut state.0, meta, world);
                }

                fn queue(state: &mut Self::State, meta: &SystemMeta, world: DeferredWorld) {
                    <Fields<$($constant)?> as SystemParam>::queue(&mut state.0, meta, world);
                }

                #[inline]
                unsafe fn get_param<'w, 's>(
                    state: &'s mut Self::State,
                    meta: &SystemMeta,
                    world: UnsafeWorldCell<'w>,
                    tick: Tick,
                ) -> Result<Self::Item<'w, 's>, SystemParamValidationError> {
                    // SAFETY: the caller upholds the requirements of the tuple.
                    let system_param!(@nested $($field)*) = unsafe {
                        <Fields<$($constant)?> as SystemParam>::get_param(
                            &mut state.0, meta, world, tick,
                        )
                    }?;
                    Ok($name { $($field,)* })
                }
            }
        };
    };
}

/// Defines a struct of query items, and `$query`, the tuple to query for them.
macro_rules! query_item {
    (@nested $first:tt $($rest:tt)*) => { ($first, query_item!(@nested $($rest)*)) };
    (@nested) => { () };

    (
        $(#[$attribute:meta])*
        $vis:vis struct $name:ident<'w, 's>: $query:ident {
            $($field_vis:vis $field:ident: $type:ty,)*
        }
    ) => {
        $(#[$attribute])*
        $vis struct $name<'w, 's> {
            $($field_vis $field: <$type as bevy::ecs::query::QueryData>::Item<'w, 's>,)*
        }

        $(#[$attribute])*
        $vis type $query = query_item!(@nested $($type)*);

        impl<'w, 's> $name<'w, 's> {
            $vis fn of(
                query_item!(@nested $($field)*): <$query as bevy::ecs::query::QueryData>::Item<'w, 's>,
            ) -> Self {
                Self { $($field,)* }
            }
        }
    };
}

pub(crate) use {query_item, system_param};
