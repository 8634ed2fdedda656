// How bright light is shown. Without bindings.
#define_import_path bevy_lean_deferred::screen_space::shown_exposure

#import bevy_lean_deferred::gbuffer::layout::light::LARGEST_LIGHT

/// Light that is shown as so many times white, where tonemapping applies an exposure of so many stops; at most what words and half
/// floats hold.
fn light_of_whites(whites: f32, stops: f32) -> f32 {
    return min(whites * exp2(-clamp(stops, -64.0, 64.0)), LARGEST_LIGHT);
}
