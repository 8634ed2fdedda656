//! The exposure that tonemapping applies to a view, set by hand or by auto exposure.
//!
//! Effects clamp the light that they keep, so that single bright pixels do not flicker. The limit is a multiple of what shows as
//! white, which exposure moves by any number of stops.

use core::{marker::PhantomData, num::NonZeroU64};

use bevy::{
    core_pipeline::schedule::{Core3d, Core3dSystems},
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        render_resource::{
            BindGroupLayoutEntryBuilder, BindingResource, Buffer, BufferInitDescriptor,
            BufferUsages, ShaderType, binding_types::uniform_buffer_sized,
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        view::{ColorGradingUniform, ExtractedView, ViewUniform, ViewUniformOffset, ViewUniforms},
    },
    shader::load_shader_library,
};

/// Bytes of a vector of four floats; the first is the exposure.
const SIZE: u64 = 16;

/// GPU buffer with the exposure of a view in its last frame, in stops. Initially that of its colour grading.
pub(super) struct ShownExposure(Buffer);

impl ShownExposure {
    pub(super) fn new(device: &RenderDevice, view: &ExtractedView) -> Self {
        let stops = [view.color_grading.global.exposure, 0.0, 0.0, 0.0];
        Self(device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("lean_deferred/effects/shown_exposure"),
            contents: bytemuck::cast_slice(&stops),
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
        }))
    }

    pub(super) fn bytes(&self) -> u64 {
        self.0.size()
    }

    pub(super) fn layout() -> BindGroupLayoutEntryBuilder {
        uniform_buffer_sized(false, NonZeroU64::new(SIZE))
    }

    pub(super) fn binding(&self) -> BindingResource<'_> {
        self.0.as_entire_binding()
    }
}

/// On a view of the render world: the state of an effect that clamps light to a multiple of white.
pub(super) trait BoundedByWhite: Component {
    fn shown_exposure(&self) -> &ShownExposure;
}

/// Updates the [`ShownExposure`] of each `V`.
pub(super) struct ShownExposurePlugin<V>(PhantomData<V>);

impl<V> Default for ShownExposurePlugin<V> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<V: BoundedByWhite> Plugin for ShownExposurePlugin<V> {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<ShownExposureShaderPlugin>() {
            app.add_plugins(ShownExposureShaderPlugin);
        }
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app
                .add_systems(
                    Render,
                    let_uniforms_be_copied::<V>
                        .run_if(any_with_component::<V>)
                        .in_set(RenderSystems::Queue)
                        .in_set(UniformUsageSystems)
                        .ambiguous_with(UniformUsageSystems),
                )
                .add_systems(
                    Core3d,
                    keep_shown_exposure::<V>
                        .run_if(any_with_component::<V>)
                        .after(Core3dSystems::PostProcess),
                );
        }
    }
}

/// The systems of `let_uniforms_be_copied`: all add the same usage, in any order.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
struct UniformUsageSystems;

struct ShownExposureShaderPlugin;

impl Plugin for ShownExposureShaderPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "shown_exposure.wgsl");
    }
}

fn can_be_copied(buffer: &Buffer) -> bool {
    buffer.usage().contains(BufferUsages::COPY_SRC)
}

/// Adds `COPY_SRC` to the usages of Bevy's view uniforms, before Bevy writes those of this frame.
fn let_uniforms_be_copied<V: BoundedByWhite>(mut uniforms: ResMut<ViewUniforms>) {
    if !uniforms.uniforms.buffer().is_some_and(can_be_copied) {
        uniforms.uniforms.add_usages(BufferUsages::COPY_SRC);
    }
}

/// Byte offset of the exposure in Bevy's view uniform.
fn exposure_offset() -> u64 {
    // Indices of the fields `color_grading` and `exposure`.
    ViewUniform::METADATA.offset(13) + ColorGradingUniform::METADATA.offset(7)
}

/// Runs after post-processing: by then Bevy's `AutoExposure` or this crate's has written the exposure to the view uniform.
fn keep_shown_exposure<V: BoundedByWhite>(
    view: ViewQuery<(&V, &ViewUniformOffset)>,
    uniforms: Res<ViewUniforms>,
    mut ctx: RenderContext,
) {
    let (held, view) = view.into_inner();
    if let Some(uniforms) = (uniforms.uniforms.buffer()).filter(|buffer| can_be_copied(buffer)) {
        let offset = u64::from(view.offset) + exposure_offset();
        let kept = &held.shown_exposure().0;
        ctx.command_encoder()
            .copy_buffer_to_buffer(uniforms, offset, kept, 0, 4);
    }
}
