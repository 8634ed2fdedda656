//! Requests the pipelines of all meshes in the main world while cameras are prewarmed, hidden and distant ones too.

use core::mem::replace;

use bevy::{
    asset::{AssetServer, LoadState, UntypedAssetId},
    camera::visibility::{RenderLayers, VisibilityRange},
    light::NotShadowReceiver,
    pbr::{Lightmap, Material, MeshMaterial3d, MeshPipelineKey, ViewKeyCache},
    platform::collections::HashMap,
    prelude::*,
    render::{Extract, view::ExtractedView},
};

use super::{
    forward_reason::ForwardReason,
    lookup::{MeshKind, MeshLookup},
    placement::{MeshDemand, MeshOutput},
    registration::MaterialShaders,
    specialize::GBufferPipelines,
};
use crate::{
    shader_library::layout::{DEFAULT_VISIBILITY_MASK, visibility_mask},
    view::{Demand, GBufferTargets, LeanDeferred, PrewarmedView, Prewarming},
};

/// Frames for which a mesh is waited for that is not prepared although its assets are loaded. Bevy prepares them within a few.
const PATIENCE: u32 = 60;

/// Meshes of the main world that are drawn by the same pipelines.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct PrewarmedKind {
    material: UntypedAssetId,
    mesh: AssetId<Mesh>,
    /// Sampled bicubically or not.
    lightmap: Option<bool>,
    receives_no_shadows: bool,
    has_visibility_mask: bool,
    crossfades: bool,
}

impl PrewarmedKind {
    /// Targets beside those of mesh and material.
    fn targets(self) -> GBufferTargets {
        let mut targets = GBufferTargets::empty();
        targets.set(GBufferTargets::SPECIALIZATION, self.receives_no_shadows);
        targets.set(GBufferTargets::VISIBILITY_MASK, self.has_visibility_mask);
        targets
    }

    /// Key bits of its instances: in their first frame, and with a previous skin or morph if the mesh `is_skinned` or
    /// `is_morphed`.
    fn instances(
        self,
        is_skinned: bool,
        is_morphed: bool,
    ) -> impl Iterator<Item = MeshPipelineKey> {
        let mut key = MeshPipelineKey::empty();
        key.set(MeshPipelineKey::VISIBILITY_RANGE_DITHER, self.crossfades);
        if let Some(is_bicubic) = self.lightmap {
            key |= MeshPipelineKey::LIGHTMAPPED;
            key.set(MeshPipelineKey::LIGHTMAP_BICUBIC_SAMPLING, is_bicubic);
        }
        let skin = is_skinned.then_some(MeshPipelineKey::HAS_PREVIOUS_SKIN);
        let morph = is_morphed.then_some(MeshPipelineKey::HAS_PREVIOUS_MORPH);
        let both = skin.zip(morph).map(|(skin, morph)| skin | morph);
        [Some(MeshPipelineKey::empty()), skin, morph, both]
            .into_iter()
            .flatten()
            .map(move |previous| key | previous)
    }
}

#[derive(Debug, Default)]
struct KindState {
    /// True if the mesh, the material or its textures are still loading. Set by extraction in each frame, so that no kind is waited
    /// for whose last mesh was despawned.
    is_loading: Option<bool>,
    /// Not prepared in this frame.
    is_missing: bool,
    /// Frames for which it was not prepared although they are loaded.
    waited: u32,
}

impl KindState {
    fn may_come(&self) -> bool {
        self.is_loading == Some(true) || self.waited < PATIENCE
    }

    fn end_frame(&mut self) {
        let is_missing = replace(&mut self.is_missing, false);
        let is_loading = self.is_loading.take() == Some(true);
        self.waited += u32::from(is_missing && !is_loading);
    }
}

/// In the render world: the kinds of meshes in the main world, while cameras are prewarmed.
#[derive(Resource, Default)]
pub(super) struct PrewarmedMeshes(HashMap<PrewarmedKind, KindState>);

/// Collects the kinds of meshes with material `M`.
pub(super) fn extract_prewarmed_meshes<M: Material>(
    mut kinds: ResMut<PrewarmedMeshes>,
    meshes: Extract<
        Query<(
            &Mesh3d,
            &MeshMaterial3d<M>,
            Option<&Lightmap>,
            (Has<NotShadowReceiver>, Option<&RenderLayers>),
            Option<&VisibilityRange>,
        )>,
    >,
    materials: Extract<Res<Assets<M>>>,
    asset_server: Extract<Res<AssetServer>>,
) {
    let is_loading =
        |id: UntypedAssetId| matches!(asset_server.get_load_state(id), Some(LoadState::Loading));
    for (mesh, material, lightmap, (receives_no_shadows, layers), range) in &meshes {
        let mask = layers.map_or(DEFAULT_VISIBILITY_MASK, visibility_mask);
        let kind = PrewarmedKind {
            material: material.0.id().untyped(),
            mesh: mesh.0.id(),
            lightmap: lightmap.map(|lightmap| lightmap.bicubic_sampling),
            receives_no_shadows,
            has_visibility_mask: mask != DEFAULT_VISIBILITY_MASK,
            crossfades: range.is_some_and(|range| !range.is_abrupt()),
        };
        let state = kinds.0.entry(kind).or_default();
        if state.is_loading.is_some() {
            continue;
        }
        let mut loads = is_loading(kind.mesh.untyped()) || is_loading(kind.material);
        if let Some(material) = materials.get(&material.0) {
            material.visit_dependencies(&mut |texture| loads |= is_loading(texture));
        }
        state.is_loading = Some(loads);
    }
}

/// A mesh that the G-buffer of a camera can carry.
struct CarriedMesh<'a> {
    kind: PrewarmedKind,
    mesh: MeshKind<'a>,
    shaders: &'a MaterialShaders,
    demand: MeshDemand,
}

impl CarriedMesh<'_> {
    /// Its demand at rest and, on views with motion vectors, in motion.
    fn forms(&self, view: PrewarmedView) -> impl Iterator<Item = MeshDemand> {
        let mut moving = self.demand;
        moving.demand.targets |= GBufferTargets::MOTION;
        let moves = view.has_motion && moving != self.demand;
        core::iter::once(self.demand).chain(moves.then_some(moving))
    }

    /// Key bits of its instances.
    fn instances(&self) -> impl Iterator<Item = MeshPipelineKey> {
        let mesh = self.mesh.mesh;
        let key = MeshPipelineKey::from_bits_retain(mesh.key_bits.bits());
        let is_skinned = mesh.layout.0.contains(Mesh::ATTRIBUTE_JOINT_INDEX);
        let is_morphed = key.contains(MeshPipelineKey::MORPH_TARGETS);
        self.kind.instances(is_skinned, is_morphed)
    }
}

/// The optional targets that such views have a use for.
fn useful_targets(view: PrewarmedView) -> GBufferTargets {
    let mut targets = GBufferTargets::all();
    targets.set(GBufferTargets::MOTION, view.has_motion);
    targets.set(GBufferTargets::VISIBILITY_MASK, view.has_light_layers);
    targets
}

/// All sets of optional targets that a view may have, if any of the meshes with these targets are visible: their unions.
fn sets_of_targets(meshes: impl IntoIterator<Item = GBufferTargets>) -> Vec<GBufferTargets> {
    let mut sets = vec![GBufferTargets::empty()];
    for targets in meshes {
        for index in 0..sets.len() {
            let union = sets[index] | targets;
            if !sets.contains(&union) {
                sets.push(union);
            }
        }
    }
    sets
}

/// Requests the pipelines that draw these meshes on prewarmed cameras, after those of visible meshes.
pub(super) fn prewarm_meshes(
    lookup: MeshLookup,
    mut pipelines: GBufferPipelines,
    mut kinds: ResMut<PrewarmedMeshes>,
    mut prewarming: ResMut<Prewarming>,
    view_keys: Res<ViewKeyCache>,
    views: Query<&ExtractedView, With<LeanDeferred>>,
) {
    if !prewarming.is_active() {
        kinds.0.clear();
        return;
    }
    pipelines.start();
    for view in &views {
        let id = view.retained_view_entity;
        let camera = prewarming.get_mut(id.main_entity);
        let (Some(camera), Some(view_key)) = (camera, view_keys.get(&id).copied()) else {
            continue;
        };
        // Decided earlier in the frame.
        let Some(view) = camera.view else {
            continue;
        };
        let mut loading = 0;
        let mut meshes = Vec::new();
        for (kind, state) in &mut kinds.0 {
            match find(&lookup, *kind) {
                Ok(mesh) => meshes.push(mesh),
                Err(ForwardReason::Compiling) => {
                    state.is_missing = true;
                    loading += usize::from(state.may_come());
                }
                Err(_) => {}
            }
        }
        camera.loading_meshes = loading;
        camera.demand = meshes
            .iter()
            .fold(Demand::default(), |all, mesh| all.union(mesh.demand.demand));
        let useful = useful_targets(view);
        let forms = meshes.iter().flat_map(|mesh| mesh.forms(view));
        let sets = sets_of_targets(forms.map(|form| form.demand.targets & useful));
        for mesh in &meshes {
            for form in mesh.forms(view) {
                let needed = form.demand.targets & useful;
                for set in sets.iter().filter(|set| set.contains(needed)) {
                    let output = MeshOutput::of(form, *set, view.culls_in_two_phases);
                    for instance in mesh.instances() {
                        pipelines.get_for(&mesh.mesh, instance, view_key, mesh.shaders, output);
                    }
                }
            }
        }
    }
    kinds.0.values_mut().for_each(KindState::end_frame);
}

/// Finds a mesh of this kind. The reason is [`ForwardReason::Compiling`] if its assets are not prepared.
fn find<'a>(lookup: &'a MeshLookup, kind: PrewarmedKind) -> Result<CarriedMesh<'a>, ForwardReason> {
    let mesh = lookup.find_kind(kind.material, kind.mesh);
    let mesh = mesh.map_err(|_| ForwardReason::Compiling)?;
    let lightmapped = kind.lightmap.is_some();
    let (demand, shaders) = MeshLookup::needs_of(&mesh, lightmapped, kind.targets())?;
    Ok(CarriedMesh {
        kind,
        mesh,
        shaders,
        demand,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_all_unions() {
        let (emissive, special) = (GBufferTargets::EMISSIVE, GBufferTargets::SPECIALIZATION);
        assert_eq!(sets_of_targets([]), [GBufferTargets::empty()]);
        let sets = sets_of_targets([emissive, special, emissive, special | emissive]);
        let empty = GBufferTargets::empty();
        assert_eq!(sets, [empty, emissive, special, emissive | special]);
        let every = GBufferTargets::all().iter();
        assert_eq!(sets_of_targets(every).len(), 16);
    }

    /// A frame counts once, however many views miss the mesh in it.
    #[test]
    fn meshes_that_are_loaded_are_waited_for_a_while() {
        let mut state = KindState::default();
        let mut end_frame = |is_loading| {
            state.is_loading = is_loading;
            state.is_missing = true;
            let may_come = state.may_come();
            state.end_frame();
            may_come
        };
        assert!((0..2 * PATIENCE).all(|_| end_frame(Some(true))));
        assert!((0..PATIENCE).all(|_| end_frame(Some(false))));
        assert!(!end_frame(Some(false)));
        assert!(!end_frame(None));
        assert!(end_frame(Some(true)));
    }

    #[test]
    fn skinned_meshes_are_drawn_with_and_without_a_previous_skin() {
        let kind = PrewarmedKind {
            material: AssetId::<StandardMaterial>::default().untyped(),
            mesh: AssetId::default(),
            lightmap: None,
            receives_no_shadows: false,
            has_visibility_mask: false,
            crossfades: true,
        };
        let dither = MeshPipelineKey::VISIBILITY_RANGE_DITHER;
        let keys: Vec<_> = kind.instances(true, false).collect();
        assert_eq!(keys, [dither, dither | MeshPipelineKey::HAS_PREVIOUS_SKIN]);
        assert_eq!(kind.instances(true, true).count(), 4);
    }
}
