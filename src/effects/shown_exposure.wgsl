// Brightness of light as shown. Without bindings.
#define_import_path bevy_lean_deferred::effects::shown_exposure

#import bevy_lean_deferred::gbuffer::layout::light::LARGEST_LIGHT

/// Light that shows as `whites` times white where tonemapping applies an exposure of `stops`. At most what packed words and half
/// floats hold.
fn light_of_whites(whites: f32, stops: f32) -> f32 {
    return min(whites * exp2(-clamp(stops, -64.0, 64.0)), LARGEST_LIGHT);
}
