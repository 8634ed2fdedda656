//! The settings panel: the fields of a camera's components, by reflection.

use core::marker::PhantomData;

use bevy::{
    diagnostic::{DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    prelude::*,
    reflect::{FromType, GetTypeRegistration},
};
use bevy_lean_deferred::LeanStatus;

use super::{fields, gpu_times, switch::switch_now, text_panel::TextPanel};

/// Marks the camera that the panel, the keys and `--set` are for.
#[derive(Component, Clone, Copy)]
pub struct PanelCamera;

/// Cameras with [`PanelCamera`]. The panel shows the first one.
pub fn cameras(world: &mut World) -> Vec<Entity> {
    let mut cameras = world.query_filtered::<Entity, With<PanelCamera>>();
    cameras.iter(world).collect()
}

/// A component on the panel.
struct Section {
    title: &'static str,
    /// Name of the component.
    name: &'static str,
    component: ReflectComponent,
    /// Switches the component on or off; none if it stays on.
    switch: Option<fn(&mut EntityWorldMut, bool)>,
}

impl Section {
    /// Paths and values of the fields; none if the camera lacks the component.
    fn fields(&self, camera: EntityRef) -> Vec<(String, String)> {
        let component = self.component.reflect(camera);
        component.map_or_else(Vec::new, |value| fields::list(value.as_partial_reflect()))
    }

    fn step(&self, world: &mut World, camera: Entity, path: &str, forward: bool) {
        let registry = world.resource::<AppTypeRegistry>().clone();
        let mut camera = world.entity_mut(camera);
        if let Some(mut component) = self.component.reflect_mut(&mut camera)
            && let Ok(field) = component.reflect_path_mut(path)
        {
            fields::step(field, forward, &registry.read());
        }
    }

    /// The title, and the state of a component that can be switched.
    fn header(&self, camera: EntityRef) -> String {
        if self.switch.is_none() {
            return self.title.into();
        }
        let is_on = self.component.contains(camera);
        let status = camera.get::<LeanStatus>().filter(|_| is_on);
        let status = status.and_then(|status| {
            let mut statuses = status.each();
            statuses.find_map(|(name, status)| (name == self.name).then(|| status.to_string()))
        });
        let state = status.unwrap_or_else(|| if is_on { "on" } else { "off" }.into());
        format!("{}: {state}", self.title)
    }
}

/// The text in the corner.
#[derive(Resource, Default)]
pub struct Panel {
    /// Line about the variants that the keys 1, 2 and 3 select.
    pub techniques: String,
    /// Lines of the example.
    pub head: String,
    pub is_hidden: bool,
    sections: Vec<Section>,
    /// The chosen section and row; row 0 is the title.
    chosen: (usize, usize),
}

/// Adds a component to the panel: see [`panel`].
pub struct PanelPlugin<C> {
    title: &'static str,
    has_switch: bool,
    component: PhantomData<fn() -> C>,
}

/// Shows the fields of the camera's `C` on the panel, and whether there is one.
pub fn panel<C>(title: &'static str) -> PanelPlugin<C> {
    PanelPlugin {
        title,
        has_switch: true,
        component: PhantomData,
    }
}

/// As [`panel`], for a component that stays.
pub fn fixed_panel<C>(title: &'static str) -> PanelPlugin<C> {
    PanelPlugin {
        has_switch: false,
        ..panel(title)
    }
}

impl<C: Component + Reflect + TypePath + GetTypeRegistration + Default> Plugin for PanelPlugin<C> {
    fn build(&self, app: &mut App) {
        app.register_type::<C>().init_resource::<Panel>();
        let mut panel = app.world_mut().resource_mut::<Panel>();
        panel.sections.push(Section {
            title: self.title,
            name: C::short_type_path(),
            component: FromType::<C>::from_type(),
            switch: match self.has_switch {
                true => Some(switch_now::<C>),
                false => None,
            },
        });
    }
}

/// Runs `change` with the panel and its camera, if it has sections.
fn with_panel(world: &mut World, change: impl FnOnce(&mut Panel, &mut World, Entity)) {
    let Some(camera) = cameras(world).first().copied() else {
        return;
    };
    world.resource_scope(|world, mut panel: Mut<Panel>| {
        if !panel.sections.is_empty() {
            change(&mut panel, world, camera);
        }
    });
}

/// Chooses the next row, or the one before.
pub fn choose_row(world: &mut World, forward: bool) {
    with_panel(world, |panel, world, camera| {
        let camera = world.entity(camera);
        let rows = |section: usize| panel.sections[section].fields(camera).len();
        let count = panel.sections.len();
        let (section, row) = panel.chosen;
        panel.chosen = match forward {
            true if row < rows(section) => (section, row + 1),
            true => ((section + 1) % count, 0),
            false if row > 0 => (section, row - 1),
            false => {
                let section = (section + count - 1) % count;
                (section, rows(section))
            }
        };
    });
}

/// Chooses the title of the next section, or of the one before.
pub fn choose_section(world: &mut World, forward: bool) {
    with_panel(world, |panel, _, _| {
        let count = panel.sections.len();
        let step = if forward { 1 } else { count - 1 };
        panel.chosen = ((panel.chosen.0 + step) % count, 0);
    });
}

/// Changes the chosen field; switches the component if its title is chosen.
pub fn change(world: &mut World, forward: bool) {
    with_panel(world, |panel, world, camera| {
        let (section, row) = panel.chosen;
        let section = &panel.sections[section];
        let fields = section.fields(world.entity(camera));
        if let Some(row) = row.checked_sub(1) {
            if let Some((path, _)) = fields.get(row) {
                section.step(world, camera, path, forward);
            }
        } else if let Some(switch) = section.switch {
            let mut camera = world.entity_mut(camera);
            let is_on = section.component.contains(&camera);
            switch(&mut camera, !is_on);
        }
    });
}

/// Changes the field `name` of all components that have it.
pub fn change_all(world: &mut World, name: &str, forward: bool) {
    with_panel(world, |panel, world, camera| {
        for section in &panel.sections {
            section.step(world, camera, name, forward);
        }
    });
}

const KEYS: &str =
    "Q quality  R resolution  D debug view  B split  G LeanDeferred  L lights  H text
Tab, Up, Down: setting  Left, Right: value";

/// GPU times in the text.
const TIMES: usize = 10;
/// Shorter ones are left out, in milliseconds.
const SHORTEST: f64 = 0.0005;

pub fn write_text(world: &mut World) {
    let Some(camera) = cameras(world).first().copied() else {
        return;
    };
    let is_hidden = world.resource::<Panel>().is_hidden;
    let text = match is_hidden {
        true => String::new(),
        false => lines(world, world.entity(camera)).join("\n"),
    };
    let mut panels = world.query_filtered::<(&mut Text, &mut Visibility), With<TextPanel>>();
    for (mut shown, mut visibility) in panels.iter_mut(world) {
        visibility.set_if_neq(match is_hidden {
            true => Visibility::Hidden,
            false => Visibility::Inherited,
        });
        if shown.0 != text {
            shown.0.clone_from(&text);
        }
    }
}

fn lines(world: &World, camera: EntityRef) -> Vec<String> {
    let panel = world.resource::<Panel>();
    let diagnostics = world.resource::<DiagnosticsStore>();
    let rate = diagnostics.get(&FrameTimeDiagnosticsPlugin::FPS);
    let rate = rate.and_then(|rate| rate.smoothed());
    let rate = rate.map(|rate| format!("{rate:.0} frames a second"));
    let mut lines = vec![panel.techniques.clone(), panel.head.clone()];
    lines.extend(rate);
    lines.retain(|line| !line.is_empty());
    for (index, section) in panel.sections.iter().enumerate() {
        let chosen = (panel.chosen.0 == index).then_some(panel.chosen.1);
        lines.push(mark(section.header(camera), chosen == Some(0)));
        let Some(chosen) = chosen else {
            continue;
        };
        for (row, (path, value)) in (1..).zip(section.fields(camera)) {
            let line = mark(format!("{path}: {value}"), row == chosen);
            lines.push(format!("    {line}"));
        }
    }
    let times = gpu_times::all(diagnostics).into_iter();
    let times = times.filter(|(_, time)| *time >= SHORTEST).take(TIMES);
    lines.extend(times.map(|(span, time)| format!("{time:7.3} ms  {span}")));
    lines.push(KEYS.into());
    lines
}

/// Puts the chosen row in brackets.
fn mark(line: String, is_chosen: bool) -> String {
    match is_chosen {
        true => format!("[{line}]"),
        false => line,
    }
}
