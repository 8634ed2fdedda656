//! Lets forward meshes trace rays through the hi-z cells and the history of a view.

use bevy::{
    camera::MainPassResolutionOverride,
    pbr::DistanceFog,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        renderer::{RenderDevice, RenderQueue},
        texture::FallbackImageZero,
        view::ExtractedView,
    },
};

use super::{active::ActiveReflections, fixtures::ReflectionFixtures, prepare::ViewReflections};
use crate::{
    effects::{
        history::{ViewHistory, units_per_metre},
        history_validity::LastFrame,
        reprojection::{exposure_ratio, last_distance, last_pixel_from_view, pixels_of, up_to},
        world_shift::WorldShift,
    },
    lighting::forward::{ForwardReflectionTextures, ForwardReflectionUniform, ForwardReflections},
    shader_library::{
        distance_fog::FogUniform,
        reconstruction::position::{STEEPEST, pixels_per_metre},
    },
    view::{ActiveLeanView, LightingIo},
};

/// Inserts [`ForwardReflections`] on views that ask for it, and removes it from others.
pub(super) fn decide_forward_reflections(
    mut commands: Commands,
    views: Query<(Entity, &ActiveReflections, Has<ForwardReflections>)>,
) {
    for (entity, active, has) in &views {
        let wants = active.settings.advanced.forward_meshes;
        if wants && !has {
            let mut forward = ForwardReflections::default();
            (forward.uniform).set_label(Some("lean_deferred/effects/reflections/forward"));
            commands.entity(entity).insert(forward);
        } else if has && !wants {
            commands.entity(entity).remove::<ForwardReflections>();
        }
    }
}

/// Fills in [`ForwardReflections`]. Without history or hi-z, rays find nothing.
pub(super) fn prepare_forward_reflections(
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    fixtures: Res<ReflectionFixtures>,
    nothing: Res<FallbackImageZero>,
    shift: Res<WorldShift>,
    mut views: Query<(
        (&ActiveReflections, Option<&ActiveLeanView>),
        (&ExtractedCamera, &ExtractedView),
        (Option<&MainPassResolutionOverride>, Option<&DistanceFog>),
        (Option<&ViewReflections>, Option<&ViewHistory>),
        &mut ForwardReflections,
    )>,
) {
    for ((active, lean), (camera, view), (resolution, fog), (held, history), mut forward) in
        &mut views
    {
        let fixtures = fixtures.get(&device);
        let forward = &mut *forward;
        // The passes run for views whose lighting adds their output.
        let has_hi_z = lean.is_some_and(|lean| lean.io.contains(LightingIo::INDIRECT_SPECULAR));
        let held = held.filter(|_| has_hi_z);
        let now = LastFrame::of(view, resolution, camera.exposure, &shift);
        let last = held.and(history).and_then(ViewHistory::last);
        let mut uniform = uniform_of(active, &now, last);
        uniform.fog = FogUniform::new(fog);
        uniform.history_size = history.map_or(Vec2::ONE, |history| history.size().as_vec2());
        forward.uniform.set(uniform);
        forward.uniform.write_buffer(&device, &queue);
        forward.textures = Some(ForwardReflectionTextures {
            hi_z: held
                .map_or(&fixtures.nothing, ViewReflections::hi_z)
                .clone(),
            history: history
                .map_or(&nothing.texture_view, |history| history.view())
                .clone(),
            history_sampler: fixtures.history_sampler.clone(),
        });
    }
}

/// Parameters of rays in the frame `now` after the `last` one, without fog.
fn uniform_of(
    active: &ActiveReflections,
    now: &LastFrame,
    last: Option<&LastFrame>,
) -> ForwardReflectionUniform {
    let settings = &active.settings;
    let size = now.viewport.size();
    let scale = pixels_per_metre(now.clip_from_view, size).y.abs();
    ForwardReflectionUniform {
        pixel_from_view: pixels_of(now),
        view_from_world: now.world_from_view.inverse(),
        last_pixel_from_view: last.map_or(Mat4::IDENTITY, |last| last_pixel_from_view(now, last)),
        last_distance: last.map_or(Vec4::ZERO, |last| last_distance(now, last)),
        fog: FogUniform::default(),
        history_size: Vec2::ONE,
        last_viewport_size: last.map_or(size, |last| last.viewport.size()).as_vec2(),
        viewport_size: size,
        steps: settings.marches(settings.texel_side(size.y)).smooth_steps,
        is_orthographic: now.is_orthographic().into(),
        pixels_per_metre: scale,
        edge_metres: STEEPEST / scale,
        metres_per_unit: last.map_or(1.0, |last| 1.0 / units_per_metre(last.clip_from_view)),
        thickness: up_to(1e6, settings.thickness),
        edge_fade: up_to(0.5, settings.advanced.edge_fade) * size.y as f32,
        max_roughness: up_to(1.25, settings.max_roughness),
        intensity: up_to(1.0, settings.intensity),
        exposure_ratio: exposure_ratio(now, last),
    }
}
