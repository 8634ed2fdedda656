//! Which materials the G-buffer carries, and with which fragment shader.

use core::{any::TypeId, marker::PhantomData};

use bevy::{
    asset::{AssetId, AssetServer, UntypedAssetId, load_embedded_asset},
    light::NotShadowReceiver,
    material::OpaqueRendererMethod,
    pbr::{
        ExtendedMaterial, Lightmap, Material, MaterialExtension, MaterialPlugin, StandardMaterial,
    },
    platform::collections::{HashMap, HashSet},
    prelude::*,
    reflect::structs::Struct,
    render::{
        Extract, ExtractSchedule, RenderApp, RenderStartup,
        sync_world::{MainEntity, MainEntityHashSet},
    },
    shader::ShaderRef,
};

/// A [`Material`] that can be drawn into the packed G-buffer.
///
/// Implement it for your own material, add [`GBufferMaterialPlugin`] for it, and its meshes go through the G-buffer of
/// every [`LeanDeferred`](crate::LeanDeferred) camera; without, Bevy's forward pass draws them there. The fragment
/// shader runs in Bevy's prepass pipeline: it gets `bevy_pbr::prepass_io::VertexOutput`, the material's own bind
/// group, and returns what `bevy_lean_deferred::gbuffer::pack::pack_pbr_input` makes of a `PbrInput`:
///
/// ```wgsl
/// #import bevy_pbr::{prepass_io::VertexOutput, pbr_fragment::pbr_input_from_standard_material}
/// #import bevy_lean_deferred::gbuffer::pack::{GBufferOutput, pack_pbr_input, apply_discards}
///
/// @fragment
/// fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> GBufferOutput {
///     var pbr_input = pbr_input_from_standard_material(in, is_front);
///     pbr_input.material.base_color.b = 1.0;
///     apply_discards(in, &pbr_input);
///     return pack_pbr_input(pbr_input);
/// }
/// ```
///
/// Its vertex shader is the one of the material's deferred pass ([`Material::deferred_vertex_shader`]).
pub trait GBufferMaterial: Material {
    /// The fragment shader for the G-buffer. The default packs a plain `StandardMaterial` bind group.
    fn gbuffer_fragment_shader() -> ShaderRef {
        ShaderRef::Default
    }

    /// Whether the base targets carry this very material exactly enough. One that answers `false` is drawn by Bevy's
    /// forward pass; it may answer differently after it was changed.
    fn fits_gbuffer(&self) -> bool;
}

impl GBufferMaterial for StandardMaterial {
    /// The base targets hold albedo, metallic, roughness, normal and occlusion. What else a `StandardMaterial` may
    /// ask for must be at its default. An explicit `OpaqueRendererMethod::Forward` is honoured.
    fn fits_gbuffer(&self) -> bool {
        let emissive = &self.emissive;
        let albedo = self.base_color.to_linear();
        let tint = self.specular_tint.to_linear();
        // `fog_enabled` and `unlit` have no bit; a depth bias moves the depth from which lighting finds the position.
        let in_unit_range = |x: f32| (0.0..=1.0).contains(&x);
        self.opaque_render_method != OpaqueRendererMethod::Forward
            && [emissive.red, emissive.green, emissive.blue] == [0.0; 3]
            && [
                albedo.red,
                albedo.green,
                albedo.blue,
                self.metallic,
                self.perceptual_roughness,
            ]
            .into_iter()
            .all(in_unit_range)
            && self.reflectance == 0.5
            && [tint.red, tint.green, tint.blue] == [1.0; 3]
            && self.clearcoat == 0.0
            && self.anisotropy_strength == 0.0
            && self.diffuse_transmission == 0.0
            && self.specular_transmission == 0.0
            && !self.unlit
            && self.fog_enabled
            && self.depth_bias == 0.0
            && !has_texture(self, "specular_texture")
            && !has_texture(self, "specular_tint_texture")
    }
}

/// Whether the optional texture `field` is set. By reflection, because whether `StandardMaterial` has the field depends
/// on features of Bevy that are not ours to see.
fn has_texture(material: &StandardMaterial, field: &str) -> bool {
    material
        .field(field)
        .and_then(|value| value.reflect_ref().as_enum().ok())
        .is_some_and(|option| option.variant_name() == "Some")
}

/// A [`MaterialExtension`] of [`StandardMaterial`] whose [`ExtendedMaterial`] can be drawn into the packed G-buffer.
/// See [`GBufferMaterial`].
pub trait GBufferMaterialExtension: MaterialExtension {
    /// The fragment shader for the G-buffer. The default ignores the extension.
    fn gbuffer_fragment_shader() -> ShaderRef {
        ShaderRef::Default
    }

    /// Whether the base targets carry what the extension makes of its base. Asked only if they carry the base.
    fn fits_gbuffer(&self) -> bool {
        true
    }
}

impl<E: GBufferMaterialExtension> GBufferMaterial for ExtendedMaterial<StandardMaterial, E> {
    fn gbuffer_fragment_shader() -> ShaderRef {
        E::gbuffer_fragment_shader()
    }

    fn fits_gbuffer(&self) -> bool {
        self.base.fits_gbuffer() && self.extension.fits_gbuffer()
    }
}

/// Lets meshes with material `M` into the G-buffer. Add it beside `M`'s [`MaterialPlugin`].
pub struct GBufferMaterialPlugin<M: GBufferMaterial>(PhantomData<fn() -> M>);

impl<M: GBufferMaterial> Default for GBufferMaterialPlugin<M> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<M: GBufferMaterial> Plugin for GBufferMaterialPlugin<M>
where
    MaterialPlugin<M>: Plugin,
{
    fn build(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_resource::<GBufferMaterials>()
            .add_systems(RenderStartup, load_fragment_shader::<M>)
            .add_systems(ExtractSchedule, extract_fitting_materials::<M>);
    }
}

/// In the render world: what the G-buffer carries.
#[derive(Resource, Default)]
pub(crate) struct GBufferMaterials {
    fragment_shaders: HashMap<TypeId, Handle<Shader>>,
    fitting: HashSet<UntypedAssetId>,
}

impl GBufferMaterials {
    /// The fragment shader to draw `material` into the G-buffer with, or `None` if forward must draw it.
    pub(crate) fn fragment_shader(&self, material: UntypedAssetId) -> Option<&Handle<Shader>> {
        self.fitting
            .contains(&material)
            .then(|| self.fragment_shaders.get(&material.type_id()))
            .flatten()
    }
}

fn load_fragment_shader<M: GBufferMaterial>(
    asset_server: Res<AssetServer>,
    mut materials: ResMut<GBufferMaterials>,
) {
    let shader = match M::gbuffer_fragment_shader() {
        ShaderRef::Default => load_embedded_asset!(asset_server.as_ref(), "gbuffer.wgsl"),
        ShaderRef::Handle(handle) => handle,
        ShaderRef::Path(path) => asset_server.load(path),
    };
    materials.fragment_shaders.insert(TypeId::of::<M>(), shader);
}

/// Follows the assets of type `M`. Bevy marks the meshes of a changed material as dirty, so they are queued anew, with
/// what is recorded here, in the same frame.
fn extract_fitting_materials<M: GBufferMaterial>(
    mut events: Extract<MessageReader<AssetEvent<M>>>,
    assets: Extract<Res<Assets<M>>>,
    mut materials: ResMut<GBufferMaterials>,
) {
    for event in events.read() {
        let (AssetEvent::Added { id }
        | AssetEvent::Modified { id }
        | AssetEvent::Removed { id }
        | AssetEvent::Unused { id }
        | AssetEvent::LoadedWithDependencies { id }) = event;
        update_fitting(*id, assets.get(*id), &mut materials);
    }
}

fn update_fitting<M: GBufferMaterial>(
    id: AssetId<M>,
    material: Option<&M>,
    materials: &mut GBufferMaterials,
) {
    if material.is_some_and(M::fits_gbuffer) {
        materials.fitting.insert(id.untyped());
    } else {
        materials.fitting.remove(&id.untyped());
    }
}

/// In the render world: meshes that forward must draw whatever their material, because the mesh itself asks for
/// something the base targets have no bit for.
#[derive(Resource, Default)]
pub(crate) struct ForwardOnlyMeshes(pub(crate) MainEntityHashSet);

pub(super) fn extract_forward_only_meshes(
    mut forward_only: ResMut<ForwardOnlyMeshes>,
    meshes: Extract<Query<Entity, (With<Mesh3d>, Or<(With<NotShadowReceiver>, With<Lightmap>)>)>>,
) {
    forward_only.0.clear();
    forward_only.0.extend(meshes.iter().map(MainEntity::from));
}

/// In the main world: has meshes queued anew whose components made or unmade them forward-only.
pub(super) fn requeue_changed_forward_only_meshes(
    changed: Query<Entity, Or<(Added<NotShadowReceiver>, Added<Lightmap>)>>,
    mut receivers: RemovedComponents<NotShadowReceiver>,
    mut lightmaps: RemovedComponents<Lightmap>,
    mut meshes: Query<&mut Mesh3d>,
) {
    for entity in changed
        .iter()
        .chain(receivers.read())
        .chain(lightmaps.read())
    {
        if let Ok(mut mesh) = meshes.get_mut(entity) {
            mesh.set_changed();
        }
    }
}
