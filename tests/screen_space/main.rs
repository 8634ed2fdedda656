//! Effects that find light on the screen, beside closed forms.

mod diffuse_gi;
mod reflections;
mod settings;
