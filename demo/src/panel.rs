//! What is measured, at the top left, and buttons for the mouse, each of which has a key too, at the bottom.

use crate::debug_view::DebugView;
use crate::exhibits::{Exhibit, Show, Shown};
use crate::measures::Measures;
use crate::tempo::Tempo;
use bevy::prelude::*;
use bevy::ui::UiGlobalTransform;
use bevy::window::PrimaryWindow;

const CARD: Color = Color::srgba(0.08, 0.09, 0.11, 0.78);
const CHOSEN: Color = Color::srgb(0.95, 0.45, 0.12);
const INK: Color = Color::srgb(0.94, 0.95, 0.96);
const FAINT: Color = Color::srgba(0.94, 0.95, 0.96, 0.6);

/// What a button or its key does.
#[derive(Clone, Copy, Component, Debug, Message, PartialEq)]
pub(crate) enum Action {
    Show(Exhibit),
    Slow,
    Pause,
    Back,
    Debug,
    Reset,
}

/// Whether the pointer is on a button, and not for the scene.
#[derive(Default, Resource)]
pub(crate) struct PointerOnPanel(pub(crate) bool);

/// The text of the measures.
#[derive(Component)]
struct Figures;

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<PointerOnPanel>()
        .add_message::<Action>()
        .add_systems(Startup, (build_figures, build_buttons))
        .add_systems(PreUpdate, (press_keys, press_buttons, act).chain())
        .add_systems(Update, (write_figures, color_buttons));
}

const KEYS: [(KeyCode, &str, Action); 15] = [
    (KeyCode::Digit1, "1", Action::Show(Exhibit::All)),
    (KeyCode::Digit2, "2", Action::Show(Exhibit::Glass)),
    (KeyCode::Digit3, "3", Action::Show(Exhibit::Brick)),
    (KeyCode::Digit4, "4", Action::Show(Exhibit::Wood)),
    (KeyCode::Digit5, "5", Action::Show(Exhibit::Stone)),
    (KeyCode::Digit6, "6", Action::Show(Exhibit::Concrete)),
    (KeyCode::Digit7, "7", Action::Show(Exhibit::Figurine)),
    (KeyCode::Digit8, "8", Action::Show(Exhibit::Furniture)),
    (KeyCode::Digit9, "9", Action::Show(Exhibit::Wrecking)),
    (KeyCode::Digit0, "0", Action::Show(Exhibit::Tower)),
    (KeyCode::KeyS, "S", Action::Slow),
    (KeyCode::KeyP, "P", Action::Pause),
    (KeyCode::KeyB, "B", Action::Back),
    (KeyCode::KeyD, "D", Action::Debug),
    (KeyCode::KeyR, "R", Action::Reset),
];

impl Action {
    fn name(self) -> &'static str {
        match self {
            Self::Show(exhibit) => exhibit.name(),
            Self::Slow => "Slow",
            Self::Pause => "Pause",
            Self::Back => "Rewind",
            Self::Debug => "Debug",
            Self::Reset => "Reset",
        }
    }
}

fn text(content: impl Into<String>, size: f32, color: Color) -> impl Bundle {
    (
        Text::new(content),
        TextFont::from_font_size(size),
        TextColor(color),
    )
}

fn build_figures(mut commands: Commands) {
    let card = Node {
        position_type: PositionType::Absolute,
        left: Val::Px(18.0),
        top: Val::Px(18.0),
        padding: UiRect::axes(Val::Px(14.0), Val::Px(10.0)),
        flex_direction: FlexDirection::Column,
        row_gap: Val::Px(4.0),
        border_radius: BorderRadius::all(Val::Px(8.0)),
        ..default()
    };
    commands.spawn((
        card,
        BackgroundColor(CARD),
        children![
            text("bevy_cleave", 17.0, CHOSEN),
            (Figures, text("", 13.0, INK)),
            text(
                "swipe: slice   tap: throw   arrows: look around",
                11.0,
                FAINT
            ),
        ],
    ));
}

/// A row that goes on below where the picture is too narrow for it.
fn row(gap: f32) -> Node {
    Node {
        justify_content: JustifyContent::Center,
        flex_wrap: FlexWrap::Wrap,
        row_gap: Val::Px(6.0),
        column_gap: Val::Px(gap),
        ..default()
    }
}

/// Buttons of the exhibits, and of the rest: in a narrow picture each of the two has a row.
fn build_buttons(mut commands: Commands) {
    let bar = Node {
        position_type: PositionType::Absolute,
        bottom: Val::Px(18.0),
        width: Val::Percent(100.0),
        ..row(24.0)
    };
    let is_rest = |(_, _, action): &(KeyCode, &str, Action)| *action == Action::Slow;
    let rest = KEYS.iter().position(is_rest).unwrap_or(KEYS.len());
    let (exhibits, rest) = KEYS.split_at(rest);
    commands.spawn(bar).with_children(|bar| {
        for group in [exhibits, rest] {
            bar.spawn(row(6.0)).with_children(|row| {
                for &(_, key, action) in group {
                    row.spawn(button(key, action));
                }
            });
        }
    });
}

fn button(key: &'static str, action: Action) -> impl Bundle {
    let button = Node {
        padding: UiRect::axes(Val::Px(11.0), Val::Px(7.0)),
        column_gap: Val::Px(6.0),
        align_items: AlignItems::Baseline,
        border_radius: BorderRadius::all(Val::Px(7.0)),
        ..default()
    };
    (
        action,
        button,
        BackgroundColor(CARD),
        children![text(key, 10.0, FAINT), text(action.name(), 13.0, INK)],
    )
}

fn press_keys(keys: Res<ButtonInput<KeyCode>>, mut actions: MessageWriter<Action>) {
    let pressed = KEYS.iter().filter(|(key, ..)| keys.just_pressed(*key));
    actions.write_batch(pressed.map(|&(_, _, action)| action));
}

fn press_buttons(
    window: Query<&Window, With<PrimaryWindow>>,
    mouse: Res<ButtonInput<MouseButton>>,
    touches: Res<Touches>,
    nodes: Query<(&Action, &ComputedNode, &UiGlobalTransform)>,
    mut is_on_panel: ResMut<PointerOnPanel>,
    mut actions: MessageWriter<Action>,
) {
    let Ok(window) = window.single() else {
        return;
    };
    let finger = touches
        .iter()
        .next()
        .map(|finger| finger.position() * window.scale_factor());
    let pointer = finger.or_else(|| window.physical_cursor_position());
    let hit = pointer.and_then(|at| {
        let mut under = nodes
            .iter()
            .filter(|(_, node, place)| node.contains_point(**place, at));
        under.next().map(|(action, ..)| *action)
    });
    is_on_panel.0 = hit.is_some();
    if mouse.just_pressed(MouseButton::Left) || touches.any_just_pressed() {
        actions.write_batch(hit);
    }
}

fn act(
    mut actions: MessageReader<Action>,
    mut show: MessageWriter<Show>,
    shown: Res<Shown>,
    mut tempo: ResMut<Tempo>,
    mut debug: ResMut<DebugView>,
) {
    for action in actions.read() {
        match *action {
            Action::Show(exhibit) => {
                show.write(Show(exhibit));
            }
            Action::Reset => {
                show.write(Show(shown.0));
            }
            Action::Slow => tempo.slow ^= true,
            Action::Pause => tempo.paused ^= true,
            Action::Back => tempo.back ^= true,
            Action::Debug => debug.0 ^= true,
        }
    }
}

fn write_figures(measures: Res<Measures>, mut figures: Query<&mut Text, With<Figures>>) {
    for mut text in &mut figures {
        text.0 = format!(
            "pieces   {:>7}   asleep {}\ncontacts {:>7}\nstep     {:>7.2} ms\nframe    {:>7.1} ms\nresidual {:>7.0e}",
            measures.pieces,
            measures.asleep,
            measures.contacts,
            measures.step_time,
            measures.frame_time,
            measures.residual,
        );
    }
}

fn color_buttons(
    shown: Res<Shown>,
    tempo: Res<Tempo>,
    debug: Res<DebugView>,
    mut buttons: Query<(&Action, &mut BackgroundColor)>,
) {
    for (action, mut color) in &mut buttons {
        let is_chosen = match *action {
            Action::Show(exhibit) => exhibit == shown.0,
            Action::Slow => tempo.slow,
            Action::Pause => tempo.paused,
            Action::Back => tempo.back,
            Action::Debug => debug.0,
            Action::Reset => false,
        };
        color.set_if_neq(BackgroundColor(if is_chosen { CHOSEN } else { CARD }));
    }
}
