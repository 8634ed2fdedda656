// Where scattered light joins the picture.
#define_import_path bevy_lean_deferred::screen_space::subsurface::output

#import bevy_lean_deferred::lighting::subsurface_light::Receiver
#import bevy_lean_deferred::screen_space::subsurface::bindings::{output_texture, view}

/// Shows at a pixel what it shows without scattering and what that adds to its light.
fn add_scattered(pixel: vec2<i32>, receiver: Receiver, added: vec3<f32>) {
    // Where that is nothing, or not a number, the picture stays as it is.
    if any(added != vec3(0.0)) && all(abs(added) < vec3(1e30)) {
        let color = receiver.color.rgb + receiver.leaving * added;
        textureStore(output_texture, vec2<i32>(view.viewport_origin) + pixel, vec4(color, receiver.color.a));
    }
}
