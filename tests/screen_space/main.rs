//! Effects that find light on the screen, beside closed forms.

mod diffuse_gi;
mod hard_cases;
mod reflections;
mod settings;
