//! Text in the upper left corner, readable on any picture.

use bevy::prelude::*;

#[derive(Component)]
pub struct TextPanel;

pub fn spawn_text_panel(mut commands: Commands) {
    commands.spawn((
        TextPanel,
        Text::default(),
        TextFont::from_font_size(14.0),
        BackgroundColor(Color::BLACK.with_alpha(0.75)),
        Node {
            position_type: PositionType::Absolute,
            top: px(8),
            left: px(8),
            padding: px(6).all(),
            ..default()
        },
    ));
}
