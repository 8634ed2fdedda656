//! Shading models that `StandardMaterial` lacks, as a material extension.
//!
//! [`ExtendedStandardMaterial`] is a `StandardMaterial` with a [`ShadingExtension`]: rim light or subsurface scattering. All cameras
//! draw it; those with [`LeanDeferred`](crate::LeanDeferred) draw it into the G-buffer. [`ShadingExtensionPlugin`], part of
//! [`LeanDeferredPlugins`](crate::LeanDeferredPlugins), registers it.

// - `extension.wgsl`: its bindings.
// - `forward.wgsl`: the fragment shader of Bevy's forward passes.
// - `gbuffer.wgsl`: the fragment shader of the G-buffer.

use bevy::{
    asset::{AssetPath, embedded_asset, embedded_path},
    ecs::system::SystemParamItem,
    pbr::{ExtendedMaterial, MaterialExtension, MaterialPlugin, StandardMaterial},
    prelude::*,
    render::{
        render_resource::{
            AsBindGroup, AsBindGroupError, BindGroupLayout, BindGroupLayoutEntry,
            BindlessDescriptor, BindlessSlabResourceLimit, ShaderType, UnpreparedBindGroup,
        },
        renderer::RenderDevice,
    },
    shader::{ShaderRef, load_shader_library},
};

use crate::{
    gbuffer::{
        ForwardReason, GBufferMaterialExtension, GBufferMaterialPlugin, GBufferNeeds, ShadingModel,
    },
    shading_models::{rim::pack_rim, subsurface::pack_subsurface},
    view::can_build,
};

/// A `StandardMaterial` with a [`ShadingExtension`].
pub type ExtendedStandardMaterial = ExtendedMaterial<StandardMaterial, ShadingExtension>;

/// Adds a shading model to a [`StandardMaterial`], on cameras with and without [`LeanDeferred`](crate::LeanDeferred).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn(mut commands: Commands, mut materials: ResMut<Assets<ExtendedStandardMaterial>>) {
///     commands.spawn(MeshMaterial3d(materials.add(ExtendedStandardMaterial {
///         base: Color::srgb(0.5, 0.4, 0.3).into(),
///         extension: ShadingExtension::Rim {
///             color: Color::WHITE,
///             exponent: 4.0,
///         },
///     })));
/// }
/// ```
///
/// The G-buffer holds one special shading model per pixel. If the base is unlit or has clearcoat, anisotropy or diffuse
/// transmission, Bevy's forward pass draws the mesh: rim light is added unless the base is unlit, and nothing is scattered. On
/// all cameras the arguments are rounded to their bits in the G-buffer. Bevy's own deferred renderer shows the base alone.
#[derive(Asset, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub enum ShadingExtension {
    /// The base alone. Default.
    #[default]
    None,
    /// Light that enters scatters and leaves elsewhere (Christensen and Burley 2015, "Approximate Reflectance Profiles for
    /// Efficient Subsurface Scattering"). Cameras with [`LeanSubsurfaceScattering`](crate::LeanSubsurfaceScattering) scatter it;
    /// others light the surface like the base.
    Subsurface {
        /// Factor on `mean_free_path` per channel, 0 to 1. Skin is about `(1.0, 0.35, 0.2)`, linear.
        color: Color,
        /// `d` of the profile in metres, 0.0001 to 1: a quarter of the light leaves within 0.6 d, half within 1.6 d, nine tenths
        /// within 6 d. Larger is softer.
        mean_free_path: f32,
        /// Stage at which the base colour is applied.
        albedo: SubsurfaceAlbedo,
    },
    /// Ambient and environment light from behind the surface, along the silhouette where it faces up (Mitchell, Francke and
    /// Eng 2007, "Illustrative Rendering in Team Fortress 2").
    Rim {
        /// Factor on the light per channel, 0 to 1.
        color: Color,
        /// Exponent of the falloff, 1 to 16. Smaller is a wider rim; Mitchell, Francke and Eng use 4.
        exponent: f32,
    },
}

/// Stage at which the base colour of a surface with subsurface scattering is applied.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum SubsurfaceAlbedo {
    /// Applied to scattered light: textures stay sharp. Entering light is divided by the base colour; channels below 0.04 count
    /// as 0.04 there. Default.
    #[default]
    AfterScattering,
    /// Applied to entering light: textures blur as the light does.
    BeforeScattering,
}

impl ShadingExtension {
    fn shading_model(self) -> ShadingModel {
        match self {
            Self::None => ShadingModel::Plain,
            Self::Subsurface { .. } => ShadingModel::Subsurface,
            Self::Rim { .. } => ShadingModel::Rim,
        }
    }

    /// Arguments as packed in the G-buffer.
    fn packed_arguments(self) -> u32 {
        let linear = |color: Color| color.to_linear().to_vec3();
        match self {
            Self::None => 0,
            Self::Subsurface {
                color,
                mean_free_path,
                albedo,
            } => pack_subsurface(
                linear(color),
                mean_free_path,
                albedo == SubsurfaceAlbedo::BeforeScattering,
            ),
            Self::Rim { color, exponent } => pack_rim(linear(color), exponent),
        }
    }
}

impl GBufferMaterialExtension for ShadingExtension {
    fn gbuffer_fragment_shader() -> ShaderRef {
        embedded("gbuffer.wgsl")
    }

    fn gbuffer_needs(&self, base: GBufferNeeds) -> Result<GBufferNeeds, ForwardReason> {
        match (self.shading_model(), base.shading_model) {
            (ShadingModel::Plain, _) => Ok(base),
            (special, ShadingModel::Plain) => Ok(base.with_shading_model(special)),
            _ => Err(ForwardReason::TwoShadingModels),
        }
    }
}

impl MaterialExtension for ShadingExtension {
    fn fragment_shader() -> ShaderRef {
        embedded("forward.wgsl")
    }
}

fn embedded(file: &str) -> ShaderRef {
    ShaderRef::Path(AssetPath::from_path_buf(embedded_path!(file)).with_source("embedded"))
}

/// Uniform of a material's extension.
#[doc(hidden)]
#[derive(ShaderType, Reflect)]
#[reflect(no_auto_register)]
pub struct ExtensionUniform {
    shading_model: u32,
    arguments: u32,
}

impl From<&ExtensionBindings> for ExtensionUniform {
    fn from(bindings: &ExtensionBindings) -> Self {
        let extension = bindings.extension;
        Self {
            shading_model: extension.shading_model() as u32,
            arguments: extension.packed_arguments(),
        }
    }
}

/// Bindings of the extension in the bind group of the material. No `StandardMaterial` uses these numbers.
#[derive(AsBindGroup)]
#[data(50, ExtensionUniform, binding_array(101))]
#[bindless(index_table(range(50..51), binding(100)))]
#[doc(hidden)]
pub struct ExtensionBindings {
    extension: ShadingExtension,
}

/// True if the device cannot bind the base bindlessly: both share one bind group.
fn has_no_bindless(render_device: &RenderDevice) -> bool {
    !StandardMaterial::bindless_supported(render_device)
}

/// Not derived: Bevy's derive macro supports structs only.
impl AsBindGroup for ShadingExtension {
    type Data = ();
    type Param = <ExtensionBindings as AsBindGroup>::Param;

    fn label() -> &'static str {
        "lean_deferred/material_extension"
    }

    fn bindless_slot_count() -> Option<BindlessSlabResourceLimit> {
        ExtensionBindings::bindless_slot_count()
    }

    fn bindless_supported(render_device: &RenderDevice) -> bool {
        !has_no_bindless(render_device)
    }

    fn bindless_descriptor() -> Option<BindlessDescriptor> {
        ExtensionBindings::bindless_descriptor()
    }

    fn bind_group_data(&self) -> Self::Data {}

    fn unprepared_bind_group(
        &self,
        layout: &BindGroupLayout,
        render_device: &RenderDevice,
        param: &mut SystemParamItem<'_, '_, Self::Param>,
        force_no_bindless: bool,
    ) -> Result<UnpreparedBindGroup, AsBindGroupError> {
        ExtensionBindings { extension: *self }.unprepared_bind_group(
            layout,
            render_device,
            param,
            force_no_bindless || has_no_bindless(render_device),
        )
    }

    fn bind_group_layout_entries(
        render_device: &RenderDevice,
        force_no_bindless: bool,
    ) -> Vec<BindGroupLayoutEntry> {
        ExtensionBindings::bind_group_layout_entries(
            render_device,
            force_no_bindless || has_no_bindless(render_device),
        )
    }
}

/// Draws [`ExtendedStandardMaterial`]s on cameras with and without `LeanDeferred`. Part of
/// [`LeanDeferredPlugins`](crate::LeanDeferredPlugins); alone, add it beside
/// [`LeanDeferredPlugin`](crate::LeanDeferredPlugin), whose shaders it imports. Adds the [`MaterialPlugin`] unless the app has one: add
/// one with your own settings before this plugin.
#[derive(Default)]
pub struct ShadingExtensionPlugin;

impl Plugin for ShadingExtensionPlugin {
    fn build(&self, app: &mut App) {
        if !can_build(app, "ShadingExtensionPlugin", true) {
            return;
        }
        load_shader_library!(app, "extension.wgsl");
        embedded_asset!(app, "forward.wgsl");
        embedded_asset!(app, "gbuffer.wgsl");
        app.register_type::<ShadingExtension>()
            .register_type::<SubsurfaceAlbedo>();
        if !app.is_plugin_added::<MaterialPlugin<ExtendedStandardMaterial>>() {
            app.add_plugins(MaterialPlugin::<ExtendedStandardMaterial>::default());
        }
        app.add_plugins(GBufferMaterialPlugin::<ExtendedStandardMaterial>::default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gbuffer::GBufferMaterial;

    #[test]
    fn a_second_special_shading_model_goes_forward() {
        let rim = ShadingExtension::Rim {
            color: Color::WHITE,
            exponent: 4.0,
        };
        let needs = |extension, clearcoat| {
            let base = StandardMaterial {
                clearcoat,
                ..default()
            };
            ExtendedStandardMaterial { base, extension }.gbuffer_needs()
        };
        assert_eq!(
            needs(rim, 0.0).map(|needs| needs.shading_model),
            Ok(ShadingModel::Rim)
        );
        assert_eq!(needs(rim, 1.0), Err(ForwardReason::TwoShadingModels));
        assert_eq!(
            needs(ShadingExtension::None, 1.0).map(|needs| needs.shading_model),
            Ok(ShadingModel::Clearcoat)
        );
    }
}
