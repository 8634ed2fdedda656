//! Runs commands in an app's `Update`.

use bevy::prelude::*;
use kit::headless::Headless;

pub type Action = Box<dyn FnOnce(&mut Commands) + Send + Sync>;

/// Actions for the next frame.
#[derive(Resource, Default)]
struct Actions(Vec<Action>);

fn run_actions(mut commands: Commands, mut actions: ResMut<Actions>) {
    for action in actions.0.drain(..) {
        action(&mut commands);
    }
}

/// Makes `app` run the actions that [`act`] queues.
pub fn add_actions(app: &mut App) {
    app.init_resource::<Actions>()
        .add_systems(Update, run_actions);
}

/// Queues an action for the next frame.
pub fn queue(headless: &mut Headless, action: Action) {
    headless.world().resource_mut::<Actions>().0.push(action);
}

/// Queues `action` on `entity` for the next frame.
pub fn act(
    headless: &mut Headless,
    entity: Entity,
    action: impl FnOnce(&mut EntityCommands) + Send + Sync + 'static,
) {
    let action = move |commands: &mut Commands| action(&mut commands.entity(entity));
    queue(headless, Box::new(action));
}
