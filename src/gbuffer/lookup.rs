//! Looks up the G-buffer needs of a mesh, or finds that only forward can draw it.

use core::{hash::BuildHasher, ops::Deref};

use bevy::{
    asset::UntypedAssetId,
    material::RenderPhaseType,
    pbr::{MeshPipelineKey, PreparedMaterial, RenderMeshQueueData},
    platform::hash::FixedHasher,
    prelude::*,
    render::{
        mesh::{RenderMesh, allocator::MeshSlabs},
        sync_world::MainEntity,
        view::RenderVisibilityRanges,
    },
};

use super::{
    bevy::{lightmaps::LightmappedMeshes, queue_rules::BevyLookup},
    forward_reason::ForwardReason,
    mesh_overrides::MeshOverrides,
    moving::MovingMeshes,
    placement::MeshDemand,
    registration::{GBufferMaterials, MaterialShaders},
    targets::GBufferNeeds,
};
use crate::{
    gpu::named::system_param,
    shader_library::layout::DEFAULT_VISIBILITY_MASK,
    view::{Demand, GBufferTargets, LightingVariants, ShadingModel},
};

system_param! {
    /// The meshes and materials that decide how a mesh is drawn.
    pub(super) struct MeshLookup<'w> {
        pub(super) bevy: BevyLookup<'w>,
        gbuffer_materials: Res<'w, GBufferMaterials>,
        pub(super) special_meshes: Res<'w, MeshOverrides>,
        pub(super) lightmapped_meshes: Res<'w, LightmappedMeshes>,
        moving_meshes: Res<'w, MovingMeshes>,
        pub(super) visibility_ranges: Res<'w, RenderVisibilityRanges>,
    }
}

/// Properties that meshes of one mesh asset and one material share.
#[derive(Clone, Copy)]
pub(super) struct MeshKind<'a> {
    pub(super) material: &'a PreparedMaterial,
    pub(super) material_id: UntypedAssetId,
    pub(super) mesh: &'a RenderMesh,
    mesh_id: AssetId<Mesh>,
    pub(super) slabs: MeshSlabs,
    /// Needs of the material and the shaders that draw it into the G-buffer, or the reason that forward must draw it.
    needs: Result<(GBufferNeeds, &'a MaterialShaders), ForwardReason>,
    /// True if vertices may move within the mesh.
    pub(super) deforms: bool,
}

/// Number of mesh kinds that are cached while views are sorted.
pub(super) const RECENT_KINDS: usize = 1024;

/// Cache of the kinds that were looked up last, indexed by a hash of mesh asset and material.
#[derive(Default)]
pub(super) struct RecentKinds<'a>(Vec<Option<MeshKind<'a>>>);

/// A mesh whose assets are all loaded.
pub(super) struct MeshToQueue<'a> {
    pub(super) instance: RenderMeshQueueData<'a>,
    kind: MeshKind<'a>,
    /// Index of its kind in the cache.
    pub(super) place: usize,
}

impl<'a> Deref for MeshToQueue<'a> {
    type Target = MeshKind<'a>;

    fn deref(&self) -> &Self::Target {
        &self.kind
    }
}

impl MeshLookup<'_> {
    /// Returns `Err(true)` if the mesh may be ready in a later frame, `Err(false)` if waiting is of no use: as Bevy's own
    /// queue systems, so that both wait for the same meshes.
    pub(super) fn find<'a>(
        &'a self,
        entity: MainEntity,
        recent: &mut RecentKinds<'a>,
    ) -> Result<MeshToQueue<'a>, bool> {
        let (material_id, instance) = self.bevy.instance(entity)?;
        let mesh_id = instance.mesh_asset_id();
        let place = FixedHasher.hash_one((material_id, mesh_id)) as usize % RECENT_KINDS;
        if recent.0.is_empty() {
            recent.0.resize(RECENT_KINDS, None);
        }
        let kind = match recent.0[place] {
            Some(kind) if kind.material_id == material_id && kind.mesh_id == mesh_id => kind,
            _ => *recent.0[place].insert(self.find_kind(material_id, mesh_id)?),
        };
        Ok(MeshToQueue {
            instance,
            kind,
            place,
        })
    }

    /// As [`find`](Self::find), without an instance.
    pub(super) fn find_kind(
        &self,
        material_id: UntypedAssetId,
        mesh_id: AssetId<Mesh>,
    ) -> Result<MeshKind<'_>, bool> {
        let (material, mesh, slabs) = self.bevy.assets(material_id, mesh_id)?;
        let has = |attribute| mesh.layout.0.contains(attribute);
        let needs = match material.properties.render_phase_type {
            RenderPhaseType::Opaque | RenderPhaseType::AlphaMask => {
                self.gbuffer_materials.get(material_id)
            }
            RenderPhaseType::Transmissive => Err(ForwardReason::Transmissive),
            RenderPhaseType::Transparent => Err(ForwardReason::Blended),
        };
        let needs = needs.and_then(|(needs, shaders)| {
            // Without normals, forward lights with undefined output of the vertex shader, which the G-buffer cannot
            // reproduce.
            if !has(Mesh::ATTRIBUTE_NORMAL) {
                return Err(ForwardReason::NoNormals);
            }
            // The same applies without tangents.
            if needs.shading_model == ShadingModel::Anisotropy && !has(Mesh::ATTRIBUTE_TANGENT) {
                return Err(ForwardReason::NoTangents);
            }
            Ok((needs, shaders))
        });
        let key = MeshPipelineKey::from_bits_retain(mesh.key_bits.bits());
        Ok(MeshKind {
            material,
            material_id,
            mesh,
            mesh_id,
            slabs,
            needs,
            deforms: has(Mesh::ATTRIBUTE_JOINT_INDEX)
                || key.contains(MeshPipelineKey::MORPH_TARGETS),
        })
    }

    /// Returns the largest possible demand of the mesh and the shaders that draw it into the G-buffer, or the reason
    /// that forward must draw it.
    pub(super) fn gbuffer_needs<'a>(
        &self,
        entity: MainEntity,
        mesh: &MeshToQueue<'a>,
    ) -> Result<(MeshDemand, &'a MaterialShaders), ForwardReason> {
        let mut targets = self.special_meshes.targets(entity);
        if self.moving_meshes.contains(entity) {
            targets |= GBufferTargets::MOTION;
        }
        if self.special_meshes.visibility_mask(entity) != DEFAULT_VISIBILITY_MASK {
            targets |= GBufferTargets::VISIBILITY_MASK;
        }
        let lightmapped = self.lightmapped_meshes.key(entity).is_some();
        Self::needs_of(mesh, lightmapped, targets)
    }

    /// As [`gbuffer_needs`](Self::gbuffer_needs), for an instance that needs these `targets` beside those of its mesh and
    /// material.
    pub(super) fn needs_of<'a>(
        mesh: &MeshKind<'a>,
        lightmapped: bool,
        targets: GBufferTargets,
    ) -> Result<(MeshDemand, &'a MaterialShaders), ForwardReason> {
        let (needs, shaders) = mesh.needs?;
        let mut targets = needs.targets | targets;
        // Unlit surfaces have none of its light.
        if lightmapped && needs.shading_model != ShadingModel::Unlit {
            targets |= GBufferTargets::EMISSIVE;
        }
        if mesh.deforms {
            targets |= GBufferTargets::MOTION;
        }
        let demand = MeshDemand {
            demand: Demand {
                targets,
                variants: LightingVariants::of(needs.shading_model, lightmapped),
            },
            is_alpha_masked: matches!(
                mesh.material.properties.render_phase_type,
                RenderPhaseType::AlphaMask
            ),
        };
        Ok((demand, shaders))
    }
}
