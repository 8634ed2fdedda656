//! Definitions of the lighting shader that follow from others.
//!
//! This file uses nothing of Bevy: `examples/web/shaders`, which is built without it, includes the file.

/// The definitions that are set wherever `name` is.
pub fn implied_by(name: &str) -> &'static [&'static str] {
    match name {
        // Bevy blends normal maps of decals only onto meshes with tangents. The G-buffer does not record tangents; most
        // meshes under such decals have them.
        "CLUSTERED_DECALS_ARE_USABLE" => &["VERTEX_TANGENTS"],
        "CONTACT_SHADOWS" => &["SHADOWS"],
        // The bias of shadow maps needs the geometric normal, which is reconstructed from depth.
        "DIRECTIONAL_SHADOW_MAPS" => &["SHADOWS", "GEOMETRIC_NORMAL"],
        "POINT_SHADOW_MAPS" | "SPOT_SHADOW_MAPS" => {
            &["SHADOWS", "GEOMETRIC_NORMAL", "CLUSTERED_SHADOW_MAPS"]
        }
        "PROJECTION_PERSPECTIVE" | "PROJECTION_ORTHOGRAPHIC" => &["PROJECTION_IS_AFFINE"],
        "SCREEN_SPACE_AMBIENT_OCCLUSION" | "LEAN_AMBIENT_OCCLUSION" => &["APPLIES_VISIBILITY"],
        "FORWARD_REFLECTIONS" => &["INDIRECT_SPECULAR", "INDIRECT_LIGHT"],
        "INDIRECT_SPECULAR" => &["INDIRECT_LIGHT"],
        "INDIRECT_DIFFUSE" => &["INDIRECT_LIGHT", "APPLIES_VISIBILITY"],
        "DEBUG_VIEW" => &[],
        "DEBUG_DIFFUSE_LIGHT" | "DEBUG_SPECULAR_LIGHT" => &["DEBUG_VIEW", "SHOWS_PART_OF_LIGHT"],
        "DEBUG_GEOMETRIC_NORMAL" => &["DEBUG_VIEW", "SHOWS_CHANNEL", "GEOMETRIC_NORMAL"],
        name if name.starts_with("DEBUG_") => &["DEBUG_VIEW", "SHOWS_CHANNEL"],
        name if name.starts_with("GBUFFER_") => &["GBUFFER_VALID_MASK"],
        _ => &[],
    }
}
