//! Registers materials for the G-buffer, and tracks the needs of their assets.

use core::{any::TypeId, mem::replace};

use alloc::sync::Arc;

use bevy::{
    asset::{AssetServer, UntypedAssetId, load_embedded_asset},
    mesh::VertexAttributeDescriptor,
    pbr::{Material, MaterialPlugin},
    platform::collections::HashMap,
    prelude::*,
    render::{Extract, ExtractSchedule, RenderApp, RenderStartup},
    shader::ShaderRef,
};

use super::{
    demand::ViewDemands,
    forward_reason::ForwardReason,
    material::GBufferMaterial,
    prewarm::{PrewarmedMeshes, extract_prewarmed_meshes},
    targets::GBufferNeeds,
};
use crate::view::{EffectSystems, LeanDeferred, PrewarmExtraction};

/// Draws meshes with material `M` into the G-buffer. Add it beside `M`'s [`MaterialPlugin`], in any order.
///
/// [`default`](Self::default) registers a [`GBufferMaterial`], [`new`](Self::new) a material of another crate.
pub struct GBufferMaterialPlugin<M: Material> {
    shaders: Arc<ShaderRefs>,
    needs: Arc<Needs<M>>,
}

type Needs<M> = dyn Fn(&M) -> Result<GBufferNeeds, ForwardReason> + Send + Sync;

struct ShaderRefs {
    fragment: ShaderRef,
    vertex: Option<VertexStage<ShaderRef>>,
}

/// A vertex shader, and the attributes that it reads in addition to those of Bevy's prepass.
pub(super) struct VertexStage<S> {
    pub(super) shader: S,
    pub(super) attributes: Arc<[VertexAttributeDescriptor]>,
}

impl<M: GBufferMaterial> Default for GBufferMaterialPlugin<M> {
    fn default() -> Self {
        Self::new(M::gbuffer_fragment_shader(), M::gbuffer_needs)
    }
}

impl<M: Material> GBufferMaterialPlugin<M> {
    /// Registers any material, with the fragment shader that packs it and a function for the needs of each asset. Meshes are left to
    /// Bevy's forward pass if it returns a [`ForwardReason`]. [`GBufferMaterial`] documents both.
    ///
    /// ```
    /// use bevy::{pbr::ExtendedMaterial, prelude::*};
    /// use bevy_lean_deferred::prelude::*;
    /// # mod terrain {
    /// #     use bevy::{pbr::MaterialExtension, prelude::*, reflect::TypePath, render::render_resource::AsBindGroup};
    /// #     #[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
    /// #     pub struct Moss {}
    /// #     impl MaterialExtension for Moss {}
    /// # }
    ///
    /// type Mossy = ExtendedMaterial<StandardMaterial, terrain::Moss>;
    ///
    /// fn add_plugins(app: &mut App) {
    ///     app.add_plugins(GBufferMaterialPlugin::<Mossy>::new(
    ///         "shaders/mossy_gbuffer.wgsl",
    ///         |material| material.base.gbuffer_needs(),
    ///     ));
    /// }
    /// ```
    pub fn new(
        fragment_shader: impl Into<ShaderRef>,
        needs: impl Fn(&M) -> Result<GBufferNeeds, ForwardReason> + Send + Sync + 'static,
    ) -> Self {
        let shaders = ShaderRefs {
            fragment: fragment_shader.into(),
            vertex: None,
        };
        Self {
            shaders: Arc::new(shaders),
            needs: Arc::new(needs),
        }
    }

    /// Replaces [`Material::deferred_vertex_shader`]. `attributes` are those that the shader reads in addition to Bevy's prepass
    /// (`bevy_pbr::prepass_io::Vertex`, locations 0 to 7). For materials with a vertex shader for Bevy's main pass only.
    ///
    /// The shader has the definitions of the prepass, including `PREPASS_PIPELINE`. It must write the fields of
    /// `bevy_pbr::prepass_io::VertexOutput` at their locations. Further outputs start at location 10.
    pub fn with_vertex_shader(
        self,
        shader: impl Into<ShaderRef>,
        attributes: impl IntoIterator<Item = VertexAttributeDescriptor>,
    ) -> Self {
        let fragment = match &self.shaders.fragment {
            ShaderRef::Default => ShaderRef::Default,
            ShaderRef::Handle(handle) => ShaderRef::Handle(handle.clone()),
            ShaderRef::Path(path) => ShaderRef::Path(path.clone()),
        };
        let shaders = ShaderRefs {
            fragment,
            vertex: Some(VertexStage {
                shader: shader.into(),
                attributes: attributes.into_iter().collect(),
            }),
        };
        Self {
            shaders: Arc::new(shaders),
            ..self
        }
    }
}

impl<M: Material> Plugin for GBufferMaterialPlugin<M>
where
    MaterialPlugin<M>: Plugin,
{
    fn build(&self, _: &mut App) {}

    /// In `finish`, so that the plugins may be added in any order.
    fn finish(&self, app: &mut App) {
        let has_material = app.is_plugin_added::<MaterialPlugin<M>>();
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        let has_gbuffer = render_app.world().contains_resource::<ViewDemands>();
        if !has_material || !has_gbuffer {
            let missing = if has_material {
                "LeanDeferredPlugin"
            } else {
                "MaterialPlugin for it"
            };
            error!(
                "GBufferMaterialPlugin<{}> is off, and forward draws the material: the app has no {missing}. Add it.",
                M::short_type_path()
            );
            return;
        }
        let (shaders, needs) = (self.shaders.clone(), self.needs.clone());
        let load_shaders =
            move |asset_server: Res<AssetServer>, mut materials: ResMut<GBufferMaterials>| {
                let shaders = MaterialShaders::load(&shaders, &asset_server);
                materials.shaders.insert(TypeId::of::<M>(), shaders);
            };
        let extract_needs = move |cameras: Extract<Query<(), With<LeanDeferred>>>,
                                  events: Extract<MessageReader<AssetEvent<M>>>,
                                  assets: Extract<Res<Assets<M>>>,
                                  materials: ResMut<GBufferMaterials>,
                                  mut is_following: Local<bool>| {
            let was_following = replace(&mut *is_following, !cameras.is_empty());
            if *is_following {
                extract_material_needs(&*needs, was_following, events, assets, materials);
            }
        };
        render_app
            .init_resource::<GBufferMaterials>()
            // Each material type writes only its own entries.
            .allow_ambiguous_resource::<GBufferMaterials>()
            .allow_ambiguous_resource::<PrewarmedMeshes>()
            .add_systems(RenderStartup, load_shaders)
            .add_systems(
                ExtractSchedule,
                (
                    extract_needs.in_set(EffectSystems::Lean),
                    extract_prewarmed_meshes::<M>.in_set(PrewarmExtraction),
                ),
            );
    }
}

/// In the render world: shaders of the registered material types, and needs of their assets.
#[derive(Resource, Default)]
pub(crate) struct GBufferMaterials {
    shaders: HashMap<TypeId, MaterialShaders>,
    needs: HashMap<UntypedAssetId, Result<GBufferNeeds, ForwardReason>>,
}

/// Shaders that draw a material type into the G-buffer.
pub(crate) struct MaterialShaders {
    pub(super) fragment: Handle<Shader>,
    /// The shader that draws depth alone, if the other one is that of `StandardMaterial`.
    pub(super) masked_depth: Option<Handle<Shader>>,
    /// Replaces the vertex shader of the material.
    pub(super) vertex: Option<Arc<VertexStage<Handle<Shader>>>>,
}

impl MaterialShaders {
    fn load(refs: &ShaderRefs, asset_server: &AssetServer) -> Self {
        let load = |shader: &ShaderRef| match shader {
            ShaderRef::Default => None,
            ShaderRef::Handle(handle) => Some(handle.clone()),
            ShaderRef::Path(path) => Some(asset_server.load(path.clone())),
        };
        let vertex = refs.vertex.as_ref().and_then(|vertex| {
            Some(Arc::new(VertexStage {
                shader: load(&vertex.shader)?,
                attributes: vertex.attributes.clone(),
            }))
        });
        let own = load(&refs.fragment);
        let standard = || load_embedded_asset!(asset_server, "gbuffer.wgsl");
        let masked_depth = || load_embedded_asset!(asset_server, "masked_depth.wgsl");
        Self {
            masked_depth: own.is_none().then(masked_depth),
            fragment: own.unwrap_or_else(standard),
            vertex,
        }
    }
}

impl GBufferMaterials {
    /// Needs and shaders of `material`, or the reason that Bevy's forward pass must draw it.
    pub(crate) fn get(
        &self,
        material: UntypedAssetId,
    ) -> Result<(GBufferNeeds, &MaterialShaders), ForwardReason> {
        let shaders = self.shaders.get(&material.type_id());
        let shaders = shaders.ok_or(ForwardReason::NotRegistered)?;
        // Without needs, the event of the asset is still to come.
        let needs = self.needs.get(&material).copied();
        Ok((needs.unwrap_or(Err(ForwardReason::Compiling))?, shaders))
    }
}

/// Tracks the needs of the assets of type `M`. Bevy marks the meshes of a changed material as dirty, so they are queued again with
/// the new needs in the same frame. Reads all assets if they were not tracked in the last frame.
fn extract_material_needs<M: Material>(
    needs: &Needs<M>,
    was_following: bool,
    mut events: Extract<MessageReader<AssetEvent<M>>>,
    assets: Extract<Res<Assets<M>>>,
    mut materials: ResMut<GBufferMaterials>,
) {
    if !was_following {
        // Removed materials that meshes still have are not among the assets.
        for event in events.read() {
            if let AssetEvent::Unused { id } = event {
                materials.needs.remove(&id.untyped());
            }
        }
        let all = assets
            .iter()
            .map(|(id, material)| (id.untyped(), needs(material)));
        materials.needs.extend(all);
        return;
    }
    for event in events.read() {
        let (AssetEvent::Added { id }
        | AssetEvent::Modified { id }
        | AssetEvent::Removed { id }
        | AssetEvent::Unused { id }
        | AssetEvent::LoadedWithDependencies { id }) = event;
        if let Some(material) = assets.get(*id) {
            materials.needs.insert(id.untyped(), needs(material));
        } else if matches!(event, AssetEvent::Unused { .. }) {
            // Bevy draws with a removed material while a mesh has its handle.
            materials.needs.remove(&id.untyped());
        }
    }
}
