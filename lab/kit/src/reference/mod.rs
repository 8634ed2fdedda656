//! Twins in Rust of the shipped WGSL, under the names and paths that the WGSL has below `src`. Tests compare both on a device; rendering
//! uses the WGSL alone. Twins that the crate calls itself are re-exported.

pub mod effects {
    pub mod auto_exposure {
        pub mod adaptation;
        pub mod luminance;
    }
    pub mod diffuse_gi {
        pub mod entry;
    }
    pub mod reprojection;
    pub mod subsurface {
        pub mod profile;
    }
}

pub mod shader_library {
    pub mod cell;
    pub mod distance_fog;
    pub mod ggx;
    pub mod horizon;
    pub mod layout;
    pub mod reconstruction {
        pub mod motion;
        pub mod normal;
        pub mod position;
    }
}

pub mod shading_models {
    pub mod anisotropy;
    pub mod clearcoat;
    pub mod diffuse_transmission;
    pub mod rim;
    pub mod subsurface;
    pub mod unlit;
}
