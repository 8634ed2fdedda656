//! Screen-space lighting effects against closed forms.

mod apps;
mod bounds;
mod carried;
mod diffuse_gi;
mod energy;
mod film;
mod fog;
mod forward_mirrors;
mod hard_cases;
mod hostile;
mod lamps;
mod mirror_images;
mod mirrors;
mod motion;
mod outlines;
mod reflections;
mod resized;
mod scenes;
mod settings;
mod small_lamps;
mod subsurface;
mod subsurface_apps;
mod subsurface_views;
mod thin;
mod views;
